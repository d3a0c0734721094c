// SPDX-License-Identifier: LGPL-2.1-or-later
// The check of a mesh: counts, volume, the worst cell, and what a person would want to know before a run.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_lists.h"

namespace stroma {

namespace {

/// A volume below this share of the longest edge cubed counts as flat: the cell's shape gradients then lose about
/// all digits of a double.
constexpr double flat_share = 1e-12;

void addCell(double volume, double quality, double longest_edge, MeshReport& report, Index cell) {
  report.volume += volume;
  if (std::abs(volume) <= flat_share * longest_edge * longest_edge * longest_edge)
    report.flat.push_back(cell);
  else if (volume < 0)
    report.inverted.push_back(cell);
  if (report.worst_cell < 0 || quality < report.worst_quality) report.worst_quality = quality, report.worst_cell = cell;
}

double longestEdge(const CellKind& kind, const Vec3* corner) {
  double square = 0;
  for (const auto& [i, j] : kind.edges) square = std::max(square, (corner[i] - corner[j]).squaredNorm());
  return std::sqrt(square);
}

template <class Cell>
void markUsed(const std::vector<Cell>& cells, std::vector<char>& used) {
  for (const Cell& cell : cells)
    for (Index node : cell) used[node] = 1;
}

/// "3 unused nodes (0 1 2)", at most five of them named.
std::string named(const std::vector<Index>& list, std::string_view what) {
  const std::size_t shown = std::min<std::size_t>(list.size(), 5);
  return fmt::format("{} {} ({}{})", list.size(), what,
                     fmt::join(list.begin(), list.begin() + std::ptrdiff_t(shown), " "),
                     shown < list.size() ? " ..." : "");
}

}  // namespace

MeshReport Mesh::report() const {
  MeshReport out;
  out.nodes = nodes(), out.overlap = overlap;
  forEachCellList([](const CellKind&, const auto& cells, Index& count) { count = Index(cells.size()); }, *this, out);
  Index volume_cells = 0;
  std::vector<char> used(position.size(), 0);
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        markUsed(cells, used);
        for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c) {
          const auto corner = cornersOf(cells[c], position);
          addCell(kind.size(corner.data()), kind.quality(corner.data()), longestEdge(kind, corner.data()), out,
                  volume_cells++);
        }
      },
      *this);
  out.volume /= overlap;

  for (std::size_t n = 0; n < used.size(); ++n)
    if (!used[n]) out.unused_nodes.push_back(Index(n));

  if (!position.empty()) out.low = out.high = position.front();
  for (const Vec3& p : position) out.low = out.low.cwiseMin(p), out.high = out.high.cwiseMax(p);
  return out;
}

std::string MeshReport::text() const {
  std::vector<std::string> parts{fmt::format("{} nodes", nodes)};
  Index first = 0;  // volume cell of the kind
  std::string worst;
  forEachCellList(
      [&](const CellKind& kind, Index count) {
        if (count > 0) parts.push_back(fmt::format("{} {}", count, kind.plural));
        if (kind.dimension < 3) return;
        if (worst_cell >= first && worst_cell < first + count)
          worst = fmt::format("{} {}", kind.singular, worst_cell - first);
        first += count;
      },
      *this);
  if (worst_cell >= 0) {
    parts.push_back(fmt::format("volume {:.6g} m^3", volume));
    if (overlap != 1) parts.push_back(fmt::format("cells cover the body {:g} times", overlap));
    parts.push_back(fmt::format("worst quality {:.3g} ({})", worst_quality, worst));
  }
  if (!inverted.empty()) parts.push_back(named(inverted, "inverted cells"));
  if (!flat.empty()) parts.push_back(named(flat, "flat cells"));
  if (!unused_nodes.empty()) parts.push_back(named(unused_nodes, "unused nodes"));
  parts.push_back(fmt::format("box ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g})", low.x(), low.y(), low.z(),
                              high.x(), high.y(), high.z()));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace stroma
