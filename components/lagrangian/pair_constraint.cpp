// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/lagrangian/pair_constraint.h"

#include <fmt/format.h>

#include "framework/scene/usual_component.h"

namespace stroma::lagrangian {

void PairConstraint::declare(DataTable& table) {
  table.addLink("object1", object1_).alias("mstate").help("state of the first points; of this node or the nearest above when not given");
  table.addLink("object2", object2_).help("state of the second points; object1 when not given");
  table.add("forces", forces_).help("forces of constraint of the last step").unit("N").output();
}

void PairConstraint::init() {
  first_ = object1_.get() ? object1_.get() : find<State>(true);
  if (!first_)
    throw ComponentError("this constraint has no mechanical state to act on",
                         "a " + usualComponent(Part::state) + " in the same node or above, or object1=\"@path\"");
  second_ = object2_.get() ? object2_.get() : first_;
  for (const State* state : {first_, second_}) {
    if (takesValues() ? state->rows_per_node == 1 && state->kindOf(0) == RowKind::value : state->hasPointsOnly()) continue;
    throw ComponentError(fmt::format("this constraint acts on {}, and {} has {}", takesValues() ? "numbers" : "points",
                                     state->path(), state->hasFrames() ? "rigid frames" : takesValues() ? "points" : "numbers"),
                         takesValues() ? "a state of numbers (template=\"Vec1\")" : "a state of points (template=\"Vec3\")",
                         state->hasFrames() ? "points that follow the frames by a RigidMapping" : "");
  }
}

void PairConstraint::checkNode(const State& state, Index node, const char* attribute) const {
  if (node < 0 || node >= state.nodes())
    throw ComponentError(fmt::format("{} names node {}, and {} has {}", attribute, node, state.path(), state.nodes()),
                         fmt::format("a node from 0 to {}", state.nodes() - 1));
}

}  // namespace stroma::lagrangian
