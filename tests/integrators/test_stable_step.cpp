// SPDX-License-Identifier: LGPL-2.1-or-later
// The warning of explicit methods above their stable step: the number against a closed form, and the element by name.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

std::string warningOf(const std::string& scene) {
  ::testing::internal::CaptureStderr();
  const Simulation simulation = simulationFromText(scene);
  return ::testing::internal::GetCapturedStderr();
}

TEST(StableStep, NamesTheStiffElement) {
  for (const int stiff : {0, 13, 22}) {
    std::string moduli;
    for (int cell = 0; cell < 27; ++cell) moduli += cell == stiff ? "1e7 " : "1e3 ";
    const std::string warning = warningOf(fmt::format(
        R"(<Node name="root" dt="1" gravity="0 0 0"><EulerExplicitSolver name="explicit"/>
             <RegularGridTopology n="4 4 4" min="0 0 0" max="3 3 3"/><MechanicalObject/><UniformMass totalMass="64"/>
             <HexahedronFEMForceField name="fem" youngModulus="{}" poissonRatio="0.3" method="polar"/></Node>)",
        moduli));
    EXPECT_NE(warning.find("estimated stable step"), std::string::npos) << warning;
    EXPECT_NE(warning.find(fmt::format("strongest in element {} of /fem", stiff)), std::string::npos) << warning;
  }
}

/// A mass on a spring: w = sqrt(k/m) = 20 rad/s, so that symplectic Euler is stable up to 2/w = 0.1 s.
TEST(StableStep, OfAnOscillatorIsItsClosedForm) {
  const auto scene = [](double dt) {
    return fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerExplicitSolver/>
             <MechanicalObject position="0 0 0 1 0 0"/><UniformMass vertexMass="2"/>
             <SpringForceField springsIndices1="0" springsIndices2="1" stiffness="800" lengths="1" damping="0"/>
             <FixedProjectiveConstraint indices="0"/></Node>)",
        dt);
  };
  EXPECT_EQ(warningOf(scene(0.0999)).find("stable step"), std::string::npos);
  EXPECT_NE(warningOf(scene(0.1001)).find("stable step of symplectic Euler, 0.1 s"), std::string::npos);
}

}  // namespace
}  // namespace stroma::test
