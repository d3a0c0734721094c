// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/scene/data.h"

namespace stroma {

/// Declares a list of cells under the kind's name and alias ("tetrahedra", "tetras").
template <class Cell>
Data& addCellList(DataTable& table, const CellKind& kind, std::vector<Cell>& cells) {
  Data& data = table.add(std::string(kind.plural), cells);
  if (!kind.alias.empty()) data.alias(std::string(kind.alias));
  if (kind.type == CellType::prism) data.alias("pentas");
  return data;
}

}  // namespace stroma
