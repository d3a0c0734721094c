// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fmt/format.h>

#include <string>

namespace stroma::test {

/// A bar of tetrahedra that bends far under its weight, by implicit Euler with these attributes. The bar is 0.4 m long and 0.1 m thick,
/// E is 30 kPa; `elasticity` has the rest of its attributes.
inline std::string bentBar(double dt, double mass, const std::string& integrator, const std::string& solver,
                           const std::string& elasticity) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 -9.81 0">
    <EulerImplicitSolver {}/>
    {}
    <RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="0.4 0.1 0.1"/>
    <MechanicalObject name="dofs"/><UniformMass totalMass="{}"/>
    <BoxROI name="wall" box="-0.001 -1 -1  0.001 1 1"/><FixedProjectiveConstraint indices="@wall.indices"/>
    <Node name="cells"><TetrahedronSetTopologyContainer name="tetrahedra"/>
      <Hexa2TetraTopologicalMapping input="@../grid" output="@tetrahedra" cutting="five"/>
      <TetrahedronFEMForceField mstate="@../dofs" topology="@tetrahedra" youngModulus="30000" {}/></Node></Node>)",
                     dt, integrator, solver, mass, elasticity);
}

}  // namespace stroma::test
