// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction with normal forces l and directions that are held fixed in a solve (Li et al. 2020). With u the way along the
// tangents since the start of the step and y = |u| / e, its force has the potential mu l f0(|u|),
//   f0' = 2 y - y^2 for y < 1, else 1
// A body on a tool that has moved begins a solve with |u| far above e. Where its contacts then all slip, the tangent along u
// is zero, the next iterate has them slip the other way, and Newton's method finds hardly ever which of them stick. From the
// other side it takes a few iterations. Contacts are therefore held first, by the stiffness 2 mu l / e of u = 0, and solved
// again with their friction.
//
// With rho = |u|/f0' the force is -mu l u/rho. Its derivative knows the direction of u only as it is now, and Newton's method again
// hardly finds what sticks where slipping begins or ends. The tangent is therefore that of the equation rho t = u, with a t that
// has a life of its own: along a correction it follows
//   rho dt = du - t rho' (u/|u|).du,   |t| <= 1,   K = mu l / rho (1 - rho' sym(t (u/|u|)^T))
// with rho and u of where the line starts (Chan, Golub and Mulet 1999, for the denoising of images). t = u/rho is the derivative
// itself. The force is not touched by it.
//
// mu is that of the solve before, as l is: the coefficient of what sticks for y <= 1, that of what slides for y >= 2, a smooth step
// between. Each solve has a potential then, what sticks bears up to the larger coefficient, and what slides goes on with the smaller.
// What slides against the way of the step before has stood in between, and is asked with the larger one whether it goes on.
//
// Adhesion that pulls with a force a bears mu_a a along the surfaces besides, where it sticks, and nothing from y = 2 on: what slides is
// not glued (Fang, Li and others 2023 let it go by the law of f; here it follows the solves too).
#pragma once
#include <map>

#include "components/contact/contact_terms.h"

namespace stroma {
class Archive;
}

namespace stroma::contact {

class StepEnergy;

class Friction {
 public:
  const StepEnergy* balance = nullptr;  ///< how often a force at the end of the step counts
  double mu = 0, mu_static = 0;  ///< of what slides; of what sticks, not less
  double mu_adhesion = 0;
  double slip = 1e-6;   ///< e [m]
  bool acts() const { return mu > 0 || mu_static > 0 || mu_adhesion > 0; }
  bool letsGo() const { return mu_static != mu || mu_adhesion > 0; }  ///< what slides has less than what sticks
  bool is_damped = true;  ///< by the integrator, what springs of steps of one solve hold
  bool definite = false;  ///< the derivative is to have no unstable direction
  double farthest = 0;  ///< what is off by more is not held [m]
  struct Slide {
    std::array<int, 4> v;
    std::array<double, 4> c;
    Vec3 n;
    double force = 0;   ///< mu l + mu_a a [N]; negative: takes away what was counted twice
    bool on_plane = false;  ///< its other point moves with the obstacles
    bool held = false;  ///< by a spring of rho = e/hold; 2: the tangent of u = 0
    double hold = 2;
    Vec3 u = Vec3::Zero(), t = Vec3::Zero();              ///< at the x of the last compute()
    Vec3 start_u = Vec3::Zero(), start_t = Vec3::Zero();  ///< where the line starts
  };
  /// What slides from now on.
  std::vector<Slide> slides;
  /// Slides become the touches, with the coefficients of the step before.
  void note(const BarrierLaw& law, const std::vector<Touch>& touches);
  /// The same with the coefficients of the ways that have been made up to x.
  void noteAgain(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
                 const Vec3& moved);
  void setSlip(double e) { slip = wanted_slip_ = e; }
  /// Where a step is tried again whose solves have failed, in lines and not by a guess, or creep is to be tiny: what sticks may creep by e
  /// in the first solve now. When forces and shares have settled the next one has a tenth of it, down to what it was set to. What has stuck
  /// is held first by the spring that gives its y again, and with it its force.
  void ease(double e, bool again) {
    constexpr double tiny = 1e-3;  // of e: the first try begins so as well
    slip = (again && lines_ > 1) || wanted_slip_ < tiny * e ? std::max(wanted_slip_, e) : wanted_slip_;
  }
  bool isEased() const { return acts() && slip > wanted_slip_; }
  void sharpen(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// Slides with the forces and shares at the end x of a solve, and the change of the forces on all vertices, see relativeChange().
  double renew(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved, bool was_held,
               std::vector<Vec3>& before, std::vector<Vec3>& after);
  /// A step begins, with so many vertices.
  void begin(std::size_t vertices) { slid_.resize(vertices, Vec3::Zero()), slid_before_.reserve(vertices), met_.assign(vertices, false); }
  void beginAgain() { met_.assign(met_.size(), false), stuck_.clear(), knows_stuck_ = false, lines_ = 0; }
  /// Of the step before, at its end x: what slips then is likely to go on.
  void remember(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// At the first x of a solve: holds what is off by more than e, has not been held in this step, and does not go on as before.
  void hold(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  bool hasSlid() const { return std::ranges::any_of(slid_, [](const Vec3& u) { return !u.isZero(0); }); }  ///< in the step before
  bool isHolding() const { return std::ranges::any_of(slides, &Slide::held); }
  /// Nothing is held any more. True: something was.
  bool release();
  /// Obstacles have moved since the last x: that counts as the first one of a solve.
  void looksAgain() { looks_ = true; }
  /// Nor will anything be before note() is called again.
  void settle() { looks_ = false; }
  /// A line starts at the x of the last compute().
  void lineStarts();
  /// Forces at x of what began the step at `start` while obstacles have moved by `moved`.
  void compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// The same where a step of dt [s] starts, with the velocities v there. `x`: work space.
  void computeAtSpeed(const Surfaces& surfaces, ConstRows v, double dt, const std::vector<Vec3>& start, const Vec3& moved,
                      std::vector<Vec3>& x);
  // ---- in explicit steps and those of one solve, instead (contact_springs.cpp) ----
  /// Forces at x of the touches there.
  void stretch(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
               const Vec3& moved);
  /// A part of a step ends at the x of the last stretch(): springs stay as they are now.
  void keepStretched(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// In steps of one solve: forces at x of the touches where the step starts, each of which sticks or slides all the step.
  void lean(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
            const Vec3& moved);
  /// A step ends at x: who goes on sticking, and who sliding.
  void keepLeaning(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                   const std::vector<Vec3>& start, const Vec3& moved);
  /// A step of dt [s] starts with the velocities v: what these take farther than it may stick slides. `x`: work space.
  void leanAtSpeed(const BarrierLaw& law, const std::vector<Touch>& touches, ConstRows v, double dt, const std::vector<Vec3>& start,
                   const Vec3& moved, std::vector<Vec3>& x);
  /// Remembers what a step starts with, or, where the same one is made again, goes back to that.
  void leanAgain(bool again);
  bool isSliding(const Slide& slide) const { return are_springs_ ? !slide.held : slide.u.norm() > slip; }
  const Terms& terms() const { return terms_; }
  /// The potential [J] whose gradient the forces of compute() are, with what is held as it is.
  double energy(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) const;
  /// On all vertices, of the last compute(); `out` has that many.
  void forces(std::vector<Vec3>& out) const;
  void clear() { slides.clear(), terms_.clear(), slid_.clear(), sticking_.clear(), goes_.clear(); }
  void serialize(Archive& archive);

 private:
  using PlaceOf = std::array<int, 5>;  ///< vertices of a slide, and which of them have a weight
  void followLine(Slide& slide) const;
  static PlaceOf placeOf(const Slide& slide);
  void noteStuck(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  double addSpring(const BarrierLaw& law, const Touch& touch);
  void weighWays(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                 const std::vector<Vec3>& start, const Vec3& moved);
  void addTerm(const Surfaces& surfaces, const Slide& slide, const Vec3& force, const Mat3& m);
  void add(const BarrierLaw& law, const Touch& touch, double sticking, double part = 1);
  template <class Add>
  void addAll(const BarrierLaw& law, const std::vector<Touch>& touches, Add&& addOf);
  double stickingAt(double way) const;
  static Vec3 wayOf(const Slide& slide, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);

  Terms terms_;
  double wanted_slip_ = 1e-6;  ///< slip, where it is not eased [m]
  int lines_ = 0;              ///< that have started in this try of a step
  std::vector<bool> met_;   ///< of each vertex: it has been held in this step
  std::map<PlaceOf, double> stuck_;    ///< y of what has stuck in the solve before, in a step whose e was larger
  bool knows_stuck_ = false;
  std::vector<Vec3> slid_;  ///< of each vertex: u in the step before; zero where it has stuck [m]
  std::vector<Vec3> slid_before_;  ///< work space
  // ---- in explicit steps slid_ is what springs are stretched by; in those of one solve also, or of what slides its last way ----
  bool are_springs_ = false;
  static constexpr double sticks = 1, slides_on = 2, came_back = 3;
  std::vector<double> goes_;      ///< in steps of one solve, of each vertex: 0 (not pushed) or one of these
  std::vector<double> goes_at_start_;  ///< of the step
  std::vector<Vec3> slid_at_start_;
  std::vector<double> sticking_;  ///< of each vertex: 1 has stuck, 0 has slid; empty: all stick
  std::vector<double> weights_, reach_;  ///< work space
  bool looks_ = false;      ///< slides have been noted since hold()
  bool is_computed_ = false, is_on_line_ = false;  ///< slides have their u and t; those of the start of a line
};

}  // namespace stroma::contact
