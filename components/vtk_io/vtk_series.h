// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vtkUnstructuredGrid.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace stroma {

class Archive;

/// The files of a series of grids, each complete or not there at all: STEM00000.vtu, STEM00001.vtu, ... and STEM.pvd,
/// which lists them with their times and is valid after each one.
class VtkSeries {
 public:
  struct Format {
    bool xml = true;         ///< false: legacy .vtk, without a list
    bool overwrite = false;  ///< one file, STEM.vtu, instead of a series
  };

  /// `stem` without the extension of a file of VTK.
  void setUp(std::filesystem::path stem, Format format);
  /// `anew`: begins again with file 0; else the series goes on with the next number.
  void start(bool anew);
  void serialize(Archive& archive);  ///< the files so far
  void write(vtkUnstructuredGrid& grid, double time);
  /// The list, the files of the series that are there, and the first.
  std::vector<std::string> files() const;
  /// "grid-NNNNN.vtu"
  std::string pattern() const;

 private:
  std::string ending() const { return format_.xml ? ".vtu" : ".vtk"; }
  std::string contents(vtkUnstructuredGrid& grid) const;
  void writeCollection() const;

  std::filesystem::path stem_;
  Format format_;
  std::vector<std::pair<double, std::string>> written_;  ///< time [s] and name of each file
};

}  // namespace stroma
