// SPDX-License-Identifier: LGPL-2.1-or-later
// What a contact gives and takes in steps by the mean of its forces at both ends, f0 and f1, as the trapezoidal rule and Newmark's have it.
// With U the energy of the contact and dx the way of a step, it gives (f0 + f1).dx / 2 for U0 - U1. Where bodies touch and part within a
// step or two the first may be more: energy comes from nowhere, and again in the next steps. A step in which what was given in all exceeds
// what there was is then solved again with f1 alone, which for a convex U never gives more: f1.dx <= U0 - U1. Everything else
// keeps the rule of the integrator.
//
// Source: Kane, Repetto, Ortiz and Marsden 1999 (contact forces of the end of a step in Newmark's method); the account of the energy
// that decides where is our own.
#pragma once
#include "components/contact/contact_terms.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class StepEnergy {
 public:
  void stepBegins() { has_start_ = is_backward_ = false; }
  /// The forces at x, where the step starts, stay in its equations.
  void startsAt(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// What the step has given until its end x, if its equations are those of before; obstacles without vertices have gone on by `way`.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way);
  /// More than there was: the step is to be solved with the forces of its end.
  bool goesBackward();
  /// It is: forces and energies are asked for that lead to (2 f1 - f0 + f0) / 2.
  bool isBackward() const { return is_backward_; }
  /// Terms of f1 become those of 2 f1; f -= f0.
  void replace(Terms& terms, const Surfaces& surfaces, Rows f) const;
  /// Of the potential U at x, that of these forces.
  double replaced(double energy, const Surfaces& surfaces, const std::vector<Vec3>& x) const;
  /// The step has ended where look() was.
  void stepTaken();
  void forget() { *this = {}; }
  void serialize(Archive& archive);

 private:
  bool has_start_ = false, is_backward_ = false, is_known_ = false;
  std::vector<Vec3> start_forces_, end_forces_;  ///< on each vertex [N]
  double before_ = 0, after_ = 0;  ///< U where the step starts and ends [J]
  double gained_ = 0, gains_ = 0;  ///< in all steps, and in the one that was looked at [J]
  double most_ = 0;                ///< the largest U of an end [J]
};

}  // namespace stroma::contact
