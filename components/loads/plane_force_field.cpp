// SPDX-License-Identifier: LGPL-2.1-or-later
// PlaneForceField: a plane that pushes nodes to the side its normal points to.
//
// With g = d - n.x the depth of a node behind the plane n.x = d (n of unit length), where g > 0:
//
//   E = k/2 g^2,   f = k g n - c g v,   df/dx = -k n n^T (and the normal part of the damping),   df/dv = -c g I
//
// A body of mass m rests at the depth m g_0 / k per node that carries it. maxForce limits k g. bilateral also pulls nodes in
// front of the plane back to it (the damping is then proportional to |g|). For frames it acts on the centres.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0.1 0  1 0 0  2 0.05 0"/>
//   <UniformMass totalMass="0.3"/>
//   <PlaneForceField normal="0 1 0" d="0" stiffness="1000" damping="20"/>
// </Node>
#include "components/loads/penalty_field.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PlaneForceField final : public PenaltyField {
 public:
  void declare(DataTable& table) override {
    PenaltyField::declare(table);
    table.add("normal", normal_).recompiled().help("normal of the plane, to the side that is left free").unit("-");
    table.add("d", offset_).atOnce().help("distance of the plane from the origin along the normal").unit("m");
    table.add("stiffness", stiffness_constant_).atOnce().help("force over depth").unit("N/m").min(0).physical();
    table.add("maxForce", largest_force_).atOnce().help("largest force on a node; 0: not limited").unit("N").min(0);
    table.add("bilateral", bilateral_).help("pull nodes in front of the plane back to it as well");
    for (const char* name : {"showPlane", "planeColor", "showPlaneSize"}) table.addVisualOnly(name);
  }
  void init() override {
    PenaltyField::init();
    if (!state().hasPointsOnly() && !state().hasFrames())
      throw ComponentError("this force field acts on points, and " + state().path() + " has numbers", "a state of points or of frames");
    if (!(normal_.norm() > 0)) throw ComponentError("normal has no direction", "a vector that is not zero");
    unit_normal_ = normal_.normalized();
  }

 protected:
  bool takesAllRows() const override { return true; }  // the centres of frames
  Depth depth(const Vec3& x) const override {
    const double g = offset_ - unit_normal_.dot(x);
    if (bilateral_ && g < 0) return {-g, unit_normal_, Mat3::Zero(), true};
    return {g, -unit_normal_, Mat3::Zero()};
  }

 private:
  Vec3 normal_ = Vec3::UnitY(), unit_normal_ = normal_;
  double offset_ = 0;
  bool bilateral_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(plane_force_field) {
  factory.add<stroma::PlaneForceField>("PlaneForceField", "a plane that pushes nodes to one side");
}
