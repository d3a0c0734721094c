// SPDX-License-Identifier: LGPL-2.1-or-later
// Chains of points on rods that are pushed.
#include <algorithm>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/beams/pushed_rods.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {
const std::string catheter =
    "length=\"0.2\" straightLength=\"0.2\" radius=\"0.002\" youngModulus=\"1e9\" densityOfBeams=\"8\" numEdgesCollis=\"10\"";
const std::string guide = "length=\"0.3\" straightLength=\"0.25\" spireDiameter=\"0.05\" spireHeight=\"0\" radius=\"0.001\" "
                          "radiusExtremity=\"0.001\" youngModulus=\"1e9\" youngModulusExtremity=\"1e9\" densityOfBeams=\"5 4\" "
                          "numEdgesCollis=\"10 5\"";

std::string chain(const std::string& more = "") {
  return "<Node name=\"skin\"><EdgeSetTopologyContainer name=\"edges\"/><MultiAdaptiveBeamTopologicalMapping name=\"make\" "
         "ircontroller=\"@../push\" output=\"@edges\"/><MechanicalObject name=\"skin\"/><MultiAdaptiveBeamMapping "
         "ircontroller=\"@../push\"/>" + more + "</Node>";
}
std::vector<Vec3> pointsOf(Simulation& simulation) {
  const State& skin = *simulation.states()[1];
  std::vector<Vec3> points;
  for (Index i = 0; i < skin.nodes(); ++i) points.push_back(skin.x()[i]);
  return points;
}

/// The last of the frames.
Vec3 lastFrame(Simulation& simulation) {
  const State& frames = *simulation.states()[0];
  return frames.x()[frames.size() - 2];
}

/// Those of the outer rod up to its tip, then those of the inner one, which wait at the opening until there is a place for them.
TEST(ContactChains, PointsComeOutAsTheRodsDo) {
  Rods rods;
  rods.add("catheter", catheter), rods.add("guide", guide);
  rods.inside = chain();
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.05 0.03\" controlledInstrument=\"1\"", 40));
  const auto expectAlong = [&](const std::vector<double>& out, double tolerance) {
    const std::vector<Vec3> points = pointsOf(simulation);
    ASSERT_EQ(points.size(), 16u);
    for (std::size_t i = 0; i < 16; ++i) {
      const double at = i + out.size() < 16 ? 0 : out[i + out.size() - 16];
      EXPECT_NEAR(points[i].x(), at, tolerance) << i;
    }
  };
  expectAlong({0.01, 0.03, 0.05}, 1e-12);
  // the guide comes out of the catheter: stretches of 0.025 in its straight part, 0.01 in its hook
  simulation.setAttribute("/push", "xtip", "0.05 0.062");
  run(simulation, 1);
  std::istringstream places(valueOf(simulation, "collisionCurvAbs"));
  for (const double expected : {0.062, 0.052, 0.05, 0.03, 0.01}) {
    double place = 0;
    places >> place;
    EXPECT_NEAR(place, expected, 1e-12);
  }
  run(simulation, 20);
  const std::vector<Vec3> points = pointsOf(simulation);
  EXPECT_LT((points[15] - lastFrame(simulation)).norm(), 1e-12);
  EXPECT_NEAR((points[15] - points[14]).norm(), 0.01, 1e-4) << "along the hook";
  EXPECT_LT(Vec3(points[10]).norm(), 1e-12) << "waits";
  EXPECT_GT(Vec3(points[11]).norm(), 0.005);
}

/// A load on the last point is one on the tip, and runs go on from checkpoints to the last bit.
TEST(ContactChains, ALoadOnTheTipIsOneOnTheRodAndRunsRepeatThemselves) {
  Rods rods;
  rods.add("catheter", catheter), rods.add("guide", guide);
  const std::string push = "xtip=\"0.03 0.05\" controlledInstrument=\"1\" speed=\"0.02\"";
  const auto with = [&](const std::string& inside) { return rods.inside = inside, rods.scene(push, 40); };
  const std::string carried = with(chain("<ConstantForceField indices=\"15\" forces=\"0 0 1e-3\"/>"));
  Simulation direct = simulationFromText(with("<ConstantForceField indices=\"39\" forces=\"0 0 1e-3 0 0 0\"/>" + chain()));
  Simulation one = simulationFromText(carried), other = simulationFromText(carried);
  run(direct, 30), run(one, 15);
  const Archive kept = one.checkpoint();
  run(one, 15);
  EXPECT_LT((lastFrame(one) - lastFrame(direct)).norm(), 1e-7);
  EXPECT_GT(lastFrame(one).x(), 0.08);
  other.restore(kept.readable());
  run(other, 15);
  EXPECT_EQ(one.stateHash(), other.stateHash());
  EXPECT_EQ(pointsOf(one)[12], pointsOf(other)[12]);
  one.reset();
  EXPECT_LT((pointsOf(one)[15] - lastFrame(one)).norm(), 1e-12) << "back in";
  run(one, 30);
  EXPECT_EQ(one.stateHash(), other.stateHash());
}

/// Pushed against an oblique plane the rods bend: each point of the chain that goes into it is pushed out.
TEST(ContactChains, AWallHoldsAllPointsBack) {
  Rods rods;
  rods.add("catheter", "length=\"0.2\" straightLength=\"0.2\" radius=\"0.003\" youngModulus=\"1e6\" densityOfBeams=\"8\" "
                       "numEdgesCollis=\"10\"");
  rods.add("guide", "length=\"0.3\" straightLength=\"0.3\" radius=\"0.002\" youngModulus=\"1e6\" densityOfBeams=\"12\" "
                    "numEdgesCollis=\"16\"");
  rods.integrator = "<EulerImplicitSolver newtonIterations=\"50\"/>";
  rods.inside = chain("<PlaneForceField normal=\"-0.6 0 0.8\" d=\"-0.066\" stiffness=\"1e3\"/>");
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.06 0.1\" controlledInstrument=\"1\" speed=\"0.02\"", 40, 0.05));
  run(simulation, 40);
  simulation.setAttribute("/push", "speed", "0");
  run(simulation, 60);
  double least = 1;
  for (const Vec3& point : pointsOf(simulation)) least = std::min(least, Vec3(-0.6, 0, 0.8).dot(point) + 0.066);
  EXPECT_LT(least, 0) << "it touches";
  EXPECT_GT(least, -1e-5);
  EXPECT_GT(lastFrame(simulation).z(), 0.01);
}

TEST(ContactChains, SayWhatIsWrong) {
  Rods rods;
  rods.add("catheter", catheter), rods.add("guide", guide);
  const auto problems = [&](const std::string& inside) { return rods.inside = inside, problemsOf(rods.scene("xtip=\"0.05 0.03\"", 60)); };
  EXPECT_EQ(problems(chain()), "");
  expectContains(problems("<Node><MechanicalObject position=\"0 0 0\"/><MultiAdaptiveBeamMapping useCurvAbs=\"false\"/></Node>"),
                 "useCurvAbs is false");
  expectContains(problemsOf("<Node><MechanicalObject template=\"Rigid3\" position=\"0 0 0 0 0 0 1\"/><UniformMass totalMass=\"1\"/><Node>"
                            "<MechanicalObject position=\"0 0 0\"/><MultiAdaptiveBeamMapping/></Node></Node>"),
                 "there is no controller that pushes rods");
  expectContains(problemsOf("<Node><MultiAdaptiveBeamTopologicalMapping/></Node>"), "there is no controller that pushes rods");
  expectContains(problems("<Node><MultiAdaptiveBeamTopologicalMapping nbEdges=\"100000\"/><MechanicalObject/></Node>"),
                 "the chain has 100000 edges");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
