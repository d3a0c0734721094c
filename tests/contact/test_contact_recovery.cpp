// SPDX-License-Identifier: LGPL-2.1-or-later
// What goes wrong in scenes of contact: bodies that start crushed, barriers a million times too stiff, steps a thousand times too long.
// They regain their shape, no number is not finite and nothing passes through anything.
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double side = 0.04, gap = 0.0012, lid = 0.06;

struct Trouble {
  std::string name;
  double height;     ///< of the start, in heights at rest
  double stiffness;  ///< of the contact [Pa]; 2 kPa is a tenth of the modulus
  double dt;
  int steps;
};

/// A cube of 64 cells over a floor and under a lid, both of which it can touch.
std::string troubledScene(const Trouble& trouble, const std::string& integrator, const std::string& friction) {
  std::string start;
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 5; ++i)
        start += fmt::format("{} {} {}  ", 0.25 * side * i, 0.25 * side * j, gap + trouble.height * 0.25 * side * k);
  return fmt::format(
      "<Node name=\"root\" dt=\"{}\" gravity=\"0 0 -9.81\">{}<SparseLDLSolver/><Node name=\"a\">"
      "<RegularGridTopology name=\"mesh\" n=\"5 5 5\" min=\"0 0 {}\" max=\"{} {} {}\"/>"
      "<MechanicalObject name=\"dofs\" position=\"{}\" rest_position=\"@mesh.position\"/><UniformMass totalMass=\"0.06\"/>"
      "<HexahedronFEMForceField youngModulus=\"20 kPa\" poissonRatio=\"0.3\" method=\"svd\"/></Node>"
      "<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" planes=\"0 0 1 0  0 0 -1 {}\" contactDistance=\"1 mm\" "
      "stiffness=\"{}\" {}/></Node>",
      trouble.dt, integrator, gap, side, side, gap + side, start, -lid, trouble.stiffness, friction);
}

void expectRecovery(const Trouble& trouble, const std::string& integrator, const std::string& friction) {
  SCOPED_TRACE(integrator + " " + friction + " " + trouble.name);
  Simulation simulation = simulationFromText(troubledScene(trouble, integrator, friction));
  const State& state = *simulation.states().front();
  StepReport report;
  double low = 0, high = 0;
  for (int step = 0; step < trouble.steps; ++step) {
    report = simulation.step();
    ASSERT_FALSE(report.failed()) << "step " << step << ": " << report.reason;
    low = lid, high = 0;
    for (Index i = 0; i < state.size(); ++i) {
      const double z = state.x()[i].z();
      ASSERT_TRUE(Vec3(state.x()[i]).allFinite()) << "step " << step;
      low = std::min(low, z), high = std::max(high, z);
    }
    ASSERT_GT(low, 0) << "step " << step;
    ASSERT_LT(high, lid) << "step " << step;
  }
  // a barrier of 2 GPa in steps of 10 s makes more of the rounding of positions than there are loads, and a sentence says so
  EXPECT_TRUE(report.newton_converged || report.reason.find("round-off of positions") != std::string::npos) << report.reason;
  EXPECT_NEAR(high - low, side, 0.05 * side);  // its weight takes off half of that at most
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
}

TEST(ContactRecovery, BodiesInTroubleRegainTheirShape) {
  const std::string euler = "<EulerImplicitSolver newtonIterations=\"60\"/>";
  const std::string bdf = "<BDFOdeSolver order=\"2\" newtonIterations=\"60\"/>";
  for (const Trouble& trouble : {Trouble{"crushed", 0.05, 2e3, 0.01, 40}, Trouble{"flat", 0.001, 2e3, 0.01, 40},
                                 Trouble{"stiff", 1, 2e9, 0.01, 10}, Trouble{"long steps", 1, 2e3, 10, 5},
                                 Trouble{"stiff and crushed", 0.05, 2e9, 0.01, 40},
                                 Trouble{"crushed in long steps", 0.05, 2e3, 10, 8}, Trouble{"all of it", 0.05, 2e9, 10, 8}})
    for (const char* friction : {"", "friction=\"0.5\""}) {
      expectRecovery(trouble, euler, friction);
      if (trouble.dt < 1 && trouble.height != 0.001) expectRecovery(trouble, bdf, friction);
    }
}

/// Balls of a method that has no potential hit each other, and tangents have directions of negative curvature: along those the work of the
/// residual grows, and a search that asks for less of it found no step.
TEST(ContactRecovery, StepsInWhichSoftBallsHitEachOtherConverge) {
  Simulation simulation(loadScene(STROMA_SOURCE_DIR "/scenes/examples/balls_in_a_soft_bowl.xml", {}, factory(), modules()));
  for (int step = 0; step < 20; ++step) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged) << "step " << step << ": " << report.reason;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
