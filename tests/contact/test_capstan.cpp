// SPDX-License-Identifier: LGPL-2.1-or-later
// A belt around a drum: what holds one end may be smaller than what pulls the other by exp(mu theta), the equation of the capstan.
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double drum = 0.05, width = 5e-3, thickness = 5e-4, range = 1e-3, young = 1e8, hold = 1;  // SI units
constexpr int straight = 4;

/// A belt that comes up on the left, goes over half of the drum in `turns` cells, and down on the right.
struct Belt {
  std::string nodes, cells, left, right;
  explicit Belt(int turns) {
    const double inner = drum + 0.97 * range;
    const int stations = turns + 2 * straight + 1;
    for (int i = 0; i < stations; ++i) {
      const int on_drum = std::clamp(i - straight, 0, turns), off = i < straight ? straight - i : std::max(0, i - straight - turns);
      const double angle = M_PI * on_drum / turns;
      for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j) {
          const double r = inner + k * thickness;
          nodes += fmt::format("{} {} {}  ", -r * std::cos(angle), (j - 0.5) * width, r * std::sin(angle) - 0.01 * off);
          const std::string node = fmt::format("{} ", 4 * i + 2 * k + j);
          if (i == 0) left += node;
          if (i == stations - 1) right += node;
        }
      if (i + 1 < stations) {
        const int a = 4 * i, b = 4 * (i + 1);
        cells += fmt::format("{} {} {} {} {} {} {} {}  ", a, b, b + 1, a + 1, a + 2, b + 2, b + 3, a + 3);
      }
    }
  }
};

/// The right end is pulled down by `way`. Returns the force there over the one on the left end.
double ratioOf(double mu, double way) {
  constexpr int turns = 60, steps = 4;
  const Belt belt(turns);
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" hexahedra=\"{}\"/><MechanicalObject name=\"dofs\"/>"
                  "<UniformMass totalMass=\"1\"/><HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"0\" "
                  "method=\"svd\"/><PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                  "<ConstantForceField indices=\"{}\" totalForce=\"0 0 {}\"/>"
                  "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 {}\" outside=\"hold\" "
                  "movements=\"0 0 0  0 0 {}\"/>"
                  "<BarrierContact contactDistance=\"{}\" stiffness=\"1e6\" selfContact=\"0\" capsules=\"0 -0.1 0 0 0.1 0 {}\" "
                  "friction=\"{}\" slipVelocity=\"1e-7\" frictionIterations=\"50\"/>",
                  belt.nodes, belt.cells, young, belt.left, -hold, belt.right, steps, -way, range, drum, mu),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-7\"/>"));
  for (int step = 0; step < steps; ++step) {
    expectCleanStep(simulation, step);
    if (::testing::Test::HasFatalFailure()) return 0;
  }
  // the ends hang down: the drum bears the sum of both forces
  return numbersOf(simulation, "wrenches")[2] / hold - 1;
}

/// Nodes lie on the drum as corners of a polygon of n sides, each on a wedge: the forces before and behind one have the ratio
/// (1 + mu t)/(1 - mu t), t = tan(pi/2n). For many sides that is exp(mu pi); with 60 it is nearer to it than 1e-3. The belt
/// stretches before all of it slides. It is hardly drawn on then: what it takes to bend it at the ends of the drum grows with that.
TEST(Capstan, ForcesOfABeltHaveTheRatioOfTheDrum) {
  for (const auto& [mu, way] : {std::pair(0.1, 1e-3), std::pair(0.3, 1.8e-3)}) {
    const double ratio = ratioOf(mu, way);
    RecordProperty(fmt::format("ratio with mu {}", mu), std::to_string(ratio));
    EXPECT_NEAR(std::log(ratio), mu * M_PI, 0.01 * mu * M_PI) << "mu " << mu;
  }
  EXPECT_LT(ratioOf(0.3, 5e-4), 0.8 * std::exp(0.3 * M_PI)) << "a part of the belt sticks";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
