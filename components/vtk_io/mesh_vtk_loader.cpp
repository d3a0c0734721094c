// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads a mesh in VTK's formats: legacy .vtk (ASCII or binary, versions 1 to 5.1) and XML .vtu and .vtp.
//
// Which of them it is, is seen from the content. Lines, triangles, quads, tetrahedra and hexahedra are read, pixels and
// voxels turned into quads and hexahedra, polylines into edges, strips and polygons into triangles (around their first
// corner). Vertices, wedges and pyramids are counted and reported; quadratic cells are an error.
//
// Labels: when the file has cell data of whole numbers under the name `groupArray` (default "label"),
// `tetrahedraGroups` and its like hold the value of each cell, as MeshGmshLoader's hold the physical group.
//
// Directions: directionArray="fibres" names cell data or point data of three numbers, or six or nine for a frame of two
// or three vectors; `tetrahedraDirections`, `hexahedraDirections` and `nodeDirections` hold them, turned with the mesh,
// as AnisotropyDirections takes them.
//
// Source: VTK's readers (vtkGenericDataObjectReader, vtkXMLGenericDataObjectReader); the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshVTKLoader name="loader" filename="meshes/block.vtk"/>
//   <TetrahedronSetTopologyContainer name="tets" src="@loader"/>
// </Node>
#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
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
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// VTK has one window for its messages in the process: files are read one after the other.
std::mutex& outputWindow() {
  static std::mutex instance;
  return instance;
}

/// Keeps what VTK would print, and gives VTK its own window back at the end.
class CapturedOutput : public vtkOutputWindow {
 public:
  static CapturedOutput* New();
  vtkTypeMacro(CapturedOutput, vtkOutputWindow);  // NOLINT(bugprone-derived-method-shadowing-base-method): the macro's
  void DisplayText(const char* text) override { text_ += text; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};
vtkStandardNewMacro(CapturedOutput);

class Capture {
 public:
  Capture() : before_(vtkOutputWindow::GetInstance()), window_(vtkSmartPointer<CapturedOutput>::New()) {
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // a second way to the terminal
    vtkOutputWindow::SetInstance(window_);
  }
  ~Capture() { vtkOutputWindow::SetInstance(before_); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;
  bool hasError() const { return window_->text().find("ERROR") != std::string::npos; }
  /// The first error, without VTK's own file, line and address.
  std::string message() const {
    std::string text = window_->text();
    const std::size_t begin = text.find("): ");
    if (begin != std::string::npos) text = text.substr(begin + 3);
    text = text.substr(0, text.find('\n'));
    return text;
  }

 private:
  std::lock_guard<std::mutex> lock_{outputWindow()};
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkSmartPointer<CapturedOutput> window_;
};

class MeshVTKLoader : public MeshLoader {
 public:
  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    table.add("groupArray", group_array_).help("cell data of whole numbers that go to tetrahedraGroups and its like");
    declareGroups(table, "label");
    declareDirections(table);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    const std::string name = file.substr(file.rfind('/') + 1);
    Capture capture;
    const vtkSmartPointer<vtkPointSet> data = readPoints(file, name);
    if (capture.hasError()) throw ComponentError(fmt::format("{}: VTK says: {}", name, capture.message()));
    if (!data)
      throw ComponentError(fmt::format("{} holds no mesh that VTK can read", name),
                           "an unstructured grid, poly data or a structured grid");
    convert(*data, name, mesh);
    for (const auto& [what, count] : skipped_) inform(fmt::format("{} cells of kind {} are not used", count, what));
  }

 private:
  vtkSmartPointer<vtkPointSet> readPoints(const std::string& file, const std::string& name) const;
  void convert(vtkPointSet& data, const std::string& name, Mesh& mesh);
  void addCell(int type, const std::vector<Index>& n, const std::string& name, Mesh& mesh);
  void skip(int type, const std::string& name);
  vtkDataArray* findLabels(vtkPointSet& data, const std::string& name) const;
  vtkDataArray* findDirections(vtkDataSetAttributes& data, const std::string& name) const;
  void readDirections(vtkPointSet& data, const std::string& name);

  std::string group_array_ = "label";
  std::map<std::string, long> skipped_;
};

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

vtkSmartPointer<vtkPointSet> MeshVTKLoader::readPoints(const std::string& file, const std::string& name) const {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
  std::ostringstream text;
  text << stream.rdbuf();
  const std::string bytes = std::move(text).str();
  const auto read_with = [&file](const auto& reader) {
    reader->SetFileName(file.c_str());
    reader->Update();
    return vtkSmartPointer<vtkPointSet>(vtkPointSet::SafeDownCast(reader->GetOutput()));
  };
  if (bytes.starts_with("# vtk")) {
    checkLegacyCounts(bytes, name);
    return read_with(vtkSmartPointer<vtkGenericDataObjectReader>::New());
  }
  if (bytes.substr(0, 1024).find("<VTKFile") != std::string::npos) {
    checkXmlCounts(bytes, name);
    return read_with(vtkSmartPointer<vtkXMLGenericDataObjectReader>::New());
  }
  throw ComponentError(fmt::format("{} is not a file of VTK", name),
                       "a first line '# vtk DataFile' or an element <VTKFile");
}

std::vector<std::string> namesOf(vtkDataSetAttributes& data) {
  std::vector<std::string> names;
  for (int k = 0; k < data.GetNumberOfArrays(); ++k)
    if (const char* word = data.GetArrayName(k)) names.emplace_back(word);
  return names;
}

/// The array of labels, or null when the file has none and none was asked for.
vtkDataArray* MeshVTKLoader::findLabels(vtkPointSet& data, const std::string& name) const {
  vtkDataArray* labels = data.GetCellData()->GetArray(group_array_.c_str());
  const bool asked_for = this->data().find("groupArray")->isSet();
  const std::vector<std::string> names = namesOf(*data.GetCellData());
  if (!labels && asked_for)
    throw ComponentError(fmt::format("{} has no cell data '{}'", name, group_array_),
                         names.empty() ? "a file with cell data" : "an array of the file",
                         nearest(group_array_, names));
  if (!labels) return nullptr;
  bool whole = labels->GetNumberOfComponents() == 1;
  for (vtkIdType c = 0; whole && c < labels->GetNumberOfTuples(); ++c) {
    const double value = labels->GetComponent(c, 0);
    whole = std::abs(value) <= 1e9 && value == std::floor(value);
  }
  if (whole) return labels;
  if (asked_for)
    throw ComponentError(fmt::format("{}: the cell data '{}' are no labels", name, group_array_),
                         "one whole number per cell");
  return nullptr;
}

/// The array of directions among cell or point data, or null.
vtkDataArray* MeshVTKLoader::findDirections(vtkDataSetAttributes& data, const std::string& name) const {
  vtkDataArray* array = data.GetArray(directions_.array.c_str());
  if (!array) return nullptr;
  const int width = array->GetNumberOfComponents();
  if (width == 3 || width == 6 || width == 9) return array;
  throw ComponentError(fmt::format("{}: the data '{}' have {} components", name, directions_.array, width),
                       "3 (a direction), 6 or 9 (two or three)");
}

/// Adds the vectors of entry `at` of an array.
void addVectors(vtkDataArray& array, vtkIdType at, std::vector<Vec3>& out) {
  for (int k = 0; k + 2 < array.GetNumberOfComponents(); k += 3)
    out.emplace_back(array.GetComponent(at, k), array.GetComponent(at, k + 1), array.GetComponent(at, k + 2));
}

/// The kind that VTK's number stands for, and which of our nodes each of VTK's is; null for others.
struct Numbering {
  const CellKind* kind = nullptr;
  std::span<const int> order;
};

Numbering numberingOf(int type) {
  // axis-aligned cells in VTK's order of images
  static constexpr std::array<int, 8> image_order{0, 1, 3, 2, 4, 5, 7, 6};
  if (type == VTK_PIXEL) return {&cell_kinds::quad, {image_order.data(), 4}};
  if (type == VTK_VOXEL) return {&cell_kinds::hexahedron, image_order};
  const CellKind* kind = kindByNumber(&CellKind::vtk, type);
  return kind ? Numbering{kind, kind->vtk.order} : Numbering{};
}

/// Directions of nodes and of those cells that become volume cells, one each, in the order of the file.
void MeshVTKLoader::readDirections(vtkPointSet& data, const std::string& name) {
  if (directions_.array.empty()) return;
  vtkDataArray *of_cells = findDirections(*data.GetCellData(), name),
               *of_points = findDirections(*data.GetPointData(), name);
  if (!of_cells && !of_points) {
    std::vector<std::string> names = namesOf(*data.GetCellData());
    for (const std::string& word : namesOf(*data.GetPointData())) names.push_back(word);
    throw ComponentError(fmt::format("{} has neither cell nor point data '{}'", name, directions_.array),
                         names.empty() ? "a file with cell or point data" : "an array of the file",
                         nearest(directions_.array, names));
  }
  for (vtkIdType n = 0; of_points && n < data.GetNumberOfPoints(); ++n) addVectors(*of_points, n, directions_.nodes);
  for (vtkIdType c = 0; of_cells && c < data.GetNumberOfCells(); ++c) {
    const CellKind* of_cell = numberingOf(data.GetCellType(c)).kind;
    forEachCellList(
        [&](const CellKind& kind, std::vector<Vec3>& directions) {
          if (&kind == of_cell && kind.dimension == 3) addVectors(*of_cells, c, directions);
        },
        directions_.cells);
  }
}

void MeshVTKLoader::convert(vtkPointSet& data, const std::string& name, Mesh& mesh) {
  readDirections(data, name);
  mesh.position.resize(data.GetNumberOfPoints());
  for (std::size_t n = 0; n < mesh.position.size(); ++n) data.GetPoint(vtkIdType(n), mesh.position[n].data());
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  std::vector<Index> nodes;
  vtkDataArray* labels = findLabels(data, name);
  for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
    data.GetCellPoints(c, ids);
    nodes.clear();
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) {
      if (ids->GetId(k) < 0 || ids->GetId(k) >= data.GetNumberOfPoints())
        throw ComponentError(fmt::format("{}: cell {} names node {}, but there are {} nodes", name, c, ids->GetId(k),
                                         data.GetNumberOfPoints()));
      nodes.push_back(Index(ids->GetId(k)));
    }
    addCell(data.GetCellType(c), nodes, name, mesh);
    if (!labels) continue;
    const int label = int(labels->GetComponent(c, 0));  // of all that the cell has become
    forEachCellList([label](const CellKind&, auto& groups, const auto& cells) { groups.resize(cells.size(), label); },
                    groups_, mesh);
  }
}

void MeshVTKLoader::addCell(int type, const std::vector<Index>& n, const std::string& name, Mesh& mesh) {
  if (type == VTK_POLY_LINE) {
    for (std::size_t i = 0; i + 1 < n.size(); ++i) mesh.edges.push_back({n[i], n[i + 1]});
  } else if (type == VTK_TRIANGLE_STRIP) {
    // Every second triangle of a strip turns the other way.
    for (std::size_t i = 0; i + 2 < n.size(); ++i)
      mesh.triangles.push_back(i % 2 ? Triangle{n[i + 1], n[i], n[i + 2]} : Triangle{n[i], n[i + 1], n[i + 2]});
  } else if (type == VTK_POLYGON && n.size() != 4) {
    for (std::size_t i = 1; i + 1 < n.size(); ++i) mesh.triangles.push_back({n[0], n[i], n[i + 1]});
  } else {
    const auto [of_cell, order] = numberingOf(type == VTK_POLYGON ? VTK_QUAD : type);
    if (!of_cell || of_cell->dimension == 0) return skip(type, name);
    if (n.size() != std::size_t(of_cell->nodes))
      throw ComponentError(fmt::format("{}: a {} with {} nodes", name, of_cell->singular, n.size()),
                           fmt::format("{} nodes", of_cell->nodes));
    forEachCellList(
        [&, kind = of_cell, numbers = order](const CellKind& each, auto& cells) {
          if (&each != kind) return;
          auto& cell = cells.emplace_back();
          for (std::size_t k = 0; k < cell.size(); ++k) cell[numbers[k]] = n[k];
        },
        mesh);
  }
}

void MeshVTKLoader::skip(int type, const std::string& name) {
  const std::string kind = vtkCellTypes::GetClassNameFromTypeId(type);
  if (!vtkCellTypes::IsLinear(static_cast<unsigned char>(type)))
    throw ComponentError(fmt::format("{}: cells of kind {} are not supported", name, kind), "linear cells");
  ++skipped_[kind];
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_vtk_loader) {
  factory.add<stroma::MeshVTKLoader>("MeshVTKLoader", "reads a mesh in VTK's formats (.vtk, .vtu, .vtp)");
}
