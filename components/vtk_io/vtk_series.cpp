// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/vtk_io/vtk_series.h"

#include <fmt/format.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "framework/scene/archive.h"
#include "framework/scene/output_file.h"

namespace stroma {

void VtkSeries::setUp(std::filesystem::path stem, Format format) {
  stem_ = std::move(stem), format_ = format;
  if (stem_.extension() == ".vtu" || stem_.extension() == ".vtk" || stem_.extension() == ".pvd")
    stem_.replace_extension();
}

void VtkSeries::start(bool anew) {
  if (anew) written_.clear();
}

std::vector<std::string> VtkSeries::files() const {
  namespace fs = std::filesystem;
  std::vector<std::string> files{stem_.string() + (format_.overwrite ? "" : "00000") + ending()};
  if (format_.xml) files.push_back(stem_.string() + ".pvd");
  if (format_.overwrite) return files;
  const fs::path folder = stem_.has_parent_path() ? stem_.parent_path() : fs::path(".");
  const std::string start = stem_.filename().string();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(start) || !name.ends_with(ending())) continue;
    const std::string number = name.substr(start.size(), name.size() - start.size() - ending().size());
    if (number.size() >= 5 && number != "00000" && number.find_first_not_of("0123456789") == std::string::npos)
      files.push_back(entry.path().string());
  }
  return files;
}

void VtkSeries::serialize(Archive& archive) {
  std::size_t count = written_.size();
  archive.value("files", count);
  written_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    archive.value("time " + std::to_string(i), written_[i].first);
    archive.value("name " + std::to_string(i), written_[i].second);
  }
}

std::string VtkSeries::pattern() const {
  return fmt::format("{}{}{}", stem_.string(), format_.overwrite ? "" : "NNNNN", ending());
}

void VtkSeries::write(vtkUnstructuredGrid& grid, double time) {
  const std::string number = format_.overwrite ? "" : fmt::format("{:05}", written_.size());
  const std::filesystem::path file = stem_.string() + number + ending();
  writeWholeFile(file.string(), contents(grid));
  if (format_.overwrite) written_.clear();
  written_.emplace_back(time, file.filename().string());
  if (format_.xml) writeCollection();
}

std::string VtkSeries::contents(vtkUnstructuredGrid& grid) const {
  if (format_.xml) {
    const auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
    writer->SetInputData(&grid);
    writer->SetWriteToOutputString(true);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToNone();
    writer->Write();
    return writer->GetOutputString();
  }
  const auto writer = vtkSmartPointer<vtkUnstructuredGridWriter>::New();
  writer->SetInputData(&grid);
  writer->WriteToOutputStringOn();
  writer->SetFileTypeToBinary();
  writer->Write();
  return writer->GetOutputStdString();
}

void VtkSeries::writeCollection() const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (const auto& [time, file] : written_)
    text += fmt::format("    <DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", time, file);
  writeWholeFile(stem_.string() + ".pvd", text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace stroma
