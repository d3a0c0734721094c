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
/// Cells are even up to x = `even`.
std::string slabOf(const Ironing& size, double even = 8) {
  constexpr double beyond = 0.125, width = 1 + 2 * beyond;
  std::vector<double> x = evenly(0, even, int(std::lround(even / size.h)));
  for (const double more : gradedUpTo(size.h, size.h, 1.3, 12 - even))
    if (more > 0) x.push_back(even + more);
  const HexahedralMesh mesh = brickOf(x, {-beyond, 1 + beyond}, downFrom(0, gradedUpTo(0.6 * size.h, 1, 1.25, 4)));
  const std::string bottom = mesh.where([](const Vec3& p) { return p.z() < -4 + 1e-9; });
  return neoHookeanNode("slab", mesh, young / width, nu,
                        fmt::format("<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                                    "<FixedProjectiveConstraint indices=\"{}\"/>",
                                    bottom));
}

/// 1.2 wide and 1.2 high, with an arc below that falls by 0.3. It starts `gap` above the slab, after 0.2 of the 1 mm, and its top
/// goes along `path`: down by what it rests above the slab more.
std::string blockOf(const Ironing& size, double gap, const std::string& path) {
  HexahedralMesh mesh = brickOf(evenly(-half_width, half_width, size.cells), {0, 1}, evenly(0, 1, size.rows));
  const std::string top = mesh.where([](const Vec3& p) { return p.z() > 1 - 1e-9; });
  for (Vec3& p : mesh.points) {
    const double angle = std::asin(half_width / radius) * p.x() / half_width, t = p.z();
    p.x() = 0.8 + (1 - t) * radius * std::sin(angle) + t * p.x();
    p.z() = gap + (1 - t) * radius * (1 - std::cos(angle)) + t * 1.2;
  }
  return neoHookeanNode("block", mesh, 10 * young, nu,
                        fmt::format("<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"0 1 0\"/>"
                                    "<LinearMovementProjectiveConstraint indices=\"{}\" {} outside=\"hold\"/>",
                                    top, path));
}

struct Forces {
  double vertical, horizontal;  ///< [N/mm]
};

Forces forcesOf(const Ironing& size) {
  const std::string path = fmt::format("keyTimes=\"0 {}\" movements=\"0 0 0  0 0 {}\"", down, -0.8 - 0.4 * range);
  Simulation simulation = simulationFromText(contactScene(
      slabOf(size) + blockOf(size, range, path) +
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

/// Pressed and drawn along for 10 mm, a cell per step: nodes pass each other by cells. Each step has an equilibrium that is found.
TEST(PublishedBenchmarks, ShallowIroningDrawn) {
  constexpr double h = 0.4, gap = 0.06, depth = 0.8 + 0.4 * gap;
  constexpr int pressing = 8, drawing = 25;
  const std::string along = fmt::format("keyTimes=\"0 {} {}\" movements=\"0 0 0  0 0 {}  10 0 {}\"", pressing, pressing + drawing,
                                        -depth, -depth);
  Simulation simulation = simulationFromText(contactScene(
      slabOf({h, 8, 4}, 12) + blockOf({h, 8, 4}, gap, along) +
          fmt::format("<BarrierContact name=\"contact\" mstate=\"@block/dofs\" topology=\"@block/mesh\" other=\"@slab/dofs\" "
                      "contactDistance=\"{}\" friction=\"{}\" slipVelocity=\"4e-2\" frictionIterations=\"8\" selfContact=\"0\"/>",
                      gap, mu),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-3\"/>"));
  std::vector<Forces> path{{0, 0}};
  for (int step = 1; step <= pressing + drawing; ++step) {
    expectCleanStep(simulation, step);
    if (HasFatalFailure()) return;
    const std::vector<double> wrench = wrenchesOf(simulation, "contact");
    path.push_back({wrench[2], -wrench[0]});
  }
  // after 4.8 and 5.2 mm
  const Forces pressed = path[pressing], before = path[pressing + 12], after = path[pressing + 13];
  const Forces middle{0.5 * (before.vertical + after.vertical), 0.5 * (before.horizontal + after.horizontal)};
  RecordProperty("pressed, and in the middle of the way [N/mm]",
                 fmt::format("{:.1f} {:.1f}  {:.1f} {:.1f}", pressed.vertical, pressed.horizontal, middle.vertical,
                             middle.horizontal));
  expectWithin(pressed.vertical, 267.9, 332, "vertical, pressed");
  expectWithin(pressed.horizontal, 55, 71, "horizontal, pressed");
  // Poulios and Renard 2015 to Code_Aster; Poulios and Renard to Fischer and Wriggers 2006
  expectWithin(middle.vertical, 337.4, 421, "vertical, in the middle");
  expectWithin(middle.horizontal, 102.1, 188.8, "horizontal, in the middle");
  // from 1 to 9 mm the block is away from the ends of the slab: it slides by about Coulomb's law along the whole way
  for (int step = pressing + 3; step <= pressing + 22; ++step) {
    SCOPED_TRACE(step);
    expectWithin(path[std::size_t(step)].vertical, 337.4, 430, "vertical");
    expectWithin(path[std::size_t(step)].horizontal / path[std::size_t(step)].vertical, 0.25, 0.4, "ratio");
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
