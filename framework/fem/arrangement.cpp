// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/fem/arrangement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace stroma {
namespace {

/// Spreads the lower 21 bits of v to every third bit.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

/// An order of the elements and its blocks; block b holds order[start[b]] ... order[start[b + 1] - 1]. Slabs of two layers of
/// cells or more only touch their neighbours, so two colours do, and nearly every node's sums are finished while it is in cache.
struct Slabs {
  std::vector<Index> order;
  std::vector<std::size_t> start;
};

std::vector<Vec3> centresOf(const Index* nodes, int per_element, Index count, const std::vector<Vec3>& position) {
  std::vector<Vec3> centre(std::size_t(count), Vec3::Zero());
  for (Index e = 0; e < count; ++e) {
    for (int a = 0; a < per_element; ++a) centre[e] += position[std::size_t(nodes[e * per_element + a])];
    centre[e] /= per_element;
  }
  return centre;
}

/// Blocks of the smallest size or more, of at least two layers of a cube of as many elements (five per cell, which
/// gives fewer layers than pairs of tetrahedra or hexahedra have): slabs then only touch their neighbours.
std::size_t blockCount(Index count, int per_element) {
  const double layers = std::cbrt(double(count) / 5);
  return std::size_t(std::max(1.0, std::min(double(count) / blockElements(per_element), layers / 2.5)));
}

/// The order of the file, cut in equal pieces.
Slabs fileOrder(Index count, int per_element) {
  Slabs slabs;
  slabs.order.resize(count);
  std::iota(slabs.order.begin(), slabs.order.end(), 0);
  const std::size_t blocks = blockCount(count, per_element);
  for (std::size_t b = 0; b <= blocks; ++b) slabs.start.push_back(std::size_t(count) * b / blocks);
  return slabs;
}

Slabs geometricOrder(const Index* nodes, int per_element, Index count, const std::vector<Vec3>& position) {
  const std::vector<Vec3> centre = centresOf(nodes, per_element, count, position);
  Vec3 low = centre[0], high = centre[0];
  for (const Vec3& c : centre) low = low.cwiseMin(c), high = high.cwiseMax(c);
  int axis = 0;
  const double extent = std::max((high - low).maxCoeff(&axis), 1e-300);

  Slabs slabs = fileOrder(count, per_element);
  std::stable_sort(slabs.order.begin(), slabs.order.end(), [&](Index a, Index b) { return centre[a][axis] < centre[b][axis]; });
  std::vector<std::uint64_t> code(static_cast<std::size_t>(count));
  for (Index e = 0; e < count; ++e) {
    const Vec3 p = (centre[e] - low) / extent * double((1 << 21) - 1);
    code[e] = spread(std::uint64_t(p.x())) | spread(std::uint64_t(p.y())) << 1 | spread(std::uint64_t(p.z())) << 2;
  }
  for (std::size_t b = 0; b + 1 < slabs.start.size(); ++b)
    std::stable_sort(slabs.order.begin() + std::ptrdiff_t(slabs.start[b]), slabs.order.begin() + std::ptrdiff_t(slabs.start[b + 1]),
                     [&](Index x, Index y) { return code[x] < code[y]; });
  return slabs;
}

/// The smallest colour that no block sharing a node has; blocks in order. Nodes remember the colours around them in
/// bits (the last bit collects everything beyond 63, where a block gets a colour of its own).
std::vector<int> colourBlocks(const Slabs& slabs, const Index* nodes, int per_element, std::size_t node_count) {
  const std::vector<Index>& order = slabs.order;
  const std::size_t blocks = slabs.start.size() - 1;
  std::vector<std::uint64_t> around(node_count, 0);
  std::vector<int> colour(blocks);
  int overflow = 63;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = slabs.start[b], last = slabs.start[b + 1];
    std::uint64_t taken = 0;
    for (std::size_t i = first; i < last; ++i)
      for (int a = 0; a < per_element; ++a) taken |= around[std::size_t(nodes[order[i] * per_element + a])];
    int c = 0;
    while (c < 63 && (taken >> c & 1)) ++c;
    const std::uint64_t bit = std::uint64_t(1) << std::min(c, 63);
    colour[b] = c < 63 ? c : overflow++;
    for (std::size_t i = first; i < last; ++i)
      for (int a = 0; a < per_element; ++a) around[std::size_t(nodes[order[i] * per_element + a])] |= bit;
  }
  return colour;
}

}  // namespace

Arrangement arrangeElements(const Index* nodes, int nodes_per_element, Index count, const std::vector<Vec3>& position, int lanes) {
  Arrangement result;
  result.elements = count;
  result.block_start.push_back(0);
  result.colour_start.push_back(0);
  if (count == 0) return result;

  // A file whose pieces only touch their neighbours (a grid, a mesh numbered by layers) is as good an order as any, and
  // its nodes lie in memory as it visits them.
  Slabs slabs = fileOrder(count, nodes_per_element);
  std::vector<int> colour = colourBlocks(slabs, nodes, nodes_per_element, position.size());
  if (*std::max_element(colour.begin(), colour.end()) > 2) {
    slabs = geometricOrder(nodes, nodes_per_element, count, position);
    colour = colourBlocks(slabs, nodes, nodes_per_element, position.size());
  }
  std::vector<Index> block(colour.size());
  std::iota(block.begin(), block.end(), 0);
  std::stable_sort(block.begin(), block.end(), [&](Index a, Index b) { return colour[a] < colour[b]; });

  for (std::size_t i = 0; i < block.size(); ++i) {
    if (i > 0 && colour[block[i]] != colour[block[i - 1]]) result.colour_start.push_back(Index(i));
    const auto first = slabs.order.begin() + std::ptrdiff_t(slabs.start[block[i]]);
    const auto last = slabs.order.begin() + std::ptrdiff_t(slabs.start[block[i] + 1]);
    const std::ptrdiff_t in_block = last - first, rows = (in_block + lanes - 1) / lanes;
    for (std::ptrdiff_t b = 0; b < rows; ++b)
      for (int l = 0; l < lanes; ++l) {
        const std::ptrdiff_t at = l * rows + b;  // far apart: lanes that share nodes wait for each other's sums
        result.element.push_back(at < in_block ? first[at] : -1);
      }
    result.block_start.push_back(Index(result.element.size() / std::size_t(lanes)));
  }
  result.colour_start.push_back(Index(block.size()));
  result.batches = result.block_start.back();
  return result;
}

}  // namespace stroma
