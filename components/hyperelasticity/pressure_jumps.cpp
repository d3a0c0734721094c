// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/pressure_jumps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace stroma::porous {
namespace {

/// The neighbours of each node along edges, one list after the other.
struct Neighbours {
  std::vector<std::size_t> start;
  std::vector<Index> nodes;
  std::span<const Index> of(Index node) const {
    return std::span(nodes).subspan(start[std::size_t(node)], start[std::size_t(node) + 1] - start[std::size_t(node)]);
  }
};

Neighbours neighboursOf(const PorousCells& cells, std::size_t nodes) {
  std::vector<std::pair<Index, Index>> pairs;
  for (std::size_t cell = 0; cell < cells.count(); ++cell)
    for (const std::array<int, 2>& edge : cells.kind().edges) {
      const Index a = cells.nodes(cell)[std::size_t(edge[0])], b = cells.nodes(cell)[std::size_t(edge[1])];
      pairs.emplace_back(a, b), pairs.emplace_back(b, a);
    }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Neighbours out;
  out.start.assign(nodes + 1, 0);
  for (const auto& [from, to] : pairs) ++out.start[std::size_t(from) + 1], out.nodes.push_back(to);
  for (std::size_t i = 0; i < nodes; ++i) out.start[i + 1] += out.start[i];
  return out;
}

}  // namespace

PressureJump pressureJump(const PorousCells& cells, const std::vector<double>& pressure, const std::vector<char>& drained) {
  constexpr double much = 0.1;    // of the largest pressure
  constexpr double nearly = 0.3;  // of the jump, for neighbours that are about as high or as low
  const Neighbours neighbours = neighboursOf(cells, pressure.size());
  double largest = 0;
  for (const double each : pressure) largest = std::max(largest, std::abs(each));
  const auto isEnd = [&](Index node, double sign, double jump) {
    const double here = sign * pressure[std::size_t(node)];
    return std::ranges::all_of(neighbours.of(node), [&](Index other) {
      return drained[std::size_t(other)] || sign * pressure[std::size_t(other)] <= here + nearly * jump;
    });
  };
  const auto touchesDrained = [&](Index node) {
    return std::ranges::any_of(neighbours.of(node), [&](Index other) { return drained[std::size_t(other)] != 0; });
  };
  PressureJump most;
  for (std::size_t i = 0; i < pressure.size(); ++i) {
    const Index a = Index(i);
    const double sign = pressure[i] < 0 ? -1 : 1;
    if (drained[i] || !touchesDrained(a)) continue;
    for (const Index b : neighbours.of(a)) {
      const double jump = sign * (pressure[i] - pressure[std::size_t(b)]);
      const bool is_more = jump > much * largest && jump > std::abs(most.here - most.beneath);
      if (drained[std::size_t(b)] || touchesDrained(b) || !is_more) continue;
      const auto goesOn = [&](Index c) {
        return c != a && !drained[std::size_t(c)] && !touchesDrained(c) &&
               sign * (pressure[std::size_t(c)] - pressure[std::size_t(b)]) > nearly * jump;
      };
      if (isEnd(a, sign, jump) && isEnd(b, -sign, jump) && std::ranges::any_of(neighbours.of(b), goesOn))
        most = {a, pressure[i], pressure[std::size_t(b)]};
    }
  }
  return most;
}

}  // namespace stroma::porous
