// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction with lagged normal forces l and directions, fixed in a solve (Li et al. 2020). With the slip u since the start of
// the step and y = |u| / e, its force has the potential mu l f0(|u|),
//   f0' = 2 y - y^2 for y < 1, else 1
// A body on a tool that has moved begins a solve with |u| far above e. If all its contacts slip, the stiffness along u is
// zero, the next iterate makes them slip the other way, and Newton's method hardly ever finds which of them stick. Starting
// from sticking it takes a few iterations. Contacts are therefore first held by springs with the stiffness 2 mu l / e of
// u = 0, and then solved again with friction.
//
// With rho = |u|/f0' the force is -mu l u/rho. Its derivative only uses the present direction of u, and Newton's method again
// has difficulty where slipping begins or ends. The tangent is therefore that of the equation rho t = u, with t as an
// independent variable: along a correction it follows
//   rho dt = du - t rho' (u/|u|).du,   |t| <= 1,   K = mu l / rho (1 - rho' sym(t (u/|u|)^T))
// with rho and u at the start of the line search (primal-dual method of Chan, Golub and Mulet 1999, for image denoising).
// t = u/rho gives the exact derivative. The force does not depend on t.
//
// mu is lagged like l: the static coefficient for y <= 1 in the previous solve, the kinetic one for y >= 2, and a smooth step
// between. Each solve then has a potential, sticking contacts bear up to the static coefficient, and sliding ones continue
// with the kinetic one. A contact that reverses its direction has stopped in between, and restarts with the static one.
//
// Adhesion that pulls with a force a also bears mu_a a along the surfaces while it sticks, and nothing for y >= 2: a sliding contact
// is not glued (Fang, Li and others 2023 release it by the law of f; here the coefficient is lagged).
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
  const StepEnergy* balance = nullptr;  ///< the weight of a force at the end of the step
  double mu = 0, mu_static = 0;  ///< kinetic; static, not smaller
  double mu_adhesion = 0;
  double slip = 1e-6;   ///< e [m]
  bool acts() const { return mu > 0 || mu_static > 0 || mu_adhesion > 0; }
  bool letsGo() const { return mu_static != mu || mu_adhesion > 0; }  ///< sliding contacts have less friction than sticking ones
  bool is_damped = true;  ///< the integrator damps the springs of single-solve steps
  bool definite = false;  ///< the derivative must not have unstable directions
  double farthest = 0;  ///< contacts with a larger slip are not held [m]
  struct Slide {
    std::array<int, 4> v;
    std::array<double, 4> c;
    Vec3 n;
    double force = 0;   ///< mu l + mu_a a [N]; negative: compensates a share counted twice
    bool on_plane = false;  ///< its other point moves with the obstacles
    bool held = false;  ///< by a spring with rho = e/hold; 2: the tangent of u = 0
    double hold = 2;
    Vec3 u = Vec3::Zero(), t = Vec3::Zero();              ///< at the x of the last compute()
    Vec3 start_u = Vec3::Zero(), start_t = Vec3::Zero();  ///< at the start of the line search
  };
  /// Sets the list of frictional contacts.
  std::vector<Slide> slides;
  /// Builds it from the touches, with the coefficients of the previous step.
  void note(const BarrierLaw& law, const std::vector<Touch>& touches);
  /// The same with the coefficients that follow from the slip up to x.
  void noteAgain(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
                 const Vec3& moved);
  void setSlip(double e) { slip = wanted_slip_ = e; }
  /// Eases friction in a step that is retried after failed solves, or if the slip tolerance is tiny: the first solve allows a slip
  /// of e. Whenever forces and shares have settled, the next solve has a tenth of that, down to the wanted value. Sticking contacts
  /// are first held by the spring that reproduces their y, and so their force; those that only compensate a share are not held.
  void ease(double e, bool again) {
    constexpr double tiny = 1e-3;  // of e: the first try begins so as well
    slip = (again && lines_ > 1) || wanted_slip_ < tiny * e ? std::max(wanted_slip_, e) : wanted_slip_;
  }
  bool isRelaxed() const { return acts() && slip > wanted_slip_; }
  void sharpen(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// Updates them with the forces and shares at the end x of a solve. Returns the relative change of the forces.
  double renew(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved, bool was_held,
               std::vector<Vec3>& before, std::vector<Vec3>& after);
  /// Begins a step with this number of vertices.
  void begin(std::size_t vertices) { slid_.resize(vertices, Vec3::Zero()), slid_before_.reserve(vertices), met_.assign(vertices, false); }
  void beginAgain() { met_.assign(met_.size(), false), stuck_.clear(), knows_stuck_ = false, lines_ = 0; }
  /// Stores the slip of the previous step at its end x: contacts that slip then are likely to continue.
  void remember(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// At the first x of a solve: holds contacts with a slip above e that were not held in this step and do not continue to slide.
  void hold(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  bool hasSlid() const { return std::ranges::any_of(slid_, [](const Vec3& u) { return !u.isZero(0); }); }  ///< in the previous step
  bool isHolding() const { return std::ranges::any_of(slides, &Slide::held); }
  /// Releases all held contacts. Returns true if there were any.
  bool release();
  /// Obstacles have moved since the last x, so the next x is treated as the first of a solve.
  void looksAgain() { looks_ = true; }
  /// Holds nothing until note() is called again.
  void settle() { looks_ = false; }
  /// A line search starts at the x of the last compute().
  void lineStarts();
  /// Forces at x for a step from `start`, while obstacles have moved by `moved`.
  void compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// The same at the start of a step of dt [s], with the velocities v there. `x`: work space.
  void computeAtSpeed(const Surfaces& surfaces, ConstRows v, double dt, const std::vector<Vec3>& start, const Vec3& moved,
                      std::vector<Vec3>& x);
  // ---- alternative for explicit and single-solve steps (contact_springs.cpp) ----
  /// Forces at x of the touches there.
  void stretch(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
               const Vec3& moved);
  /// A substep ends at the x of the last stretch(): springs keep their present state.
  void keepStretched(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  /// In single-solve steps: forces at x of the touches at the start of the step, each of which sticks or slides throughout.
  void lean(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
            const Vec3& moved);
  /// A step ends at x: decides which contacts continue to stick or slide.
  void keepLeaning(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                   const std::vector<Vec3>& start, const Vec3& moved);
  /// A step of dt [s] starts with the velocities v: contacts that these move beyond the sticking limit slide. `x`: work space.
  void leanAtSpeed(const BarrierLaw& law, const std::vector<Touch>& touches, ConstRows v, double dt, const std::vector<Vec3>& start,
                   const Vec3& moved, std::vector<Vec3>& x);
  /// Stores the state at the start of a step, or restores it if the same step is repeated.
  void leanAgain(bool again);
  bool isSliding(const Slide& slide) const { return are_springs_ ? !slide.held : slide.u.norm() > slip; }
  const Terms& terms() const { return terms_; }
  /// The potential [J] whose negative gradient compute() gives, with held contacts as they are.
  double energy(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) const;
  /// On all vertices, from the last compute(); `out` has that many.
  void forces(std::vector<Vec3>& out) const;
  void clear() { slides.clear(), terms_.clear(), slid_.clear(), sticking_.clear(), goes_.clear(); }
  void serialize(Archive& archive);

 private:
  using PlaceOf = std::array<int, 5>;  ///< vertices of a contact, and a mask of those with a weight
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
  double wanted_slip_ = 1e-6;  ///< slip without easing [m]
  int lines_ = 0;              ///< line searches in this try of a step
  std::vector<bool> met_;   ///< per vertex: it has been held in this step
  std::map<PlaceOf, double> stuck_;    ///< y of contacts that stuck in the previous solve, with a larger e
  bool knows_stuck_ = false;
  std::vector<Vec3> slid_;  ///< per vertex: u in the previous step; zero if it stuck [m]
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
