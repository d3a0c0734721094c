// SPDX-License-Identifier: LGPL-2.1-or-later
// The check of a mesh: counts, volume, the worst cell, and what a person would want to know before a run. Declared by the
// engine: Mesh::report(), meshComplaint().
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"
#include "tools/mesh_report/cell_quality.h"

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
  if (report.worst_cell < 0 || quality < report.worst_quality) {
    report.worst_quality = quality;
    report.worst_cell = cell;
  }
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

/// Of `keys`, those whose value another one before them has; ascending.
template <class Key>
std::vector<Index> secondOnes(std::vector<std::pair<Key, Index>> keys) {
  std::sort(keys.begin(), keys.end());
  std::vector<Index> second;
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) second.push_back(keys[i].second);
  std::sort(second.begin(), second.end());
  return second;
}

/// Volume cells are numbered through, tetrahedra first.
std::vector<Index> repeatedCells(const Mesh& mesh) {
  std::vector<Index> all;
  Index first = 0;
  forEachCellList(
      [&]<class Cell>(const CellKind& kind, const std::vector<Cell>& cells) {
        if (kind.dimension < 3) return;
        std::vector<std::pair<Cell, Index>> keys;
        keys.reserve(cells.size());
        for (Cell cell : cells) {
          std::sort(cell.begin(), cell.end());
          keys.emplace_back(cell, first++);
        }
        const std::vector<Index> second = secondOnes(std::move(keys));
        all.insert(all.end(), second.begin(), second.end());
      },
      mesh);
  return all;
}

/// Positions are distinguished to a fraction of the mesh's size that is the round-off of files with nine digits.
std::vector<Index> coincidentNodes(const Mesh& mesh, const MeshReport& box) {
  constexpr double share = 1e-8;
  const double size = (box.high - box.low).maxCoeff();
  if (!(size > 0)) return {};
  std::vector<char> used(mesh.position.size(), 0);
  forEachCellList(
      [&used](const CellKind& kind, const auto& cells) {
        for (std::size_t c = 0; kind.dimension == 3 && c < cells.size(); ++c)
          for (const Index node : cells[c]) used[std::size_t(node)] = 1;
      },
      mesh);
  std::vector<std::pair<std::array<std::int64_t, 3>, Index>> keys;
  for (std::size_t n = 0; n < used.size(); ++n) {
    if (!used[n]) continue;
    const Vec3 place = (mesh.position[n] - box.low) / (share * size);
    keys.push_back({{std::llround(place.x()), std::llround(place.y()), std::llround(place.z())}, Index(n)});
  }
  return secondOnes(std::move(keys));
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
          addCell(kind.size(corner.data()), cellQuality(kind, corner.data()), longestEdge(kind, corner.data()), out,
                  volume_cells++);
        }
      },
      *this);
  out.volume /= overlap;

  for (std::size_t n = 0; n < used.size(); ++n)
    if (!used[n]) out.unused_nodes.push_back(Index(n));

  if (!position.empty()) out.low = out.high = position.front();
  for (const Vec3& p : position) {
    out.low = out.low.cwiseMin(p);
    out.high = out.high.cwiseMax(p);
  }
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

std::string meshComplaint(const Mesh& mesh) {
  const MeshReport report = mesh.report();
  const bool no_volume = highestDimension(mesh) == 3 && !(report.volume > 0);
  std::string twice;
  if (const std::vector<Index> cells = repeatedCells(mesh); !cells.empty())
    twice = ", " + named(cells, "volume cells that are there already");
  if (const std::vector<Index> nodes = coincidentNodes(mesh, report); !nodes.empty())
    twice += ", " + named(nodes, "nodes in the place of others, which part the body unless something joins them");
  if (report.inverted.empty() && report.flat.empty() && report.unused_nodes.empty() && !no_volume && twice.empty())
    return {};
  return fmt::format("{}{}{}", no_volume ? "the mesh has no volume: " : "the mesh has faults: ", report.text(), twice);
}

}  // namespace stroma
