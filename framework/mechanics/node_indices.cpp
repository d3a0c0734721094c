// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/node_indices.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace stroma {

void checkNode(int index, std::size_t position, const State& state, const std::string& attribute) {
  if (index >= 0 && index < state.size()) return;
  throw ComponentError(
      fmt::format("{}[{}] is {}, and {} has {} nodes", attribute, position, index, state.path(), state.size()),
      fmt::format("indices in 0 ... {}", state.size() - 1));
}

std::vector<Index> checkedNodesInOrder(const std::vector<int>& indices, const State& state,
                                       const std::string& attribute) {
  if (indices.empty())
    throw ComponentError(fmt::format("{} lists no node of {}", attribute, state.path()), "at least one node",
                         "when a selection is linked here, check that its box or sphere holds nodes");
  for (std::size_t i = 0; i < indices.size(); ++i) checkNode(indices[i], i, state, attribute);
  return {indices.begin(), indices.end()};
}

std::vector<Index> checkedNodes(const std::vector<int>& indices, const State& state, const std::string& attribute) {
  std::vector<Index> nodes = checkedNodesInOrder(indices, state, attribute);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<Index> allNodes(const State& state) {
  std::vector<Index> nodes(std::size_t(state.size()));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

}  // namespace stroma
