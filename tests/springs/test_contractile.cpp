// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs whose lengths at rest are prescribed over time, against their formulas.
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string chain(const std::string& field, const std::string& more = "") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>"
         "<MechanicalObject position=\"0 0 0  2 0 0  2 1 0\"/><UniformMass vertexMass=\"0.1\"/>" +
         field + more + "</Node>";
}

std::string fibres(const std::string& attributes) {
  return "<ContractileForceField edges=\"0 1  1 2\" stiffness=\"50\" " + attributes + "/>";
}

TEST(ContractileForceField, RestLengthsFollowTheTable) {
  FieldUnderTest t(chain(fibres("times=\"0 1 3\" factors=\"1 0.5 1\" period=\"3\"")), "ContractileForceField");
  struct At {
    double time, factor;
  };
  for (const At& at : {At{0, 1}, At{0.5, 0.75}, At{1, 0.5}, At{2, 0.75}, At{3, 1}, At{7, 0.5}, At{30.5, 0.75}}) {
    t.field().setTime(at.time);
    t.rest();
    const Vector f = t.force();
    const Vec3 first(50 * 2 * (1 - at.factor), 0, 0), second(0, 50 * (1 - at.factor), 0);
    EXPECT_LT((f[0] - first).norm(), 1e-12) << at.time;
    EXPECT_LT((f[1] - second + first).norm(), 1e-12) << at.time;
    EXPECT_LT((f[2] + second).norm(), 1e-12) << at.time;
    EXPECT_NEAR(t.field().energy(t.x), 25 * 5 * (1 - at.factor) * (1 - at.factor), 1e-12);
  }
}

TEST(ContractileForceField, WithoutAPeriodTheLastFactorStaysAndASlackFibreMayBeWithoutForce) {
  FieldUnderTest t(chain(fibres("times=\"1 2\" factors=\"1 1.5\" elongationOnly=\"true\"")), "ContractileForceField");
  t.field().setTime(100);
  EXPECT_EQ(dot(t.force(), t.force()), 0) << "shorter than 1.5 times its rest length";
  t.x[0] = Vec3(-4, 0, 0);
  EXPECT_NEAR(t.force()[0].x(), 50 * (6 - 3), 1e-12);
  t.field().setTime(0);
  EXPECT_NEAR(t.force()[0].x(), 50 * (6 - 2), 1e-12);
}

TEST(ContractileForceField, PullingFibresBalance) {
  FieldUnderTest t(chain(fibres("damping=\"3\" times=\"0 1\" factors=\"1 0.5\"")), "ContractileForceField");
  for (const double time : {0.2, 0.7, 2.}) {
    t.field().setTime(time);
    t.rest();
    EXPECT_GT(t.force()[0].norm(), 1) << "at rest it pulls";
    for (const double noise : {0.03, 0.3}) {
      t.deform(noise);
      EXPECT_LT(momentumOf(t.x, t.force()).force, 1e-12) << "Newton's law";
      EXPECT_LT(momentumOf(t.x, t.force()).torque, 1e-12) << "Euler's law";
    }
  }
}

TEST(ContractileForceField, AMuscleShortensToItsLength) {
  for (const char* integrator : {"<EulerImplicitSolver rayleighMass=\"20\"/>", "<RungeKutta4Solver/>"}) {
    Simulation simulation = simulationFromText(
        std::string("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\">") + integrator +
        "<SparseLDLSolver/><MechanicalObject position=\"0 0 0  2 0 0\"/><UniformMass vertexMass=\"0.1\"/>"
        "<MeshTopology position=\"0 0 0  2 0 0\" edges=\"0 1\"/><FixedProjectiveConstraint indices=\"0\"/>"
        "<ContractileForceField stiffness=\"50\" damping=\"2\" times=\"0 1\" factors=\"1 0.7\"/></Node>");
    for (int i = 0; i < 400; ++i) ASSERT_FALSE(simulation.step().diverged);
    EXPECT_NEAR(simulation.systems()[0]->x[1].x(), 1.4, 1e-6) << integrator;
  }
}

TEST(ContractileForceField, BadInputIsSaid) {
  const auto says = [](const std::string& field, const std::string& words) {
    const std::string problems = problemsOf(chain(field));
    EXPECT_NE(problems.find(words), std::string::npos) << problems;
  };
  says(fibres("times=\"0 1\" factors=\"1\""), "2 times and 1 factors");
  says(fibres("times=\"0 0\" factors=\"1 1\""), "ascending");
  says(fibres("times=\"0 1\" factors=\"1 2\" period=\"1\""), "jump");
  says(fibres("times=\"0 2\" factors=\"1 1\" period=\"1\""), "up to the period");
  says(fibres("period=\"1\""), "nothing to repeat");
  says("<ContractileForceField stiffness=\"1\"/>", "no fibres");
  says("<ContractileForceField stiffness=\"1\" edges=\"0 9\"/>", "9");
  says(fibres("times=\"0 1\" factors=\"1 0\""), "factors");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
