// SPDX-License-Identifier: LGPL-2.1-or-later
// The program that reads segmented images through VTK: NIfTI (.nii, .nii.gz), MetaImage (.mhd, .mha) and VTK's XML image
// data (.vti). tools/mesh/label_image_file.cpp takes what it hands over.
//
// Where the voxels lie is taken from the file: of NIfTI the sform when it is given, else the qform (both map to the
// scanner's right-anterior-superior axes), of MetaImage and .vti origin, spacing and direction.
#include <fmt/format.h>
#include <sys/stat.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkLogger.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkMetaImageReader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLImageDataReader.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <sstream>

#include "framework/scene/diagnostics.h"
#include "framework/scene/reader_process.h"
#include "tools/mesh/label_image.h"

namespace stroma {
namespace {

namespace fs = std::filesystem;

/// How much memory reading takes for each byte of a file: labels shrink by a thousand when they are compressed, and
/// there are a few copies of each.
constexpr double memory_of_compressed = 8 * 1100;

/// Keeps what VTK would print.
class CapturedOutput : public vtkOutputWindow {
 public:
  static CapturedOutput* New();
  vtkTypeMacro(CapturedOutput, vtkOutputWindow);
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

/// Keeps what VTK's reader of MetaImages prints past VTK's own messages: only there does it say that data are missing.
class CapturedStreams {
 public:
  CapturedStreams() : out_(std::cout.rdbuf(text_.rdbuf())), err_(std::cerr.rdbuf(text_.rdbuf())) {}
  ~CapturedStreams() { std::cout.rdbuf(out_), std::cerr.rdbuf(err_); }
  CapturedStreams(const CapturedStreams&) = delete;
  CapturedStreams& operator=(const CapturedStreams&) = delete;
  std::string firstLine() const { return text_.str().substr(0, text_.str().find('\n')); }

 private:
  std::ostringstream text_;
  std::streambuf *out_, *err_;
};

/// An image as VTK gives it, and the affine map from VTK's positions to the scanner's.
struct VtkImage {
  vtkSmartPointer<vtkImageData> data;
  std::optional<Mat3> direction;  ///< instead of VTK's
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

VtkImage readNifti(const std::string& file) {
  const auto reader = vtkSmartPointer<vtkNIFTIImageReader>::New();
  if (!reader->CanReadFile(file.c_str())) throw ComponentError(fmt::format("{} is not a NIfTI file", file));
  reader->SetFileName(file.c_str());
  reader->Update();
  if (reader->GetTimeDimension() > 1)
    throw ComponentError(fmt::format("{} holds {} volumes", file, reader->GetTimeDimension()), "one segmented volume");
  VtkImage image;
  image.data = reader->GetOutput();
  if (vtkMatrix4x4* m = reader->GetSFormMatrix() ? reader->GetSFormMatrix() : reader->GetQFormMatrix())
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) image.linear(i, k) = m->GetElement(i, k);
      image.shift[i] = m->GetElement(i, 3);
    }
  return image;
}

template <class Reader>
VtkImage readWith(const std::string& file, const char* kind) {
  const auto reader = vtkSmartPointer<Reader>::New();
  if (!reader->CanReadFile(file.c_str())) throw ComponentError(fmt::format("{} is not a {} file", file, kind));
  reader->SetFileName(file.c_str());
  reader->Update();
  VtkImage image;
  image.data = reader->GetOutput();
  return image;
}

/// VTK's reader leaves out the directions of the axes: three numbers per axis in the text at the top of the file.
VtkImage readMetaImage(const std::string& file) {
  VtkImage image = readWith<vtkMetaImageReader>(file, "MetaImage");
  std::ifstream stream(file, std::ios::binary);
  for (std::string line; std::getline(stream, line) && !line.starts_with("ElementDataFile");) {
    std::istringstream words(line);
    std::string key, equals;
    words >> key >> equals;
    if (key != "TransformMatrix" && key != "Orientation" && key != "Rotation") continue;
    Mat3 direction;
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 3; ++i) words >> direction(i, axis);
    if (!words) throw ComponentError(fmt::format("{}: {} has not nine numbers", file, key));
    image.direction = direction;
  }
  return image;
}

VtkImage readFile(const std::string& file) {
  const auto ends = [&file](std::string_view suffix) { return file.ends_with(suffix); };
  if (ends(".nii") || ends(".nii.gz")) return readNifti(file);
  if (ends(".mhd") || ends(".mha")) return readMetaImage(file);
  if (ends(".vti")) return readWith<vtkXMLImageDataReader>(file, "VTK image");
  throw ComponentError(fmt::format("the format of {} is not known from its name", file),
                       "an image .nii, .nii.gz, .mhd, .mha or .vti, or a closed surface .obj, .stl, .vtk or .vtp");
}

void placeVoxels(const VtkImage& from, LabelImage& image) {
  int size[3], extent[6];
  from.data->GetDimensions(size);
  from.data->GetExtent(extent);
  const double *origin = from.data->GetOrigin(), *spacing = from.data->GetSpacing();
  Mat3 direction;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) direction(i, k) = from.data->GetDirectionMatrix()->GetElement(i, k);
  if (from.direction) direction = *from.direction;
  image.size = {size[0], size[1], size[2]};
  image.steps = from.linear * direction * Vec3(spacing[0], spacing[1], spacing[2]).asDiagonal();
  image.origin = from.linear * Vec3(origin[0], origin[1], origin[2]) + from.shift +
                 image.steps * Vec3(extent[0], extent[2], extent[4]);
  if (!(std::abs(image.steps.determinant()) > 0) || !image.steps.allFinite() || !image.origin.allFinite())
    throw ComponentError("the image's spacing or axes span no volume");
}

/// The labels that occur, ascending; throws when these are not labels.
std::vector<int> labelsOf(vtkDataArray& values, const std::string& file) {
  constexpr std::size_t most = 256;
  std::set<double> found;
  double last = std::nan("");
  for (vtkIdType i = 0; i < values.GetNumberOfTuples() && found.size() <= most; ++i)
    if (const double value = values.GetComponent(i, 0); value != last) found.insert(last = value);
  const auto refuse = [&](const std::string& why) {
    throw ComponentError(fmt::format("{} is not a segmented image: {}", file, why),
                         "one small whole number a voxel, 0 outside");
  };
  if (found.size() > most) refuse(fmt::format("more than {} different values", most));
  for (const double value : found)
    if (value != std::floor(value) || value < 0 || value > 1e6)
      refuse(fmt::format("the value {} is {}", value, value < 0 ? "negative" : "not a label"));
  found.erase(0);
  if (found.empty()) refuse("every voxel is 0");
  if (found.size() > 255) refuse(fmt::format("{} labels besides 0, and 255 are the most", found.size()));
  return {found.begin(), found.end()};
}

LabelImage convert(const VtkImage& raw, const std::string& file) {
  vtkDataArray* values = raw.data ? raw.data->GetPointData()->GetScalars() : nullptr;
  // .vti writers often name no active scalars
  if (!values && raw.data && raw.data->GetPointData()->GetNumberOfArrays() == 1)
    values = raw.data->GetPointData()->GetArray(0);
  if (!values || values->GetNumberOfTuples() == 0)
    throw ComponentError(fmt::format("{} has no voxel values", file), "one array of point data, a label a voxel");
  if (values->GetNumberOfComponents() != 1)
    throw ComponentError(fmt::format("{} has {} values a voxel", file, values->GetNumberOfComponents()), "one label");
  LabelImage image;
  placeVoxels(raw, image);
  image.values = labelsOf(*values, file);
  std::vector<std::uint8_t> region_of(std::size_t(image.values.back()) + 1, 0);
  for (std::size_t i = 0; i < image.values.size(); ++i) region_of[image.values[i]] = std::uint8_t(i + 1);
  image.region.resize(values->GetNumberOfTuples());
  for (std::size_t i = 0; i < image.region.size(); ++i)
    image.region[i] = region_of[std::size_t(values->GetComponent(vtkIdType(i), 0))];
  return image;
}

/// Of the file, and of the one beside it that a MetaImage names.
double bytesOf(const std::string& file) {
  const auto sizeOf = [](const fs::path& path) {
    std::error_code none;
    const auto size = fs::file_size(path, none);
    return none ? 0. : double(size);
  };
  double bytes = sizeOf(file);
  std::ifstream stream(file, std::ios::binary);
  for (std::string key, equals, value; file.ends_with(".mhd") && stream >> key >> equals;) {
    std::getline(stream >> std::ws, value);
    if (key == "ElementDataFile") bytes += sizeOf(fs::path(file).parent_path() / value.substr(0, value.find('\r')));
  }
  return bytes;
}

ValueLists readImage(const std::string& file, const Texts&) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) throw ComponentError(fmt::format("there is no file {}", file));
  if (!S_ISREG(status.st_mode)) throw ComponentError(fmt::format("{} is not a file", file), "an image");
  limitReader(bytesOf(file), memory_of_compressed);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // a second way to the terminal
  const auto window = vtkSmartPointer<CapturedOutput>::New();
  vtkOutputWindow::SetInstance(window);
  std::string printed;
  const VtkImage raw = [&] {
    const CapturedStreams streams;
    VtkImage image = readFile(file);
    printed = streams.firstLine();
    return image;
  }();
  if (window->hasError()) throw ComponentError(fmt::format("{} cannot be read; VTK says: {}", file, window->message()));
  if (!printed.empty()) throw ComponentError(fmt::format("{} cannot be read; VTK says: {}", file, printed));
  const LabelImage image = convert(raw, file);
  ValueLists lists;
  lists.add("size", Integers(image.size.begin(), image.size.end()));
  lists.add("origin", Reals(image.origin.begin(), image.origin.end()));
  lists.add("steps", Reals(image.steps.data(), image.steps.data() + 9));
  lists.add("values", Integers(image.values.begin(), image.values.end()));
  lists.add("region", Texts{{image.region.begin(), image.region.end()}});
  return lists;
}

}  // namespace
}  // namespace stroma

int main(int argc, char** argv) { return stroma::runReader(argc, argv, stroma::readImage); }
