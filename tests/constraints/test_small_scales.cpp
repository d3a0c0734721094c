// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes of a femtogram: what constraints hold obliquely takes no digits from what is free, whatever solves. One step of Euler's
// rule from rest, without stiffness: v = h a, with a of the constrained bodies.
#include <fmt/format.h>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double mass = 1e-18, step = 1e-3;  // [kg], [s]
const Vec3 gravity(0.5, -9.81, 2);

const std::vector<std::string> solvers = {
    "<SparseLDLSolver/>",
    "<SparseLUSolver/>",
    "<EigenSimplicialLDLT/>",
    "<EigenSparseQR/>",
    "<SVDLinearSolver/>",
    "<CGLinearSolver iterations='100' tolerance='1e-14' template='GraphScattered'/>",
    "<CGLinearSolver iterations='100' tolerance='1e-14' template='CompressedRowSparseMatrix'/>",
};

/// The velocities after the step; node 0 is held, nodes 1 and 2 have 1 and 3 masses.
std::vector<Vec3> velocities(const std::string& solver, const std::string& constraint) {
  Simulation simulation = simulationFromText(
      fmt::format("<Node name='root' dt='{}' gravity='0.5 -9.81 2'><EulerImplicitSolver/>{}<MechanicalObject name='dofs' "
                  "position='0 0 0  1e-5 0 0  2e-5 0 0'/><DiagonalMass vertexMass='{} {} {}'/>"
                  "<FixedProjectiveConstraint indices='0'/>{}</Node>",
                  step, solver, mass, mass, 3 * mass, constraint));
  simulation.step();
  const System& system = *simulation.systems().at(0);
  return {system.v[0], system.v[1], system.v[2]};
}

void expectVelocities(const std::string& constraint, const Vec3& first, const Vec3& second) {
  for (const std::string& solver : solvers) {
    SCOPED_TRACE(constraint + solver);
    const std::vector<Vec3> v = velocities(solver, constraint);
    EXPECT_EQ(v[0].norm(), 0);
    EXPECT_LT((v[1] - step * first).norm(), 1e-12 * step * gravity.norm());
    EXPECT_LT((v[2] - step * second).norm(), 1e-12 * step * gravity.norm());
  }
}

TEST(SmallScales, AHeldNodeTakesNothingFromAFreeOne) { expectVelocities("", gravity, gravity); }

TEST(SmallScales, AnObliquePlane) {
  const Vec3 n = Vec3(1, 2, 0.5).normalized();
  expectVelocities("<FixedPlaneProjectiveConstraint indices='1' direction='1 2 0.5'/>", gravity - n.dot(gravity) * n, gravity);
}

TEST(SmallScales, AnObliqueDirection) {
  const Vec3 n = Vec3(1, 1, 0).normalized();
  expectVelocities("<DirectionProjectiveConstraint indices='2' direction='1 1 0'/>", gravity, n.dot(gravity) * n);
}

/// Under a load on one of two tied nodes both have F / (m1 + m2) more.
TEST(SmallScales, TiedNodes) {
  const Vec3 load(3e-18, 1e-18, -2e-18), both = gravity + load / (4 * mass);
  expectVelocities("<ConstantForceField indices='1' forces='3e-18 1e-18 -2e-18'/><AttachProjectiveConstraint object1='@dofs' "
                   "object2='@dofs' indices1='1' indices2='2' twoWay='true'/>",
                   both, both);
}

/// u1 = 2 u2 in all directions: a1 = g - l / m1 and a2 = g + 2 l / m2, with l = -g / (1 / m1 + 4 / m2).
TEST(SmallScales, RelatedNodes) {
  const Vec3 force = -gravity / (1 / mass + 4 / (3 * mass));
  expectVelocities("<LinearRelationProjectiveConstraint indices='1 2' coefficients='1 -2'/>", gravity - force / mass,
                   gravity + 2 * force / (3 * mass));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
