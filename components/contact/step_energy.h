// SPDX-License-Identifier: LGPL-2.1-or-later
// The impulse of a contact in a step by a rule that goes by the forces at both ends, as the trapezoidal rule and Newmark's do. With
// f0 and f1 the forces where the step starts and ends, dx its way and U the energy of the contact, two bodies push each other by
//
//   f = (1 - s) f0 + s f1   with   f.dx = U0 - U1
//
// so that what moves on in a step by h (v0 + v1)/2 keeps its energy, however stiff the contact and long the step. For a gap d that is the
// discrete gradient -(U(d1) - U(d0))/(d1 - d0). For a convex U there is such an s from 0 to 1, as f0.dx >= U0 - U1 >= f1.dx. Where the
// motion is resolved it is 1/2, the mean of the rule; where bodies touch and part within a step or two the mean would give and take
// any energy. A step is solved with the mean first, and again with other s only where that is off by a thousandth of the largest U. A solve
// has its s, so that its forces keep their potential, and f1 without bound as a gap closes. Friction has the same s, and where it is not
// 1/2 rubs by the way of the step, which takes energy.
//
// Each pair of bodies has its own s, and so has each body with each plane. What a step has given too much or too little the next one has
// to settle, from where the two come to touch until they have parted: U may change without work too, as shares of surfaces do.
// The search for s may not settle, as where several contacts begin in one step and each changes what is right for the others. Then s is 1
// for all: nothing gains, and much may be lost. The end of a run tells how much.
//
// Source: Gonzalez 1996, Simo and Tarnow 1992, Laursen and Chawla 1997 (forces of a step whose work is the change of the energy); the
// mixture that holds for all contacts of a pair at once is our own.
#pragma once
#include <limits>
#include <string>

#include "components/contact/contact_friction.h"
#include "components/contact/rigid_ways.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class StepEnergy {
 public:
  void stepBegins();
  /// The step starts at x, with the forces of `friction`, and the part `of_end` of its impulse is by the forces that its solves ask for.
  /// They get all of the contact's.
  void startsAt(const BarrierLaw& law, const std::vector<Vec3>& x, double of_end, const Friction& friction);
  bool hasStart() const { return has_start_; }
  const std::vector<Touch>& startTouches() const { return touches_; }
  /// How often those count that rub by the way of the step; 0: where s is 1/2 they rub by the speed at the start.
  double rubbingPartOf(const BarrierLaw& law, const std::array<int, 4>& v) const;
  /// The forces at the end of the step between what v is of count so often in its solves: s over the part of the impulse.
  double factorOf(const BarrierLaw& law, const std::array<int, 4>& v) const;
  /// Terms of f1, one of each touch, become those of the whole step, and f gets what is of f0.
  void complete(Terms& terms, const BarrierLaw& law, const std::vector<Touch>& touches, Rows f) const;
  /// The potential at x of these forces.
  double energy(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  /// What the step has given until its end x, if its equations are those of before; obstacles without vertices have gone on by `way`.
  /// rows: positions of all rows of the scene.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way, ConstRows rows);
  /// That is not what there was: the step is to be solved with another s for some.
  bool goesOn();
  /// The step has ended at x, as for look().
  void stepTaken(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way, ConstRows rows);
  void compile(const BarrierLaw& law, const std::vector<State*>& bodies) { ways_.compile(law.surfaces, bodies); }
  void forget();
  /// `others`, and a sentence where bodies had another energy when they parted, or have it now, than when they met.
  std::string doubt(const std::string& others) const;
  void serialize(Archive& archive);

 private:
  using Pair = std::array<int, 2>;  ///< two pieces; or -1 - the number of a plane, and a piece
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  struct Account {
    Pair pair;
    double before = 0, after = 0;        ///< U where the step starts and ends [J]
    double by_start = 0, by_end = 0;     ///< f0.dx and f1.dx [J]
    double gained = 0;                   ///< since they touch [J]
    double most = 0;                     ///< the largest U of an end since then [J]
    double share = 0.5;                  ///< s
    double low = -infinite, high = infinite;  ///< log s/(1 - s) of solves that have given too much and too little
    double last = 0, last_way = 0;       ///< that of the solve before, and how far from there s seemed to be
    bool touches = false, is_searched = false;
    double gains() const { return (1 - share) * by_start + share * by_end + after - before; }
    double excess() const;
    bool search(int round, bool is_alone);
    void begin() { share = 0.5, low = -infinite, high = infinite, is_searched = false; }
  };
  /// Contacts from where bodies touch until they part.
  struct Contacts {
    int all = 0, unkept = 0;
    double lost = 0, given = 0;  ///< [J]
    void add(const Account& account);
  };
  struct Pull {
    std::array<int, 4> v;
    std::array<double, 4> c;
    Vec3 force;
  };
  static Pair pairOf(const BarrierLaw& law, const std::array<int, 4>& v);
  Account& accountOf(const Pair& pair);
  double shareOf(const Pair& pair) const;
  double partOf(const BarrierLaw& law, const Pull& pull, bool rubs) const;
  void giveUp();
  bool isAsLeft(const BarrierLaw& law, const std::vector<Vec3>& x) const;

  bool has_start_ = false;
  bool gives_up_ = false;           ///< s is 1 for all in the rest of the step
  double of_end_ = 1;
  int rounds_ = 0;                  ///< solves of the step that were looked at
  std::vector<Account> accounts_;   ///< by pairs
  Contacts parted_;
  std::vector<Pull> start_, rubs_;  ///< forces of contact and friction where the step starts
  std::vector<Touch> touches_;      ///< there
  std::vector<Vec3> end_;           ///< all vertices where the last step ended
  Vec3 moved_ = Vec3::Zero();       ///< obstacles there
  std::array<double, 6> law_{};     ///< what U depended on there
  RigidWays ways_;
};

}  // namespace stroma::contact
