// SPDX-License-Identifier: LGPL-2.1-or-later
// EulerExplicitSolver: explicit Euler and its symplectic variant.
//
//   a = M^-1 f(x0, v0)
//   symplectic (the default):  v1 = v0 + h a,  x1 = x0 + h v1
//   otherwise:                 v1 = v0 + h a,  x1 = x0 + h v0
//
// a is projected onto the directions that constraints leave free. Both are of first order. The symplectic variant keeps the
// energy of an undamped body bounded as long as h w < 2, w the highest angular frequency of the mesh (about the speed of sound
// over the smallest height of an element); beyond that it diverges. The other variant gains energy at every step and is
// provided for comparison. Above the estimated limit a warning names the element that the fastest motion strains most. A
// diagonal mass is inverted once; a consistent one is solved for with the node's linear solver. With BarrierContact a step is
// subdivided where that is stiff; in the symplectic variant a then acts for half of the previous and half of the current
// substep.
//
// Example:
// <Node name="root" dt="0.001" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include "components/integrators/explicit_step.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class EulerExplicitSolver final : public ExplicitIntegrator {
 public:
  void declare(DataTable& table) override {
    ExplicitIntegrator::declare(table);
    table.add("symplectic", symplectic_).help("move the positions with the new velocity: keeps the energy bounded");
    table.addVisualOnly("threadSafeVisitor");
  }

 private:
  ExplicitScheme scheme() const override {
    ExplicitScheme scheme = fromRungeKutta("explicit Euler", {{}}, {1});
    if (symplectic_) {
      scheme.name = "symplectic Euler";
      scheme.x = {1};
    }
    return scheme;
  }
  bool symplectic_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(euler_explicit_solver) {
  factory.add<stroma::EulerExplicitSolver>("EulerExplicitSolver", "explicit or symplectic Euler");
}
