// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "framework/fem/tetrahedron_fans.h"

namespace stroma::tetrahedron {
namespace {

/// Cells of n^3 cubes cut in five.
std::vector<Tetrahedron> cutCubes(int n) {
  const auto node = [n](int i, int j, int k) { return Index(i + (n + 1) * (j + (n + 1) * k)); };
  std::vector<Tetrahedron> cells;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int odd = (i + j + k) % 2;
        const auto corner = [&](int c) { return node(i + ((c & 1) ^ odd), j + (c >> 1 & 1), k + (c >> 2)); };
        cells.push_back({corner(0), corner(1), corner(2), corner(4)});
        cells.push_back({corner(3), corner(1), corner(2), corner(7)});
        cells.push_back({corner(5), corner(1), corner(4), corner(7)});
        cells.push_back({corner(6), corner(2), corner(4), corner(7)});
        cells.push_back({corner(1), corner(2), corner(4), corner(7)});
      }
  return cells;
}

Tetrahedron sorted(Tetrahedron cell) {
  std::sort(cell.begin(), cell.end());
  return cell;
}

/// Every cell once, each with its own nodes; an empty place repeats the fan's cell. Returns the share of empty places.
double expectFans(const std::vector<Tetrahedron>& cells, std::size_t node_count) {
  std::vector<int> seen(cells.size(), 0);
  std::size_t empty = 0, places = 0;
  for (const Fan& fan : gatherFans(cells, node_count))
    for (int i = 0; i < fan_size; ++i) {
      Tetrahedron nodes;
      for (int a = 0; a < 4; ++a) nodes[a] = fan.nodes[corner(i, a)];
      const Index e = fan.element[i];
      ++places, empty += e < 0;
      if (e >= 0) ++seen[e];
      EXPECT_EQ(sorted(nodes), sorted(cells[e >= 0 ? e : fan.element[0]]));
    }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(cells.size()));
  return double(empty) / double(std::max<std::size_t>(places, 1));
}

TEST(TetrahedronFans, CutCubesPairNearlyAll) {
  for (int n : {1, 2, 5, 10}) {
    SCOPED_TRACE(n);
    std::vector<Tetrahedron> cells = cutCubes(n);
    const std::size_t nodes = std::size_t((n + 1) * (n + 1) * (n + 1));
    // a cube alone: only one of its corners finds the middle
    EXPECT_LE(expectFans(cells, nodes), n == 1 ? 0.4 : 0.05);
    std::mt19937 random(3);
    std::shuffle(cells.begin(), cells.end(), random);
    EXPECT_LE(expectFans(cells, nodes), n == 1 ? 0.4 : 0.05);
  }
}

TEST(TetrahedronFans, CellsThatCoverABodyTwiceOrTouchNothing) {
  std::vector<Tetrahedron> twice = cutCubes(2);
  const std::vector<Tetrahedron> once = twice;
  twice.insert(twice.end(), once.begin(), once.end());
  EXPECT_LE(expectFans(twice, 27), 0.1);
  EXPECT_EQ(expectFans({{0, 1, 2, 3}, {3, 4, 5, 6}, {6, 5, 7, 8}}, 9), 0.5) << "a common edge is not a face";
  EXPECT_EQ(expectFans({}, 0), 0);
}

}  // namespace
}  // namespace stroma::tetrahedron
