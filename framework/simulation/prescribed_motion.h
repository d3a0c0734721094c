// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/actors.h"
#include "framework/simulation/node_groups.h"
#include "framework/simulation/shared_placements.h"
#include "framework/simulation/step.h"

namespace stroma {

/// The nodes moved by constraints: their velocity during a step and their position at its end.
class PrescribedMotion {
 public:
  PrescribedMotion(const Actors& actors, const NodeGroups& groups);
  /// Reserves room for `count` projectors, so that a motion that begins later allocates nothing.
  void reserve(std::size_t count);

  // ---- which nodes: clear(), add() for each active constraint, finish() ----
  void clear();
  void add(std::size_t constraint, double t_end);
  void finish();
  bool empty() const { return moving_.empty(); }

  /// Gives constrained directions the constant velocity that takes them to the positions of prescribe() at the end of the step.
  /// Nodes that follow others aim at where the current velocity takes those.
  void aim(const StepContext& context, ConstRows x, Rows v);
  /// Writes positions and velocities at time t [s] of everything with a prescribed motion in this step.
  void place(const StepContext& context, double t, Rows x, Rows v) const;
  /// Throws ComponentError if prescribed positions of fixed nodes conflict; `start`: the time [s] before the first step.
  void check(double start, ConstRows x, ConstRows v);
  /// Empty, or a sentence that says which prescribed positions of a node conflict in this step.
  const std::string& misplaced() const { return misplaced_; }
  void forgetMisplaced() { misplaced_.clear(); }

 private:
  void placeOnce(const StepContext& context, double t, Rows x, Rows v) const;
  void placeGroups(Rows x, Rows v) const;
  std::string describeConflict(const SharedPlacements::Conflict& conflict) const;

  const Actors& actors_;
  const NodeGroups& groups_;
  std::vector<NodeProjector> moving_;  ///< sorted by row, at most one per row
  std::vector<NodeProjector> placed_;  ///< the same without the rows that only follow their group
  mutable SharedPlacements shared_;    ///< nodes with more than one prescribed motion
  mutable std::string misplaced_;
  Vector target_x_, target_v_;  ///< work space, shape (all rows)
};

}  // namespace stroma
