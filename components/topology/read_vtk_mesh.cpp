// SPDX-License-Identifier: LGPL-2.1-or-later
// The program that reads a file in VTK's formats for MeshVTKLoader: VTK trusts what a file says of
// itself in more places than can be checked beforehand.
//
// Arguments: the file, the arrays of labels, of directions and of values. Lists handed over: points (three each), types,
// offsets (one more than cells) and nodes of the cells; names and values of arrays of cells and of points; how VTK calls
// the kinds of cells that occur, and which of these are linear.
//
// Source: VTK's readers (vtkGenericDataObjectReader, vtkXMLGenericDataObjectReader).
#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkCellTypes.h>
#include <vtkDataArray.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkIdList.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>
#include <vtkXMLGenericDataObjectReader.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <set>
#include <sstream>

#include "components/topology/lists_of_vtk.h"
#include "framework/scene/diagnostics.h"
#include "framework/scene/reader_process.h"

namespace stroma {
namespace {

/// How much memory reading takes for each byte of a file: text has two bytes a number at least, and compressed data
/// shrink by a thousand at most.
constexpr double memory_of_text = 64, memory_of_compressed = 1100;

/// Keeps what VTK would print.
class CapturedOutput : public vtkOutputWindow {
 public:
  static CapturedOutput* New();
  vtkTypeMacro(CapturedOutput, vtkOutputWindow);  // NOLINT(bugprone-derived-method-shadowing-base-method): the macro's
  void DisplayText(const char* text) override { text_ += text; }
  bool hasError() const { return text_.find("ERROR") != std::string::npos; }
  /// The first error, without VTK's own file, line and address.
  std::string message() const {
    const std::size_t begin = text_.find("): ");
    const std::string text = begin == std::string::npos ? text_ : text_.substr(begin + 3);
    return text.substr(0, text.find('\n'));
  }

 private:
  std::string text_;
};
vtkStandardNewMacro(CapturedOutput);

/// Refuses a legacy file in which a line of keywords holds a number greater than the file has bytes: VTK would allocate
/// what such a line declares. The second line is a free title.
void checkLegacyCounts(const std::string& bytes, const std::string& name) {
  std::size_t line = 1, at = 0;
  for (; at < bytes.size(); ++line) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    const bool keywords = line > 2 && std::isalpha(static_cast<unsigned char>(bytes[at]));
    for (std::size_t word = at; keywords && word < end;) {
      const std::size_t stop = std::min(bytes.find_first_of(" \t\r", word), end);
      std::uint64_t count = 0;
      const auto [parsed, error] = std::from_chars(bytes.data() + word, bytes.data() + stop, count);
      const bool is_number = parsed == bytes.data() + stop && error != std::errc::invalid_argument;
      if (is_number && (error == std::errc::result_out_of_range || count > bytes.size()))
        throw ComponentError(fmt::format("{}:{}: {} are declared, but the file has {} bytes", name, line,
                                         bytes.substr(at, std::min<std::size_t>(stop - at, 60)), bytes.size()));
      word = stop + 1;
    }
    at = end + 1;
  }
}

/// The same for the attributes NumberOfPoints and the like of an XML file, whose data may be compressed (by at most
/// about a thousand).
void checkXmlCounts(const std::string& bytes, const std::string& name) {
  const std::string key = "NumberOf";
  for (std::size_t at = bytes.find(key); at != std::string::npos; at = bytes.find(key, at + 1)) {
    const std::size_t quote = bytes.find('"', at);
    if (quote == std::string::npos) return;
    std::uint64_t count = 0;
    const auto [parsed, error] = std::from_chars(bytes.data() + quote + 1, bytes.data() + bytes.size(), count);
    if (error == std::errc::result_out_of_range || (error == std::errc() && count / 1100 > bytes.size()))
      throw ComponentError(fmt::format("{}: {} is declared, but the file has {} bytes", name,
                                       bytes.substr(at, std::size_t(parsed - bytes.data()) + 1 - at), bytes.size()));
  }
}

template <class Reader>
vtkSmartPointer<vtkPointSet> readWith(const std::string& file) {
  const auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(file.c_str());
  if constexpr (requires { reader->ReadAllScalarsOn(); }) {  // the first of each kind otherwise
    reader->ReadAllScalarsOn();
    reader->ReadAllVectorsOn();
    reader->ReadAllTensorsOn();
    reader->ReadAllFieldsOn();
  }
  reader->Update();
  return vtkPointSet::SafeDownCast(reader->GetOutput());
}

vtkSmartPointer<vtkPointSet> readPoints(const std::string& file, const std::string& name) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
  std::ostringstream text;
  text << stream.rdbuf();
  const std::string bytes = std::move(text).str();
  if (bytes.starts_with("# vtk")) {
    limitReader(double(bytes.size()), memory_of_text);
    checkLegacyCounts(bytes, name);
    return readWith<vtkGenericDataObjectReader>(file);
  }
  if (bytes.substr(0, 1024).find("<VTKFile") != std::string::npos) {
    limitReader(double(bytes.size()), memory_of_compressed);
    checkXmlCounts(bytes, name);
    return readWith<vtkXMLGenericDataObjectReader>(file);
  }
  throw ComponentError(fmt::format("{} is not a file of VTK", name),
                       "a first line '# vtk DataFile' or an element <VTKFile");
}

Texts namesOf(vtkDataSetAttributes& data) {
  Texts names;
  for (int k = 0; k < data.GetNumberOfArrays(); ++k)
    if (const char* word = data.GetArrayName(k)) names.emplace_back(word);
  return names;
}

/// An array's values, and how many each entry has.
void addArray(vtkDataSetAttributes& data, const std::string& array, const std::string& name, ValueLists& lists) {
  vtkDataArray* found = array.empty() ? nullptr : data.GetArray(array.c_str());
  if (!found) return;
  const int width = found->GetNumberOfComponents();
  Reals values;
  values.reserve(std::size_t(found->GetNumberOfTuples()) * std::size_t(width));
  for (vtkIdType i = 0; i < found->GetNumberOfTuples(); ++i)
    for (int k = 0; k < width; ++k) values.push_back(found->GetComponent(i, k));
  lists.add(name, std::move(values));
  lists.add(name + vtk_lists::width, Integers{width});
}

void addPoints(vtkPointSet& data, ValueLists& lists) {
  Reals points(3 * std::size_t(data.GetNumberOfPoints()));
  for (vtkIdType n = 0; n < data.GetNumberOfPoints(); ++n) data.GetPoint(n, points.data() + 3 * n);
  lists.add(vtk_lists::points, std::move(points));
}

void addCells(vtkPointSet& data, ValueLists& lists) {
  Integers types, offsets{0}, nodes;
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
    data.GetCellPoints(c, ids);
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) nodes.push_back(ids->GetId(k));
    types.push_back(data.GetCellType(c));
    offsets.push_back(std::int64_t(nodes.size()));
  }
  Integers kinds, linear;
  Texts names;
  for (const std::int64_t type : std::set(types.begin(), types.end())) {
    kinds.push_back(type);
    names.emplace_back(vtkCellTypes::GetClassNameFromTypeId(int(type)));
    linear.push_back(vtkCellTypes::IsLinear(static_cast<unsigned char>(type)) ? 1 : 0);
  }
  lists.add(vtk_lists::types, std::move(types)), lists.add(vtk_lists::offsets, std::move(offsets)),
      lists.add(vtk_lists::nodes, std::move(nodes));
  lists.add(vtk_lists::kinds, std::move(kinds)), lists.add(vtk_lists::kinds_linear, std::move(linear));
  lists.add(vtk_lists::kinds_names, std::move(names));
}

ValueLists readMesh(const std::string& file, const Texts& arguments) {
  const std::string name = file.substr(file.rfind('/') + 1);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // a second way to the terminal
  const auto window = vtkSmartPointer<CapturedOutput>::New();
  vtkOutputWindow::SetInstance(window);
  const vtkSmartPointer<vtkPointSet> data = readPoints(file, name);
  if (window->hasError()) throw ComponentError(fmt::format("{}: VTK says: {}", name, window->message()));
  if (!data)
    throw ComponentError(fmt::format("{} holds no mesh that VTK can read", name),
                         "an unstructured grid, poly data or a structured grid");
  ValueLists lists;
  addPoints(*data, lists);
  addCells(*data, lists);
  lists.add(vtk_lists::cell_arrays, namesOf(*data->GetCellData()));
  lists.add(vtk_lists::point_arrays, namesOf(*data->GetPointData()));
  addArray(*data->GetCellData(), arguments.at(0), vtk_lists::labels, lists);
  addArray(*data->GetCellData(), arguments.at(1), vtk_lists::cell_directions, lists);
  addArray(*data->GetPointData(), arguments.at(1), vtk_lists::point_directions, lists);
  if (arguments.size() > 2) addArray(*data->GetCellData(), arguments[2], vtk_lists::cell_values, lists);
  return lists;
}

}  // namespace
}  // namespace stroma

int main(int argc, char** argv) { return stroma::runReader(argc, argv, stroma::readMesh); }
