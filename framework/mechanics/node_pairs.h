// SPDX-License-Identifier: LGPL-2.1-or-later
// Components that pair the nodes of two states, object1 and object2.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// Copies object1, if given, to `mstate`; call it before the component looks up its state. Throws ComponentError if
/// mstate names another state.
void setFirstState(const Link<State>& object1, Link<State>& mstate);

/// An attribute that lists nodes of a state.
struct NodeList {
  const char* attribute;
  const std::vector<int>& indices;
  const State& state;
};
/// The nodes of both lists, in their order. Throws ComponentError as checkedNodesInOrder() does, and if the lists differ
/// in length.
std::pair<std::vector<Index>, std::vector<Index>> checkedPairs(const NodeList& first, const NodeList& second);

}  // namespace stroma
