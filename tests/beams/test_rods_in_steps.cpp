// SPDX-License-Identifier: LGPL-2.1-or-later
// What integrators do with rods that are pushed: steps in parts, steps that are taken back, memories of rows, contact.
#include <cmath>
#include <numbers>
#include <iterator>
#include <sstream>

#include "framework/algebra/stop.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/step_limiter.h"
#include "tests/beams/pushed_rods.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

Vector copyOf(ConstRows rows) {
  Vector kept(rows.count);
  copy(rows, kept);
  return kept;
}
double difference(ConstRows a, ConstRows b) {
  double most = 0;
  for (Index i = 0; i < a.count; ++i) most = std::max(most, (Vec3(a[i]) - Vec3(b[i])).norm());
  return most;
}
std::vector<double> tableOf(Simulation& simulation, const std::string& wire) {
  for (const auto& component : simulation.root().components())
    if (component->name() == wire) {
      std::istringstream text(component->data().find("beams")->print());
      return {std::istream_iterator<double>(text), {}};
    }
  return {};
}

/// Explicit integrators tell each part of a step that it begins, and again when it has been taken back.
TEST(RodsInSteps, RodsMoveOnceInAStepThatIsMadeInParts) {
  Rods rods;
  rods.add("catheter", straight);
  rods.add("guide", hooked);
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.03 0.06\" speed=\"0.5\" controlledInstrument=\"1\"", 40));
  run(simulation, 3);
  System& system = *simulation.systems()[0];
  const Vector start = copyOf(system.x), velocity = copyOf(system.v);
  const auto tell = [&](double t, double t_end) {
    for (ForceField* field : system.forceFields()) dynamic_cast<StepListener&>(*field).stepBegins(system.x, t, t_end);
  };
  const double energy = system.potentialEnergy(system.x), moving = system.kineticEnergy();
  tell(0.3, 0.4);  // a node comes out, and others get its number
  const Vector moved = copyOf(system.x), rates = copyOf(system.v);
  EXPECT_GT(difference(moved, start), 1e-3);
  const auto goOn = [&] {
    for (Index row = 2 * 39; row < system.allRows(); row += 2) system.x[row].y() += 1e-5;
  };
  tell(0.3, 0.35);
  EXPECT_EQ(difference(system.x, moved), 0) << "the first part";
  goOn(), copy(moved, system.x);
  tell(0.3, 0.32);
  EXPECT_EQ(difference(system.x, moved), 0) << "the first part again";
  goOn();
  const Vector after = copyOf(system.x);
  tell(0.32, 0.34);
  EXPECT_EQ(difference(system.x, after), 0) << "the second part";
  goOn(), copy(after, system.x);
  tell(0.32, 0.4);
  EXPECT_EQ(difference(system.x, after), 0) << "and again";
  // all of the step again
  const double energy_after = system.potentialEnergy(system.x);
  copy(start, system.x), copy(velocity, system.v);
  EXPECT_EQ(system.potentialEnergy(system.x), energy) << "a step that failed leaves no beams";
  EXPECT_EQ(system.kineticEnergy(), moving);
  copy(after, system.x);
  EXPECT_EQ(system.potentialEnergy(system.x), energy_after) << "nor takes them away from one that goes on";
  copy(start, system.x);
  tell(0.3, 0.4);
  EXPECT_EQ(difference(system.x, moved), 0) << "from the start";
  EXPECT_EQ(difference(system.v, rates), 0);
}

TEST(RodsInSteps, AStepThatIsTakenBackIsMadeAgain) {
  Rods rods;
  rods.add("catheter", straight);
  rods.add("guide", hooked);
  const std::string scene = rods.scene("xtip=\"0.03 0.06\" speed=\"0.06\" controlledInstrument=\"1\" rotationInstrument=\"0 0.3\"", 40);
  Simulation straight_on = simulationFromText(scene), stopped = simulationFromText(scene);
  for (int i = 0; i < 20; ++i) {
    straight_on.step();
    StopRequest request;
    request.make();
    const std::uint64_t before = stopped.stateHash();
    EXPECT_TRUE(stopped.step(StopToken(request)).stopped) << i;
    EXPECT_EQ(stopped.stateHash(), before);
    stopped.step();
    ASSERT_EQ(stopped.stateHash(), straight_on.stateHash()) << i;
  }
}

/// What an integrator remembers of rows would be that of other places.
TEST(RodsInSteps, IntegratorsThatRememberRowsAreRefused) {
  const auto problems = [](const std::string& integrator) {
    Rods rods;
    rods.add("guide", straight);
    rods.integrator = integrator;
    return problemsOf(rods.scene("xtip=\"0.1\""));
  };
  for (const char* good : {"<EulerImplicitSolver/>", "<EulerImplicitSolver newtonIterations=\"20\"/>", "<BDFOdeSolver/>", "<StaticSolver/>",
                           "<TrapezoidalRuleSolver/>", "<EulerExplicitSolver/>", "<RungeKutta4Solver/>", "<CentralDifferenceSolver/>"})
    EXPECT_EQ(problems(good), "") << good;
  for (const char* bad : {"<NewmarkImplicitSolver/>", "<BDFOdeSolver order=\"2\"/>"}) {
    expectContains(problems(bad), "from step to step");
    expectContains(problems(bad), "EulerImplicitSolver");
  }
}

/// Nothing is made anew where nothing has changed.
TEST(RodsInSteps, ARodThatStandsStillMovesNoNodes) {
  Rods rods;
  rods.add("guide", hooked);
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.1\""));
  run(simulation, 3);
  System& system = *simulation.systems()[0];
  system.x[0] = Vec3(0, 0, 5);  // a node that waits, which a push would put back
  run(simulation, 2);
  EXPECT_EQ(system.x[0].z(), 5);
  simulation.setAttribute("/push", "rotationInstrument", "0.1");
  run(simulation, 1);
  EXPECT_EQ(system.x[0].z(), 0);
}

/// The tip of the outer one is nearer to that of the inner one than the threshold.
TEST(RodsInSteps, TipsThatAreNearStayWhereTheyAre) {
  Rods rods;
  rods.threshold = 0.01;
  rods.add("catheter", straight);
  rods.add("guide", straight);
  for (const char* tips : {"0.096 0.1", "0.1 0.096"}) {
    Simulation simulation = simulationFromText(rods.scene(fmt::format("xtip=\"{}\"", tips), 40));
    run(simulation, 10);
    EXPECT_LT((tipOf(simulation) - Vec3(0.1, 0, 0)).norm(), 1e-9) << tips;
    const std::vector<double> first = tableOf(simulation, "wire_catheter"), second = tableOf(simulation, "wire_guide");
    int shared = 0;
    for (std::size_t i = 0; i < first.size(); i += 14)
      if (first[i + 2] != 0 && second[i + 2] != 0) {
        ++shared;
        EXPECT_NEAR(first[i + 3], second[i + 3], 1e-12) << i / 14;
      }
    EXPECT_EQ(shared, 4) << tips;
  }
}

/// A helix in a straight rod with few beams: its own beams would turn by more than half a turn.
TEST(RodsInSteps, AHelixThatIsDrawnIntoAStraightRodIsDivided) {
  Rods rods;
  rods.add("catheter", "length=\"0.3\" straightLength=\"0.3\" radius=\"0.001\" youngModulus=\"1e9\" densityOfBeams=\"2\"");
  rods.add("guide", "length=\"0.35\" straightLength=\"0.3\" spireDiameter=\"0.012\" spireHeight=\"0\" radius=\"0.0005\" "
                    "radiusExtremity=\"0.0002\" youngModulus=\"1e8\" youngModulusExtremity=\"1e8\" densityOfBeams=\"4 6\"");
  Simulation simulation = simulationFromText(rods.scene("xtip=\"0.1 0.1\" speed=\"0.1\"", 60, 0.02));
  run(simulation, 100);
  EXPECT_NEAR(std::stod(valueOf(simulation, "xtip").substr(0, 3)), 0.3, 1e-12);
}

/// A rod whose tip is pushed against an oblique plane bends and slides along it.
std::string plane(const std::string& more = "") {
  return "<Node><MeshTopology triangles=\"0 1 2\"/><MechanicalObject name=\"skin\" position=\"0.3 0 0  0.29 0.002 0  0.29 -0.002 0\"/>"
         "<AdaptiveBeamMapping interpolation=\"@../wire_guide\"/><BarrierContact name=\"wall\" contactDistance=\"0.004\" stiffness=\"1e5\" "
         "planes=\"-0.6 0 0.8 -0.066\" " + more + "/></Node>";
}
/// Of the points on the tip [m].
double gapOf(Simulation& simulation) {
  const State& skin = *simulation.states()[1];
  double least = 1;
  for (Index i = 0; i < 3; ++i) least = std::min(least, Vec3(-0.6, 0, 0.8).dot(Vec3(skin.x()[i])) + 0.066);
  return least;
}
const std::string soft = "length=\"0.3\" straightLength=\"0.3\" radius=\"0.002\" youngModulus=\"1e6\" densityOfBeams=\"12\"";

TEST(RodsInSteps, PushedAgainstAPlaneARodSlidesAlongIt) {
  std::vector<Vec3> tips;
  for (const char* integrator : {"<EulerImplicitSolver newtonIterations=\"50\"/>", "<StaticSolver/>"}) {
    Rods rods;
    rods.add("guide", soft);
    rods.integrator = integrator, rods.inside = plane();
    Simulation simulation = simulationFromText(rods.scene("xtip=\"0.1\" speed=\"0.02\"", 30, 0.05));
    run(simulation, 30);
    simulation.setAttribute("/push", "speed", "0");
    run(simulation, 100);
    const Vec3 tip = tipOf(simulation);
    EXPECT_GT(gapOf(simulation), 0) << integrator;
    EXPECT_LT(gapOf(simulation), 0.004) << integrator;
    EXPECT_GT(tip.z(), 0.01) << integrator;
    tips.push_back(tip);
  }
  EXPECT_LT((tips[0] - tips[1]).norm(), 1e-5) << "one equilibrium";
}

/// The beam at the opening is thrust in each step: with the exact stiffness of its neighbours three of four steps did not converge.
TEST(RodsInSteps, AHookThatIsPushedConvergesInEachStep) {
  Simulation simulation = simulationFromText(R"(<Node name="root" dt="0.01" gravity="0 0 0">
    <WireRestShape name="guide" length="0.3" straightLength="0.25" spireDiameter="0.08" spireHeight="0" densityOfBeams="10 6"
      radius="0.0005" radiusExtremity="0.0005" youngModulus="1e9" youngModulusExtremity="5e8" massDensity="1000"
      massDensityExtremity="1000"/>
    <EulerImplicitSolver newtonIterations="20" rayleighStiffness="0.1" rayleighMass="0.1"/><SparseLDLSolver/>
    <RegularGridTopology n="20 1 1" min="0 0 0" max="0.3 0 0"/><MechanicalObject template="Rigid3"/>
    <WireBeamInterpolation name="wire" WireRestShape="@guide"/><AdaptiveBeamForceFieldAndMass interpolation="@wire"/>
    <InterventionalRadiologyController instruments="@wire" xtip="0.05" speed="0.2" startingPos="0 0 0  0 0 0 1" threshold="0.001"/>
    </Node>)");
  for (int step = 0; step < 60; ++step) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(!report.failed() && report.newton_converged) << step << ": " << report.reason;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
