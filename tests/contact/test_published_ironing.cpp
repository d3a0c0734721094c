// SPDX-License-Identifier: LGPL-2.1-or-later
// Shallow ironing (Fischer and Wriggers 2006): a block with a round lower side is pressed into a softer slab, in plane strain with
// friction. Six programs have published the forces on the block.
#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

// mm, N and MPa
constexpr double young = 689.6, nu = 0.32, mu = 0.3, radius = 0.75, half_width = 0.6, range = 0.02;
constexpr int down = 13;  ///< steps for 0.8 mm

/// Cells of the slab are `h` wide where the block goes; the block has `cells` across and `rows` up.
struct Ironing {
  double h;
  int cells, rows;
};

/// 12 wide and 4 high; its upper side is z = 0. It is wider than the block across the plane of the strain, so that no edges meet,
/// and softer by as much: the force on a layer of unit width is that of the block's own.
std::string slabOf(const Ironing& size) {
  constexpr double beyond = 0.125, width = 1 + 2 * beyond;
  std::vector<double> x = evenly(0, 8, int(std::lround(8 / size.h)));
  for (const double more : gradedUpTo(size.h, size.h, 1.3, 4))
    if (more > 0) x.push_back(8 + more);
  const HexahedralMesh mesh = brickOf(x, {-beyond, 1 + beyond}, downFrom(0, gradedUpTo(0.6 * size.h, 1, 1.25, 4)));
  const std::string bottom = mesh.where([](const Vec3& p) { return p.z() < -4 + 1e-9; });
  return neoHookeanNode("slab", mesh, young / width, nu,
                        fmt::format("<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                                    "<FixedProjectiveConstraint indices=\"{}\"/>",
                                    bottom));
}

/// 1.2 wide and 1.2 high, with an arc below that falls by 0.3. It starts where it nearly touches, after 0.2 of the 1 mm, and goes
/// down by what it rests above the slab more.
std::string blockOf(const Ironing& size) {
  constexpr double depth = 0.8 + 0.4 * range;
  HexahedralMesh mesh = brickOf(evenly(-half_width, half_width, size.cells), {0, 1}, evenly(0, 1, size.rows));
  const std::string top = mesh.where([](const Vec3& p) { return p.z() > 1 - 1e-9; });
  for (Vec3& p : mesh.points) {
    const double angle = std::asin(half_width / radius) * p.x() / half_width, t = p.z();
    p.x() = 0.8 + (1 - t) * radius * std::sin(angle) + t * p.x();
    p.z() = range + (1 - t) * radius * (1 - std::cos(angle)) + t * 1.2;
  }
  return neoHookeanNode("block", mesh, 10 * young, nu,
                        fmt::format("<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                                    "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 {}\" "
                                    "movements=\"0 0 0  0 0 {}\"/>",
                                    top, down, -depth));
}

struct Forces {
  double vertical, horizontal;  ///< [N/mm]
};

Forces forcesOf(const Ironing& size) {
  Simulation simulation = simulationFromText(contactScene(
      slabOf(size) + blockOf(size) +
          fmt::format("<BarrierContact name=\"contact\" mstate=\"@block/dofs\" topology=\"@block/mesh\" other=\"@slab/dofs\" "
                      "contactDistance=\"{}\" friction=\"{}\" slipVelocity=\"1e-3\" frictionIterations=\"20\" "
                      "selfContact=\"0\"/>",
                      range, mu),
      1, Vec3::Zero(),
      "<StaticSolver relative_residual_tolerance_threshold=\"1e-4\" absolute_residual_tolerance_threshold=\"1e-3\"/>"));
  for (int step = 1; step <= down; ++step) {
    expectCleanStep(simulation, step);
    if (::testing::Test::HasFatalFailure()) break;
  }
  const std::vector<double> wrench = wrenchesOf(simulation, "contact");
  return {wrench[2], -wrench[0]};
}

/// Pressed 1 mm deep near the end of the slab, which is free to give way to that side: friction takes the block along.
TEST(PublishedBenchmarks, ShallowIroningPressed) {
  const Forces forces = forcesOf({0.25, 12, 6});
  RecordProperty("vertical and horizontal force [N/mm]", fmt::format("{:.1f} {:.1f}", forces.vertical, forces.horizontal));
  // Poulios and Renard 2015 and solids4foam, to Code_Aster (SSNP153); Fischer and Wriggers 2006, Hartmann and others 2009 and
  // Yastrebov 2011 lie between
  expectWithin(forces.vertical, 267.9, 332, "vertical");
  expectWithin(forces.horizontal, 55, 71, "horizontal");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
