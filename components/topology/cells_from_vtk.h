// SPDX-License-Identifier: LGPL-2.1-or-later
// What the program read_vtk_mesh hands over, and cells in VTK's numbering turned into ours.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "framework/mesh/cell_lists.h"
#include "framework/scene/value_lists.h"

namespace stroma {

/// Numbers of each cell or node.
struct VtkArray {
  bool found = false;
  std::size_t width = 0;  ///< numbers of each
  Reals values;
};

/// A mesh as VTK gives it: lists that fit each other and nodes that exist, whatever the file says.
class VtkMesh {
 public:
  /// `name` is the file's, for messages. Throws ComponentError.
  VtkMesh(const ValueLists& lists, std::string name);

  std::vector<Vec3> position;
  VtkArray labels, cell_directions, point_directions, cell_values;
  Texts cell_arrays, point_arrays;  ///< names of all arrays of the file

  std::size_t cells() const { return types_.size(); }
  /// The kind of a cell, null for others.
  const CellKind* kindOfCell(std::size_t cell) const;
  /// Adds the cells to `mesh`, and to `groups` the label of each, when `label_of_cell` is not empty. Returns how many
  /// cells of which of VTK's kinds are left out.
  std::map<std::string, long> addCells(const std::vector<int>& label_of_cell, Mesh& mesh,
                                       PerCellList<std::vector<int>>& groups) const;

 private:
  VtkArray arrayOf(const ValueLists& lists, const std::string& list, std::size_t entries) const;
  void addCell(int type, const std::vector<Index>& nodes, Mesh& mesh, std::map<std::string, long>& skipped) const;
  void skip(int type, std::map<std::string, long>& skipped) const;
  [[noreturn]] void fail(const std::string& why) const;

  std::string name_;
  Integers types_, offsets_, nodes_;
  std::map<int, std::pair<std::string, bool>> kinds_;  ///< VTK's word for a number, and whether the kind is linear
};

}  // namespace stroma
