// SPDX-License-Identifier: LGPL-2.1-or-later
// A body is where it would be alone, however heavy others are: Newton's method ends where each of them is in balance.
#include <stdexcept>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A block that is held at one end.
std::string block(const std::string& name, const std::string& grid, double mass, double young, const std::string& method,
                  const std::string& more = {}) {
  return fmt::format("<Node name=\"{0}\"><RegularGridTopology {1}/><MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"{2:g}\"/>"
                     "<HexahedronFEMForceField youngModulus=\"{3:g}\" poissonRatio=\"0.3\" method=\"{4}\"/>"
                     "<FixedProjectiveConstraint indices=\"0 9 18 27\"/>{5}</Node>",
                     name, grid, mass, young, method, more);
}

/// The places of a soft beam after some steps, beside a frame of a ton or alone; its forces are in proportion to `scale`.
std::vector<Vec3> beam(const std::string& integrator, double scale, bool beside_heavy, const std::string& more = {},
                       const std::string& solver = "<SparseLDLSolver/>", int steps = 3) {
  std::string bodies = block("beam", "n=\"9 2 2\" min=\"0 0 0\" max=\"1 0.1 0.1\"", scale, 1e5 * scale, "polar", more);
  if (beside_heavy) bodies += block("frame", "n=\"9 2 2\" min=\"5 0 0\" max=\"6 1 1\"", 1e3, 1e9, "small");
  const std::string root = "<Node name=\"root\" dt=\"0.05\" gravity=\"0 -10 0\">";
  Simulation simulation = simulationFromText(root + integrator + solver + bodies + "</Node>");
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
    EXPECT_TRUE(report.newton_converged) << report.reason;
  }
  std::vector<Vec3> places;
  const State& state = *simulation.states()[0];
  for (Index i = 0; i < state.size(); ++i) places.push_back(state.x()[i]);
  return places;
}

TEST(LightBodies, AreInBalanceBesideHeavyOnes) {
  for (const std::string integrator : {"<StaticSolver/>", "<EulerImplicitSolver newtonIterations=\"30\"/>",
                                       "<TrapezoidalRuleSolver newtonIterations=\"30\"/>", "<BDFOdeSolver newtonIterations=\"30\"/>",
                                       "<NewmarkImplicitSolver newtonIterations=\"30\"/>"})
    for (const double scale : {1e-3, 1e-6, 1e-9, 1e-12}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, scale));
      const std::vector<Vec3> alone = beam(integrator, scale, false), beside = beam(integrator, scale, true);
      ASSERT_EQ(alone.size(), beside.size());
      double off = 0, way = 0;
      for (std::size_t i = 0; i < alone.size(); ++i)
        off = std::max(off, (alone[i] - beside[i]).norm()), way = std::max(way, std::abs(alone[i].y()));
      EXPECT_LT(off, 1e-3 * way);
    }
}

double largestOff(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) off = std::max(off, (a[i] - b[i]).norm());
  return off;
}

double lowest(const std::vector<Vec3>& places) {
  double way = 0;
  for (const Vec3& place : places) way = std::max(way, std::abs(place.y()));
  return way;
}

/// A rod of a Lagrangian constraint in the beam.
TEST(LightBodies, AreInBalanceWithForcesOfConstraint) {
  const std::string rod = "<DistanceLagrangianConstraint first_point=\"4\" second_point=\"13\"/>";
  for (const std::string integrator : {"<StaticSolver/>", "<EulerImplicitSolver newtonIterations=\"60\"/>",
                                       "<BDFOdeSolver newtonIterations=\"60\"/>"})
    for (const double scale : {1e-3, 1e-9}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, scale));
      const std::vector<Vec3> alone = beam(integrator, scale, false, rod), beside = beam(integrator, scale, true, rod);
      EXPECT_LT(largestOff(alone, beside), 1e-3 * lowest(alone));
    }
}

/// The first state, which has no forces of a step before.
TEST(LightBodies, AreInBalanceWithForcesOfConstraintFromTheFirstStep) {
  const std::string rod = "<DistanceLagrangianConstraint first_point=\"4\" second_point=\"13\"/>", statics = "<StaticSolver/>";
  for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver/>", "<PCGLinearSolver/>"})
    for (const double scale : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
      SCOPED_TRACE(fmt::format("{} {}", solver, scale));
      const std::vector<Vec3> alone = beam(statics, scale, false, rod, solver, 1), beside = beam(statics, scale, true, rod, solver, 1);
      EXPECT_LT(largestOff(alone, beside), 1e-4 * lowest(alone));
    }
}

/// A rod in the beam, and one from its free end to the frame, which gives way by less than can be seen. Forces of constraint are far larger
/// on the way than at its end: what a body is measured by are those of now.
TEST(LightBodies, AreInBalanceTiedToAHeavyOne) {
  const std::string rod = "<DistanceLagrangianConstraint first_point=\"4\" second_point=\"13\"/>";
  const auto tied = [&](const std::string& solver, double scale) {
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"0.05\" gravity=\"0 -10 0\"><StaticSolver/>" + solver +
        block("beam", "n=\"9 2 2\" min=\"0 0 0\" max=\"1 0.1 0.1\"", scale, 1e5 * scale, "polar", rod) +
        block("frame", "n=\"9 2 2\" min=\"1.2 0 0\" max=\"2.2 1 1\"", 1e3, 1e9, "small") +
        "<DistanceLagrangianConstraint object1=\"@/beam/dofs\" object2=\"@/frame/dofs\" first_point=\"8\" second_point=\"0\"/></Node>");
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.newton_converged && !report.diverged) << report.reason;
    std::vector<Vec3> places;
    for (Index i = 0; i < simulation.states()[0]->size(); ++i) places.push_back(simulation.states()[0]->x()[i]);
    return places;
  };
  const std::vector<Vec3> expected = tied("<SparseLDLSolver/>", 1e-5);
  for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver/>"})
    for (const double scale : {1e-2, 1e-5, 1e-9})
      EXPECT_LT(largestOff(expected, tied(solver, scale)), 1e-5 * lowest(expected)) << solver << " " << scale;
}

/// A spring to the ground under a body that is pushed up where the first row of the system is near y = -2. Its tangent does not know.
/// `turns`: the push is the other way where the body is above the middle of the places with and without it, so that nothing balances.
/// It throws where the first row is between y = -3.6 and -2.6, once.
class PushedByOther : public GroundSpring {
 public:
  void declare(DataTable& table) override {
    GroundSpring::declare(table);
    table.add("push_near", push_).help("force").unit("N");
    table.add("turns_above", turns_above_).help("y").unit("m");
  }
  ForceTraits traits() const override {
    ForceTraits traits = GroundSpring::traits();
    traits.linear = traits.constant_stiffness = traits.conservative = false;
    return traits;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    GroundSpring::addForce(x, v, f);
    const Vec3 other = x[0];
    if (throws && other.y() > -3.6 && other.y() < -2.6) throws = false, throw std::runtime_error("a force of the test that throws");
    const Index row = state().firstRow();
    const double push = push_ * std::exp(-100 * (other.y() + 2) * (other.y() + 2));
    f[row] += Vec3(0, Vec3(x[row]).y() > turns_above_ ? -push : push, 0);
  }
  inline static bool throws = false;

 private:
  double push_ = 0, turns_above_ = 1e9;
};

/// A point of a nanogram at a hardening spring, which comes to y = -2 by way of -10, and one of a ton, which goes 1 mm down.
Simulation lightAndHeavy(const std::string& push) {
  static const bool registered = (factory().add<PushedByOther>("TestPushedByOther", "test"), true);
  EXPECT_TRUE(registered);
  registerGroundSpring(factory());
  return simulationFromText("<Node name=\"root\" dt=\"1\" gravity=\"0 -10 0\"><StaticSolver/><SparseLDLSolver/>"
                            "<Node name=\"light\"><MechanicalObject name=\"dofs\" position=\"0 0 0\"/><UniformMass totalMass=\"1e-9\"/>"
                            "<TestGroundSpring stiffness=\"1e-9\" cubic=\"1e-9\"/></Node>"
                            "<Node name=\"heavy\"><MechanicalObject name=\"dofs\" position=\"5 0 0\"/><UniformMass totalMass=\"1e3\"/>"
                            "<TestPushedByOther stiffness=\"1e7\" " +
                            push + "/></Node></Node>");
}

TEST(LightBodies, LeaveTheOthersInBalance) {
  Simulation simulation = lightAndHeavy("push_near=\"1\"");
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  EXPECT_NEAR(simulation.states()[0]->x()[0].y(), -2, 1e-5);
  EXPECT_NEAR(simulation.states()[1]->x()[0].y(), (1 - 1e4) / 1e7, 1e-10);
  EXPECT_LT(report.newton_residual, 1e-8);
}

TEST(LightBodies, ThatLeaveTheOthersOutOfBalanceAreNoResult) {
  Simulation simulation = lightAndHeavy("push_near=\"1\" turns_above=\"-0.00099995\"");
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.newton_converged);
  expectContains(report.reason, "of all bodies after");
}

TEST(LightBodies, AreForgottenWhereAForceThrows) {
  const std::string hardens = "cubic=\"3e10\"";  // the heavy body needs three iterations, of which the third is for less than 1e-6
  Simulation simulation = lightAndHeavy(hardens), undisturbed = lightAndHeavy(hardens);
  const StepReport expected = undisturbed.step();
  EXPECT_TRUE(expected.newton_converged) << expected.reason;
  PushedByOther::throws = true;
  EXPECT_THROW(simulation.step(), std::runtime_error);
  EXPECT_FALSE(PushedByOther::throws);
  EXPECT_EQ(simulation.states()[1]->x()[0].y(), 0) << "the step is taken back";
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  EXPECT_LT(report.newton_residual, 1e-8);
  EXPECT_EQ(report.newton_iterations, expected.newton_iterations);
  for (const std::size_t i : {0, 1}) EXPECT_EQ(simulation.states()[i]->x()[0].y(), undisturbed.states()[i]->x()[0].y());
  EXPECT_NEAR(simulation.states()[0]->x()[0].y(), -2, 1e-5);
}

/// A spring that is pressed to a tenth of its length makes the matrix of a step indefinite. What falls beside it falls as alone.
TEST(LightBodies, FallBesideASpringInPressure) {
  const auto point = [](const char* name, double mass) {
    return fmt::format("<Node name=\"{}\"><MechanicalObject position=\"5 0 0\"/><UniformMass totalMass=\"{:g}\"/></Node>", name, mass);
  };
  const std::string spring = "<Node name=\"spring\"><MechanicalObject position=\"9 0 0  9.1 0 0\"/><UniformMass totalMass=\"0.02\"/>"
                             "<FixedProjectiveConstraint indices=\"0\"/><SpringForceField springsIndices1=\"0\" springsIndices2=\"1\" "
                             "lengths=\"1\" stiffness=\"5000\"/></Node>";
  for (const std::string solver : {"<SparseLDLSolver/>", "<EigenSimplicialLLT/>",
                                   "<PCGLinearSolver preconditioner=\"ssor\" tolerance=\"1e-10\"/>",
                                   "<CGLinearSolver iterations=\"100\" tolerance=\"1e-10\"/>"}) {
    SCOPED_TRACE(solver);
    Simulation simulation =
        simulationFromText("<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/>" + solver + point("light", 1e-9) +
                           point("heavy", 1) + spring + "</Node>");
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
    EXPECT_FALSE(report.linear_converged);  // and that is told
    EXPECT_NEAR(simulation.states()[1]->v()[0].y(), -0.1, 1e-6);
    EXPECT_NEAR(simulation.states()[0]->v()[0].y(), -0.1, 1e-4);  // where solves end by a residual
  }
}

/// A soft beam beside a ton, one linear step: conjugate gradients end by the residual of all, which the ton has. As by factors.
TEST(LightBodies, BendInALinearStep) {
  const auto speeds = [](const std::string& solver, double mass) {
    Simulation simulation = simulationFromText(fmt::format(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/>{}<Node name=\"beam\">"
        "<RegularGridTopology n=\"12 3 3\" min=\"0 0 0\" max=\"1 0.1 0.1\"/><MechanicalObject/><UniformMass totalMass=\"{}\"/>"
        "<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"0.3\" method=\"large\"/>"
        "<FixedProjectiveConstraint indices=\"0 12 24 36 48 60 72 84 96\"/></Node>"
        "<Node name=\"ton\"><MechanicalObject position=\"0 5 0  1 5 0\"/><UniformMass totalMass=\"1000\"/>"
        "<SpringForceField springsIndices1=\"0\" springsIndices2=\"1\" lengths=\"1\" stiffness=\"1e5\"/></Node></Node>",
        solver, mass, 1e6 * mass));
    EXPECT_TRUE(simulation.step().linear_converged) << solver;
    Vector v(simulation.states()[0]->size());
    copy(simulation.states()[0]->v(), v);
    return v;
  };
  for (const double mass : {0.1, 1e-3, 1e-6}) {
    const Vector factors = speeds("<SparseLDLSolver/>", mass);
    for (const std::string solver : {"<CGLinearSolver iterations=\"500\" tolerance=\"1e-6\"/>",
                                     "<PCGLinearSolver preconditioner=\"ssor\" tolerance=\"1e-6\"/>"})
      EXPECT_LT(distance(speeds(solver, mass), factors), 1e-3 * norm(factors)) << solver << mass;
  }
}

/// A chain in pressure that nothing holds falls as a whole, and what is beside it falls where it is held, too: what makes the matrix of a
/// step definite resists no common movement.
TEST(LightBodies, FallInPressure) {
  for (const std::string solver : {"<SparseLDLSolver/>", "<CGLinearSolver/>", "<PCGLinearSolver preconditioner=\"ssor\"/>",
                                   "<AutomaticLinearSolver/>"})
    for (const int nodes : {2, 3, 10})
      for (const bool is_held : {false, true}) {
        SCOPED_TRACE(fmt::format("{} {} {}", solver, nodes, is_held));
        std::string places, first, second;
        for (int i = 0; i < nodes; ++i) places += fmt::format("{:g} 0 0 ", 0.1 * i);
        for (int i = 1; i < nodes; ++i) first += fmt::format("{} ", i - 1), second += fmt::format("{} ", i);
        Simulation simulation = simulationFromText(fmt::format(
            "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/>{}<Node name=\"chain\"><MechanicalObject "
            "position=\"{}\"/><UniformMass totalMass=\"{:g}\"/>{}<SpringForceField springsIndices1=\"{}\" springsIndices2=\"{}\" "
            "lengths=\"1\" stiffness=\"5000\"/></Node><Node name=\"other\"><MechanicalObject position=\"0 5 0\"/>"
            "<UniformMass totalMass=\"1\"/></Node></Node>",
            solver, places, 0.01 * nodes, is_held ? "<FixedProjectiveConstraint indices=\"0\"/>" : "", first, second));
        const StepReport report = simulation.step();
        EXPECT_FALSE(report.linear_converged);
        double sum = 0;
        for (Index i = 0; i < nodes; ++i) sum += simulation.states()[0]->v()[i].y();
        if (!is_held) EXPECT_NEAR(sum / nodes, -0.1, 1e-9);
        EXPECT_NEAR(simulation.states()[1]->v()[0].y(), -0.1, 1e-9);
      }
}

/// A chain of masses in flight whose springs are pressed: what is between its masses takes nothing of the impulse of gravity.
TEST(FreeBodies, InPressureKeepTheImpulseOfForces) {
  struct Case {
    int count;
    double stiffness;  ///< at 7.4 N/m no block of a node alone is unstable, only the pair is
    Vec3 along;
    const char* held;
  };
  const Vec3 x(0.1, 0, 0), askew(0.06, 0.08, 0);
  const char* guided = "<PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"1 0 1\"/>";
  for (const Case& chain : {Case{2, 5000, x, ""}, Case{3, 5000, x, ""}, Case{10, 5000, askew, ""}, Case{2, 7.4, x, ""},
                            Case{3, 5000, x, guided}}) {
    std::string positions, first, second, lengths;
    for (int i = 0; i < chain.count; ++i) positions += fmt::format("{:g} {:g} 0  ", i * chain.along.x(), i * chain.along.y());
    for (int i = 0; i + 1 < chain.count; ++i) first += fmt::format("{} ", i), second += fmt::format("{} ", i + 1), lengths += "1 ";
    for (const char* solver : {"<SparseLDLSolver/>", "<CGLinearSolver/>", "<PCGLinearSolver/>"}) {
      SCOPED_TRACE(fmt::format("{} masses, {} N/m, {}, {}", chain.count, chain.stiffness, solver, chain.held));
      Simulation simulation = simulationFromText(fmt::format(
          "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/>{}<MechanicalObject position=\"{}\"/>"
          "<UniformMass totalMass=\"{:g}\"/>{}<SpringForceField springsIndices1=\"{}\" springsIndices2=\"{}\" lengths=\"{}\" "
          "stiffness=\"{:g}\"/></Node>",
          solver, positions, 0.01 * chain.count, chain.held, first, second, lengths, chain.stiffness));
      const StepReport report = simulation.step();
      EXPECT_FALSE(report.diverged) << report.reason;
      if (chain.stiffness > 10) EXPECT_FALSE(report.linear_converged) << "the matrix is definite";
      double sum = 0;
      for (int i = 0; i < chain.count; ++i) sum += simulation.states()[0]->v()[i].y();
      EXPECT_NEAR(sum / chain.count, -0.1, 1e-5) << report.reason;
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
