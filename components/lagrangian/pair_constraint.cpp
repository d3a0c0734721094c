// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/lagrangian/pair_constraint.h"

#include <fmt/format.h>

#include "framework/mechanics/node_indices.h"
#include "framework/scene/archive.h"
#include "framework/scene/usual_component.h"

namespace stroma::lagrangian {

void PairConstraint::declare(DataTable& table) {
  table.addLink("object1", object1_)
      .alias("mstate")
      .help("state of the first nodes; of this node or the nearest above by default");
  table.addLink("object2", object2_).help("state of the second nodes; object1 by default");
  table.add("forces", forces_).help("forces of constraint of the last step; of turns and angles torques [N m]").unit("N").output();
}

void PairConstraint::declareOneState(DataTable& table) {
  table.addLink("mstate", object1_)
      .alias("object1")
      .help("state that it acts on; of this node or the nearest above by default");
  table.add("forces", forces_).help("forces of constraint of the last step; of turns and angles torques [N m]").unit("N").output();
}

void PairConstraint::init() {
  first_ = object1_.get() ? object1_.get() : find<State>(true);
  if (!first_)
    throw ComponentError("this constraint has no mechanical state to act on",
                         "a " + usualComponent(Part::state) + " in the same node or above, or object1=\"@path\"");
  second_ = object2_.get() ? object2_.get() : first_;
  checkState(*first_), checkState(*second_);
  if (first_->hasFrames() != second_->hasFrames())
    throw ComponentError(fmt::format("of {} and {} one has rigid frames and the other points", first_->path(), second_->path()),
                         "two of a kind", "points that follow the frames by a RigidMapping");
}

void PairConstraint::checkState(const State& state) const {
  if (nodes() == Nodes::values) {
    if (state.rows_per_node == 1 && state.kindOf(0) == RowKind::value) return;
    throw ComponentError(fmt::format("this constraint acts on numbers, and {} has {}", state.path(),
                                     state.hasFrames() ? "rigid frames" : "others"),
                         "a state of numbers (template=\"Vec1\")");
  }
  const bool frames = nodes() == Nodes::points_or_frames, values = nodes() == Nodes::points_or_values;
  if (state.hasPointsOnly() || (frames && state.hasFrames()) || (values && !state.hasFrames())) return;
  throw ComponentError(
      fmt::format("this constraint acts on points{}, and {} has {}", frames ? " or rigid frames" : values ? " or numbers" : "",
                  state.path(),
                  state.hasFrames() ? "rigid frames" : "numbers"),
      frames ? "a state of points or of frames (template=\"Vec3\" or \"Rigid3\")" : "a state of points (template=\"Vec3\")",
      state.hasFrames() ? "points that follow the frames by a RigidMapping" : "");
}

void PairConstraint::checkNode(const State& state, Index node, const char* attribute) const {
  if (!isNode(node, state))
    throw ComponentError(fmt::format("{} names node {}, and {} has {}", attribute, node, state.path(), state.nodes()),
                         fmt::format("a node from 0 to {}", state.nodes() - 1));
}

void PairConstraint::addTurning(const Vec3& n, Index from, Index to, double size, LagrangianRows& rows) {
  const Vec3 across = n.unitOrthogonal();
  for (const Vec3& t : {across, Vec3(n.cross(across))}) {
    rows.bend(size);
    rows.addToBend(to, t);
    if (from >= 0) rows.addToBend(from, -t);
  }
}

void PairConstraint::serialize(Archive& archive) { archive.list("forces", forces_); }

}  // namespace stroma::lagrangian
