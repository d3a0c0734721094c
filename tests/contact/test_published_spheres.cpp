// SPDX-License-Identifier: LGPL-2.1-or-later
// Two hollow spheres, one in the other, are pressed flat between two plates (Puso and Laursen 2004).
#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

// mm, N and MPa

constexpr double plate_range = 0.05;

struct Spheres {
  int inner, outer, layers;  ///< cells along an eighth of a great circle, and over each wall
  double range, mu;
};

/// An eighth of a hollow sphere, held by its planes of symmetry.
std::string sphereOf(const std::string& name, double inner, double outer, int n, int layers) {
  const HexahedralMesh mesh = eighthOfSphere(inner, outer, n, layers);
  std::string held;
  for (int axis = 0; axis < 3; ++axis)
    held += fmt::format("<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"{} {} {}\"/>",
                        mesh.where([axis](const Vec3& p) { return std::abs(p[axis]) < 1e-9; }), int(axis == 0), int(axis == 1),
                        int(axis == 2));
  return neoHookeanNode(name, mesh, 1, 0.3, held);
}

/// The force of the plate after 2.5, 5, 6 and 7.5 mm, as far as it comes. Steps are a quarter of a millimetre.
std::array<double, 4> forcesOf(const Spheres& size) {
  constexpr int steps = 30;
  Simulation simulation = simulationFromText(contactScene(
      sphereOf("outer", 12 + 0.5 * size.range, 14, size.outer, size.layers) +
          sphereOf("inner", 10, 12 - 0.5 * size.range, size.inner, size.layers) +
          fmt::format("<BarrierContact name=\"between\" mstate=\"@outer/dofs\" topology=\"@outer/mesh\" other=\"@inner/dofs\" "
                      "contactDistance=\"{}\" friction=\"{}\" slipVelocity=\"1e-3\" frictionIterations=\"8\" selfContact=\"0\"/>",
                      size.range, size.mu) +
          fmt::format("<BarrierContact name=\"plate\" mstate=\"@outer/dofs\" topology=\"@outer/mesh\" planes=\"0 0 -1 {}\" "
                      "contactDistance=\"{}\" stiffness=\"1\" selfContact=\"0\" keyTimes=\"0 {}\" "
                      "movements=\"0 0 0  0 0 {}\"/>",
                      -14 - plate_range, plate_range, steps, -0.25 * steps) +
          fmt::format("<BarrierContact name=\"ground\" mstate=\"@inner/dofs\" topology=\"@inner/mesh\" planes=\"0 0 1 {}\" "
                      "contactDistance=\"{}\" stiffness=\"1\" selfContact=\"0\"/>",
                      -plate_range, plate_range),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"3e-4\"/>"));
  std::array<double, 4> forces{};
  const std::array<double, 4> ways{2.5, 5, 6, 7.5};
  for (int step = 1; step <= steps; ++step) {
    expectCleanStep(simulation, step);
    if (::testing::Test::HasFatalFailure()) break;
    for (std::size_t i = 0; i < ways.size(); ++i)
      if (0.25 * step == ways[i]) forces[i] = -wrenchesOf(simulation, "plate")[2];
  }
  return forces;
}

/// The walls buckle between 5.5 and 6 mm. What programs have published differs by 9 to 15 % of itself: no margin is added. Walls are
/// thinner by half of the range in which contact acts, and come nearer by what is left of it: with a range of 0.05 and plates of 0.2 mm
/// the last force is 2 % lower.
TEST(PublishedBenchmarks, HollowSpheresBetweenPlates) {
  const auto forces = forcesOf({8, 8, 2, 0.025, 0});
  RecordProperty("force at 2.5, 5, 6 and 7.5 mm [N]",
                 fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}", forces[0], forces[1], forces[2], forces[3]));
  // Abaqus and FEBio (Zimmerman and Ateshian 2018), Areias and others 2015, Puso and Laursen 2004
  expectWithin(forces[0], 0.888, 1.025, "2.5 mm");
  expectWithin(forces[1], 2.241, 2.441, "5 mm");
  expectWithin(forces[2], 2.506, 2.794, "6 mm");
  expectWithin(forces[3], 3.418, 3.789, "7.5 mm");
}

/// Walls fold past 7 mm, where edges slide over each other: each of these steps has an equilibrium that is found.
TEST(PublishedBenchmarks, HollowSpheresWithFriction) {
  const auto forces = forcesOf({8, 8, 2, 0.025, 0.5});
  RecordProperty("force at 2.5, 5, 6 and 7.5 mm [N]",
                 fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}", forces[0], forces[1], forces[2], forces[3]));
  // Abaqus and FEBio (Zimmerman and Ateshian 2018), Areias and others 2015
  expectWithin(forces[0], 0.932, 1.045, "2.5 mm");
  expectWithin(forces[1], 2.343, 2.586, "5 mm");
  expectWithin(forces[2], 3.002, 3.201, "6 mm");
  expectWithin(forces[3], 3.772, 3.921, "7.5 mm");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
