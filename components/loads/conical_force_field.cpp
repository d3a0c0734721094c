// SPDX-License-Identifier: LGPL-2.1-or-later
// ConicalForceField: a cone that keeps nodes inside, closed by the part of a sphere around its tip.
//
// With y = x - coneCenter, n the direction of coneHeight, H its length, alpha = coneAngle between the axis and the side, and
// r, a the lengths of y across and along n, a node is inside where r cos(alpha) <= a sin(alpha) and |y| <= H. The depth g of a
// node outside is its distance from this region: from the side, the cap, the tip, or the rim between side and cap.
//
//   E = k/2 g^2,   f = -k g grad g - c g v,   df/dx = -k (grad g grad g^T + g H_g),   df/dv = -c g I
//
// Source: the name and the attributes are SOFA's. There (towardsTip) with |y| > H  f = -k (|y| - H) y/|y| + c (|y| - H) v, whatever
// the angle; else f = k g m - c (m.v) m with m towards the side where a > 0 and towards the tip where not. The tangent is
// -k m m^T, and the damping is no part of it.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0.6 0.5 0  0 1.1 0.1  0.1 -0.1 0  0.7 1 0"/>
//   <UniformMass totalMass="0.4"/>
//   <ConicalForceField coneCenter="0 0 0" coneHeight="0 1 0" coneAngle="30" stiffness="1000"/>
// </Node>
#include <cmath>
#include <numbers>
#include <utility>

#include "components/loads/penalty_field.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ConicalForceField final : public PenaltyField {
 public:
  void declare(DataTable& table) override {
    PenaltyField::declare(table);
    table.add("coneCenter", tip_).atOnce().help("the tip").unit("m");
    table.add("coneHeight", height_).help("from the tip along the axis to the cap").unit("m").required();
    table.add("coneAngle", angle_).help("between the axis and the side").unit("degree").min(0, false).max(90);
    table.add("towardsTip", towards_tip_).help("nodes too far from the tip are drawn to it without damping, as in SOFA");
    table.add("stiffness", stiffness_constant_).atOnce().help("force over depth").unit("N/m").min(0).physical();
  }
  void init() override {
    PenaltyField::init();
    if (!(height_.norm() > 0)) throw ComponentError("coneHeight has no direction", "a vector that is not zero");
    axis_ = height_.normalized();
    const double angle = angle_ * std::numbers::pi / 180;
    cosine_ = std::cos(angle), sine_ = std::sin(angle);
  }

  ForceTraits traits() const override {
    ForceTraits traits = PenaltyField::traits();
    if (towards_tip_) traits.conservative = traits.exact_tangent = traits.velocity_dependent = false;
    return traits;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (!towards_tip_) return PenaltyField::addForce(x, v, f);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Index row = rows_[i][0];
      const auto [g, way] = wayBack(x[row] - tip_);
      stiffness_[i].setZero();
      if (g <= 0) continue;
      const bool is_beyond = (x[row] - tip_).norm() > height_.norm();
      f[row] += stiffness_constant_ * g * way;
      f[row] += damping_constant_ * (is_beyond ? Vec3(g * v[row]) : Vec3(-way.dot(v[row]) * way));
      stiffness_[i].blocks[0] = -stiffness_constant_ * way * way.transpose();
    }
  }

 protected:
  Depth depth(const Vec3& x) const override {
    const Vec3 y = x - tip_;
    const double a = y.dot(axis_), size = height_.norm();
    const Vec3 across = y - a * axis_;
    const double r = across.norm();
    const Vec3 e = r > 0 ? Vec3(across / r) : Vec3(Vec3::Zero());
    const double along_side = a * cosine_ + r * sine_, from_side = r * cosine_ - a * sine_;
    if (from_side <= 0) return fromCentre(y, size);
    if (along_side <= 0) return fromCentre(y, 0);
    const Mat3 around = Mat3::Identity() - axis_ * axis_.transpose() - e * e.transpose();
    if (along_side <= size) return {from_side, cosine_ * e - sine_ * axis_, cosine_ / r * around};
    const double a_rim = a - size * cosine_, r_rim = r - size * sine_, g = std::hypot(a_rim, r_rim);
    const double u = a_rim / g, w = r_rim / g;
    const Vec3 tangent = u * e - w * axis_;
    return {g, u * axis_ + w * e, tangent * tangent.transpose() / g + w / r * around};
  }

 private:
  /// How far a node is outside, and the direction in which it is drawn back.
  std::pair<double, Vec3> wayBack(const Vec3& y) const {
    const double far = y.norm(), size = height_.norm(), a = y.dot(axis_);
    if (far > size) return {far - size, -y / far};
    const Vec3 across = y - a * axis_;
    const double r = across.norm();
    if (r * cosine_ <= a * sine_) return {0, Vec3::Zero()};
    if (a <= 0) return {far, -y / far};
    const Vec3 side = cosine_ * axis_ + sine_ / r * across, back = side.dot(y) * side - y;
    const double g = back.norm();
    return {g, g > 0 ? Vec3(back / g) : Vec3(Vec3::Zero())};
  }
  static Depth fromCentre(const Vec3& y, double radius) {
    const double length = y.norm();
    if (!(length > 0)) return {};
    const Vec3 n = y / length;
    return {length - radius, n, (Mat3::Identity() - n * n.transpose()) / length};
  }

  Vec3 tip_ = Vec3::Zero(), height_ = Vec3::Zero(), axis_ = Vec3::UnitY();
  double angle_ = 10, cosine_ = 1, sine_ = 0;
  bool towards_tip_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(conical_force_field) {
  factory.add<stroma::ConicalForceField>("ConicalForceField", "a cone that keeps nodes inside");
}
