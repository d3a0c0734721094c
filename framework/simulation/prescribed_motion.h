// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/actors.h"
#include "framework/simulation/node_groups.h"
#include "framework/simulation/shared_placements.h"
#include "framework/simulation/step.h"

namespace stroma {

/// The nodes that constraints move: their velocity in a step and their place at its end.
class PrescribedMotion {
 public:
  PrescribedMotion(const Actors& actors, const NodeGroups& groups);
  /// Room for `count` projectors, so that a motion that begins later allocates nothing.
  void reserve(std::size_t count);

  // ---- which nodes: clear(), add() for each constraint that is active, finish() ----
  void clear();
  void add(std::size_t constraint, double t_end);
  void finish();
  bool empty() const { return moving_.empty(); }

  /// Gives the held directions the constant velocity that reaches the end of the step where prescribe() wants them. What
  /// follows other nodes is aimed at where their present velocity takes them.
  void aim(const StepContext& context, ConstRows x, Rows v);
  /// Writes positions and velocities at time t [s] of what has a prescribed motion in this step.
  void place(const StepContext& context, double t, Rows x, Rows v) const;
  /// Throws ComponentError if fixed nodes have conflicting positions; `start`: the time [s] before the first step.
  void check(double start, ConstRows x, ConstRows v);
  /// Empty, or a sentence: prescribed positions of a node conflict in this step.
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
  mutable SharedPlacements shared_;    ///< of nodes with more than one prescribed motion
  mutable std::string misplaced_;
  Vector target_x_, target_v_;  ///< work space, shape (all rows)
};

}  // namespace stroma
