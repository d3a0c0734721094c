// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes with rods that an InterventionalRadiologyController pushes.
#pragma once
#include <fmt/format.h>

#include <string>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_text.h"

namespace stroma::test {

struct Rods {
  std::string shapes, wires, names;
  double threshold = 0.0005;
  void add(const std::string& name, const std::string& shape) {
    shapes += fmt::format("<WireRestShape name=\"{}\" {} massDensity=\"1000\" massDensityExtremity=\"1000\"/>", name, shape);
    wires += fmt::format("<WireBeamInterpolation name=\"wire_{0}\" WireRestShape=\"@{0}\"/>"
                         "<AdaptiveBeamForceFieldAndMass interpolation=\"@wire_{0}\"/>",
                         name);
    names += "@wire_" + name + " ";
  }
  std::string integrator = "<EulerImplicitSolver newtonIterations=\"30\"/>", inside;
  std::string scene(const std::string& controller, int nodes = 30, double dt = 0.1) const {
    return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}{}<SparseLDLSolver/>
    <RegularGridTopology n="{} 1 1" min="0 0 0" max="1 0 0"/><MechanicalObject name="dofs" template="Rigid3"/>{}
    <InterventionalRadiologyController name="push" instruments="{}" threshold="{}" {}/>{}</Node>)",
                       dt, shapes, integrator, nodes, wires, names, threshold, controller, inside);
  }
};
inline const std::string straight = "length=\"0.3\" straightLength=\"0.3\" radius=\"0.001\" youngModulus=\"1e9\" densityOfBeams=\"12\"";
inline const std::string hooked = "length=\"0.3\" straightLength=\"0.25\" spireDiameter=\"0.05\" spireHeight=\"0\" radius=\"0.001\" "
                           "radiusExtremity=\"0.001\" youngModulus=\"1e9\" youngModulusExtremity=\"1e9\" densityOfBeams=\"5 4\"";

inline Vec3 tipOf(Simulation& simulation) {
  const System& system = *simulation.systems()[0];
  return system.x[system.allRows() - 2];
}
/// How many steps were not solved: those after a jump of a tip may not be, the last one is.
inline int run(Simulation& simulation, int steps) {
  int unsolved = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
    if (report.diverged) return steps;
    if (!report.newton_converged) ++unsolved;
    if (i + 1 == steps) EXPECT_TRUE(report.newton_converged) << i << ": " << report.newton_residual;
  }
  return unsolved;
}
/// The sum of the mass of all places along x [kg].
inline double alongMass(Simulation& simulation) {
  System& system = *simulation.systems()[0];
  Vector along(system.allRows()), momentum(system.allRows());
  for (Index row = 0; row < system.allRows(); row += 2) along[row] = Vec3::UnitX();
  system.addMassProduct(along, 1, momentum);
  double sum = 0;
  for (Index row = 0; row < system.allRows(); row += 2) sum += momentum[row].x();
  return sum;
}
inline std::string valueOf(Simulation& simulation, const std::string& name) {
  for (const auto& component : simulation.root().components())
    if (component->name() == "push") return component->data().find(name)->print();
  return {};
}

}  // namespace stroma::test
