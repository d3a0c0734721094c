// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies at rest are not computed until something changes.
//
//   falls asleep   if no node has moved farther than sleepDistance/2 from a fixed point for sleepTime, in steps that were all solved;
//                  the body stays where it is, with zero velocity
//   sleeps         while x and v are unchanged to round-off, and so are the positions of nodes with a prescribed motion, the active
//                  constraints, and the force at (x, 0)
//   wakes          in the step in which one of these changes, after any edit, and by an input
//
// Forces are computed in a skipped step only if something other than x can change them: time, an input, a state of another
// system, internal state or lagged quantities, or a field without traits. Everything else needs an edit, which wakes the body. Bodies
// in contact are one system and sleep together. A body that vibrates or creeps within sleepTime comes to rest within
// sleepDistance of where it sleeps. One that creeps more slowly does not: its sleepTime is too short. Multistep integrators store
// a history at rest after a skipped step.
#pragma once
#include <cstdint>
#include <string>

#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

class Sleep {
 public:
  void declare(DataTable& table);
  /// Throws ComponentError if steps change more than forces determine.
  void compile(System& system);
  bool isOn() const { return distance_ > 0; }
  /// Called at the start of a step: true if the body sleeps through it. x and v are then those of its end.
  bool passesOver(const StepContext& context);
  /// The report of a step that was not skipped: without a solution a body that does not move is not at rest.
  StepReport judged(StepReport report);
  /// Called after an accepted step; true if it was skipped.
  bool stepTaken(double dt);
  void wake() { is_asleep_ = passed_ = has_start_ = false, elapsed_ = 0; }
  void reset() { wake(), steps_asleep_ = 0; }
  void serialize(Archive& archive);
  std::string describe() const;

 private:
  bool isUndisturbed(const StepContext& context);
  void fallAsleep();

  System* system_ = nullptr;
  double distance_ = 0, time_ = 1;
  int steps_asleep_ = 0;
  bool is_asleep_ = false;
  bool is_still_ = false;    ///< v = 0 since a step of this sleep
  bool passed_ = false;      ///< the current step is skipped
  bool is_solved_ = true;    ///< the current step, by the report of judged()
  bool looks_ = false;       ///< something other than x, v and edits changes forces
  bool had_inputs_ = false;  ///< when it fell asleep
  bool has_start_ = false;   ///< start_ is set
  double elapsed_ = 0;       ///< [s] since start_
  std::uint64_t held_ = 0;   ///< its constraints when it fell asleep
  Vector start_;             ///< reference positions, shape (all rows), as the following
  Vector place_, force_;     ///< x and f of its sleep
  Vector zero_, work_;
};

}  // namespace stroma
