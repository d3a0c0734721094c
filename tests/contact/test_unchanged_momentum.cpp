// SPDX-License-Identifier: LGPL-2.1-or-later
// Angular momentum of two free bodies that collide: contact along a line through both points has no moment; friction, which acts at
// two points a gap apart, has at most the gap times its size.
#include <Eigen/Geometry>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double range = 0.02;
const std::string barrier = "BarrierContact", constraint = "ConstraintContact";
const std::string newton = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-11\"/>";

struct Collision {
  std::string method, integrator;
  double dt;
  int steps;
};

/// A turned cube flies into another one. Their elastic forces have no moment in any shape.
Simulation twoBodies(const Collision& c, double friction) {
  const auto node = [](const std::string& name, const Body& body, const Vec3& v) {
    std::string velocity;
    for (std::size_t i = 0; i < body.points.size(); ++i) velocity += fmt::format("{} {} {}  ", v.x(), v.y(), v.z());
    return fmt::format(
        "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\" velocity=\"{}\"/><MeshMatrixMass massDensity=\"1000\" lumping=\"true\"/>"
        "<TetrahedronHyperelasticityFEMForceField materialName=\"StableNeoHookean\" youngModulus=\"1e6\" poissonRatio=\"0.3\"/></Node>",
        name, body.mesh(), velocity);
  };
  const Body a = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2});
  Body b = boxOf(Vec3(0, 0, 0), Vec3(0.8, 0.8, 0.8), {2, 2, 2});
  b.turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.3).normalized()).toRotationMatrix(), Vec3(0.3, 0.2, 0));
  b.turn(Mat3::Identity(), Vec3(0, 0, 1.05 - b.lowest(2)));
  return simulationFromText(contactScene(
      node("a", a, Vec3::Zero()) + node("b", b, Vec3(0.2, 0, -3)) +
          fmt::format("<{} name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"{}\" "
                      "friction=\"{}\" selfContact=\"0\" {}/>",
                      c.method, range, friction, c.method == barrier ? "stiffness=\"1e5\" frictionIterations=\"20\"" : ""),
      c.dt, Vec3::Zero(), c.integrator));
}

/// Sum of x x M v, and of the lengths of its parts [N m s].
std::pair<Vec3, double> momentOf(const System& system, ConstRows v) {
  Vector product(system.allRows());
  system.addMassProduct(v, 1, product);
  Vec3 sum = Vec3::Zero();
  double size = 0;
  for (Index i = 0; i < product.count(); ++i) {
    const Vec3 part = Vec3(system.x[i]).cross(Vec3(product[i]));
    sum += part, size += part.norm();
  }
  return {sum, size};
}

/// What friction may turn in a step: the gap, at most `range`, times the friction of all contacts, dt long.
double boundOf(Simulation& simulation, const Collision& c) {
  const std::vector<double> f =
      c.method == barrier ? numbersOf(simulation, "frictionForces") : constraintOutput(simulation, "frictionForces");
  double sum = 0;
  for (std::size_t i = 0; i + 2 < f.size(); i += 3) sum += std::hypot(f[i], f[i + 1], f[i + 2]);
  return c.dt * range * sum;
}

/// Backward Euler's rule does not keep x x M v itself, as v1 x M v0 remains. But the impulse M (v1 - v0) is that of forces at the end of
/// the step, and has no moment there.
TEST(UnchangedMomentum, ImpulsesOfBackwardEulerHaveNoMoment) {
  for (const std::string& method : {barrier, constraint})
    for (const double friction : {0.0, 0.4}) {
      SCOPED_TRACE(fmt::format("{} {}", method, friction));
      const Collision c{method, newton, 0.002, 60};
      Simulation simulation = twoBodies(c, friction);
      System& system = *simulation.systems()[0];
      const double size = momentOf(system, system.v).second;
      double largest = 0, most = 0;
      for (int i = 0; i < c.steps; ++i) {
        Vector change(system.v.count());
        copy(system.v, change);
        expectCleanStep(simulation, i);
        if (HasFatalFailure()) return;
        axpy(-1, system.v, change);
        const double moment = momentOf(system, change).first.norm(), bound = friction > 0 ? boundOf(simulation, c) : 0;
        // round-off, and what Newton's method leaves
        ASSERT_LE(moment, 1.001 * bound + 1e-11 * size) << "step " << i;
        largest = std::max(largest, moment / size), most = std::max(most, bound / size);
      }
      RecordProperty(fmt::format("{}_{}", method, friction), fmt::format("largest moment {:.3g}, bound {:.3g}", largest, most));
      EXPECT_EQ(largest > 1e-9, friction > 0) << "friction has some";
      EXPECT_GT(system.v[0].norm(), 0.1) << "the first was pushed";
    }
}

/// Symplectic Euler and central differences keep x x M v to round-off: x1 x M v1 = x0 x M v0 + dt x0 x f(x0). So do parts of steps.
TEST(UnchangedMomentum, ExplicitStepsKeepAngularMomentum) {
  for (const std::string integrator : {"<EulerExplicitSolver/>", "<CentralDifferenceSolver/>", "<NewtonCotesSolver degree=\"1\"/>"})
    for (const double friction : {0.0, 0.4}) {
      SCOPED_TRACE(fmt::format("{} {}", integrator, friction));
      const Collision c{barrier, integrator, 4e-4, 300};
      Simulation simulation = twoBodies(c, friction);
      System& system = *simulation.systems()[0];
      const auto [start, size] = momentOf(system, system.v);
      double bound = 0, largest = 0;
      for (int i = 0; i < c.steps; ++i) {
        expectCleanStep(simulation, i);
        if (HasFatalFailure()) return;
        if (friction > 0) bound += boundOf(simulation, c);
        const double change = (momentOf(system, system.v).first - start).norm();
        ASSERT_LE(change, bound + 1e-13 * size) << "step " << i;
        largest = std::max(largest, change / size);
      }
      RecordProperty(fmt::format("{}_{}", integrator.substr(1, 12), friction), fmt::format("{:.3g}, bound {:.3g}", largest, bound / size));
      EXPECT_EQ(largest > 1e-9, friction > 0) << "friction has some";
      EXPECT_GT(system.v[0].norm(), 0.1) << "the first was pushed";
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
