// SPDX-License-Identifier: LGPL-2.1-or-later
// Obstacles on a path beside each integrator, against closed forms: what they lift goes along with them, and belts draw with mu times the
// weight. What a hand leads does not end a run, and a reset takes it back. What is thin ends its steps too.
#include "framework/mechanics/step_limiter.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double g = 9.81;
const std::vector<std::string> implicit_ones{
    "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<EulerImplicitSolver trapezoidalScheme=\"true\" newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<TrapezoidalRuleSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<NewmarkImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>",
    "<BDFOdeSolver order=\"2\" newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>"};
const std::string plane = "planes=\"0 0 1 0\"", box = "boxes=\"-1 -1 -0.1 1 1 0\"";

/// A soft cube of 1 kg that stands on an obstacle, or has a hand below.
std::string cubeOn(const std::string& obstacle, double young, const std::string& more, const std::string& state = "") {
  return fmt::format(
      "<RegularGridTopology n=\"3 3 3\" min=\"0 0 0.00095\" max=\"0.1 0.1 0.10095\"/><MechanicalObject name=\"dofs\" {}/>"
      "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"0.3\"/>"
      "<BarrierContact name=\"contact\" contactDistance=\"1e-3\" stiffness=\"1e5\" {} {}/>",
      state, young, obstacle, more);
}

Vec3 mean(const Simulation& simulation, bool of_velocities) {
  const State& state = *simulation.states().front();
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < state.size(); ++i) sum += of_velocities ? Vec3(state.v()[i]) : Vec3(state.x()[i]);
  return sum / double(state.size());
}

/// z = z0 + c t: the cube goes up with the ramp from the start. In a step the ramp comes half of the gap.
TEST(MovingObstacles, ARampLiftsACubeAsFastAsItGoes) {
  constexpr double c = 0.05, dt = 0.01;
  std::string velocities = "velocity=\"";
  for (int i = 0; i < 27; ++i) velocities += fmt::format("0 0 {} ", c);
  for (const std::string& integrator : implicit_ones)
    for (const std::string& obstacle : {plane, box}) {
      SCOPED_TRACE(integrator + obstacle);
      Simulation simulation = simulationFromText(
          contactScene(cubeOn(obstacle, 1e6, "keyTimes=\"0 10\" movements=\"0 0 0  0 0 0.5\"", velocities + "\""), dt,
                       Vec3(0, 0, -g), integrator));
      const double start = mean(simulation, false).z();
      for (int i = 0; i < 30; ++i) {
        expectCleanStep(simulation, i, false);
        if (HasFatalFailure()) return;
        ASSERT_NEAR(mean(simulation, false).z(), start + c * dt * (i + 1), 2e-4) << "step " << i;
      }
    }
}

/// A solve that is stopped while obstacles are half way leaves them there, and bodies go back to where the step starts. The step that
/// begins again has obstacles where they were: else they would be in bodies, and no filter would have seen it.
TEST(MovingObstacles, AStepThatWasStoppedBeginsAgainWithThem) {
  for (const std::string& obstacle : {plane, box}) {
    FieldUnderTest t(contactScene(cubeOn(obstacle, 1e6, "keyTimes=\"0 1\" movements=\"0 0 0  0 0 0.05\"")), "BarrierContact");
    auto& limiter = dynamic_cast<StepLimiter&>(t.field());
    const auto moved = [&t] {
      std::istringstream text(t.field().data().find("moved")->print());
      double x = 0, y = 0, z = 0;
      text >> x >> y >> z;
      return z;
    };
    Vector start(t.x.count());
    copy(t.x, start);
    limiter.stepBegins(start, 0, 0.01);
    ASSERT_TRUE(limiter.hasRemainingMotion());
    limiter.advanceRemainingMotion(0.5);
    ASSERT_NEAR(moved(), 2.5e-4, 1e-12);
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] += Vec3(0, 0, 3e-4);
    t.force();
    ASSERT_TRUE(limiter.updatesLagged(t.x)) << "they have a way left";
    limiter.stepBegins(start, 0, 0.01);
    EXPECT_EQ(moved(), 0);
    EXPECT_TRUE(limiter.hasRemainingMotion());
  }
}

/// Without a slip the belt would have 1 m/s; after 0.2 s the cube has mu g t.
TEST(MovingObstacles, BeltsDrawWithTheirFriction) {
  constexpr double mu = 0.2, time = 0.2;
  std::vector<std::pair<std::string, double>> all;
  for (const std::string& integrator : implicit_ones) all.emplace_back(integrator, 0.01);
  for (const char* integrator : {"<EulerExplicitSolver/>", "<RungeKutta2Solver/>", "<RungeKutta4Solver/>"})
    all.emplace_back(integrator, 5e-4);
  for (const std::pair<std::string, double>& each : all)
    for (const std::string& obstacle : {plane, box}) {
      SCOPED_TRACE(each.first + obstacle);
      Simulation simulation = simulationFromText(
          contactScene(cubeOn(obstacle, 1e5, fmt::format("friction=\"{}\" keyTimes=\"0 10\" movements=\"0 0 0  10 0 0\"", mu)),
                       each.second, Vec3(0, 0, -g), each.first));
      for (int i = 0; i < std::lround(time / each.second); ++i) {
        expectCleanStep(simulation, i, false);
        if (HasFatalFailure()) return;
      }
      EXPECT_NEAR(mean(simulation, true).x(), mu * g * time, 0.01 * mu * g * time);
    }
}

/// A hand that jumps by 5 cm is led by explicit steps at a speed that barriers stop.
TEST(MovingObstacles, AHandMayJumpInExplicitSteps) {
  for (const char* integrator : {"<EulerExplicitSolver/>", "<CentralDifferenceSolver/>", "<RungeKutta4Solver/>"}) {
    SCOPED_TRACE(integrator);
    Simulation simulation =
        simulationFromText(contactScene(cubeOn(box, 1e5, "friction=\"0.3\""), 5e-4, Vec3(0, 0, -g), integrator));
    for (int i = 0; i < 130; ++i) {
      if (i == 10) simulation.setAttribute("/contact", "offset", "0 0 0.05");
      expectCleanStep(simulation, i, false);
      if (HasFatalFailure()) return;
      ASSERT_EQ(outputOf(simulation, "crossings"), 0);
    }
    EXPECT_NEAR(numbersOf(simulation, "moved").at(2), 0.05, 1e-12) << "it has come";
    EXPECT_GT(mean(simulation, false).z(), 0.1) << "the cube with it";
  }
}

/// A membrane of cells of 1 cm that is held at its rim, and a needle 1 mm thick above it that goes down by 10 mm per step.
std::string needleOverMembrane() {
  constexpr int n = 13;
  std::string positions, triangles, rim;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = i + n * j;
      positions += fmt::format("{} {} 0 ", 0.01 * i - 0.06, 0.01 * j - 0.06);
      if (i % (n - 1) == 0 || j % (n - 1) == 0) rim += fmt::format("{} ", a);
      if (i + 1 < n && j + 1 < n) triangles += fmt::format("{} {} {}  {} {} {}  ", a, a + 1, a + n + 1, a, a + n + 1, a + n);
    }
  return fmt::format(
      "<MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass totalMass=\"0.02\"/>"
      "<TriangularFEMForceField youngModulus=\"1e6\" poissonRatio=\"0.3\" thickness=\"1e-3\"/>"
      "<FixedProjectiveConstraint indices=\"{}\"/>"
      "<BarrierContact name=\"contact\" contactDistance=\"2e-3\" friction=\"0.2\" keyTimes=\"0 0.006 10\" "
      "movements=\"0 0 0  0 0 -0.06  0 0 -0.06\" capsules=\"0.003 0.002 0.03  0.003 0.002 0.1 0.0005\"/>",
      positions, triangles, rim);
}

/// Where Newton's line search came back to where the step starts, what waited to go on was forgotten, and the step had no end.
TEST(MovingObstacles, ANeedleGoesThroughItsStepsAndNotThroughAMembrane) {
  constexpr double start = 0.0295, way = 0.01;
  const std::string integrator = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-5\" rayleighMass=\"1\"/>";
  Simulation simulation = simulationFromText(contactScene(needleOverMembrane(), 0.001, Vec3::Zero(), integrator));
  const State& state = *simulation.states().front();
  for (int i = 0; i < 6; ++i) {
    expectCleanStep(simulation, i);
    if (HasFatalFailure()) return;
    const double tip = start - way * (i + 1);
    ASSERT_NEAR(numbersOf(simulation, "moved").at(2), -way * (i + 1), 1e-12) << "step " << i;
    ASSERT_EQ(outputOf(simulation, "crossings"), 0) << "step " << i;
    double lowest = 0;
    for (Index node = 0; node < state.size(); ++node) lowest = std::min(lowest, state.x()[node][2]);
    EXPECT_LT(lowest, std::min(1e-12, tip)) << "step " << i << ": the membrane is before the tip";
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
