// SPDX-License-Identifier: LGPL-2.1-or-later
// The mesh of an input file of Abaqus or CalculiX: nodes, cells and sets, as they are written.
#pragma once
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "framework/mesh/cell_lists.h"

namespace stroma {

struct AbaqusFile {
  /// A cell of the mesh: which of the lists holds it, and where.
  struct Place {
    CellType type;
    Index number;
  };
  /// Faces of cells: a set or the number of an element, and S1 to S6 or another word. Or nodes: a set or the number of one.
  struct Faces {
    std::string of, face;
    bool of_nodes = false;
  };
  Mesh mesh;
  std::unordered_map<long, Index> nodes;                             ///< by their numbers in the file
  std::unordered_map<long, Place> elements;                          ///< likewise
  std::map<std::string, std::vector<long>> node_sets, element_sets;  ///< numbers; names in capitals
  std::map<std::string, std::vector<Faces>> surfaces;
  std::vector<std::string> sections;       ///< sets that have a section, in the order of the file
  std::vector<std::string> element_lines;  ///< sets that lines *ELEMENT name, likewise
  std::map<std::string, long> skipped;     ///< elements without a counterpart, by type
  std::string moved;                       ///< instance that the assembly moves; empty: none
};

/// Throws ComponentError with file:line and a sentence.
AbaqusFile readAbaqus(const std::string& file);

/// Letters as capitals, without quotes and blanks around.
std::string abaqusName(std::string_view text);

}  // namespace stroma
