// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "framework/mesh/cell_lists.h"

namespace stroma {

namespace {

template <class Cell>
std::string firstCellError(const std::vector<Cell>& cells, std::string_view word, Index nodes) {
  for (std::size_t c = 0; c < cells.size(); ++c) {
    Cell sorted = cells[c];
    std::sort(sorted.begin(), sorted.end());
    if (sorted.front() < 0 || sorted.back() >= nodes)
      return fmt::format("{} {} names node {}, but the mesh has {} nodes (0 to {})", word, c,
                         sorted.front() < 0 ? sorted.front() : sorted.back(), nodes, nodes - 1);
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) return fmt::format("{} {} names node {} twice", word, c, *twice);
  }
  return {};
}

}  // namespace

std::string Mesh::firstError() const {
  if (position.size() > std::size_t(std::numeric_limits<Index>::max()))
    return fmt::format("{} nodes are more than a 32-bit index can name", position.size());
  for (std::size_t n = 0; n < position.size(); ++n)
    if (!position[n].allFinite())
      return fmt::format("the position of node {} is not finite: {} {} {}", n, position[n].x(), position[n].y(), position[n].z());
  std::string error;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        if (error.empty()) error = firstCellError(cells, kind.singular, nodes());
      },
      *this);
  return error;
}

}  // namespace stroma
