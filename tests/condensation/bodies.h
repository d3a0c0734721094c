// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes of linear bodies with the solver left open, and the comparison of what two solvers make of them.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// A block of 4 x 3 x 6 cells held at z = 0; `cells`: "hexahedra" or "tetrahedra".
struct Block {
  std::string solver = {};
  std::string loads = {};
  std::string cells = "tetrahedra";
  std::string more = {};  ///< further components
  std::string young = "5000";
  std::string mass = "<UniformMass totalMass=\"0.7\"/>";
  std::string gravity = "0.3 -9.81 0.2";
  double dt = 0.02;

  std::string text() const {
    const std::string grid = "<RegularGridTopology name=\"grid\" n=\"5 4 7\" min=\"0 0 0\" max=\"0.08 0.06 0.14\"/>";
    const bool tetrahedra = cells == "tetrahedra";
    return "<Node name=\"root\" dt=\"" + std::to_string(dt) + "\" gravity=\"" + gravity + "\">" + solver +
           (tetrahedra ? "<Node name=\"source\">" + grid + "</Node>" : "") + "<Node name=\"body\">" +
           (tetrahedra ? "<TetrahedronSetTopologyContainer name=\"cells\"/><Hexa2TetraTopologicalMapping "
                         "input=\"@../source/grid\" output=\"@cells\"/>"
                       : grid) +
           "<MechanicalObject name=\"dofs\"/>" + mass + (tetrahedra ? "<Tetrahedron" : "<Hexahedron") +
           "FEMForceField name=\"fem\" method=\"small\" youngModulus=\"" + young +
           "\" poissonRatio=\"0.35\"/><FixedProjectiveConstraint name=\"floor\" indices=\"" + nodes(0, 20) + "\"/>" +
           loads + more + "</Node></Node>";
  }
  static std::string nodes(int from, int to) {
    std::string list;
    for (int i = from; i < to; ++i) list += std::to_string(i) + " ";
    return list;
  }
};

inline Vector displacement(const Simulation& simulation) {
  simulation.complete();
  const System& system = *simulation.systems().front();
  Vector u(system.allRows());
  copy(system.x, u);
  for (const State* state : system.states())
    for (Index i = 0; i < state->size(); ++i) u[state->firstRow() + i] -= state->rest_position[i];
  return u;
}

/// |a - b| / |b|
inline double difference(const Vector& a, const Vector& b) {
  Vector d(a.count());
  copy(a, d);
  axpy(-1, b, d);
  return norm(d) / norm(b);
}

inline Vector after(const std::string& scene, int steps) {
  Simulation simulation = simulationFromText(scene);
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
    EXPECT_TRUE(report.newton_converged) << "step " << i << ": " << report.reason;
    EXPECT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
  return displacement(simulation);
}

inline const std::string condensed_in_time[] = {
    "<CondensedDynamicSolver/>", "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\"/>",
    "<CondensedDynamicSolver condensed=\"false\" solve=\"inverse\"/>"};
inline const std::string condensed_statics[] = {"<CondensedStaticSolver/>", "<CondensedStaticSolver condensed=\"false\"/>"};

/// All `solvers` against the `whole` body, and that its loads matter.
template <class Solvers>
void expectWhole(const Solvers& solvers, const std::string& whole, Block block, int steps, double tolerance) {
  block.solver = whole;
  const Vector expected = after(block.text(), steps);
  for (const std::string& solver : solvers) {
    SCOPED_TRACE(solver);
    block.solver = solver;
    EXPECT_LT(difference(after(block.text(), steps), expected), tolerance);
  }
  block.loads.clear(), block.solver = whole;
  EXPECT_GT(difference(after(block.text(), steps), expected), 1e-3) << "nothing happens";
}

}  // namespace stroma::test
