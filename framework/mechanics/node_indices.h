// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The nodes listed by an attribute, ascending and without duplicates, as the first row of each (the centre of a frame).
/// Throws ComponentError naming `attribute` if the list is empty or an index is outside [0, state.nodes()).
std::vector<Index> checkedNodes(const std::vector<int>& indices, const State& state, const std::string& attribute);

/// The same, in the order of the list.
std::vector<Index> checkedNodesInOrder(const std::vector<int>& indices, const State& state,
                                       const std::string& attribute);

/// Whether a state has this node. A mapped state may get its nodes from a mapping in the same node, which is then initialised.
bool isNode(int index, const State& state);

/// Throws as above for one index; `position` is its place in the list.
void checkNode(int index, std::size_t position, const State& state, const std::string& attribute);

/// The first rows of all nodes.
std::vector<Index> allNodes(const State& state);

/// All rows of the nodes whose first rows these are.
std::vector<Index> rowsOf(const std::vector<Index>& nodes, const State& state);

/// Expands a list that may hold one value for all to `count` values. Throws ComponentError if the number does not fit;
/// `attribute` and `of_what` ("springs") appear in the message.
template <class T>
void spread(std::vector<T>& values, std::size_t count, const std::string& attribute, const std::string& of_what) {
  if (values.size() == 1) values.resize(count, T(values[0]));
  if (values.size() == count) return;
  throw ComponentError(
      attribute + " has " + std::to_string(values.size()) + " values for " + std::to_string(count) + " " + of_what,
      "1 value or " + std::to_string(count));
}

}  // namespace stroma
