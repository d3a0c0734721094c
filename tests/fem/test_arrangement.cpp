// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "framework/fem/element_loop.h"

namespace stroma {
namespace {

/// Every element once, padding only at the ends of blocks, blocks of one colour without a common node.
void expectValid(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& position, int lanes) {
  const Arrangement a = arrangeElements(cells[0].data(), 4, Index(cells.size()), position, lanes);
  ASSERT_EQ(a.element.size(), std::size_t(a.batches) * std::size_t(lanes));
  std::multiset<Index> seen;
  for (Index e : a.element)
    if (e >= 0) seen.insert(e);
  ASSERT_EQ(seen.size(), cells.size());
  EXPECT_EQ(std::set<Index>(seen.begin(), seen.end()).size(), cells.size());
  ASSERT_EQ(a.colour_start.back() + 1, Index(a.block_start.size()));
  for (std::size_t c = 0; c + 1 < a.colour_start.size(); ++c) {
    std::vector<int> owner(position.size(), -1);
    for (Index block = a.colour_start[c]; block < a.colour_start[c + 1]; ++block)
      for (Index i = a.block_start[block] * lanes; i < a.block_start[block + 1] * lanes; ++i) {
        const Index e = a.element[i];
        if (e < 0) continue;
        for (Index n : cells[e]) {
          ASSERT_TRUE(owner[n] < 0 || owner[n] == block) << "colour " << c << " shares node " << n;
          owner[n] = block;
        }
      }
  }
}

TEST(Arrangement, RandomMeshes) {
  std::mt19937 random(1);
  for (int count : {1, 7, 8, 9, 16383, 16384, 30000, 100000}) {
    std::vector<Vec3> position;
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < count / 5 + 4; ++i) position.emplace_back(uniform(random), uniform(random), uniform(random));
    std::vector<Tetrahedron> cells;
    std::uniform_int_distribution<Index> node(0, Index(position.size()) - 1);
    for (int e = 0; e < count; ++e) cells.push_back({node(random), node(random), node(random), node(random)});
    for (int lanes : {2, 4, 8}) expectValid(cells, position, lanes);
  }
}

TEST(Arrangement, AllPositionsAtOnePoint) {
  const std::vector<Vec3> position(40000, Vec3(1, 1, 1));
  std::vector<Tetrahedron> cells;
  for (Index e = 0; e + 3 < 40000; ++e) cells.push_back({e, e + 1, e + 2, e + 3});
  expectValid(cells, position, 8);
}

// A chain, in which a node meets the three before and after it.
TEST(ElementLoop, PatternAndSlotsDoNotDependOnThreads) {
  constexpr Index nodes = 40000, first_row = 5;
  std::vector<Tetrahedron> cells;
  std::vector<Vec3> position;
  for (Index i = 0; i < nodes; ++i) position.emplace_back(i, 0, 0);
  for (Index e = 0; e + 3 < nodes; ++e) cells.push_back({e, e + 1, e + 2, e + 3});
  ElementLoop<4> loop;
  loop.build(cells, position, first_row);
  ASSERT_GE(loop.elements(), parallelElements(4)) << "one thread does it all";
  for (const int count : {1, 3}) {
    setThreads(count);
    BlockPattern pattern(first_row + nodes);
    loop.addPattern(pattern);
    const BlockMatrix matrix(std::move(pattern));
    const std::vector<Index> slots = loop.slots(matrix);
    setThreads(1);
    for (Index i = 0; i < nodes; ++i) {
      std::vector<Index> expected;
      for (Index j = std::max(0, i - 3); j <= std::min(nodes - 1, i + 3); ++j) expected.push_back(first_row + j);
      const auto columns = matrix.columns().begin(), start = columns + matrix.rowStart()[first_row + i];
      ASSERT_EQ(std::vector<Index>(start, columns + matrix.rowStart()[first_row + i + 1]), expected) << i;
    }
    for (Index b = 0; b < loop.batches(); ++b)
      for (int l = 0; l < pack_lanes; ++l)
        for (int ij = 0; ij < 16; ++ij) {
          const Index e = loop.elementOf(b, l);
          const Index slot = e < 0 ? 0 : matrix.slot(first_row + cells[e][ij / 4], first_row + cells[e][ij % 4]);
          ASSERT_EQ(slots[std::size_t((b * 16 + ij) * pack_lanes + l)], slot);
        }
  }
}

TEST(Arrangement, NoElements) {
  const Arrangement a = arrangeElements(nullptr, 4, 0, {}, 8);
  EXPECT_EQ(a.batches, 0);
}

}  // namespace
}  // namespace stroma
