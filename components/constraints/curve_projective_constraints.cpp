// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes that move along a curve, from BeginTime to EndTime. With u = (t - BeginTime)/(EndTime - BeginTime):
//
// ParabolicProjectiveConstraint: the parabola from P1 through P2 to P3, its axis across the way from P1 to P3.
//   x(u) = P1 + u c + u (1 - u)/(s (1 - s)) h,   c = P3 - P1,   P2 - P1 = s c + h,   h.c = 0
//   The speed along c is constant. With P2 on the line of P1 and P3 it is that line.
//
// HermiteSplineProjectiveConstraint: a cubic from X0 to X1 with the tangents dX0 and dX1 there, run through by w(u):
//   x(w) = H00(w) X0 + H10(w) dX0 + H01(w) X1 + H11(w) dX1,   w(u) = H10(u) a + H01(u) + H11(u) b
//   H00 = 2 w^3 - 3 w^2 + 1,  H10 = w^3 - 2 w^2 + w,  H01 = 3 w^2 - 2 w^3,  H11 = w^3 - w^2
//   a and b, the second numbers of SX0 and SX1, are the speeds of w at the ends. With 0, the default,
//   the nodes start from rest and come to rest.
//
// All listed nodes are at the same place. Positions and velocities are exact at the end of every step. Before BeginTime and
// after EndTime the nodes are free, as in SOFA; with outside="hold" they stay where the curve begins and ends.
//
// Source: the names and attributes are SOFA's, but for `outside`; velocities there are a difference quotient of the parabola,
// and the derivative of the spline by w.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="200"/>
//   <ParabolicProjectiveConstraint indices="0" P1="0 0 0" P2="0.4 0.3 0" P3="1 0 0" BeginTime="0" EndTime="1"/>
//   <HermiteSplineProjectiveConstraint indices="2" X0="2 0 0" dX0="0 1 0" X1="2 0 1" dX1="0 0 1" EndTime="2" outside="hold"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/constraints/held_nodes.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/start_velocity.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A place on a curve, and its derivative by u.
struct OnCurve {
  Vec3 x = Vec3::Zero(), slope = Vec3::Zero();
};

class CurveMovement : public HeldNodes, public StartVelocity {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    declareMatrix(table);
    table.add("BeginTime", begin_).help("when the movement begins").unit("s");
    table.add("EndTime", end_).help("when it ends").unit("s").required();
    table.add("late", late_).help("in each step the nodes go to where they were to be at its start, with SOFA's velocities");
    table.addChoice("outside", outside_, {"free", "hold"}).help("state of the nodes before BeginTime and after EndTime");
  }
  void init() override {
    HeldNodes::init();
    if (!(end_ > begin_))
      throw ComponentError(fmt::format("the movement from {:g} s ends at {:g} s", begin_, end_), "EndTime after BeginTime");
    if (outside_ == Outside::free && !data().find("outside")->isSet())
      inform(fmt::format("the nodes are free before t = {:g} s and after t = {:g} s; outside=\"hold\" fixes them", begin_, end_));
  }

  bool activeIn(double t, double t_end) const override {
    if (late_) {
      const bool is_on = (t > begin_ || sameTime(t, begin_)) && (t < end_ || sameTime(t, end_));
      return ProjectiveConstraint::activeIn(t, t_end) && (is_on || outside_ == Outside::hold);
    }
    const bool moves = (t_end > begin_ || sameTime(t_end, begin_)) && t < end_ && !sameTime(t, end_);
    return ProjectiveConstraint::activeIn(t, t_end) && (moves || outside_ == Outside::hold);
  }
  bool isConstant() const override { return outside_ == Outside::hold; }
  bool prescribesMotion() const override { return true; }
  bool keepsStartVelocity() const override { return late_; }
  void placeStart(double t, Rows x, Rows v) const override {
    if (late_ && activeIn(t, t)) prescribe(t, x, v);  // SOFA projects before the first step too
  }
  void prescribe(double time, Rows x, Rows v) const override {
    const double lag = late_ ? node().dt() : 0;
    const double t = std::max(time - lag, std::min(time, node().root().root_time));
    const double u = (t - begin_) / (end_ - begin_);
    const OnCurve here = at(std::clamp(u, 0., 1.));
    if (late_) {
      if (u < 0 && !sameTime(t, begin_)) return;
      for (std::size_t i = 0; i < nodes().size(); ++i) {
        x[row(i)] = here.x;
        v[row(i)] = velocityOfSofa(u, lag, end_ - begin_);
      }
      return;
    }
    const bool stands = (u < 0 && !sameTime(t, begin_)) || (u > 1 && !sameTime(t, end_) && outside_ == Outside::hold);
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      x[row(i)] = here.x;
      v[row(i)] = stands ? Vec3(Vec3::Zero()) : Vec3(here.slope / (end_ - begin_));
    }
  }

 protected:
  virtual OnCurve at(double u) const = 0;
  virtual Vec3 velocityOfSofa(double u, double lag, double span) const = 0;

 private:
  enum class Outside : int { free, hold } outside_ = Outside::free;
  double begin_ = 0, end_ = 0;
  bool late_ = false;
};

class ParabolicMovement final : public CurveMovement {
 public:
  void declare(DataTable& table) override {
    CurveMovement::declare(table);
    table.add("P1", first_).help("where the parabola begins").unit("m").required();
    table.add("P2", second_).help("a point on the way").unit("m").required();
    table.add("P3", third_).help("where it ends").unit("m").required();
  }
  void init() override {
    CurveMovement::init();
    const Vec3 chord = third_ - first_, way = second_ - first_;
    if (!(chord.norm() > 0)) throw ComponentError("P1 and P3 are the same place", "three points");
    const double share = way.dot(chord) / chord.squaredNorm();
    height_ = way - share * chord;
    if (height_.norm() <= 1e-12 * chord.norm()) return void(height_.setZero());
    if (!(share > 0 && share < 1))
      throw ComponentError(
          fmt::format("P2 is at {:.3g} of the way from P1 to P3: there is no parabola through it between them", share),
          "a point between them");
    height_ /= share * (1 - share);
  }

 protected:
  OnCurve at(double u) const override {
    const Vec3 chord = third_ - first_;
    return {first_ + u * chord + u * (1 - u) * height_, chord + (1 - 2 * u) * height_};
  }
  /// Of the chord over the next step.
  Vec3 velocityOfSofa(double u, double lag, double span) const override { return (at(u + lag / span).x - at(u).x) / lag; }

 private:
  Vec3 first_ = Vec3::Zero(), second_ = Vec3::Zero(), third_ = Vec3::Zero();
  Vec3 height_ = Vec3::Zero();  ///< h / (s (1 - s))
};

class HermiteSplineMovement final : public CurveMovement {
 public:
  void declare(DataTable& table) override {
    CurveMovement::declare(table);
    table.add("X0", start_).help("where the curve begins").unit("m").required();
    table.add("dX0", start_tangent_).help("its tangent there, over the whole of w").unit("m");
    table.add("X1", end_place_).help("where it ends").unit("m").required();
    table.add("dX1", end_tangent_).help("its tangent there").unit("m");
    table.add("SX0", start_speed_).help("two numbers; the second is the speed of w at the start").unit("-");
    table.add("SX1", end_speed_).help("two numbers; the second is the speed of w at the end").unit("-");
  }
  void init() override {
    CurveMovement::init();
    for (const auto& [name, list] : {std::pair("SX0", &start_speed_), std::pair("SX1", &end_speed_)})
      if (list->size() != 2) throw ComponentError(fmt::format("{} has {} numbers", name, list->size()), "two numbers");
  }

 protected:
  OnCurve at(double u) const override {
    const Weights by_time = weightsAt(u);
    const double w = start_speed_[1] * by_time.h10 + by_time.h01 + end_speed_[1] * by_time.h11;
    const double speed = start_speed_[1] * by_time.d10 + by_time.d01 + end_speed_[1] * by_time.d11;
    const Weights h = weightsAt(w);
    return {h.h00 * start_ + h.h10 * start_tangent_ + h.h01 * end_place_ + h.h11 * end_tangent_,
            speed * (-h.d01 * start_ + h.d10 * start_tangent_ + h.d01 * end_place_ + h.d11 * end_tangent_)};
  }
  /// By w, not by time.
  Vec3 velocityOfSofa(double u, double, double) const override {
    const Weights by_time = weightsAt(u);
    const double w = start_speed_[1] * by_time.h10 + by_time.h01 + end_speed_[1] * by_time.h11;
    const Weights h = weightsAt(w);
    return -h.d01 * start_ + h.d10 * start_tangent_ + h.d01 * end_place_ + h.d11 * end_tangent_;
  }

 private:
  /// H and their derivatives.
  struct Weights {
    double h00, h10, h01, h11, d10, d01, d11;
  };
  static Weights weightsAt(double w) {
    const double h01 = w * w * (3 - 2 * w);
    return {1 - h01, w * (w - 1) * (w - 1), h01, w * w * (w - 1), (3 * w - 1) * (w - 1), 6 * w * (1 - w), w * (3 * w - 2)};
  }

  Vec3 start_ = Vec3::Zero(), start_tangent_ = Vec3::Zero(), end_place_ = Vec3::Zero(), end_tangent_ = Vec3::Zero();
  std::vector<double> start_speed_{0, 0}, end_speed_{0, 0};
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(curve_projective_constraints) {
  factory.add<stroma::ParabolicMovement>("ParabolicProjectiveConstraint", "Moves nodes along a parabola");
  factory.add<stroma::HermiteSplineMovement>("HermiteSplineProjectiveConstraint", "Moves nodes along a cubic curve");
}
