// SPDX-License-Identifier: LGPL-2.1-or-later
// What a contact gives and takes in steps by the mean of its forces at both ends, f0 and f1, as the trapezoidal rule and Newmark's have it.
// With U the energy of the contact and dx the way of a step, it gives (f0 + f1).dx / 2 for U0 - U1. Where bodies touch and part within a
// step or two the first may be more: energy comes from nowhere, and again in the next steps. A step in which what was given in all exceeds
// what there was is then solved again with f1 alone, which for a convex U never gives more: f1.dx <= U0 - U1. Everything else
// keeps the rule of the integrator.
//
// Each pair of bodies has its own account, and so has each body with each plane. It begins where they come to touch and ends where they
// have parted: what one bounce has lost is not there for the next one, or for others. Within a bounce it is: to come in by the mean of the
// forces loses what to go out by it gives.
//
// Source: Kane, Repetto, Ortiz and Marsden 1999 (contact forces of the end of a step in Newmark's method); the account of the energy
// that decides where is our own.
#pragma once
#include "components/contact/contact_terms.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class StepEnergy {
 public:
  void stepBegins();
  /// The forces at x, where the step starts, stay in its equations.
  void startsAt(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// What the step has given until its end x, if its equations are those of before; obstacles without vertices have gone on by `way`.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way);
  /// Some have more than there was: the step is to be solved with the forces of its end between them.
  bool goesBackward();
  /// It is: forces and energies are asked for that lead to (2 f1 - f0 + f0) / 2.
  bool isBackward() const { return rounds_ > 0; }
  /// Terms of f1, of all touches at x, become those of 2 f1 where it is; f -= f0.
  void replace(Terms& terms, const BarrierLaw& law, const std::vector<Vec3>& x, Rows f) const;
  /// The potential at x of these forces.
  double replaced(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  /// The step has ended at x, as for look().
  void stepTaken(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way);
  void forget() { *this = {}; }
  void serialize(Archive& archive);

 private:
  using Pair = std::array<int, 2>;  ///< two pieces; or -1 - the number of a plane, and a piece
  struct Account {
    Pair pair;
    double before = 0, after = 0;  ///< U where the step starts and ends [J]
    double given = 0;              ///< in the step that was looked at [J]
    double gained = 0;             ///< since they touch [J]
    double most = 0;               ///< the largest U of an end since then [J]
    bool touches = false, is_backward = false;
    double gains() const { return given + after - before; }
  };
  static Pair pairOf(const BarrierLaw& law, const Touch& touch);
  Account& accountOf(const Pair& pair);
  bool isBackward(const Pair& pair) const;
  bool isAsLeft(const BarrierLaw& law, const std::vector<Vec3>& x) const;

  bool has_start_ = false;
  int rounds_ = 0;                  ///< in which accounts of the step have gone backward
  std::vector<Account> accounts_;   ///< by pairs
  std::vector<Touch> start_;        ///< touches where the step starts
  std::vector<Vec3> end_;           ///< all vertices where the last step ended
  Vec3 moved_ = Vec3::Zero();       ///< obstacles there
  std::array<double, 6> law_{};     ///< what U depended on there
};

}  // namespace stroma::contact
