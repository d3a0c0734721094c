// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The nodes that an attribute of a component lists, ascending and each once, by the first of their rows: of a frame
/// its centre. Throws ComponentError with a sentence that names `attribute` when the list is empty or an index lies
/// outside [0, state.nodes()).
std::vector<Index> checkedNodes(const std::vector<int>& indices, const State& state, const std::string& attribute);

/// The same, in the order of the list.
std::vector<Index> checkedNodesInOrder(const std::vector<int>& indices, const State& state,
                                       const std::string& attribute);

/// Whether a state has this node. One that follows may have its nodes from a mapping beside it, which is then ready.
bool isNode(int index, const State& state);

/// Throws as above for one index; `position` is its place in the list.
void checkNode(int index, std::size_t position, const State& state, const std::string& attribute);

/// The first rows of all nodes.
std::vector<Index> allNodes(const State& state);

/// All rows of the nodes whose first rows these are.
std::vector<Index> rowsOf(const std::vector<Index>& nodes, const State& state);

/// A list that may give one value for all: `values` becomes `count` values. Throws ComponentError when it has another
/// number of them; `attribute` and `of_what` ("springs") are for the sentence.
template <class T>
void spread(std::vector<T>& values, std::size_t count, const std::string& attribute, const std::string& of_what) {
  if (values.size() == 1) values.resize(count, T(values[0]));
  if (values.size() == count) return;
  throw ComponentError(
      attribute + " has " + std::to_string(values.size()) + " values for " + std::to_string(count) + " " + of_what,
      "1 value or " + std::to_string(count));
}

}  // namespace stroma
