// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <unordered_map>

#include "components/topology/gmsh_reader.h"
#include "components/topology/gmsh_tags.h"

namespace stroma {

/// Reads the views of a .msh file ($NodeData and $ElementData) that stand after its elements.
class GmshViews {
 public:
  /// The tag of the next cell of a kind, in the order of the mesh.
  void addCell(CellType type, std::int64_t tag) { cell_tags_[std::size_t(type)].push_back(tag); }
  /// Reads a view from behind its first word. False for one of a width that has no use, which the caller skips.
  bool read(bool of_nodes, bool binary, GmshCursor& in, const GmshTags& nodes, std::map<std::string, GmshData>& data);

 private:
  struct Header {
    std::string name;
    std::int64_t count[3] = {0, 0, 0};  ///< time step, width, entries
  };
  static Header readHeader(GmshCursor& in);
  void prepare(bool of_nodes, std::size_t width, std::size_t nodes, GmshData& data);
  void indexCells();
  double* placeOf(bool of_nodes, std::int64_t tag, const GmshCursor& in, const GmshTags& nodes, GmshData& data) const;

  std::array<std::vector<std::int64_t>, cell_types> cell_tags_;                     ///< by CellType
  std::unordered_map<std::int64_t, std::pair<CellType, std::size_t>> cell_of_tag_;  ///< kind and number in its list
};

}  // namespace stroma
