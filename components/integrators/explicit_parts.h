// SPDX-License-Identifier: LGPL-2.1-or-later
// Substeps of explicit integrators with force fields that limit steps.
//
// A barrier stiffens as its gap closes, and an explicit method has to resolve that. With the highest angular frequency w of the masses
// on the stiffness of such fields alone, a substep of length h is accepted if
//   - its path is free of collisions, including prescribed motion, and
//   - h w is small at its start and end;
// otherwise it is rejected and shortened. Without contact a step is one substep.
//
// A rule whose velocity is shared by halves of neighbouring steps (symplectic Euler, central differences) changes it by (h- + h)/2 a
// between substeps of length h- and h. It is then of second order in contact with unequal substeps; equal ones give the original rule.
#pragma once
#include <functional>
#include <string>

#include "components/integrators/explicit_step.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

class ExplicitParts {
 public:
  /// `method` is the subject of messages; `largest_angle`: the stability limit of h w.
  void compile(System& system, Acceleration& acceleration, const std::string& method, double largest_angle);
  /// False if no field limits steps: run() must not be called then.
  bool areNeeded() const { return !limits_.empty(); }
  /// Moves x and v of the system from the start of the step to its end. `make` makes one substep, and calls isFree() for the
  /// intermediate positions at which it evaluates forces.
  StepReport run(const StepContext& context, const std::function<StepReport(const StepContext& part)>& make);
  /// Whether the path from the start of a substep to x is free. False: abandon the substep.
  bool isFree(ConstRows x);
  /// The time of the next force evaluation or call of isFree().
  void setTime(double t) {
    for (ForceField* field : fields_) field->setTime(t);
  }
  /// The length of the previous substep, or of the first one [s].
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
  std::vector<ForceField*> fields_;  ///< that limit steps
  StepLimits limits_;
  std::string method_;
  double angle_ = 0;                    ///< target value of h w
  double last_ = 0;                     ///< of the last substep [s]; 0: there is none
  double last_step_ = 0;                ///< last substep of the last accepted step [s]
  double wanted_ = 0, free_ = 1;        ///< length of the next substep [s]; the free fraction of the present path
  Vector x0_, v0_, end_, way_, p_, a_;  ///< shape (independentRows())
  Vector force_;                        ///< shape (allRows())
};

}  // namespace stroma
