// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma::test {

/// A bar of 1 m, 1000 kg/m^3 and 1 MPa that hangs from its top under 10 m/s^2, without lateral contraction:
/// u_y = -0.01 (s - s^2 / 2), s the distance from the top; elastic energy 1/2 E A 0.01^2 / 3.
inline constexpr const char* bar = R"(<Node name="root" gravity="0 -10 0" dt="1">
  <Node name="bar">
    <StaticSolver/><SparseLDLSolver/>
    <RegularGridTopology name="grid" n="2 3 2" min="0 0 0" max="0.01 1 0.01"/>
    <MechanicalObject name="dofs"/>
    <DiagonalMass massDensity="1000"/>
    <HexahedronFEMForceField name="fem" method="small" youngModulus="1e6" poissonRatio="0"/>
    <BoxROI name="top" box="-1 0.999 -1  1 1.001 1"/>
    <FixedProjectiveConstraint indices="@top.indices"/>
  </Node>
</Node>)";

}  // namespace stroma::test
