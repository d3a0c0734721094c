// SPDX-License-Identifier: LGPL-2.1-or-later
// Ellipsoids and spheres that push nodes out (positive stiffness) or keep them inside (negative stiffness).
//
// With y = x - c, radii r_j, q = sum y_j^2/r_j^2, w = sum y_j^2/r_j^4, the length
//
//   s = (q - sqrt(q)) / sqrt(w)
//
// vanishes on the ellipsoid and is the distance to it in first order; for a sphere it is |y| - r. A node's depth g is
// -s inside an ellipsoid that pushes out, and s outside of one that keeps inside. Where g > 0, with k = |stiffness|:
//
//   E = k/2 g^2,   f = -k g grad g - c g v,   df/dx = -k (grad g grad g^T + g H),   df/dv = -c g I
//
// At the centre, where all ways out are equally short, there is no force. A bilateral sphere attracts nodes from both sides:
// the depth is |s|.
//
// Source: the names and attributes are SOFA's; the force here has a potential. That of SOFA's EllipsoidForceField,
// depth="ratio", has the number s = sqrt(q) - 1 instead of the length, so that the stiffness is a force, along the unit normal
// n: f = -k g n - c g v. It has no potential; the tangent is the symmetric part of the derivative.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0.4 0  0.5 0 0.1  0.2 -0.3 0"/>
//   <UniformMass totalMass="0.3"/>
//   <EllipsoidForceField center="0 0 0" vradius="1 0.6 0.8" stiffness="-1000" damping="20"/>
//   <SphereForceField center="0 0 0" radius="2" stiffness="-1000"/>
//   <SphereForceField center="0 -1.2 0" radius="0.8" stiffness="1000"/>
// </Node>
#include <algorithm>
#include <cmath>

#include "components/loads/ellipsoid_level.h"
#include "components/loads/penalty_field.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class Ellipsoid : public PenaltyField {
 public:
  void declare(DataTable& table) override {
    PenaltyField::declare(table);
    table.add("center", centre_).help("centre").unit("m");
    table.add("stiffness", signed_stiffness_)
        .help("force over depth; positive: nodes are pushed out, negative: kept inside")
        .unit("N/m")
        .physical();
  }

 protected:
  void initRadii(const Vec3& radii, const char* attribute) {
    PenaltyField::init();
    radii_ = radii;
    if (!(radii_.minCoeff() > 0)) throw ComponentError(std::string(attribute) + " is not positive", "positive lengths");
    if (signed_stiffness_ == 0) warn("the stiffness is zero: the component has no effect");
    stiffness_constant_ = std::abs(signed_stiffness_);
  }
  Depth depth(const Vec3& x) const override {
    const Vec3 y = x - centre_;
    const double sign = signed_stiffness_ > 0 ? -1 : 1;
    if (y.cwiseQuotient(radii_).squaredNorm() < 1e-24) return {};
    Depth level = by_ratio_ ? ratioOf(y, radii_) : levelOf(y, radii_);
    level.g *= sign, level.gradient *= sign, level.hessian *= sign;
    if (bilateral_ && level.g < 0) level = {-level.g, -level.gradient, -level.hessian, true};
    return level;
  }

  bool by_ratio_ = false, bilateral_ = false;

 private:
  Vec3 centre_ = Vec3::Zero(), radii_ = Vec3::Zero();
  double signed_stiffness_ = 500;
};

class EllipsoidForceField final : public Ellipsoid {
 public:
  void declare(DataTable& table) override {
    Ellipsoid::declare(table);
    table.add("vradius", given_radii_).help("half lengths of the axes").unit("m").required();
    table.addChoice("depth", depth_of_, {"distance", "ratio"})
        .help("factor of the stiffness: the distance to first order, or SOFA's ratio of lengths minus one");
  }
  void init() override {
    by_ratio_ = depth_of_ == DepthOf::ratio;
    initRadii(given_radii_, "vradius");
  }
  ForceTraits traits() const override {
    ForceTraits traits = Ellipsoid::traits();
    if (by_ratio_) traits.conservative = traits.exact_tangent = false;
    return traits;
  }

 private:
  enum class DepthOf : int { distance, ratio } depth_of_ = DepthOf::distance;
  Vec3 given_radii_ = Vec3::Zero();
};

class SphereForceField final : public Ellipsoid {
 public:
  void declare(DataTable& table) override {
    Ellipsoid::declare(table);
    table.add("radius", radius_).help("radius").unit("m").required();
    table.add("bilateral", bilateral_).help("pull nodes on the other side back to it as well");
  }
  void init() override { initRadii(Vec3::Constant(radius_), "radius"); }

 private:
  double radius_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(ellipsoid_force_field) {
  factory.add<stroma::EllipsoidForceField>("EllipsoidForceField", "an ellipsoid that keeps nodes out or inside");
  factory.add<stroma::SphereForceField>("SphereForceField", "a sphere that keeps nodes out or inside");
}
