// SPDX-License-Identifier: LGPL-2.1-or-later
// An arch of blocks that nothing but friction and thrust holds. A semicircular one stands where it is thicker than 0.1075 of its
// radius (Milankovitch 1907), thinner ones fall by hinges at the rims of blocks.
#include <Eigen/Geometry>
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr int blocks = 25;
constexpr double depth = 0.3, range = 2e-3;  // across the arch, contact distance [m]

/// A block of the arch of radius 1 m, seen from its middle; faces of neighbours are `gap` apart.
Body blockAt(int number, double thickness, double gap, Vec3& middle) {
  const double from = M_PI * number / blocks, to = M_PI * (number + 1) / blocks;
  Body block = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1));
  const auto out = [](double angle) { return Vec3(-std::cos(angle), 0, std::sin(angle)); };
  const auto along = [](double angle) { return Vec3(std::sin(angle), 0, std::cos(angle)); };
  middle = out(0.5 * (from + to));
  for (Vec3& p : block.points) {
    const double angle = p.x() < 0.5 ? from : to;
    p = (1 + (p.z() - 0.5) * thickness) * out(angle) + (p.x() < 0.5 ? 0.5 : -0.5) * gap * along(angle) +
        Vec3(0, (p.y() - 0.5) * depth, 0) - middle;
  }
  return block;
}

struct Arch {
  double thickness = 0.15, friction = 0.6;
  bool by_constraint = false;  ///< all blocks are free, on a plane; else the first and the last are held
  int steps = 60;
};

std::string sceneOf(const Arch& arch) {
  const double length = M_PI / blocks, mass = 1000 * arch.thickness * length * depth;
  const double inertia = mass / 12 * (arch.thickness * arch.thickness + depth * depth);
  const double gap = (arch.by_constraint ? 1.0005 : 0.98) * range;
  std::string content, others;
  for (int b = 0; b < blocks; ++b) {
    Vec3 middle;
    const Body block = blockAt(b, arch.thickness, gap, middle);
    const bool held = !arch.by_constraint && (b == 0 || b == blocks - 1);
    if (arch.by_constraint) middle.z() += gap / 2;
    content += fmt::format(
        "<Node name=\"b{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} {} {}  0 0 0 1\"/><UniformMass "
        "totalMass=\"{}\" inertia=\"{} {} {}\"/>{}<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node>"
        "</Node>",
        b, middle.x(), middle.y(), middle.z(), mass, inertia, inertia, inertia,
        held ? "<FixedProjectiveConstraint indices=\"0\"/>" : "", block.mesh());
    if (b > 0) others += fmt::format("@b{}/skin/dofs ", b);
  }
  content += fmt::format("<{} mstate=\"@b0/skin/dofs\" other=\"{}\" contactDistance=\"{}\" friction=\"{}\" selfContact=\"0\" {}/>",
                         arch.by_constraint ? "ConstraintContact" : "BarrierContact", others, range, arch.friction,
                         arch.by_constraint ? "planes=\"0 0 1 0\"" : "stiffness=\"5e6\" slipVelocity=\"1e-3\"");
  return contactScene(content, 0.01, Vec3(0, 0, -9.81), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-6\"/>");
}

struct Fall {
  double way = 0, speed = 0;  ///< of the keystone [m], [m/s]
  double fastest = 0;         ///< its largest speed once the gaps of the start have closed [m/s]
};

/// How far the keystone has come down, and how fast it is. The run ends early where both exceed `enough`.
Fall fallOf(const Arch& arch, const Fall& enough = {1e9, 1e9, 0}) {
  Simulation simulation = simulationFromText(sceneOf(arch));
  const State* keystone = nullptr;
  for (const State* state : simulation.states())
    if (state->path() == fmt::format("/b{}/frame", blocks / 2)) keystone = state;
  const double start = keystone->x()[0].z();
  Fall fall;
  for (int step = 0; step < arch.steps && !(fall.way > enough.way && fall.speed > enough.speed); ++step) {
    expectCleanStep(simulation, step, false);
    if (::testing::Test::HasFatalFailure()) break;
    const double speed = keystone->v()[0].norm();
    fall = {start - keystone->x()[0].z(), speed, step < 5 ? 0 : std::max(fall.fastest, speed)};
  }
  return fall;
}

TEST(Arch, StandsWhereItIsThickEnough) {
  const Fall thick = fallOf({});
  RecordProperty("the keystone of the thick arch [m], [m/s]", fmt::format("{} {}", thick.way, thick.speed));
  EXPECT_LT(thick.way, 5 * range) << "only the joints yield";
  EXPECT_LT(thick.speed, 0.01);
  const Fall far{20 * range, 0.1, 0};
  const Fall thin = fallOf({.thickness = 0.08}, far);
  RecordProperty("the keystone of the thin arch [m], [m/s]", fmt::format("{} {}", thin.way, thin.speed));
  EXPECT_GT(thin.way, far.way);
  EXPECT_GT(thin.speed, far.speed);
}

/// 25 blocks on a plane by forces of constraint. Joints can only open between blocks: the thinnest arch of which forces at the rims
/// of joints are in balance is 0.1070 radii thick, and the least friction of one of 0.15 radii is 0.3501, by linear programming.
TEST(Arch, StandsByForcesOfConstraint) {
  for (const Arch& stands : {Arch{0.112, 0.6, true, 30}, Arch{0.15, 0.37, true, 30}}) {  // four times as long as those that fall
    const Fall fall = fallOf(stands);
    EXPECT_LT(fall.way, 0.02 * range) << stands.thickness << ", the gaps that it starts with close";
    // Newton's tolerance allows some 1e-5, which grows until a step needs another iteration
    EXPECT_LT(fall.fastest, 1e-4) << stands.thickness << ", an arch that falls is a hundred times as fast";
  }
  for (const Arch& falls : {Arch{0.102, 0.6, true, 15}, Arch{0.15, 0.33, true, 15}}) {
    const Fall far{0.25 * range, 0.01, 0};
    const Fall fall = fallOf(falls, far);
    EXPECT_GT(fall.way, far.way) << falls.thickness;
    EXPECT_GT(fall.speed, far.speed) << falls.thickness;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
