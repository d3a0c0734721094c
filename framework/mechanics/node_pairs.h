// SPDX-License-Identifier: LGPL-2.1-or-later
// Components that pair the nodes of two states, object1 and object2.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// object1, where it is given, becomes what `mstate` names: before the component looks for its state. Throws
/// ComponentError when mstate names another one.
void setFirstState(const Link<State>& object1, Link<State>& mstate);

/// An attribute that lists nodes of a state.
struct NodeList {
  const char* attribute;
  const std::vector<int>& indices;
  const State& state;
};
/// The nodes of both lists, in their order, as many of each. Throws ComponentError as checkedNodesInOrder(), and when
/// one list is longer.
std::pair<std::vector<Index>, std::vector<Index>> checkedPairs(const NodeList& first, const NodeList& second);

}  // namespace stroma
