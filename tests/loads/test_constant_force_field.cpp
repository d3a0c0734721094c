// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::vector<Vec3> forcesOf(const std::string& attributes) {
  Simulation simulation(sceneFromText(fourNodes("<ConstantForceField " + attributes + "/>")));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  // the force is minus the gradient of the energy, which is linear: any difference serves
  for (Index i = 0; i < 4; ++i)
    for (int c = 0; c < 3; ++c) {
      const double before = system.potentialEnergy(system.x);
      system.x[i][c] += 0.5;
      EXPECT_NEAR((system.potentialEnergy(system.x) - before) / -0.5, system.f[i][c], 1e-13);
      system.x[i][c] -= 0.5;
    }
  std::vector<Vec3> forces;
  for (Index i = 0; i < 4; ++i) forces.push_back(system.f[i]);
  return forces;
}

TEST(ConstantForceField, LoadsNodes) {
  const Vec3 f(0, -2, 1), zero = Vec3::Zero();
  EXPECT_EQ(forcesOf("indices='1 3' forces='0 -2 1 0 -4 2'"), (std::vector<Vec3>{zero, f, zero, 2 * f}));
  EXPECT_EQ(forcesOf("indices='1 3' forces='0 -2 1'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='1 3' force='0 -2 1'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='1 3' totalForce='0 -4 2'"), (std::vector<Vec3>{zero, f, zero, f}));
  EXPECT_EQ(forcesOf("indices='2 2' totalForce='0 -2 1'"), (std::vector<Vec3>{zero, zero, f, zero}));
  EXPECT_EQ(forcesOf("indices='0' indexFromEnd='true' totalForce='0 -2 1'"), (std::vector<Vec3>{zero, zero, zero, f}));
  EXPECT_EQ(forcesOf("totalForce='0 -8 4'"), (std::vector<Vec3>{f, f, f, f}));
}

TEST(ConstantForceField, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(fourNodes("<ConstantForceField " + attributes + "/>"));
  };
  expectContains(problems("indices='0'"), "there is no force");
  expectContains(problems("indices='0' totalForce='1 0 0' forces='1 0 0'"), "more than one");
  expectContains(problems("indices='0 1' forces='1 0 0 2 0 0 3 0 0'"), "3 values for 2 nodes");
  expectContains(problems("indices='9' totalForce='1 0 0'"), "indices in 0 ... 3");
  expectContains(problems("indices='' totalForce='1 0 0'"), "lists no node");
  expectContains(sceneFromText(fourNodes("<ConstantForceField totalForce='1 0 0'/>")).diagnostics.text(),
                 "all 4 nodes");
}

/// Rows of a frame are two: the force on its centre and the torque.
TEST(LinearForceField, LoadsTheFramesThatAreNamed) {
  Simulation simulation(sceneFromText(
      "<Node name='root' dt='1' gravity='0 0 0'><EulerExplicitSolver/><MechanicalObject template='Rigid3' position='0 0 0 0 0 0 1 "
      "1 0 0 0 0 0 1  2 0 0 0 0 0 1  3 0 0 0 0 0 1'/><UniformMass totalMass='4' inertia='1 1 1'/>"
      "<LinearForceField points='2 1' times='0 1' forces='1 2 3 4 5 6  0 0 0 0 0 0'/></Node>"));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  const Vec3 force(1, 2, 3), torque(4, 5, 6);
  for (const Index frame : {0, 1, 2, 3}) {
    const bool is_named = frame == 1 || frame == 2;
    EXPECT_EQ(Vec3(system.f[2 * frame]), is_named ? force : Vec3(Vec3::Zero())) << frame;
    EXPECT_EQ(Vec3(system.f[2 * frame + 1]), is_named ? torque : Vec3(Vec3::Zero())) << frame;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
