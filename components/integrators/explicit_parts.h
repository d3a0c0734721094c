// SPDX-License-Identifier: LGPL-2.1-or-later
// Explicit steps beside force fields that limit them, in parts that are short enough for these.
//
// A barrier grows as its gap closes, and with it the stiffness that an explicit method has to follow. With w the highest angular
// frequency of the masses on the stiffness of such fields alone, a part of length h is made where
//   - its way is free, for what is moved too, and
//   - h w is small where it starts and where it ends;
// else it is taken back and made shorter. Where nothing touches a step is one part.
//
// A rule with one velocity for two halves of neighbouring steps (symplectic Euler, central differences) changes it by (h- + h)/2 a
// between parts of length h- and h: it is then of second order in contact although parts differ, and equal parts are the rule.
#pragma once
#include <functional>
#include <string>

#include "components/integrators/explicit_step.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

class ExplicitParts {
 public:
  /// `method` is the subject of a sentence; `largest_angle`: h w up to which it is stable.
  void compile(System& system, Acceleration& acceleration, const std::string& method, double largest_angle);
  /// False where no field limits steps: run() is then not to be called.
  bool areNeeded() const { return !limits_.empty(); }
  /// From x and v of the system where the step starts to those of its end. `make` leads them from the start of a part to its end, and
  /// asks isFree() for places between at which it takes forces.
  StepReport run(const StepContext& context, const std::function<StepReport(const StepContext& part)>& make);
  /// Whether the way from where a part starts to x is free. False: the part is to be given up.
  bool isFree(ConstRows x);
  /// Of the next place at which forces are taken, or isFree() is asked.
  void setTime(double t) {
    for (ForceField* field : fields_) field->setTime(t);
  }
  /// The length of the part before, or that of the first one [s].
  double before(double h) const { return last_ > 0 ? last_ : h; }
  void stepTaken() { last_step_ = last_; }
  void reset() { last_ = last_step_ = 0; }
  void serialize(Archive& archive);
  /// For `explain`, or empty.
  std::string describe() const;

 private:
  double angularFrequency(const StepContext& context);
  double lengthOf(double left, double wanted) const;
  void takeBack();
  bool fits(const StepContext& part);
  std::string tooManyParts(const StepContext& context, double t, double h) const;

  System* system_ = nullptr;
  Acceleration* acceleration_ = nullptr;
  std::vector<ForceField*> fields_;  ///< that limit
  StepLimits limits_;
  std::string method_;
  double angle_ = 0;                    ///< h w that a part is to have
  double last_ = 0;                     ///< of the last part made [s]; 0: there is none
  double last_step_ = 0;                ///< of the last one of a step that stands
  double wanted_ = 0, free_ = 1;        ///< of the next part [s]; the share of the way of this one that is free
  Vector x0_, v0_, end_, way_, p_, a_;  ///< shape (independentRows())
  Vector force_;                        ///< shape (allRows())
};

}  // namespace stroma
