// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/node_indices.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "framework/mechanics/mapping.h"

namespace stroma {

bool isNode(int index, const State& state) {
  if (index < state.nodes()) return index >= 0;
  for (const auto& beside : state.node().components())
    if (dynamic_cast<Mapping*>(beside.get())) beside->ensureReady();
  return index < state.nodes();
}

void checkNode(int index, std::size_t position, const State& state, const std::string& attribute) {
  if (isNode(index, state)) return;
  throw ComponentError(fmt::format("{}[{}] is {}, and {} has {} nodes", attribute, position, index, state.path(), state.nodes()),
                       fmt::format("indices in 0 ... {}", state.nodes() - 1));
}

std::vector<Index> checkedNodesInOrder(const std::vector<int>& indices, const State& state, const std::string& attribute) {
  if (indices.empty())
    throw ComponentError(fmt::format("{} lists no node of {}", attribute, state.path()), "at least one node",
                         "if a selection is linked here, check that its box or sphere contains nodes");
  for (std::size_t i = 0; i < indices.size(); ++i) checkNode(indices[i], i, state, attribute);
  std::vector<Index> nodes(indices.begin(), indices.end());
  for (Index& node : nodes) node *= state.rows_per_node;
  return nodes;
}

std::vector<Index> checkedNodes(const std::vector<int>& indices, const State& state, const std::string& attribute) {
  std::vector<Index> nodes = checkedNodesInOrder(indices, state, attribute);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<Index> allNodes(const State& state) {
  std::vector<Index> nodes(std::size_t(state.nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  for (Index& node : nodes) node *= state.rows_per_node;
  return nodes;
}

std::vector<Index> rowsOf(const std::vector<Index>& nodes, const State& state) {
  std::vector<Index> rows;
  for (const Index node : nodes)
    for (Index k = 0; k < state.rows_per_node; ++k) rows.push_back(node + k);
  return rows;
}

}  // namespace stroma
