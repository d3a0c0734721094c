// SPDX-License-Identifier: LGPL-2.1-or-later
// Reader of Gmsh meshes: .msh formats 1, 2.2, 4.0 and 4.1 in ASCII, 2.2 and 4.1 in binary of both byte orders. Small
// and without dependencies, because opening the Gmsh library takes longer than the rest of a start.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "framework/mesh/cell_lists.h"

namespace stroma {

/// A view of the file ($NodeData, $ElementData): `width` numbers each, in the order of the mesh; zeros where the file
/// has none. Empty lists: the file has none for this kind.
struct GmshData {
  int width = 0;
  std::vector<double> nodes;
  std::array<std::vector<double>, cell_types> cells;  ///< by CellType; volume cells only
  bool repeated = false;                              ///< for several time steps; kept is the first
};

/// What a .msh file holds. Nodes are in the order of the file, whatever their tags.
struct GmshFile {
  double version = 0;
  bool binary = false;
  Mesh mesh;
  /// The physical group (tag) of each cell, 0 for none; shape as the mesh's lists.
  PerCellList<std::vector<int>> groups;
  /// Names of physical groups by (dimension, tag).
  std::map<std::pair<int, int>, std::string> group_names;
  /// Views by name; only those after the elements.
  std::map<std::string, GmshData> data;
  /// Elements that Stroma has no cell for (points, quadratic edges) and their number.
  std::map<std::string, long> skipped;
};

/// Reads the file. Throws ComponentError with a sentence and the line (ASCII) or byte (binary) when it cannot be read,
/// is cut short, names a node it does not have, or holds quadratic elements. No allocation exceeds what the size of the
/// file justifies.
GmshFile readGmsh(const std::string& file);
/// The same from memory; `name` stands for the file in messages.
GmshFile parseGmsh(std::string_view bytes, const std::string& name);

}  // namespace stroma
