// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/fem/arrangement.h"

#include <algorithm>
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

std::vector<Index> mortonOrder(const Index* nodes, int per_element, Index count, const std::vector<Vec3>& position) {
  Vec3 low = position[std::size_t(nodes[0])], high = low;
  std::vector<Vec3> centre(std::size_t(count), Vec3::Zero());
  for (Index e = 0; e < count; ++e) {
    for (int a = 0; a < per_element; ++a) centre[std::size_t(e)] += position[std::size_t(nodes[e * per_element + a])];
    centre[std::size_t(e)] /= per_element;
    low = low.cwiseMin(centre[std::size_t(e)]);
    high = high.cwiseMax(centre[std::size_t(e)]);
  }
  const double extent = std::max((high - low).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> code(static_cast<std::size_t>(count));
  for (Index e = 0; e < count; ++e) {
    const Vec3 p = (centre[std::size_t(e)] - low) / extent * double((1 << 21) - 1);
    code[std::size_t(e)] =
        spread(std::uint64_t(p.x())) | spread(std::uint64_t(p.y())) << 1 | spread(std::uint64_t(p.z())) << 2;
  }
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return code[std::size_t(a)] < code[std::size_t(b)]; });
  return order;
}

/// The smallest colour that no block sharing a node has; blocks in order. Nodes remember the colours around them in
/// bits (the last bit collects everything beyond 63, where a block gets a colour of its own).
std::vector<int> colourBlocks(const std::vector<Index>& order, const Index* nodes, int per_element,
                              std::size_t node_count) {
  const std::size_t blocks = (order.size() + block_elements - 1) / block_elements;
  std::vector<std::uint64_t> around(node_count, 0);
  std::vector<int> colour(blocks);
  int overflow = 63;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = b * block_elements, last = std::min(order.size(), first + block_elements);
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

Arrangement arrangeElements(const Index* nodes, int nodes_per_element, Index count, const std::vector<Vec3>& position,
                            int lanes) {
  Arrangement result;
  result.elements = count;
  result.block_start.push_back(0);
  result.colour_start.push_back(0);
  if (count == 0) return result;

  std::vector<Index> order;
  if (count <= block_elements) {
    order.resize(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
  } else {
    order = mortonOrder(nodes, nodes_per_element, count, position);
  }
  const std::vector<int> colour = colourBlocks(order, nodes, nodes_per_element, position.size());
  std::vector<Index> block(colour.size());
  std::iota(block.begin(), block.end(), 0);
  std::stable_sort(block.begin(), block.end(),
                   [&](Index a, Index b) { return colour[std::size_t(a)] < colour[std::size_t(b)]; });

  for (std::size_t i = 0; i < block.size(); ++i) {
    if (i > 0 && colour[std::size_t(block[i])] != colour[std::size_t(block[i - 1])])
      result.colour_start.push_back(Index(i));
    const std::size_t first = std::size_t(block[i]) * block_elements;
    const std::size_t last = std::min(order.size(), first + block_elements);
    result.element.insert(result.element.end(), order.begin() + std::ptrdiff_t(first),
                          order.begin() + std::ptrdiff_t(last));
    while (result.element.size() % std::size_t(lanes)) result.element.push_back(-1);
    result.block_start.push_back(Index(result.element.size() / std::size_t(lanes)));
  }
  result.colour_start.push_back(Index(block.size()));
  result.batches = result.block_start.back();
  return result;
}

}  // namespace stroma
