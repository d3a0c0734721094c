// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/archive.h"
#include "framework/simulation/snapshots.h"

namespace stroma {

/// Watches a run for signs of a wrong result that no single state shows.
class RunWatch {
 public:
  void compile(const Systems& systems);
  void reset();

  /// Called after a successful step of system `index` that started at `before`. Every few steps it checks whether velocities have
  /// reversed. Some motions reverse in every step, others in every second one, so each check covers two steps.
  void look(std::size_t index, const System& system, const Snapshot& before, const StepContext& context);
  /// Velocities change sign in every step, or in every other one: from the 17th step on.
  bool isReversing(std::size_t index) const { return reversals_[index].in_a_row >= enough; }

  /// An edit or an input may have added energy.
  void noteWork() { worked_on_ = true; }
  bool isWorkedOn() const { return worked_on_; }

  void serialize(Archive& archive) { archive.value("worked_on", worked_on_); }
  void serialize(std::size_t index, Archive& archive);

 private:
  static constexpr int enough = 3;
  struct Reversals {
    bool turned = false;  ///< velocities reversed in the first step of a check
    int in_a_row = 0;     ///< consecutive checks, up to the last one, that found reversals
  };
  std::vector<Reversals> reversals_;  ///< per system
  bool worked_on_ = false;
};

/// Whether the mean motion of the nodes in a step is a visible fraction of the body size: anything less is round-off, or
/// soon will be.
bool movesVisibly(const System& system, double dt);

}  // namespace stroma
