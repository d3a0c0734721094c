// SPDX-License-Identifier: LGPL-2.1-or-later
// Constraints on rigid frames and on numbers: what is held, tied, moved and related, against closed forms and merged bodies.
#include <fmt/format.h>

#include <cmath>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const char* const methods[] = {"<EulerExplicitSolver/>",
                               "<RungeKutta4Solver/>",
                               "<CentralDifferenceSolver/>",
                               "<EulerImplicitSolver/>",
                               "<TrapezoidalRuleSolver newtonIterations='20' newtonTolerance='1e-12'/>",
                               "<NewmarkImplicitSolver/>",
                               "<BDFOdeSolver order='2'/>",
                               "<VariationalSymplecticSolver newtonError='1e-13' steps='40'/>"};

std::string scene(const std::string& integrator, const std::string& content, double dt = 0.01) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">{}<SparseLDLSolver/>{}</Node>)", dt, integrator, content);
}
System& systemOf(const Simulation& simulation) { return *simulation.systems().at(0); }
void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
  }
}

/// About an axis that is none of its own a body turns with the moment about that axis, J_zz, whatever the products of inertia.
TEST(HeldFrames, TurnAboutAFixedAxis) {
  for (const char* method : methods) {
    Simulation simulation = simulationFromText(
        scene(method, R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/>
        <UniformMass totalMass="1" inertia="1 0.2 0.4  0.2 2 0.3  0.4 0.3 1.5"/>
        <PartialFixedProjectiveConstraint indices="0" fixedDirections="1 1 1 1 1 0"/>
        <ConstantForceField forces="0 0 0  1 2 3"/>)"));
    run(simulation, 50);
    const Vec3 spin = systemOf(simulation).v[1];
    const double late = std::string(method).find("Central") != std::string::npos ? 0.005 : 0;  // velocities of mid-steps
    EXPECT_NEAR(spin.z(), 3 / 1.5 * (0.5 - late), 1e-9) << method;
    EXPECT_EQ(spin.x(), 0) << method;
    EXPECT_NEAR(rotationVector(orientationIn(systemOf(simulation).x, 1)).z(), 3 / 1.5 * 0.125, 0.02) << method;
  }
}

/// Three frames in one place that are attached are one body: one with a turning inertia of three moments, one with other
/// moments, one whose inertia is the same about all axes.
TEST(HeldFrames, AttachedOnesAreTheMergedBody) {
  const std::string start = "position=\"0 1 0  0.1 0.2 0.3 0.9273618\" velocity=\"0.3 0 0.1  0.4 3 -0.5\"";
  const auto body = [&](const std::string& name, const std::string& mass) {
    return "<Node name='" + name + "'><MechanicalObject name='dofs' template='Rigid3' " + start + "/>" + mass + "</Node>";
  };
  const std::string torque = "<Node name='load'><MechanicalObject name='end' position='0 0 0.5'/><RigidMapping "
                             "input='@../a/dofs'/><ConstantForceField forces='0 1 0'/></Node>";
  for (const char* method : methods) {
    Simulation tied = simulationFromText(
        scene(method, body("a", "<UniformMass totalMass='1' inertia='0.2 0.5 0.6'/>") +
                          body("b", "<UniformMass totalMass='2' inertia='0.5 1.2 1'/>") +
                          body("c", "<UniformMass totalMass='0.5' inertia='0.3 0.3 0.3'/>") + torque +
                          "<AttachProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices1='0' indices2='0' twoWay='true'/>"
                          "<AttachProjectiveConstraint object1='@b/dofs' object2='@c/dofs' indices1='0' indices2='0' twoWay='true'/>"));
    Simulation one = simulationFromText(scene(method, body("a", "<UniformMass totalMass='3.5' inertia='1 2 1.9'/>") + torque));
    run(tied, 100), run(one, 100);
    const System &parts = systemOf(tied), &whole = systemOf(one);
    for (const Index part : {0, 2, 4}) {
      EXPECT_LT((parts.x[part] - whole.x[0]).norm(), 1e-9) << method;
      EXPECT_LT(orientationIn(parts.x, part + 1).angularDistance(orientationIn(whole.x, 1)), 2e-8) << method;
      EXPECT_LT((parts.v[part + 1] - whole.v[1]).norm(), 1e-8) << method;
    }
    EXPECT_GT(orientationIn(whole.x, 1).angularDistance(Quaternion(0.9273618, 0.1, 0.2, 0.3)), 1) << "it has turned";
  }
}

TEST(HeldFrames, MeetAtTheirMeanTurn) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3"
      position="0 0 0  0 0 0 1   1 0 0  0 0 0.19866933 0.98006658"/><UniformMass vertexMass="1" inertia="1 1 1  3 3 3"/>
      <AttachProjectiveConstraint indices1="0" indices2="1" twoWay="true"/>)"));
  run(simulation, 1);
  for (const Index row : {1, 3})
    EXPECT_NEAR(rotationVector(orientationIn(systemOf(simulation).x, row)).z(), 0.75 * 0.4, 1e-7) << "weighted by inertia";
  EXPECT_NEAR(systemOf(simulation).x[0][0], 0.5, 1e-12);
}

TEST(HeldFrames, FollowOthersThatDoNotFeelIt) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3"
      position="0 0 0  0 0 0 1   0 0 0  0 0 0 1" velocity="1 0 0  1 2 3  0 0 0  0 0 0"/>
      <UniformMass vertexMass="1" inertia="1 2 3  5 5 5"/>
      <AttachProjectiveConstraint indices1="0" indices2="1" twoWay="false"/>)"));
  run(simulation, 60);
  const System& system = systemOf(simulation);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(system.x.rows().data[k], system.x.rows().data[8 + k]);
  EXPECT_EQ(Vec3(system.v[1]), Vec3(system.v[3]));
  EXPECT_GT(orientationIn(system.x, 3).angularDistance(Quaternion::Identity()), 1);
}

/// q = exp(r(t)) q_0 at the end of every step, whatever the method, and the velocity is that of this motion.
TEST(MovedFrames, GoWhereTheyAreSent) {
  std::vector<std::string> all(std::begin(methods), std::end(methods));
  all.push_back("<StaticSolver/>");
  const Vec3 from(0.2, 0, 0.4), to(0.5, -1, 1.5);
  for (const std::string& method : all) {
    Simulation simulation = simulationFromText(
        scene(method, R"(<MechanicalObject template="Rigid3" position="1 0 0  0.1 0.2 0.3 0.9273618"/>
        <UniformMass totalMass="1" inertia="1 2 2.5"/>
        <LinearMovementProjectiveConstraint indices="0" outside="hold" keyTimes="0 1"
          movements="0 0 0 0.2 0 0.4   2 0 1 0.5 -1 1.5"/>)",
              0.1));
    const Quaternion start = turnedBy(simulation.states()[0]->position[1]);
    for (int i = 1; i <= 12; ++i) {
      run(simulation, 1);
      const double s = std::min(1., 0.1 * i);
      const Vec3 r = from + s * (to - from);
      const System& system = systemOf(simulation);
      EXPECT_LT((system.x[0] - Vec3(1 + 2 * s, 0, s)).norm(), 1e-13) << method;
      EXPECT_LT((orientationIn(system.x, 1) * (turnedBy(r) * start).conjugate()).vec().norm(), 1e-14) << method;
      if (i > 10 || method == "<StaticSolver/>") continue;
      const double h = 1e-6;
      const Vec3 spin =
          rotationVector(turnedBy(r + h * (to - from)) * turnedBy(r - h * (to - from)).conjugate()) / (2 * h);
      EXPECT_LT((system.v[1] - spin).norm(), 1e-8) << method;
    }
  }
}

TEST(MovedFrames, AreFreeWhereNothingMovesThem) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/>
      <UniformMass totalMass="1" inertia="1 1 1"/><ConstantForceField forces="0 3 0  0 0 0"/>
      <PartialLinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 0 0 0 0 0  2 7 7 7 7 1"
        movedDirections="1 0 0 0 0 1"/>)"));
  run(simulation, 100);
  const System& system = systemOf(simulation);
  EXPECT_NEAR(system.x[0][0], 2, 1e-12);
  EXPECT_NEAR(system.v[0][1], 3, 1e-12) << "driven by the force alone";
  EXPECT_LT((rotationVector(orientationIn(system.x, 1)) - Vec3(0, 0, 1)).norm(), 1e-12);
}

TEST(MovedFrames, TurnAboutTheDrivenAxisAlone) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/>
      <UniformMass totalMass="1" inertia="1 1 1"/>
      <LinearVelocityProjectiveConstraint indices="0" keyTimes="0 1" velocities="7 7 7 7 7 1  7 7 7 7 9 1" coordinates="5"/>)"));
  run(simulation, 100);
  EXPECT_LT((rotationVector(orientationIn(systemOf(simulation).x, 1)) - Vec3(0, 0, 1)).norm(), 1e-12);
  EXPECT_EQ(Vec3(systemOf(simulation).x[0]).norm(), 0);
}

/// Two movements of one orientation about different axes: each has its component.
TEST(MovedFrames, FollowTwoMovementsAtOnce) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/>
      <UniformMass totalMass="1" inertia="1 1 1"/>
      <PartialLinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 0 0 0 0 0  0 0 0 0 0 0.6"
        movedDirections="0 0 0 0 0 1" outside="hold"/>
      <PartialLinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 0 0 0 0 0  0 0 0 0.4 0 0"
        movedDirections="0 0 0 1 0 0" outside="hold"/>)"));
  for (int i = 1; i <= 100; ++i) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.constraints_converged) << report.constraint_reason;
  }
  const Quaternion now = orientationIn(systemOf(simulation).x, 1);
  EXPECT_NEAR(rotationVector(turnedBy(Vec3(0, 0, 0.6)) * now.conjugate()).z(), 0, 1e-12);
  EXPECT_NEAR(rotationVector(turnedBy(Vec3(0.4, 0, 0)) * now.conjugate()).x(), 0, 1e-12);
}

/// An angular velocity whose axis changes, against short steps.
TEST(MovedFrames, TurnWithTheVelocityThatIsGiven) {
  const Vec3 w0(1, 0, 2), w1(-2, 3, 0.5);
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1"/>
      <UniformMass totalMass="1" inertia="1 2 2.5"/>
      <LinearVelocityProjectiveConstraint indices="0" keyTimes="0 1" velocities="1 0 0 1 0 2   3 0 0 -2 3 0.5"/>)"));
  run(simulation, 100);
  const System& system = systemOf(simulation);
  Quaternion q = Quaternion::Identity();
  for (int i = 0; i < 40000; ++i) q = turnedBy(2.5e-5 * (w0 + (i + 0.5) * 2.5e-5 * (w1 - w0))) * q;
  EXPECT_NEAR(system.x[0][0], 2, 1e-12);
  EXPECT_LT((orientationIn(system.x, 1) * q.conjugate()).vec().norm(), 1e-8);
  EXPECT_LT((system.v[1] - w1).norm(), 1e-12);
}

TEST(MovedFrames, AnAngleIsDriven) {
  Simulation simulation = simulationFromText(
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Vec1" position="0.5 0"/><UniformMass totalMass="1"/>
      <LinearMovementProjectiveConstraint indices="0" keyTimes="0 1" movements="0 2" outside="hold"/>
      <LinearVelocityProjectiveConstraint indices="1" keyTimes="0 1" velocities="1 3"/>)"));
  run(simulation, 50);
  EXPECT_NEAR(systemOf(simulation).x[0][0], 1.5, 1e-13);
  EXPECT_NEAR(systemOf(simulation).x[1][0], 0.5 + 0.25, 1e-13);
  EXPECT_EQ(systemOf(simulation).x[0][1], 0);
}

TEST(MovedFrames, TurnWithAnAffineMovementAndSwing) {
  const std::string frame = "<MechanicalObject template='Rigid3' position='1 0 0  0.1 0.2 0.3 0.9273618'/><UniformMass "
                            "totalMass='1' inertia='1 2 2.5'/>";
  Simulation turned = simulationFromText(
      scene("<EulerImplicitSolver/>", frame + "<AffineMovementProjectiveConstraint indices='0' endConstraintTime='1' "
                                              "rotation='0 -1 0  1 0 0  0 0 1' translation='0 0 2'/>"));
  Simulation swinging = simulationFromText(
      scene("<EulerImplicitSolver/>", frame + "<OscillatorProjectiveConstraint indices='0' translation='0 0.1 0' rotation='0 "
                                              "0.8 0' pulsation='2' phase='0.3'/>"));
  run(turned, 40), run(swinging, 40);
  const Quaternion start = turnedBy(turned.states()[0]->position[1]);
  const double quarter = std::acos(0.), swing = std::sin(2 * 0.4 + 0.3);
  EXPECT_LT((systemOf(turned).x[0] - Vec3(0.6, 0.4, 0.8)).norm(), 1e-12);
  EXPECT_LT((orientationIn(systemOf(turned).x, 1) * (turnedBy(Vec3(0, 0, 0.4 * quarter)) * start).conjugate()).vec().norm(),
            1e-12);
  EXPECT_LT((systemOf(turned).v[1] - Vec3(0, 0, quarter)).norm(), 1e-12);
  EXPECT_NEAR(systemOf(swinging).x[0][1], 0.1 * swing, 1e-12);
  EXPECT_LT((orientationIn(systemOf(swinging).x, 1) * (turnedBy(Vec3(0, 0.8 * swing, 0)) * start).conjugate()).vec().norm(),
            1e-12);
  EXPECT_LT((systemOf(swinging).v[1] - Vec3(0, 2 * std::cos(2 * 0.4 + 0.3) * 0.8, 0)).norm(), 1e-12);
}

TEST(MovedFrames, SwingAboutAPlaceAndAnOrientationThatAreGiven) {
  const std::string frames = "<MechanicalObject template='Rigid3' position='9 9 9  0 0 0 1  1 0 0  0 0 0 1'/><UniformMass totalMass='1'/>"
                             "<OscillatorProjectiveConstraint oscillators='1  1 2 3 0 0 0.6 0.8  0.1 0 0 0 0.8 0  2 0.3'/>";
  Simulation s = simulationFromText(scene("<EulerImplicitSolver/>", frames));
  run(s, 40);
  const double angle = 2 * s.time() + 0.3;
  const Quaternion mean(0.8, 0, 0, 0.6);
  const System& system = systemOf(s);
  EXPECT_LT((Vec3(system.x[2]) - Vec3(1 + 0.1 * std::sin(angle), 2, 3)).norm(), 1e-12);
  EXPECT_LT((Vec3(system.v[2]) - Vec3(0.2 * std::cos(angle), 0, 0)).norm(), 1e-12);
  const Quaternion turn(Eigen::AngleAxisd(0.8 * std::sin(angle), Vec3::UnitY()));
  EXPECT_LT((orientationIn(system.x, 3) * (turn * mean).conjugate()).vec().norm(), 1e-12);
  EXPECT_LT((Vec3(system.v[3]) - Vec3(0, 1.6 * std::cos(angle), 0)).norm(), 1e-12);
  EXPECT_GT((Vec3(system.x[0]) - Vec3(1, 2, 3)).norm(), 1) << "a frame that is not named does not swing";
}

TEST(MovedFrames, GoOnFromACheckpointToTheBit) {
  const std::string text =
      scene("<EulerImplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1  1 0 0 0 0 0 1"
      velocity="0 0 0 1 2 3  0 0 0 0 0 0"/><UniformMass totalMass="1" inertia="1 2 2.5"/>
      <LinearMovementProjectiveConstraint indices="1" keyTimes="0.05 1" movements="0 0 0 0 0 0  1 0 0 1 1 2"/>
      <LinearVelocityProjectiveConstraint indices="0" keyTimes="0.03 1" velocities="0 0 0 0 3 0  1 0 0 1 0 2"/>)");
  Simulation simulation = simulationFromText(text);
  run(simulation, 12);
  const Archive middle = simulation.checkpoint();
  run(simulation, 30);
  const auto end = simulation.stateHash();
  simulation.restore(middle.readable());
  run(simulation, 30);
  EXPECT_EQ(simulation.stateHash(), end);
  simulation.reset();
  run(simulation, 42);
  EXPECT_EQ(simulation.stateHash(), end);
}

/// Gears: 2 y_0 = y_1. A torque on the first turns both, with the inertia m_0 + 4 m_1.
TEST(RelatedNumbers, TurnTogether) {
  for (const char* method : methods) {
    Simulation simulation = simulationFromText(
        scene(method, R"(<MechanicalObject template="Vec1" position="0 0"/><DiagonalMass vertexMass="1 2"/>
        <ConstantForceField indices="0" forces="18"/>
        <LinearRelationProjectiveConstraint indices="0 1" coefficients="2 -1"/>)"));
    run(simulation, 50);
    const System& system = systemOf(simulation);
    const double late = std::string(method).find("Central") != std::string::npos ? 0.005 : 0;
    EXPECT_NEAR(system.v[0][0], 18. / 9 * (0.5 - late), 1e-9) << method;
    EXPECT_NEAR(system.x[1][0], 2 * system.x[0][0], 1e-12) << method;
  }
}

/// A frame that falls on a plane stops there, and its spin goes on.
TEST(HeldFrames, StopAtAPlane) {
  Simulation simulation = simulationFromText(
      scene("<EulerExplicitSolver/>", R"(<MechanicalObject template="Rigid3" position="0 0 0.1  0 0 0 1"
      velocity="0.5 0 -1  0 3 0"/><UniformMass totalMass="1" inertia="1 1 1"/><PlaneConstraint normal="0 0 1" d="0"/>)"));
  run(simulation, 50);
  const System& system = systemOf(simulation);
  EXPECT_NEAR(system.x[0][2], 0, 1e-12);
  EXPECT_NEAR(system.v[0][2], 0, 1e-12);
  EXPECT_NEAR(system.v[0][0], 0.5, 1e-12);
  EXPECT_LT((system.v[1] - Vec3(0, 3, 0)).norm(), 1e-14);
  EXPECT_NEAR(rotationVector(orientationIn(system.x, 1)).y(), 1.5, 1e-12);
}

/// Without external_points the targets are the frames, or numbers, of the same index.
TEST(PulledFrames, AreLedToThoseOfAnotherState) {
  const auto pulled = [](const std::string& type, const std::string& from, const std::string& to, const std::string& inertia) {
    return simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerExplicitSolver/>
        <Node name="a"><MechanicalObject name="dofs" template="{0}" position="{1}"/><UniformMass vertexMass="1" {3}/>
          <RestShapeSpringsForceField points="1" stiffness="2" angularStiffness="3" external_rest_shape="@../b/dofs"/></Node>
        <Node name="b"><MechanicalObject name="dofs" template="{0}" position="{2}"/><UniformMass vertexMass="1" {3}/></Node></Node>)",
        type, from, to, inertia));
  };
  Simulation frames = pulled("Rigid3", "0 0 0 0 0 0 1  1 0 0 0 0 0 1", "9 9 9 1 0 0 0  5 0 0 0 0 0.14943813 0.98877108",
                             "inertia='1 1 1'");
  run(frames, 1);
  EXPECT_LT((systemOf(frames).v[2] - 0.01 * 2 * Vec3(4, 0, 0)).norm(), 1e-14);
  EXPECT_LT((systemOf(frames).v[3] - 0.01 * 3 * Vec3(0, 0, 0.3)).norm(), 1e-9) << "three directions leave the turns alone";
  Simulation numbers = pulled("Vec2", "0 0  1 2", "7 7  4 -3", "");
  run(numbers, 1);
  EXPECT_NEAR(systemOf(numbers).v[2][0], 0.01 * 2 * 3, 1e-14);
  EXPECT_NEAR(systemOf(numbers).v[3][0], 0.01 * 2 * -5, 1e-14);
}

TEST(HeldFrames, SayWhatCannotBe) {
  const std::string frame = "<MechanicalObject template='Rigid3' position='0 0 0 0 0 0 1  1 0 0 0 0 0 1'/><UniformMass "
                            "totalMass='1' inertia='1 2 2.5'/>";
  const auto problems = [](const std::string& content) { return problemsOf(scene("<EulerImplicitSolver/>", content)); };
  expectContains(problems(frame + "<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0 1 0 0'/>"),
                 "movements has 1 values for 2 keyTimes");
  expectContains(problems(frame + "<LinearMovementProjectiveConstraint indices='0' keyTimes='0 1' movements='0 0 0 1'/>"),
                 "6: for x, y, z and the turns about them");
  expectContains(problems(frame + "<LinearVelocityProjectiveConstraint indices='0' keyTimes='0 1' coordinates='6' "
                                  "velocities='0 0 0 0 0 0  0 0 0 0 0 0'/>"),
                 "0 to 5");
  expectContains(problems(frame + "<AffineMovementProjectiveConstraint indices='0' rotation='2 0 0 0 1 0 0 0 1'/>"),
                 "frames cannot be stretched");
  expectContains(problems(frame + "<AttachProjectiveConstraint indices1='0' indices2='1' twoWay='true' endTime='1'/>"),
                 "ties orientations and ends");
  expectContains(problems("<MechanicalObject template='Vec1' position='0 1'/><UniformMass totalMass='1'/>"
                          "<LinearRelationProjectiveConstraint indices='0 1' coefficients='1 -1' directions='1 0 0'/>"),
                 "have no directions");
  expectContains(
      problems("<Node name='a'><MechanicalObject name='dofs' template='Rigid3' position='0 0 0 0 0 0 1'/><UniformMass "
               "totalMass='1' inertia='1 2 2.5'/></Node><Node name='b'><MechanicalObject name='dofs' template='Rigid3' "
               "position='0 0 0 0 0 0 1'/><UniformMass totalMass='1' inertia='1 2 2.5' turns='false'/></Node>"
               "<AttachProjectiveConstraint object1='@a/dofs' object2='@b/dofs' indices1='0' indices2='0' twoWay='true'/>"),
      "the inertia of only one of them turns");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
