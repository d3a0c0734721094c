// SPDX-License-Identifier: LGPL-2.1-or-later
// InteractionEllipsoidForceField: ellipsoids that move with a rigid frame and push the points of another body out (positive
// stiffness) or keep them inside (negative stiffness).
//
// With the frame's centre c and orientation R, y = R^T (x - c) and the depth g(y) of EllipsoidForceField:
//
//   E = k/2 g^2,   F = -k g R grad g - d g u,   u = v - v_c - w x r,   r = x - c,   k = |stiffness|, d = damping
//   on the point F, on the frame -F and the torque -r x F
//
// `center` and `vradius` have three numbers for each ellipsoid, in the axes of the frame. If there are several, the one with
// the smallest sum y_j^2/r_j^2 is used: a point is outside if it is outside all of them. The tangent is the symmetric part of
// the derivative, without the rotation of r and of the damping. With object2_forces="false" there is no reaction on the frame,
// and the tangent ignores its motion.
//
// Source: names and attributes are SOFA's. There g is the number sqrt(q) - 1 (depth="ratio", as EllipsoidForceField has it), the
// frame gets the force at its centre and no torque, the damping is that of the point's own velocity (onCentre), and the forces
// between bodies without a common solver are those of the start of a step (explicitForce); object2_invert is there too.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-12"/>
//   <Node name="rigid">
//     <MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0 0 0.6 0.8"/>
//     <UniformMass totalMass="1" inertia="0.1 0.1 0.1"/>
//   </Node>
//   <Node name="soft">
//     <MechanicalObject name="dofs" position="0.5 0.2 0  0.1 0.3 0.1  -0.4 0 0.3"/>
//     <UniformMass totalMass="0.3"/>
//   </Node>
//   <InteractionEllipsoidForceField object1="@soft/dofs" object2="@rigid/dofs" center="0 0 0  0.2 0 0" stiffness="100"
//                                   vradius="1 0.6 0.8  0.5 0.9 0.5"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/loads/ellipsoid_level.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class InteractionEllipsoid final : public NodeGroupField<3> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("object1", points_).help("state of the points").required();
    table.addLink("object2", frames_).help("state of the frame").required();
    table.add("object2_dof_index", frame_).help("which frame of object2").min(0);
    table.add("center", centres_).recompiled().help("centres, in the axes of the frame").unit("m").required();
    table.add("vradius", radii_).help("half lengths of the axes of each").unit("m").required();
    table.add("stiffness", signed_stiffness_)
        .atOnce()
        .help("force over depth; positive: points are pushed out, negative: kept inside")
        .unit("N/m")
        .physical();
    table.add("damping", damping_constant_).help("force over velocity and depth").unit("N s/m^2").min(0);
    table.add("object2_forces", answers_).help("the reaction of the points acts on the frame");
    table.add("explicitDamping", explicit_).help("damping has no part in derivatives, as in SOFA");
    table.add("explicitForce", explicit_force_).help("the forces are no part of the matrix: not stable for stiff ones");
    table.add("onCentre", on_centre_).help("the frame gets no torque, and points are damped as if it stood still, as in SOFA");
    table.addChoice("depth", depth_of_, {"distance", "ratio"})
        .help("factor of the stiffness: the distance to first order, or SOFA's ratio of lengths minus one");
    for (const char* name : {"color", "draw"}) table.addVisualOnly(name);
  }

  void init() override {
    setFirstState(frames_, mstate_);
    ForceField::init();
    if (!state().hasFrames() || !points_.get() || !points_.get()->hasPointsOnly())
      throw ComponentError("object1 must have points and object2 rigid frames", "states of template Vec3 and Rigid3");
    checkNode(frame_, 0, state(), "object2_dof_index");
    if (centres_.empty() || centres_.size() != radii_.size())
      throw ComponentError(fmt::format("center has {} and vradius {} vectors", centres_.size(), radii_.size()), "as many of each");
    for (const Vec3& radii : radii_)
      if (!(radii.minCoeff() > 0)) throw ComponentError("vradius is not positive", "positive lengths");
    if (signed_stiffness_ == 0) warn("the stiffness is zero: the component has no effect");
  }

  std::vector<State*> states() const override { return {&state(), points_.get()}; }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    traits.conservative = answers_ && (damping_constant_ == 0 || isDamped());  // damping that no C says is in no energy
    traits.velocity_dependent = isDamped();
    traits.exact_tangent = answers_ && damping_constant_ == 0;
    if (on_centre_ || depth_of_ == DepthOf::ratio) traits.conservative = traits.exact_tangent = false;
    if (explicit_force_) {
      traits.conservative = traits.conservative && damping_constant_ == 0;
      traits.has_stiffness = traits.velocity_dependent = traits.exact_tangent = false;
    }
    return traits;
  }
  void compile() override {
    const Index centre = state().firstRow() + Index(2 * frame_);
    std::vector<Group> rows;
    for (Index i = 0; i < points_.get()->size(); ++i) rows.push_back({points_.get()->firstRow() + i, centre, centre + 1});
    setGroups(std::move(rows), isDamped());
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Group& row : rows_) {
      const double g = depthAt(place(row, x)).g;
      if (g > 0) sum += std::abs(signed_stiffness_) / 2 * g * g;
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows v, Rows f) override {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      stiffness_[i].setZero();
      if (!damping_.empty()) damping_[i].setZero();
      const Depth depth = depthAt(place(rows_[i], x));
      if (depth.g > 0) push(i, depth, x, v, f);
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  bool isDamped() const { return damping_constant_ > 0 && !explicit_ && !on_centre_; }
  /// In the axes of the frame.
  static Vec3 place(const Group& row, ConstRows x) {
    return orientationIn(x, row[2]).conjugate() * (Vec3(x[row[0]]) - Vec3(x[row[1]]));
  }
  Depth depthAt(const Vec3& y) const {
    std::size_t best = 0;
    const auto level = [&](std::size_t e) { return (y - centres_[e]).cwiseQuotient(radii_[e]).squaredNorm(); };
    for (std::size_t e = 1; e < radii_.size(); ++e)
      if (level(e) < level(best)) best = e;
    if (level(best) < 1e-24) return {};  // at the centre every way out is as near
    const bool by_ratio = depth_of_ == DepthOf::ratio;
    Depth depth = by_ratio ? ratioOf(y - centres_[best], radii_[best]) : levelOf(y - centres_[best], radii_[best]);
    if (signed_stiffness_ > 0) {
      depth.g *= -1;
      depth.gradient *= -1;
      depth.hessian *= -1;
    }
    return depth;
  }

  void push(std::size_t i, const Depth& depth, ConstRows x, ConstRows v, Rows f) {
    const auto [point, centre, turn] = rows_[i];
    const double k = std::abs(signed_stiffness_), c = damping_constant_ * depth.g;
    const Mat3 axes = orientationIn(x, turn).toRotationMatrix();
    const Vec3 n = axes * depth.gradient, arm = Vec3(x[point]) - Vec3(x[centre]);
    const Vec3 elastic = -k * depth.g * n;
    Vec3 force = elastic;
    const Vec3 carried = on_centre_ ? Vec3(Vec3::Zero()) : Vec3(Vec3(v[centre]) + Vec3(v[turn]).cross(arm));
    if (damping_constant_ > 0) force -= c * (Vec3(v[point]) - carried);
    f[point] += force;
    const Mat3 of_place = -k * (n * n.transpose() + depth.g * axes * depth.hessian * axes.transpose());
    stiffness_[i].block(0, 0) = of_place;
    if (!damping_.empty()) damping_[i].block(0, 0) = -c * Mat3::Identity();
    if (!answers_) return;
    f[centre] -= force;
    if (on_centre_) {
      stiffness_[i].block(1, 1) = of_place;
      stiffness_[i].block(0, 1) = stiffness_[i].block(1, 0) = -of_place;
      return;
    }
    f[turn] -= arm.cross(force);
    const Mat3 r = crossMatrix(arm), pull = crossMatrix(elastic);
    setFrameBlocks(stiffness_[i], of_place, of_place * r - pull);
    const Mat3 mixed = r * pull;
    stiffness_[i].block(2, 2) = (mixed + mixed.transpose()) / 2 - r * of_place * r;
    if (damping_.empty()) return;
    setFrameBlocks(damping_[i], -c * Mat3::Identity(), -c * r);
    damping_[i].block(2, 2) = c * r * r;
  }
  /// What follows from the derivatives of the force on the point with respect to it and to the turn.
  static void setFrameBlocks(DenseTangent<3>& tangent, const Mat3& of_place, const Mat3& of_turn) {
    tangent.block(1, 1) = of_place;
    tangent.block(0, 1) = tangent.block(1, 0) = -of_place;
    tangent.block(0, 2) = of_turn, tangent.block(1, 2) = -of_turn;
    tangent.block(2, 0) = of_turn.transpose(), tangent.block(2, 1) = -of_turn.transpose();
  }

  Link<State> points_{"mechanical state"}, frames_{"mechanical state"};
  int frame_ = 0;
  std::vector<Vec3> centres_, radii_;
  double signed_stiffness_ = 500, damping_constant_ = 0;
  bool answers_ = true, explicit_ = false, explicit_force_ = false, on_centre_ = false;
  enum class DepthOf : int { distance, ratio } depth_of_ = DepthOf::distance;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(interaction_ellipsoid_force_field) {
  factory.add<stroma::InteractionEllipsoid>("InteractionEllipsoidForceField",
                                            "ellipsoids of a rigid frame that push the points of another body");
}
