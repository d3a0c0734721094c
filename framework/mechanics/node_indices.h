// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// The nodes that an attribute of a component lists, ascending and each once. Throws ComponentError with a sentence
/// that names `attribute` when the list is empty or an index lies outside [0, state.size()).
std::vector<Index> checkedNodes(const std::vector<int>& indices, const State& state, const std::string& attribute);

/// Throws as above for one index; `position` is its place in the list.
void checkNode(int index, std::size_t position, const State& state, const std::string& attribute);

}  // namespace stroma
