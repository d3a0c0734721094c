// SPDX-License-Identifier: LGPL-2.1-or-later
// Beams and joints between rigid frames: energy, force and tangent against each other, closed forms of beams small and large,
// and the words of joints.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/beams/frame_field.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string two_beams =
    R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology edges="0 1  1 2"/>
    <MechanicalObject template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9   1 0.2 0  0 0 0 1   2 0 0.3  -0.2 0 0.1 0.9"/>
    <UniformMass totalMass="3" inertia="1 1 1"/><BeamFEMForceField youngModulus="2e4" poissonRatio="0.3" radius="0.1"/></Node>)";
const std::string joints =
    R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MechanicalObject template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9   1 0.2 0  0 0 0 1   2 0 0.3  -0.2 0 0.1 0.9"/>
    <UniformMass totalMass="3" inertia="1 1 1"/>
    <JointSpringForceField spring="BEGIN_SPRING 0 1 KS_T 3 200 KS_R 5 60 FREE_AXIS 1 0 0 1 0 1 R_LIM_X -0.05 0.1 KS_B 40 END_SPRING
      BEGIN_SPRING 2 1 REST_T 0.5 0 0 REST_R 0 0 0.1 1 KS_R 0 100 FREE_AXIS 0 0 0 0 0 0 END_SPRING"/></Node>)";

const std::string frame_springs =
    R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MechanicalObject template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9   1 0.2 0  0 0 0 1   2 0 0.3  -0.2 0 0.1 0.9"/>
    <UniformMass totalMass="3" inertia="1 1 1"/>
    <FrameSpringForceField spring="BEGIN_SPRING 0 1 KS_T 200 KS_R 60 VEC1 0.4 0.1 0 VEC2 -0.3 0.2 0.5 END_SPRING
      BEGIN_SPRING 2 1 KS_T 30 VEC2 0 0 0.7 END_SPRING"/></Node>)";

class FrameFields : public testing::TestWithParam<std::string> {};

TEST_P(FrameFields, ForceIsTheSlopeOfTheEnergyAndStiffnessThatOfTheForce) {
  FrameField t(GetParam());
  for (const double size : {0.01, 0.3, 0.7, 1.2}) {
    const Vector x = t.movedBy(1, randomRows(6, 3, size), t.system.x), d = randomRows(6, 4, 1);
    SCOPED_TRACE(size);
    t.expectSlopes(x, d);
    const Vector f = t.forceAt(x), e = randomRows(6, 5, 1), product = t.product(d);
    EXPECT_NEAR(dot(e, product), dot(d, t.product(e)), 1e-12 * norm(product));
    // forces and torques balance
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    double forces = 0, torques = 0;
    for (Index i = 0; i < 6; i += 2) {
      force += f[i], forces += f[i].norm();
      torque += f[i + 1] + Vec3(x[i]).cross(Vec3(f[i])), torques += f[i + 1].norm();
    }
    EXPECT_LT(force.norm(), 1e-14 * forces);
    EXPECT_LT(torque.norm(), 1e-14 * (forces + torques));
  }
}

TEST_P(FrameFields, NothingPullsAtRestNorAfterARigidMotion) {
  FrameField t(GetParam());
  const Quaternion turn = turnedBy(Vec3(0.5, -2, 1));
  Vector x(6);
  copy(t.system.x, x);
  const double at_rest = norm(t.forceAt(x));
  for (Index i = 0; i < 6; i += 2) {
    x[i] = turn * Vec3(x[i]) + Vec3(1, 2, 3);
    Motion::turnBy(Vec3(0.5, -2, 1), x.rows().data + std::size_t(i + 1) * row_doubles);
  }
  const Vector moved = t.forceAt(x);
  EXPECT_NEAR(norm(moved), at_rest, 1e-9);
  if (GetParam() == two_beams) EXPECT_LT(at_rest, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Fields, FrameFields, testing::Values(two_beams, joints, frame_springs),
                         [](const auto& values) { return values.index == 0 ? "Beams" : values.index == 1 ? "Joints" : "Springs"; });

std::string cantilever(int beams, double length, const std::string& load, const std::string& more = "") {
  std::string position, edges;
  for (int i = 0; i <= beams; ++i) position += fmt::format("{} 0 0  0 0 0 1  ", length * i / beams);
  for (int i = 0; i < beams; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  return fmt::format(R"(<Node name="root" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><MeshTopology edges="{}"/>
    <MechanicalObject name="dofs" template="Rigid3" position="{}"/>
    <BeamFEMForceField youngModulus="1e9" poissonRatio="0.3" radius="0.02"/><FixedProjectiveConstraint indices="0"/>
    <ConstantForceField indices="{}" forces="{}"/>{}</Node>)",
                     edges, position, beams, load, more);
}
const double bending = 1e9 * std::numbers::pi * std::pow(0.02, 4) / 4;  // EI

TEST(Beams, ACantileverBendsAndTwistsAsBeamsDo) {
  for (const int beams : {1, 3, 10}) {
    Simulation simulation = simulationFromText(cantilever(beams, 2, "0 0.001 -0.002  0.003 0.001 0"));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const System& system = *simulation.systems()[0];
    const Index tip = 2 * beams;
    EXPECT_NEAR(system.x[tip].y(), 0.001 * 8 / (3 * bending), 1e-4 * 0.001 * 8 / (3 * bending));
    // a force down and a couple about y, which turns x to -z
    EXPECT_NEAR(system.x[tip].z(), -0.002 * 8 / (3 * bending) - 0.001 * 4 / (2 * bending),
                1e-4 * 0.004 * 8 / (3 * bending));
    const double twist = rotationVector(orientationIn(system.x, tip + 1)).x();
    EXPECT_NEAR(twist, 0.003 * 2 / (bending / 1.3), 1e-4 * 0.003 * 2 / (bending / 1.3));
  }
}

/// A beam that runs against the x axis of its frames bends, stretches and twists as any other.
TEST(Beams, AFrameMayLookTheOtherWay) {
  const double length = 2, force = 1e-4, couple = 0.003, pull = 0.01, area = std::numbers::pi * 4e-4;
  for (const char* turn : {"0 0 0 1", "0 0 1 0", "0 1 0 0", "0 0 0.70710678118654757 0.70710678118654757"}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/><MeshTopology edges="0 1"/>
    <MechanicalObject template="Rigid3" position="0 0 0  {0}   -2 0 0  {0}"/>
    <BeamFEMForceField youngModulus="1e9" poissonRatio="0.3" radius="0.02"/><FixedProjectiveConstraint indices="0"/>
    <ConstantForceField indices="1" forces="{1} {2} 0  {3} 0 0"/></Node>)",
        turn, -pull, force, couple));
    System& system = *simulation.systems()[0];
    Vector v(system.allRows()), f(system.allRows());
    for (ForceField* field : system.forceFields())
      if (field->type() == "BeamFEMForceField") field->addForce(system.x, v, f);
    for (Index row = 0; row < 4; ++row) EXPECT_LT(Vec3(f[row]).norm(), 1e-9) << turn << ": force at rest";
    const Quaternion start = orientationIn(system.x, 3);
    ASSERT_TRUE(simulation.step().newton_converged) << turn;
    EXPECT_NEAR(system.x[2].y(), force * length * length * length / (3 * bending), 1e-3 * system.x[2].y()) << turn;
    EXPECT_NEAR(system.x[2].x(), -length - pull * length / (1e9 * area), 1e-2 * pull * length / (1e9 * area)) << turn;
    const Vec3 turned = rotationVector(orientationIn(system.x, 3) * start.conjugate());
    EXPECT_NEAR(turned.x(), couple * length / (bending / 1.3), 1e-3 * couple * length / (bending / 1.3)) << turn;
    EXPECT_NEAR(turned.z(), -force * length * length / (2 * bending), 1e-3 * force * length * length / (2 * bending)) << turn;
  }
}

/// A column with an arm: the arm's end sinks by its own bending, the column's and the column's shortening.
TEST(Beams, AnAngleBendsAsBothOfItsBars) {
  const double height = 1, arm = 0.5, load = 1e-3, area = std::numbers::pi * 4e-4;
  Simulation simulation =
      simulationFromText(fmt::format(R"(<Node name="root" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
    <MeshTopology edges="0 1  1 2"/>
    <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0 0 {}  0 0 0 1   {} 0 {}  0 0 0 1"/>
    <BeamFEMForceField youngModulus="1e9" poissonRatio="0.3" radius="0.02"/><FixedProjectiveConstraint indices="0"/>
    <ConstantForceField indices="2" forces="0 0 -{}  0 0 0"/></Node>)",
                                     height, arm, height, load));
  ASSERT_TRUE(simulation.step().newton_converged);
  const double exact = load * (arm * arm * arm / (3 * bending) + arm * arm * height / bending + height / (1e9 * area));
  EXPECT_NEAR(height - simulation.systems()[0]->x[4].z(), exact, 1e-4 * exact);
}

/// A moment of 2 pi EI/L at its end rolls a beam up to a circle, without stretch and whatever the number of beams. In space a
/// couple about a fixed axis would turn it out of its plane long before.
TEST(Beams, AnEndMomentRollsABeamUp) {
  for (const int beams : {4, 10}) {
    const double length = 3;
    const std::string plane =
        fmt::format("<PartialFixedProjectiveConstraint indices=\"1-{}\" fixedDirections=\"0 0 1 1 1 0\"/>", beams);
    Simulation simulation = simulationFromText(
        cantilever(beams, length, fmt::format("0 0 0  0 0 {:.17g}", 2 * std::numbers::pi * bending / length), plane));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const System& system = *simulation.systems()[0];
    EXPECT_LT(system.x[2 * beams].norm(), 1e-8 * length) << beams;
    // half of the beams are half of the circle; what lies between the nodes is on the arc
    const double half = std::numbers::pi * (beams / 2) / beams * 2, radius = length / (2 * std::numbers::pi);
    EXPECT_NEAR(system.x[2 * (beams / 2)][1], radius * (1 - std::cos(half)), 1e-8) << beams;
  }
}

/// Large bending by a force at the end (Mattiasson 1981: P L^2/EI = 10 moves the end by 0.55500 and 0.81061 of L), of a beam
/// so slender that it has next to no stretch.
TEST(Beams, AForceBendsABeamFar) {
  const double length = 20;
  double error[2];
  for (int k = 0; k < 2; ++k) {
    const int beams = 4 << (2 * k);
    Simulation simulation = simulationFromText(
        cantilever(beams, length, fmt::format("0 {:.17g} 0  0 0 0", 10 * bending / (length * length))));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const Vec3 tip = Vec3(simulation.systems()[0]->x[2 * beams]) / length;
    error[k] = std::hypot(1 - tip.x() - 0.55500, tip.y() - 0.81061);
  }
  EXPECT_LT(error[0], 5e-4) << "four beams";
  EXPECT_LT(error[1], 1e-5) << "sixteen: all five digits";
}

/// The lowest frequency of a cantilever, 1.8751^2 sqrt(EI/(rho A L^4)), from the quarter of a period.
TEST(Beams, ACantileverSwingsAtItsFrequency) {
  const int beams = 20;
  const double length = 1, mass = 2,
               omega = 1.87510407 * 1.87510407 * std::sqrt(bending / (mass * std::pow(length, 3)));
  std::string text = cantilever(beams, length, "0 0 0 0 0 0");
  const double each = mass / beams, quarter = std::numbers::pi / 2 / omega;
  std::string masses;
  for (int i = 0; i <= beams; ++i) masses += fmt::format("{} ", i == 0 || i == beams ? each / 2 : each);
  text.replace(text.find("<StaticSolver/>"), 15, "<TrapezoidalRuleSolver/>");
  text.replace(text.find("gravity="), 0, fmt::format("dt=\"{:.17g}\" ", quarter / 200));
  text.replace(text.find("<BeamFEM"), 0,
               fmt::format("<DiagonalMass vertexMass=\"{}\" inertia=\"1e-6 1e-6 1e-6\"/>", masses));
  Simulation simulation = simulationFromText(text);
  System& system = *simulation.systems()[0];
  const double b = 1.87510407, s = (std::cosh(b) + std::cos(b)) / (std::sinh(b) + std::sin(b));
  for (int i = 1; i <= beams; ++i) {
    const double z = b * i / beams, size = 1e-4;
    system.x[2 * i][1] = size * (std::cosh(z) - std::cos(z) - s * (std::sinh(z) - std::sin(z)));
    Motion::turnBy(Vec3(0, 0, size * b * (std::sinh(z) + std::sin(z) - s * (std::cosh(z) - std::cos(z)))),
                   system.x.rows().data + std::size_t(2 * i + 1) * row_doubles);
  }
  double before = 0, now = system.x[2 * beams][1];
  int steps = 0;
  while (now > 0 && steps < 400) {
    before = now;
    ASSERT_FALSE(simulation.step().diverged);
    now = system.x[2 * beams][1], ++steps;
  }
  const double measured = (steps - now / (now - before)) * quarter / 200;
  EXPECT_NEAR(measured, quarter, 0.005 * quarter);
}

/// By ranges of the turn in which it is computed in other ways; of eleven joints, which are no whole batches.
TEST(Joints, ATorqueIsTheStiffnessTimesTheTurn) {
  const double sizes[] = {0, 1e-9, 0.01, 0.2, 0.5, 1.0471, 1.0473, 1.5, 2.0943, 2.0945, 3.1};
  const Vec3 axis = Vec3(1, -2, 0.5).normalized();
  std::string places, springs;
  for (int i = 0; i < 11; ++i) {
    const Quaternion turn(Eigen::AngleAxisd(sizes[i], axis));
    places += fmt::format("0 0 0  0 0 0 1  0 0 0  {:.17g} {:.17g} {:.17g} {:.17g}  ", turn.x(), turn.y(), turn.z(), turn.w());
    springs += fmt::format("BEGIN_SPRING {} {} KS_R 3 3 REST_T 0 0 0 REST_R 0 0 0 1 END_SPRING ", 2 * i, 2 * i + 1);
  }
  FrameField t(fmt::format(R"(<Node name="root"><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject template="Rigid3" position="{}"/>
    <UniformMass totalMass="22" inertia="1 1 1"/><JointSpringForceField spring="{}"/></Node>)",
                      places, springs));
  const Vector f = t.forceAt(t.system.x);
  double energy = 0;
  for (int i = 0; i < 11; ++i) {
    EXPECT_LT((Vec3(f[4 * i + 3]) + 3 * sizes[i] * axis).norm(), 4e-15 * (sizes[i] + 1e-3)) << sizes[i];
    EXPECT_EQ(Vec3(f[4 * i + 1]), -Vec3(f[4 * i + 3]));
    energy += 1.5 * sizes[i] * sizes[i];
  }
  EXPECT_NEAR(t.field.energy(t.system.x), energy, 1e-14 * energy);
}

TEST(Joints, AHingeHoldsWhatItBlocks) {
  // a rod of 1 m that hangs on a hinge about z at its end: a pendulum of J = 1/3 m l^2
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.002" gravity="0 -10 0"><VariationalSymplecticSolver/><SparseLDLSolver/>
      <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1"/>
      <UniformMass totalMass="2" inertia="0.01 0.0833333333 0.0833333333"/><FixedProjectiveConstraint indices="0"/>
      <Node name="end"><MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   -0.5 0 0  0 0 0 1"/>
        <RigidRigidMapping rigidIndexPerPoint="0 1"/>
        <JointSpringForceField spring="BEGIN_SPRING 0 1 FREE_AXIS 0 0 0 0 0 1 KS_T 0 1e6 KS_R 0 1e5 REST_T 0 0 0
          REST_R 0 0 0 1 END_SPRING"/>
      </Node></Node>)");
  System& system = *simulation.systems()[0];
  const double period =
      1.18034059902 * 2 * std::numbers::pi * std::sqrt(1. / 3 / (10 * 0.5));  // amplitude of a right angle
  const int quarter = int(std::lround(period / 4 / 0.002));
  for (int i = 0; i < quarter; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
  }
  EXPECT_NEAR(system.x[2].x(), 0, 0.01) << "it hangs straight down";
  EXPECT_NEAR(system.x[2].y(), -0.5, 0.001);
  EXPECT_LT((orientationIn(system.x, 3) * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-3);
}

/// A frame at an angle of 0.3 rad about z from its joint, which is free between two limits.
TEST(Joints, LimitsPushBackFromBothSides) {
  const auto torque = [](const std::string& limits) {
    FrameField t(R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
      <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0 0 0  0 0 0.14943813 0.98877108"/>
      <UniformMass totalMass="2" inertia="1 1 1"/>
      <JointSpringForceField spring="BEGIN_SPRING 0 1 FREE_AXIS 0 0 0 1 1 1 KS_B 50 REST_R 0 0 0 1 )" +
            limits + R"( END_SPRING"/></Node>)");
    return t.forceAt(t.system.x)[3][2];
  };
  EXPECT_NEAR(torque("R_LIM_Z -1 0.5"), 0, 1e-12);
  EXPECT_NEAR(torque("R_LIM_Z -1 0.1"), -50 * 0.2, 1e-6);
  EXPECT_NEAR(torque("R_LIM_Z 0.5 1"), 50 * 0.2, 1e-6);
  EXPECT_NEAR(torque("R_LIM_Z 0 0"), -50 * 0.3, 1e-6) << "no play at all";
}

TEST(FrameSprings, SayWhatIsWrong) {
  const auto problems = [](const std::string& spring) {
    return problemsOf(
        "<Node name=\"root\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template=\"Rigid3\" "
        "position=\"0 0 0 0 0 0 1  1 0 0 0 0 0 1\"/><UniformMass totalMass=\"1\"/><FrameSpringForceField spring=\"" +
        spring + "\"/></Node>");
  };
  EXPECT_EQ(problems("BEGIN_SPRING 0 1 KS_T 1 KD 2 VEC1 0 0 1 END_SPRING"), "");
  expectContains(problems("BEGIN_SPRING 0 1 KS_X 1 END_SPRING"), "'KS_X' is not a word");
  expectContains(problems("BEGIN_SPRING 0 1 VEC1 1 2"), "VEC1 is not followed by its numbers");
  expectContains(problems("BEGIN_SPRING 0 1 KS_T 1"), "has no end");
  expectContains(problems("BEGIN_SPRING 0 1 KS_R -1 END_SPRING"), "KS_R is -1");
  expectContains(problems("BEGIN_SPRING 1 1 END_SPRING"), "joins frame 1 to itself");
  expectContains(problems("SPRING"), "'SPRING' is not a word");
}

TEST(Joints, SayWhatIsWrong) {
  const auto problems = [](const std::string& spring) {
    return problemsOf(
        "<Node name=\"root\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template=\"Rigid3\" "
        "position=\"0 0 0 0 0 0 1  1 0 0 0 0 0 1\"/>"
        "<UniformMass totalMass=\"1\"/><JointSpringForceField spring=\"" +
        spring + "\"/></Node>");
  };
  expectContains(problems("BEGIN_SPRING 0 1 KS_X 1 END_SPRING"), "'KS_X' is not a word");
  expectContains(problems("BEGIN_SPRING 0 1 KS_T 1"), "KS_T is not followed by its numbers");
  expectContains(problems("BEGIN_SPRING 0 0 END_SPRING"), "joins frame 0 to itself");
  expectContains(problems("BEGIN_SPRING 0 7 END_SPRING"), "2 nodes");
  expectContains(problems("BEGIN_SPRING 0 1 R_LIM_X 1 -1 END_SPRING"), "leave no angle");
  expectContains(problems("BEGIN_SPRING 0 1 KS_T 0 -3 END_SPRING"), "no stiffness");
  expectContains(problems("BEGIN_SPRING 0 1 REST_R 0 0 0 0 END_SPRING"), "not an orientation");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
