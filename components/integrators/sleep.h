// SPDX-License-Identifier: LGPL-2.1-or-later
// A body that lies still is not computed until something changes.
//
//   falls asleep   when no node was farther than sleepDistance/2 from one place for sleepTime, in steps that all had a solution; it
//                  stays where it is, without speed
//   sleeps         x and v are what they were to round-off, and so are the places of nodes with a prescribed motion, what holds the
//                  others, and the force at (x, 0)
//   wakes          in the step in which one of these is not so, after any edit, and by an input
//
// Forces are computed again in each step only where something else than x can change them: time, an input, a state of another
// system, what a step remembers or lags, and a field that promises nothing. All else comes with an edit, which wakes it. Bodies
// that touch each other have one system, and sleep together. What swings or creeps within sleepTime comes to rest within
// sleepDistance of where it sleeps. What creeps more slowly does not: its sleepTime is too short. An integrator that remembers
// steps remembers those of a body at rest after one that it passed over.
#pragma once
#include <cstdint>
#include <string>

#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

class Sleep {
 public:
  void declare(DataTable& table);
  /// Throws ComponentError where steps do more than forces say.
  void compile(System& system);
  bool isOn() const { return distance_ > 0; }
  /// At the start of a step: true when the body sleeps through it. x and v are then those of its end.
  bool passesOver(const StepContext& context);
  /// A step that was not passed over: what has no solution does not move for that alone, and is not at rest.
  StepReport judged(StepReport report);
  /// Of a step that stands; true when it was passed over.
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
  bool passed_ = false;      ///< the step under way
  bool is_solved_ = true;    ///< the step under way, by what judged() was told
  bool looks_ = false;       ///< something else than x, v and edits changes forces
  bool had_inputs_ = false;  ///< when it fell asleep
  bool has_start_ = false;   ///< start_ is set
  double elapsed_ = 0;       ///< [s] since start_
  std::uint64_t held_ = 0;   ///< what held it, when it fell asleep
  Vector start_;             ///< positions that it has not left since, shape (all rows), as the following
  Vector place_, force_;     ///< x and f of its sleep
  Vector zero_, work_;
};

}  // namespace stroma
