// SPDX-License-Identifier: LGPL-2.1-or-later
// Each threshold of Newton's method ends it at the iteration where its sentence in the manual says, told by Newton's
// method on the one unknown that the scene has, written out beside it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/ground_spring.h"
#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

constexpr double stiffness = 20, cubic = 400, mass = 0.5, gravity = 10;

/// What is compared with thresholds after an iteration.
struct Iterate {
  double residual, correction, displacement;  ///< of one node: [N], [m], [m]
};

/// Newton's method for (inertia + k) d + c d^3 = m g from d = 0; the first entry is the start.
std::vector<Iterate> iterates(double inertia) {
  const auto residual = [&](double d) { return mass * gravity - (inertia + stiffness + cubic * d * d) * d; };
  std::vector<Iterate> all{{residual(0), 0, 0}};
  double d = 0;
  for (int n = 0; n < 6; ++n) {
    const double correction = residual(d) / (inertia + stiffness + 3 * cubic * d * d);
    d += correction;
    all.push_back({residual(d), std::abs(correction), d});
  }
  return all;
}

/// Iterations of the first step of two nodes that move alike, with this one threshold.
int iterations(const std::string& integrator, double dt, const char* threshold, double value) {
  registerGroundSpring(factory());
  const char* const all[] = {"relativeInitialStoppingThreshold", "absoluteResidualStoppingThreshold",
                             "relativeSuccessiveStoppingThreshold", "relativeEstimateDifferenceThreshold",
                             "absoluteEstimateDifferenceThreshold"};
  std::string attributes;
  for (const std::string name : all) attributes += fmt::format("{}='{}' ", name, name == threshold ? value : 0.0);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 -{} 0">
           <{} newtonSolver="@newton"/> <SparseLDLSolver/>
           <NewtonRaphsonSolver name="newton" maxNbIterationsNewton="6" maxNbIterationsLineSearch="0" {}/>
           <MechanicalObject rest_position="0 0 0  1 0 0"/>
           <UniformMass vertexMass="{}"/>
           <TestGroundSpring stiffness="{}" cubic="{}"/>
         </Node>)",
      dt, gravity, integrator, attributes, mass, stiffness, cubic));
  return simulation.step().newton_iterations;
}

class NewtonThresholds : public testing::TestWithParam<bool> {
 protected:
  /// The threshold counts from iteration `n` on just above `value`, and not yet just below it.
  void expectToEndAt(int n, const char* threshold, double value) {
    const double dt = GetParam() ? 0.2 : 1;
    const std::string integrator = GetParam() ? "EulerImplicitSolver" : "StaticSolver";
    EXPECT_EQ(iterations(integrator, dt, threshold, 1.01 * value), n) << integrator << ' ' << threshold;
    EXPECT_EQ(iterations(integrator, dt, threshold, 0.99 * value), n + 1) << integrator << ' ' << threshold;
  }
  /// Of a step of 0.2 s its unknown is the velocity, and its residual an impulse.
  double impulse() const { return GetParam() ? 0.2 : 1; }
  std::vector<Iterate> expected() const { return iterates(GetParam() ? mass / (0.2 * 0.2) : 0); }
};

}  // namespace

TEST_P(NewtonThresholds, OfCorrections) {
  const std::vector<Iterate> all = expected();
  for (int n = 2; n < 5; ++n) {
    const Iterate& now = all[std::size_t(n)];
    expectToEndAt(n, "relativeEstimateDifferenceThreshold", now.correction / now.displacement);
    expectToEndAt(n, "absoluteEstimateDifferenceThreshold", std::sqrt(2) * now.correction);
  }
}

TEST_P(NewtonThresholds, OfResiduals) {
  const std::vector<Iterate> all = expected();
  for (int n = 2; n < 5; ++n) {
    const double now = std::abs(all[std::size_t(n)].residual), before = std::abs(all[std::size_t(n - 1)].residual);
    expectToEndAt(n, "relativeInitialStoppingThreshold", now / all[0].residual);
    expectToEndAt(n, "absoluteResidualStoppingThreshold", impulse() * std::sqrt(2) * now);
    expectToEndAt(n, "relativeSuccessiveStoppingThreshold", now / before);
  }
}

INSTANTIATE_TEST_SUITE_P(OfBoth, NewtonThresholds, testing::Bool(),
                         [](const auto& info) { return info.param ? "EulerImplicitSolver" : "StaticSolver"; });
