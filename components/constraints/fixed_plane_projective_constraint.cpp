// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedPlaneProjectiveConstraint: nodes that may slide in a plane.
//
//   P_i = I - n n^T, n = direction / |direction|
//
// The component of the velocity along `direction` does not change. The nodes are those of `indices` or, when dmin and
// dmax are given, those with dmin < n.X < dmax in their initial position X.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <FixedPlaneProjectiveConstraint direction="1 1 0" dmin="-0.1" dmax="0.9"/>
// </Node>
#include <fmt/format.h>

#include "components/constraints/held_nodes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FixedPlaneProjectiveConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.add("direction", direction_).help("normal of the plane").unit("-").required();
    table.add("dmin", lowest_).help("with dmax: hold the nodes between two planes").unit("m");
    table.add("dmax", highest_).help("with dmin: hold the nodes between two planes").unit("m");
  }

  void init() override {
    if (!(direction_.norm() > 0)) throw ComponentError("direction is zero", "a vector that is not zero");
    const Vec3 normal = direction_.normalized();
    setProjectors({Mat3::Identity() - normal * normal.transpose()});
    const bool between = data().find("dmin")->isSet() || data().find("dmax")->isSet();
    if (!between) return HeldNodes::init();
    if (data().find("indices")->isSet() || data().find("fixAll")->isSet())
      throw ComponentError("the nodes are given both by indices and by dmin and dmax", "one of them");
    ProjectiveConstraint::init();  // NOLINT(bugprone-parent-virtual-call): HeldNodes would ask for indices
    std::vector<Index> found;
    for (Index i = 0; i < state().size(); ++i) {
      const double d = normal.dot(state().position[i]);
      if (d > lowest_ && d < highest_) found.push_back(i);
    }
    if (found.empty())
      throw ComponentError(
          fmt::format("no node of {} lies between the planes {:g} and {:g}", state().path(), lowest_, highest_),
          "dmin < direction.x < dmax for some nodes");
    setNodes(std::move(found));
  }

 private:
  Vec3 direction_ = Vec3::Zero();
  double lowest_ = 0, highest_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fixed_plane_projective_constraint) {
  factory.add<stroma::FixedPlaneProjectiveConstraint>("FixedPlaneProjectiveConstraint",
                                                      "Lets nodes slide in planes only");
}
