// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/archive.h"
#include "framework/simulation/snapshots.h"

namespace stroma {

/// What the steps of a run have shown that no single state shows: for checks of the result.
class RunWatch {
 public:
  void compile(const Systems& systems);
  void reset();

  /// After a good step of system `index`, from `before`: every few steps it sees whether the velocities have turned
  /// around. Some motions turn around at every step, others at every second one: a look is at two steps.
  void look(std::size_t index, const System& system, const Snapshot& before, const StepContext& context);
  /// Velocities change sign from step to step, or every other step: from the 17th step on.
  bool isReversing(std::size_t index) const { return reversals_[index].in_a_row >= enough; }

  /// An edit or an input may have brought energy in.
  void noteWork() { worked_on_ = true; }
  bool isWorkedOn() const { return worked_on_; }

  void serialize(Archive& archive) { archive.value("worked_on", worked_on_); }
  void serialize(std::size_t index, Archive& archive);

 private:
  static constexpr int enough = 3;
  struct Reversals {
    bool turned = false;  ///< the first step of a look did
    int in_a_row = 0;     ///< looks, up to the last one, that saw velocities turn
  };
  std::vector<Reversals> reversals_;  ///< of each system
  bool worked_on_ = false;
};

/// Whether a step moves the nodes by a share of the body's size that can be seen, in the mean: what is less is
/// round-off, or soon will be.
bool movesVisibly(const System& system, double dt);

}  // namespace stroma
