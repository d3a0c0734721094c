// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes of bodies that are tied to each other.
#pragma once
#include <fmt/format.h>

#include <string>

#include "tests/support/scene_text.h"

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

/// Runs two blocks that `ties` joins at nodes (2, j, k) of the first and (0, j, k) of the second, 40 steps or one of
/// statics, and expects positions and velocities of the block that is both, joined nodes up to `gap` [m] from each other.
inline void expectTheMergedBlock(const std::string& integrator, const std::string& solver, const std::string& ties,
                                 double gap) {
  Simulation two =
      simulationFromText(root(integrator, solver, block("a", 2, 0, held("wall")) + block("b", 2, 2, "") + ties));
  Simulation one = simulationFromText(root(integrator, solver, block("whole", 4, 0, held("wall"))));
  const System &apart = *two.systems().at(0), &merged = *one.systems().at(0);
  const bool is_static = integrator.find("Static") != std::string::npos;
  for (int step = 0; step < (is_static ? 1 : 40); ++step) {
    EXPECT_FALSE(two.step().diverged);
    EXPECT_FALSE(one.step().diverged);
  }
  double moved = 0;
  for (int body = 0; body < 2; ++body)
    for (int jk = 0; jk < 9; ++jk)
      for (int i = 0; i < 3; ++i) {
        const Index in_two = 27 * body + i + 3 * jk, in_one = i + 2 * body + 5 * jk;
        EXPECT_LT((apart.x[in_two] - merged.x[in_one]).norm(), 1e-8);
        EXPECT_LT((apart.v[in_two] - merged.v[in_one]).norm(), 1e-7);
        moved = std::max(moved, (merged.x[in_one] - one.states()[0]->rest_position[std::size_t(in_one)]).norm());
      }
  EXPECT_GT(moved, 0.05) << "something happened";
  for (int jk = 0; jk < 9; ++jk) EXPECT_LE((apart.x[2 + 3 * jk] - apart.x[27 + 3 * jk]).norm(), gap);
}

/// Nodes without forces between them.
inline std::string points(const std::string& positions, const std::string& velocities, const std::string& masses,
                          const std::string& constraints, const std::string& integrator = "<EulerExplicitSolver/>") {
  return fmt::format(R"(<Node name="root" dt="0.1" gravity="0 0 0">{}<CGLinearSolver iterations="50" tolerance="1e-14"/>
    <MechanicalObject name="dofs" position="{}" velocity="{}"/><DiagonalMass vertexMass="{}"/>{}</Node>)",
                     integrator, positions, velocities, masses, constraints);
}

}  // namespace stroma::test
