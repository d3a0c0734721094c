// SPDX-License-Identifier: LGPL-2.1-or-later
// Contact impulses that conserve energy in a rule with forces at both ends of a step, such as the trapezoidal rule and Newmark's.
// With the forces f0 and f1 at the start and end of the step, its displacement dx and the contact energy U, the contact force is
//
//   f = (1 - s) f0 + s f1   with   f.dx = U0 - U1
//
// so that a body that moves by h (v0 + v1)/2 in a step keeps its energy, however stiff the contact and long the step. For a gap d this is
// the discrete gradient -(U(d1) - U(d0))/(d1 - d0). For a convex U such an s exists between 0 and 1, because f0.dx >= U0 - U1 >= f1.dx. If
// the motion is resolved it is 1/2, the mean of the rule. If bodies touch and separate within a step or two, the mean could add or remove
// any amount of energy. A step is first solved with the mean, and again with other s only if the error exceeds a thousandth of the largest
// U. s is fixed in a solve, so forces have a potential, and f1 is unbounded as a gap closes. Friction uses the same s, and if that is not
// 1/2 it acts on the displacement of the step, which dissipates energy.
//
// Each pair of bodies, and each body with each plane, has its own s. The energy error of a step is carried to the next one, from first
// touch until separation: U may also change without work, as surface shares do.
// The search for s may fail to converge, for example if several contacts begin in one step and each affects the others. Then s is 1 for
// all: no energy is gained, but much may be lost. A warning at the end of a run says how much.
//
// Source: Gonzalez 1996, Simo and Tarnow 1992, Laursen and Chawla 1997 (forces whose work equals the change of energy); the common
// weight for all contacts of a pair is our own.
#pragma once
#include <limits>
#include <string>

#include "components/contact/contact_friction.h"
#include "components/contact/rigid_paths.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

class StepEnergy {
 public:
  void stepBegins();
  /// Starts a step at x, with the forces of `friction`. The part `of_end` of the impulse comes from the forces at its end, which
  /// solves evaluate; they carry the whole contact force.
  void startsAt(const BarrierLaw& law, const std::vector<Vec3>& x, double of_end, const Friction& friction);
  bool hasStart() const { return has_start_; }
  const std::vector<Touch>& startTouches() const { return touches_; }
  /// The weight of friction on the displacement of the step; 0: s is 1/2, and friction acts on the velocity at the start.
  double rubbingPartOf(const BarrierLaw& law, const std::array<int, 4>& v) const;
  /// The weight of the end force between the bodies of v in the solves: s divided by the part of the impulse.
  double factorOf(const BarrierLaw& law, const std::array<int, 4>& v) const;
  /// Scales terms of f1, one per touch, to the whole step, and adds the part of f0 to f.
  void complete(Terms& terms, const BarrierLaw& law, const std::vector<Touch>& touches, Rows f) const;
  /// The potential of these forces at x.
  double energy(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  /// Evaluates the energy balance at the end x of a solve; obstacles without vertices have moved by `way`. rows: positions of all
  /// rows of the scene.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way, ConstRows rows);
  /// The balance is violated: the step must be solved again with a different s for some pairs.
  bool goesOn();
  /// The step has ended at x, as in look().
  void stepTaken(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way, ConstRows rows);
  void compile(const BarrierLaw& law, const std::vector<State*>& bodies) { ways_.compile(law.surfaces, bodies); }
  void forget();
  /// `others`, and a warning if the energy of bodies at separation, or now, differs from that at first touch.
  std::string doubt(const std::string& others) const;
  void serialize(Archive& archive);

 private:
  using Pair = std::array<int, 2>;  ///< two pieces; or -1 - the number of a plane, and a piece
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  struct Account {
    Pair pair;
    double before = 0, after = 0;        ///< U at the start and end of the step [J]
    double by_start = 0, by_end = 0;     ///< f0.dx and f1.dx [J]
    double gained = 0;                   ///< since first touch [J]
    double most = 0;                     ///< the largest U at the end of a step since then [J]
    double share = 0.5;                  ///< s
    double low = -infinite, high = infinite;  ///< bounds of log s/(1 - s), from solves that gained too much and too little
    double last = 0, last_way = 0;       ///< value in the previous solve, and its estimated distance from the solution
    bool touches = false, is_searched = false;
    double gains() const { return (1 - share) * by_start + share * by_end + after - before; }
    double excess() const;
    bool search(int round, bool is_alone);
    void begin() { share = 0.5, low = -infinite, high = infinite, is_searched = false; }
  };
  /// Contacts from first touch until separation.
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
  int rounds_ = 0;                  ///< solves of the step so far
  std::vector<Account> accounts_;   ///< per pair
  Contacts parted_;
  std::vector<Pull> start_, rubs_;  ///< forces of contact and friction at the start of the step
  std::vector<Touch> touches_;      ///< at the start of the step
  std::vector<Vec3> end_;           ///< all vertices at the end of the last step
  Vec3 moved_ = Vec3::Zero();       ///< displacement of obstacles there
  std::array<double, 6> law_{};     ///< parameters of U there
  RigidPaths ways_;
};

}  // namespace stroma::contact
