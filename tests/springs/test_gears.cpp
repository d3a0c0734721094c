// SPDX-License-Identifier: LGPL-2.1-or-later
// Wheels that turn each other, springs that remember a vector, and springs outside of the matrix, against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <numbers>
#include <random>

#include "framework/mechanics/frames.h"
#include "framework/simulation/system.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string framesOf(const std::string& positions, const std::string& field, const std::string& velocity = "", double h = 0.01) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerImplicitSolver trapezoidalScheme="true"/><SparseLDLSolver/>
    <MechanicalObject template="Rigid3" position="{}" {}/><UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>{}</Node>)",
                     h, positions, velocity, field);
}

std::string gear(const std::string& words, const std::string& more = "") {
  return "<GearSpringForceField spring='BEGIN_SPRING " + words + " END_SPRING' " + more + "/>";
}

/// The slip s = R phi_1 + phi_2 swings with w^2 = k (R + 1/R) / I, turned by 2 atan(w h / 2) in a step of the trapezoidal rule,
/// while the wheels turn more than ten times.
TEST(Gears, TheSlipSwingsWhileTheWheelsTurn) {
  const double h = 0.01, k = 50, ratio = 2, inertia = 0.1, w = std::sqrt(k * (ratio + 1 / ratio) / inertia), first = 40, slip = 0.7;
  Simulation simulation = simulationFromText(
      framesOf("0 0 0  0 0 0 1   2 0 0  0 0 0 1", gear("0 0 1 1 AXIS 2 2 KS_R 50 1e4 KD 0 RATIO 2"),
               fmt::format("velocity='0 0 0 0 0 {}  0 0 0 0 0 {}'", first, slip - ratio * first), h));
  const State& state = *simulation.states().at(0);
  const double turn = 2 * std::atan(w * h / 2);
  for (int step = 1; step <= 200; ++step) {
    ASSERT_FALSE(simulation.step().failed());
    const double one = state.v()[1].z(), other = state.v()[3].z();
    ASSERT_NEAR(ratio * one + other, slip * std::cos(step * turn), 1e-9) << step;
    ASSERT_NEAR(one - ratio * other, first - ratio * (slip - ratio * first), 1e-9) << "torques are 1 : 1/R";
  }
  EXPECT_LT(Vec3(state.x()[0]).norm(), 1e-12);
}

TEST(Gears, CountWholeTurnsAgainAfterAReset) {
  Simulation simulation = simulationFromText(framesOf("0 0 0  0 0 0 1   2 0 0  0 0 0 1", gear("0 0 1 1 KS_R 50 1e4 KD 0"),
                                                      "velocity='0 0 0 40 0 0  0 0 0 -39 0 0'"));
  for (int step = 0; step < 60; ++step) simulation.step();
  const std::uint64_t hash = simulation.stateHash();
  simulation.reset();
  for (int step = 0; step < 60; ++step) simulation.step();
  EXPECT_EQ(simulation.stateHash(), hash);
}

const std::string four_frames =
    "0 0 0  0.1 0.2 0.3 0.9273618495495704   0.1 0 0.2  0.2 0.1 0.5 0.8366600265340756   2 0 0  0 0 0 1   2 0.1 0  0.3 0.1 0 "
    "0.9486832980505138";

/// Energy, force and tangent against each other: the tangent is the symmetric part, without half of the torque's own turn.
TEST(Gears, ForceAndTangentAreThoseOfTheEnergy) {
  for (const std::string words : {"0 1 2 3 AXIS 2 0", "1 1 2 3 AXIS 1 0", "0 1 3 3 AXIS 2 1", "0 1 0 2 AXIS 0 1"}) {
    SCOPED_TRACE(words);
    Simulation simulation = simulationFromText(framesOf(four_frames, gear(words + " KS_T 30 KS_R 7 20 KD 0 RATIO 1.5")));
    System& system = *simulation.systems().at(0);
    ForceField& field = *system.forceFields().at(0);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Vector d(8), v(8);
    for (Index i = 0; i < 8; ++i) d[i] = Vec3(uniform(random), uniform(random), uniform(random));
    const double h = 1e-5;
    const auto moved = [&](double s) {
      Vector x(8);
      copy(system.x, x);
      system.motion().advance(s, d, x);
      return x;
    };
    const auto forceAt = [&](const Vector& x) {
      Vector f(8);
      field.addForce(x, v, f);
      return f;
    };
    const Vector plus = forceAt(moved(h)), minus = forceAt(moved(-h)), f = forceAt(moved(0));
    EXPECT_GT(norm(f), 1);
    EXPECT_NEAR((field.energy(moved(h)) - field.energy(moved(-h))) / (2 * h), -dot(f, d), 1e-7 * norm(f));
    Vector product(8);
    field.addStiffnessProduct(d, 1, product);
    for (Index i = 0; i < 8; ++i) {
      Vec3 exact = (plus[i] - minus[i]) / (2 * h);
      if (i % 2 == 1) exact -= 0.5 * Vec3(d[i]).cross(Vec3(f[i]));
      EXPECT_LT((exact - product[i]).norm(), 1e-7 * norm(product)) << i;
    }
  }
}

/// Near half a turn the torque k_r beta has its full size, and opposite axes have none.
TEST(Gears, TheAxisIsHeldUpToHalfATurn) {
  for (const double beta : {1e-6, 0.5, std::numbers::pi - 1e-3, std::numbers::pi - 5e-5}) {
    SCOPED_TRACE(beta);
    const std::string wheel = fmt::format("{} 0 0 {}", std::sin(beta / 2), std::cos(beta / 2));  // turned about x
    Simulation simulation = simulationFromText(framesOf("0 0 0  0 0 0 1   0 0 0  " + wheel + "   2 0 0  0 0 0 1   2 0 0  0 0 0 1",
                                                        gear("0 1 2 3 AXIS 2 2 KS_R 0 20 KD 0")));
    const System& system = *simulation.systems().at(0);
    Vector f(8), v(8);
    system.forceFields().at(0)->addForce(system.x, v, f);
    EXPECT_NEAR(f[3].x(), -20 * beta, 1e-8);
    EXPECT_NEAR(f[1].x(), 20 * beta, 1e-8);
    EXPECT_LT(std::hypot(f[3].y(), f[3].z()), 1e-8);
  }
}

TEST(Gears, OneSidedTeethLeaveThePivots) {
  const std::string start = "0 0 0  0 0 0 1   0 0 0  0 0 0.1 0.99498743710662   2 0 0  0 0 0 1   2 0 0  0 0 0 1";
  const double angle = 2 * std::asin(0.1);
  for (const bool one_sided : {false, true}) {
    Simulation simulation = simulationFromText(framesOf(
        start, gear("0 1 2 3 AXIS 2 2 KS_R 30 1e4 KD 0 RATIO 2", one_sided ? "oneSided='true'" : "")));
    System& system = *simulation.systems().at(0);
    Vector f(8), v(8);
    system.forceFields().at(0)->addForce(system.x, v, f);
    EXPECT_NEAR(f[3].z(), -30 * 2 * angle, 1e-10);
    EXPECT_NEAR(f[7].z(), -30 * angle, 1e-10);
    EXPECT_NEAR(f[1].z(), one_sided ? 0 : 60 * angle, 1e-10);
    EXPECT_NEAR(f[5].z(), one_sided ? 0 : 30 * angle, 1e-10);
  }
}

/// Wheels whose centres lie apart from their pivots, all of it in one rigid motion: KD has nothing to brake. In any motion what it
/// does to wheel and pivot has no resultant and no moment, takes energy, and is C v.
TEST(Gears, DampingIsThatOfTheMotionAgainstThePivot) {
  Simulation simulation = simulationFromText(framesOf("0 0 0  0 0 0 1   0.3 0 0  0 0 0 1   2 0 0  0 0 0 1   2.3 0 0.1  0 0 0 1",
                                                      gear("0 1 2 3 AXIS 2 2 KS_T 0 KS_R 0 0 KD 20")));
  const System& system = *simulation.systems().at(0);
  ForceField& field = *system.forceFields().at(0);
  const Vec3 spin(0.2, -0.3, 1);
  Vector v(8), f(8);
  for (Index i = 0; i < 8; i += 2) v[i] = spin.cross(Vec3(system.x[i])), v[i + 1] = spin;
  field.addForce(system.x, v, f);
  EXPECT_LT(norm(f), 1e-13);
  for (Index i = 0; i < 8; ++i) v[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(5 * i + 1));
  Vector damped(8), product(8);
  field.addForce(system.x, v, damped);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (Index i = 0; i < 4; i += 2)
    force += damped[i], moment += Vec3(system.x[i]).cross(Vec3(damped[i])) + Vec3(damped[i + 1]);
  EXPECT_LT(force.norm() + moment.norm(), 1e-12 * norm(damped));
  EXPECT_LT(dot(damped, v), -1);
  field.addDampingProduct(v, 1, product);
  for (Index i = 0; i < 8; ++i) EXPECT_LT((product[i] - damped[i]).norm(), 1e-12 * norm(damped)) << i;
}

TEST(Gears, TurnsThatCannotBeCountedAreTold) {
  for (const double speed : {200., 300.}) {
    Simulation simulation = simulationFromText(framesOf("0 0 0  0 0 0 1   2 0 0  0 0 0 1", gear("0 0 1 1 AXIS 2 2 KS_R 1 1e4 KD 0"),
                                                        fmt::format("velocity='0 0 0 0 0 {0}  0 0 0 0 0 -{0}'", speed)));
    simulation.step();
    const System& system = *simulation.systems().at(0);
    const std::string doubt = system.forceFields().at(0)->doubt(system.x);
    if (speed < 250)
      EXPECT_EQ(doubt, "");
    else
      expectContains(doubt, "turns by 3 rad in a step");
  }
}

/// Teeth with k_s R beyond all numbers: of what the field computes the tangent alone overflows, and the processor notes it.
TEST(Gears, ExplicitStepsComputeNoTangent) {
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerExplicitSolver/><MechanicalObject template='Rigid3' position='0 0 0  0 0 0 "
      "1   2 0 0  0 0 0 1' velocity='1 0 0 0 0 0  0 0 0 0 0 0'/><UniformMass totalMass='2' inertia='0.1 0.1 0.1'/>" +
      gear("0 0 1 1 AXIS 2 2 KS_T 10 KS_R 1e200 1 KD 0 RATIO 1e200") + "</Node>");
  System& system = *simulation.systems().at(0);
  ForceField& field = *system.forceFields().at(0);
  const auto overflows = [](const auto& computed) {
    std::feclearexcept(FE_ALL_EXCEPT);
    computed();
    return std::fetestexcept(FE_OVERFLOW) != 0;
  };
  Vector f(4), d(4), product(4);
  EXPECT_FALSE(overflows([&] {
    for (int step = 0; step < 3; ++step) ASSERT_FALSE(simulation.step().failed());
  }));
  EXPECT_LT(system.v[0].x(), 1) << "the pivot has held it back";
  EXPECT_FALSE(overflows([&] { field.addForce(system.x, system.v, f); }));
  EXPECT_TRUE(overflows([&] { field.addStiffnessProduct(d, 1, product); })) << "nothing would be seen";
}

TEST(Gears, SayWhatIsWrong) {
  const auto told = [](const std::string& words) { return problemsOf(framesOf(four_frames, gear(words))); };
  expectContains(told("0 1 2 9"), "expected indices in 0 ... 3");
  expectContains(told("0 1 2 3 AXIS 0 3"), "AXIS 3 is no axis");
  expectContains(told("0 1 2 3 RATIO 0"), "RATIO 0 turns nothing");
  expectContains(told("0 1 2 3 KD -1"), "is no stiffness and no damping");
  expectContains(told("0 1 2 3 TEETH 7"), "'TEETH' is not a word for it");
  expectContains(told("0 1 2"), "is not followed by its numbers");
}

// ---- vectors ----

/// A mass on such a spring swings in all directions alike, across the spring too, and is damped by its viscosity.
TEST(VectorSprings, AMassSwingsAcrossThem) {
  const double h = 0.01, k = 80, m = 2, w = std::sqrt(k / m);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerImplicitSolver trapezoidalScheme="true"/><SparseLDLSolver/>
      <MechanicalObject position="0 0 0  1 0 0" velocity="0 0 0  0 0.3 0"/><UniformMass vertexMass="2"/>
      <MeshTopology position="0 0 0  1 0 0" edges="0 1"/><FixedProjectiveConstraint indices="0"/>
      <VectorSpringForceField useTopology="true" stiffness="80" viscosity="0"/></Node>)",
      h));
  const State& state = *simulation.states().at(0);
  for (int step = 1; step <= 100; ++step) {
    simulation.step();
    ASSERT_NEAR(state.v()[1].y(), 0.3 * std::cos(2 * step * std::atan(w * h / 2)), 1e-11);
    ASSERT_NEAR(state.x()[1].x(), 1, 1e-13);
  }
}

TEST(VectorSprings, DrawNodesOfTwoBodiesTogether) {
  const std::string body = "<Node name='{0}'><MechanicalObject name='dofs' position='{1}' velocity='{2}'/><UniformMass "
                           "vertexMass='1'/></Node>";
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/>" +
      fmt::format(fmt::runtime(body), "a", "0 0 0  1 0 0", "1 0 0  0 0 0") +
      fmt::format(fmt::runtime(body), "b", "0 0 2  1 3 0", "0 0 0  0 0 0") +
      "<VectorSpringForceField object1='@a/dofs' object2='@b/dofs' stiffness='10' viscosity='3'/></Node>");
  System& system = *simulation.systems().at(0);
  Vector f(4);
  system.forceFields().at(0)->addForce(system.x, system.v, f);
  EXPECT_LT((Vec3(f[0]) - Vec3(-3, 0, 20)).norm(), 1e-13);
  EXPECT_LT((Vec3(f[3]) - Vec3(0, -30, 0)).norm(), 1e-13);
  EXPECT_LT((Vec3(f[0]) + Vec3(f[2])).norm(), 1e-15);
  const std::string alone = "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject position='0 0 0'/>"
                            "<UniformMass/><VectorSpringForceField/></Node>";
  expectContains(problemsOf(alone), "joins each node to itself");
}

// ---- outside of the matrix ----

/// Newton's method may then not search along an energy, in which their work is missing.
TEST(ExplicitDamping, IsInNoEnergy) {
  const std::string points = "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject position='0 0 0  1 0 0'/>"
                             "<MeshTopology position='0 0 0  1 0 0' edges='0 1'/><UniformMass totalMass='2'/>";
  const auto isConservative = [](const std::string& scene) {
    return simulationFromText(scene).systems().at(0)->forceFields().at(0)->traits().conservative;
  };
  for (const char* field : {"<VectorSpringForceField useTopology='true' viscosity='2' explicitDamping='{}'/>",
                            "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1' damping='2' explicitForce='{}'/>",
                            "<PlaneForceField stiffness='10' damping='2' explicitDamping='{}'/>",
                            "<UniformVelocityDampingForceField dampingCoefficient='2' explicitDamping='{}'/>"})
    for (const bool is_explicit : {false, true})
      EXPECT_EQ(isConservative(points + fmt::format(fmt::runtime(field), is_explicit) + "</Node>"), !is_explicit) << field;
  const std::string sheet = "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position='0 0 0  1 0 0  0 1 0' "
                            "triangles='0 1 2'/><MechanicalObject/><UniformMass totalMass='2'/>";
  for (const char* type : {"TriangularQuadraticSpringsForceField", "TriangularBiquadraticSpringsForceField"})
    for (const bool is_explicit : {false, true})
      EXPECT_EQ(isConservative(sheet + fmt::format("<{} youngModulus='10' poissonRatio='0.3' dampingRatio='0.1' "
                                                   "explicitDamping='{}'/></Node>", type, is_explicit)), !is_explicit) << type;
  const std::string ball = "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name='f' template='Rigid3' "
                           "position='0 0 0 0 0 0 1'/><UniformMass totalMass='2' inertia='1 1 1'/><Node name='p'><MechanicalObject "
                           "name='q' position='0.5 0 0'/><UniformMass totalMass='1'/></Node>";
  for (const bool is_explicit : {false, true})
    EXPECT_EQ(isConservative(ball + fmt::format("<InteractionEllipsoidForceField object1='@p/q' object2='@f' center='0 0 0' "
                                                "vradius='1 1 1' stiffness='10' damping='2' object2_forces='true' "
                                                "explicitDamping='{}'/></Node>",
                                                is_explicit)), !is_explicit);
  for (const bool is_explicit : {false, true})
    EXPECT_EQ(isConservative(framesOf(four_frames, gear("0 1 2 3 KD 2", is_explicit ? "explicitDamping='true'" : ""))),
              !is_explicit);
}

/// Explicit forces of a linear step, velocities first: symplectic Euler's phase, 2 asin(w h / 2) per step; momentum is kept.
TEST(ExplicitSprings, TheStepIsThatOfSymplecticEuler) {
  const double h = 0.01, w = std::sqrt(100 * (1 / 1. + 1 / 3.));
  const std::string body = "<Node name='{0}'><MechanicalObject name='dofs' position='{1}'/><UniformMass vertexMass='{2}'/></Node>";
  Simulation simulation = simulationFromText(
      fmt::format("<Node name='root' dt='{}' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/>", h) +
      fmt::format(fmt::runtime(body), "a", "0 0 0", 1) + fmt::format(fmt::runtime(body), "b", "1.1 0 0", 3) +
      "<SpringForceField object1='@a/dofs' object2='@b/dofs' springsIndices1='0' springsIndices2='0' lengths='1' stiffness='100' "
      "damping='0' explicitForce='true'/></Node>");
  const System& system = *simulation.systems().at(0);
  const double step_w = 2 * std::asin(w * h / 2);
  for (int step = 1; step <= 300; ++step) {
    simulation.step();
    const double exact = 0.1 * (std::cos(step * step_w) - std::tan(step_w / 2) * std::sin(step * step_w));
    ASSERT_NEAR(system.x[1].x() - system.x[0].x() - 1, exact, 1e-11) << step;
    ASSERT_NEAR(system.v[0].x() + 3 * system.v[1].x(), 0, 1e-13);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
