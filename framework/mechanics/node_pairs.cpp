// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/node_pairs.h"

#include <fmt/format.h>

#include "framework/mechanics/node_indices.h"

namespace stroma {

void setFirstState(const Link<State>& object1, Link<State>& mstate) {
  if (!object1.target()) return;
  if (mstate.target() && mstate.target() != object1.target())
    throw ComponentError("mstate and object1 name different states", "one of them");
  mstate.set(object1.target());
}

std::pair<std::vector<Index>, std::vector<Index>> checkedPairs(const NodeList& first, const NodeList& second) {
  std::pair pairs(checkedNodesInOrder(first.indices, first.state, first.attribute),
                  checkedNodesInOrder(second.indices, second.state, second.attribute));
  if (pairs.first.size() != pairs.second.size())
    throw ComponentError(fmt::format("{} has {} nodes and {} {}", first.attribute, pairs.first.size(), second.attribute,
                                     pairs.second.size()), "as many of each");
  return pairs;
}

}  // namespace stroma
