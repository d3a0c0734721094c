// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes of bodies that are tied to each other.
#pragma once
#include <fmt/format.h>

#include <string>

namespace stroma::test {

/// A block of 2 x 2 x 2 unit cells from x = `from`, in a node of its own.
inline std::string block(const std::string& name, int cells, double from, const std::string& more) {
  return fmt::format(R"(<Node name="{0}"><RegularGridTopology name="grid" n="{1} 3 3" min="{2} 0 0" max="{3} 2 2"/>
    <MechanicalObject name="dofs"/><DiagonalMass topology="@grid" massDensity="{4}"/>{5}
    <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" cutting="ten"/>
    <TetrahedronFEMForceField mstate="@../dofs" topology="@tets" youngModulus="3000" poissonRatio="0.3" method="svd"/></Node></Node>)",
                     name, cells + 1, from, from + cells, 10, more);
}

inline std::string held(const std::string& name) {
  return "<BoxROI name='" + name +
         "' box='-0.1 -0.1 -0.1 0.1 2.1 2.1' position='@dofs.rest_position'/><FixedProjectiveConstraint indices='@" +
         name + ".indices'/>";
}

inline std::string root(const std::string& integrator, const std::string& solver, const std::string& bodies) {
  return "<Node name='root' dt='0.01' gravity='0 -9.81 0'>" + integrator + solver + bodies + "</Node>";
}

/// Nodes without forces between them.
inline std::string points(const std::string& positions, const std::string& velocities, const std::string& masses,
                          const std::string& constraints, const std::string& integrator = "<EulerExplicitSolver/>") {
  return fmt::format(R"(<Node name="root" dt="0.1" gravity="0 0 0">{}<CGLinearSolver iterations="50" tolerance="1e-14"/>
    <MechanicalObject name="dofs" position="{}" velocity="{}"/><DiagonalMass vertexMass="{}"/>{}</Node>)",
                     integrator, positions, velocities, masses, constraints);
}

}  // namespace stroma::test
