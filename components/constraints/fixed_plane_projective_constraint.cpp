// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedPlaneProjectiveConstraint: nodes that may slide in a plane.
//
//   P_i = I - n n^T, n = direction / |direction|
//
// The component of the velocity along `direction` does not change. The nodes are those of `indices` or, when dmin and dmax are
// given, those with dmin < n.X < dmax in their initial position X. With ignoreMissing both selections are used, and both may
// be empty.
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

#include <set>

#include "components/constraints/held_nodes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FixedPlaneProjectiveConstraint final : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.add("direction", direction_).help("normal of the plane").unit("-").required();
    table.add("dmin", lowest_).help("with dmax: fix the nodes between two planes").unit("m");
    table.add("dmax", highest_).help("with dmin: fix the nodes between two planes").unit("m");
  }

  void init() override {
    if (!(direction_.norm() > 0)) throw ComponentError("direction is zero", "a vector that is not zero");
    const Vec3 normal = direction_.normalized();
    setProjectors({Mat3::Identity() - normal * normal.transpose()});
    const bool between = data().find("dmin")->isSet() || data().find("dmax")->isSet();
    const bool is_listed = data().find("indices")->isSet() || data().find("fixAll")->isSet();
    if (!between && (is_listed || !ignoresMissing())) return HeldNodes::init();
    if (is_listed && !ignoresMissing())
      throw ComponentError("the nodes are given both by indices and by dmin and dmax", "one of them");
    if (is_listed)
      HeldNodes::init();
    else
      ProjectiveConstraint::init();  // NOLINT(bugprone-parent-virtual-call): HeldNodes would ask for indices
    std::set<Index> found;
    if (is_listed) found.insert(nodes().begin(), nodes().end());
    for (Index i = 0; i < state().nodes(); ++i) {
      const double d = normal.dot(state().position[i * state().rows_per_node]);
      if (d > lowest_ && d < highest_) found.insert(i);
    }
    if (found.empty() && !ignoresMissing())
      throw ComponentError(
          fmt::format("no node of {} is between the planes {:g} and {:g}", state().path(), lowest_, highest_),
          "dmin < direction.x < dmax for some nodes");
    if (found.empty()) warn("no node is held");
    setNodes({found.begin(), found.end()});
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
