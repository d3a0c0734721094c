// SPDX-License-Identifier: LGPL-2.1-or-later
// Faces that lie flat on each other: the patch test of two blocks, and a stack of free cubes. Vertices of both faces are kept
// apart, so that there are more contacts than the faces have ways to move.
#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double young = 1e6, range = 1e-3, pressure = 1e4;

/// n x n cells across, which may only go up and down. The lower one is held at its bottom; the upper one's top goes down by 0.01.
std::string block(const std::string& name, int n, double bottom) {
  const std::vector<double> x = evenly(0, 1, n);
  const HexahedralMesh mesh = brickOf(x, x, evenly(bottom, bottom + 0.5, std::max(2, n / 2)));
  const double end = bottom == 0 ? 0 : bottom + 0.5;
  const std::string nodes = mesh.where([end](const Vec3& p) { return std::abs(p.z() - end) < 1e-9; });
  const std::string stays = "<FixedProjectiveConstraint indices=\"{}\"/>", held = bottom == 0 ? stays :
      "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 2\" movements=\"0 0 0  0 0 -0.02\"/>";
  return fmt::format(
      "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1e-6\"/>"
      "<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"0\" method=\"small\"/>"
      "<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"1 1 0\"/>{}</Node>",
      name, mesh.topology(), young, fmt::format(fmt::runtime(held), nodes));
}

struct Patch {
  double force;        ///< on the lower block, of what it should be
  double strain;       ///< the largest displacement that is off, of the shortening of a block
  double least, most;  ///< pressure of the contact forces on the nodes of the lower block, of what it should be
};

/// Two blocks of 1 x 1 x 0.5, nu = 0: 10 kPa everywhere.
Patch patchOf(const std::string& method, int low, int high) {
  // the barrier starts at the gap of its pressure, so that the strain is the same
  const double gap = (method == "ConstraintContact" ? 1 : 0.8285) * range;
  Simulation simulation = simulationFromText(contactScene(
      block("a", low, 0) + block("b", high, 0.5 + gap) + "<" + method +
          fmt::format(" name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"{}\" "
                      "selfContact=\"0\"/>",
                      range),
      1, Vec3::Zero(), "<StaticSolver/>"));
  expectCleanStep(simulation, 1);
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> wrench, forces;
  for (const Component* component : all)
    if (component->name() == "contact")
      for (const auto& [name, values] : {std::pair("wrenches", &wrench), std::pair("contactForces", &forces)}) {
        std::istringstream text(component->data().find(name)->print());
        for (double value = 0; text >> value;) values->push_back(value);
      }
  Patch patch{-wrench.at(2) / pressure, 0, 1e300, 0};
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(wrench.at(k), -wrench.at(6 + k), 1e-10 * pressure) << "equal and opposite";
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i) {
      const Vec3 rest = state->rest_position[std::size_t(i)];
      const double goes = rest.z() <= 0.5 ? -0.01 * rest.z() : -0.005 - 0.01 * (rest.z() - 0.5 - gap);
      patch.strain = std::max(patch.strain, std::abs(state->x()[i].z() - rest.z() - goes) / 0.005);
    }
  const State& lower = *simulation.states().front();
  const auto share = [low](double x) { return (x < 1e-9 || x > 1 - 1e-9 ? 0.5 : 1.0) / low; };
  for (Index i = 0; i < lower.size(); ++i) {
    const Vec3 rest = lower.rest_position[std::size_t(i)];
    if (rest.z() < 0.5 - 1e-9) continue;
    const double here = -forces.at(3 * std::size_t(i) + 2) / (share(rest.x()) * share(rest.y())) / pressure;
    patch.least = std::min(patch.least, here), patch.most = std::max(patch.most, here);
  }
  return patch;
}

/// Meshes that match pass it. Others do not: what the vertices of the other face push is not what a pressure would. What that is
/// off falls with the cells within the blocks, and stays as it is at the nodes.
TEST(FlatFaces, PatchOfTwoBlocks) {
  for (const std::string method : {"ConstraintContact", "BarrierContact"}) {
    SCOPED_TRACE(method);
    const bool is_exact = method == "ConstraintContact";
    const Patch same = patchOf(method, 3, 3), coarse = patchOf(method, 3, 2), fine = patchOf(method, 6, 4);
    const double rounding = is_exact ? 1e-9 : 1e-4;  // that of the gap below
    EXPECT_NEAR(same.force, 1, rounding);
    EXPECT_LT(same.strain, rounding);
    EXPECT_NEAR(same.least, 1, rounding);
    EXPECT_NEAR(same.most, 1, rounding);
    for (const Patch& other : {coarse, fine}) {
      EXPECT_NEAR(other.force, 1, 3e-3);
      EXPECT_GT(other.least, 0.93);
      EXPECT_LT(other.most, 1.16);
    }
    EXPECT_GT(coarse.strain, 1e-3) << "the meshes do not match";
    EXPECT_LT(coarse.strain, 0.12);
    EXPECT_LT(fine.strain, 0.6 * coarse.strain);
  }
}

/// Three free cubes stand on a plane and on each other, with friction and without damping. Each step holds, and what changes the
/// momentum of each cube is its weight and what pushes and rubs it.
TEST(FlatFaces, AStackOfFreeCubes) {
  constexpr double dt = 0.01, gap = 0.01, mass = 1000;
  std::string cubes;
  for (int i = 0; i < 3; ++i) {
    const double bottom = gap + i * (1 + gap), aside = 0.01 * i;
    const Body cube = boxOf(Vec3(aside, aside, bottom), Vec3(1 + aside, 1, 1 + bottom), {1, i == 1 ? 2 : 1, 1});
    cubes += bodyNode(fmt::format("c{}", i), cube, "", "", 1e6, 0.3);
  }
  Simulation simulation = simulationFromText(contactScene(
      cubes + fmt::format("<ConstraintContact mstate=\"@c0/dofs\" topology=\"@c0/mesh\" other=\"@c1/dofs @c2/dofs\" "
                          "contactDistance=\"{}\" friction=\"0.3\" planes=\"0 0 1 0\"/>",
                          gap),
      dt, Vec3(0, 0, -9.81), "<EulerImplicitSolver/>"));
  std::array<Vec3, 3> before;
  before.fill(Vec3::Zero());
  for (int step = 0; step < 20; ++step) {
    expectCleanStep(simulation, step);
    if (HasFatalFailure()) return;
    const std::vector<double> wrench = constraintOutput(simulation, "wrenches");
    ASSERT_EQ(wrench.size(), 18u);
    for (std::size_t body = 0; body < 3; ++body) {
      Vec3 now = Vec3::Zero();
      for (const Mass* m : simulation.systems().front()->masses())
        for (Index i = 0; i < m->state().size() && &m->state() == simulation.states()[body]; ++i)
          now += m->lumped()[std::size_t(i)] * Vec3(m->state().v()[i]);
      const double volume = body == 0 ? 1 : (1 - 0.01 * double(body));
      const Vec3 pushed(wrench[6 * body], wrench[6 * body + 1], wrench[6 * body + 2]), weight(0, 0, -9.81 * mass * volume);
      EXPECT_LT((now - before[body] - dt * (pushed + weight)).norm(), 1e-8 * mass) << "step " << step << ", cube " << body;
      before[body] = now;
    }
  }
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i)
      EXPECT_LT((Vec3(state->x()[i]) - state->rest_position[std::size_t(i)]).norm(), 0.1) << "they stand";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
