// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces between each two bodies of a contact, against the momentum that the bodies gain.
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::vector<Vec3> vectorsOf(const Simulation& simulation, const std::string& type, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<Vec3> values;
  for (const Component* component : all)
    if (component->type() == type) {
      std::istringstream text(component->data().find(name)->print());
      for (Vec3 v; text >> v[0] >> v[1] >> v[2];) values.push_back(v);
    }
  return values;
}

/// Mass times velocity of the body with this path, and its mass.
std::pair<Vec3, double> momentumOf(const Simulation& simulation, const std::string& path) {
  Vec3 sum = Vec3::Zero();
  double whole = 0;
  for (const auto& system : simulation.systems())
    for (const Mass* mass : system->masses()) {
      const State& state = mass->state();
      if (state.path() != path) continue;
      for (Index i = 0; i < state.size(); ++i) {
        sum += mass->lumped()[std::size_t(i)] * Vec3(state.v()[i]);
        whole += mass->lumped()[std::size_t(i)];
      }
    }
  return {sum, whole};
}

/// A block on a plane with another one on it, pushed along, away from the origin: what moves their centres besides gravity and the
/// push is contact alone, so each pair's force follows from momenta.
TEST(PairWrenches, AreWhatTheMomentaOfTheBodiesSay) {
  const double range = 0.02, dt = 0.01;
  const Vec3 gravity(0, 0, -9.81), push(30, 10, 0);
  for (const std::string type : {"BarrierContact", "PenaltyContact", "ConstraintContact"}) {
    SCOPED_TRACE(type);
    const bool keeps = type == "ConstraintContact";
    const double gap = keeps ? 1.001 * range : 0.7 * range;
    const Body low = boxOf(Vec3(2, 1, gap), Vec3(3, 2, 0.5 + gap), {2, 2, 1});
    const Body high = boxOf(Vec3(2.2, 1.2, 0.5 + 2 * gap), Vec3(2.8, 1.8, 0.8 + 2 * gap), {2, 2, 1});
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", low, "", "", 1e6, 0.3) +
            bodyNode("b", high, fmt::format("<ConstantForceField totalForce=\"{} {} {}\"/>", push[0], push[1], push[2]), "", 1e6, 0.3) +
            fmt::format("<{} mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" "
                        "friction=\"0.2\" selfContact=\"false\" {}/>",
                        type, range, keeps ? "" : "stiffness=\"1e5\""),
        dt, gravity));
    Vec3 before_a = Vec3::Zero(), before_b = before_a;
    double largest = 0;
    for (int step = 0; step < 8; ++step) {
      expectCleanStep(simulation, step, false);  // momenta tell how far off it is
      const auto [a, mass_a] = momentumOf(simulation, "/a/dofs");
      const auto [b, mass_b] = momentumOf(simulation, "/b/dofs");
      const Vec3 on_a = (a - before_a) / dt - mass_a * gravity, on_b = (b - before_b) / dt - mass_b * gravity - push;
      before_a = a, before_b = b;
      const std::vector<Vec3> pairs = vectorsOf(simulation, type, "pairWrenches"), bodies = vectorsOf(simulation, type, "wrenches");
      ASSERT_EQ(pairs.size(), 6u);  // a with b, a with obstacles, b with obstacles
      ASSERT_EQ(bodies.size(), 4u);
      const double tolerance = 1e-3 * mass_a * 9.81;  // friction is that of the solve before
      EXPECT_LT((pairs[0] + on_b).norm(), tolerance) << "step " << step;
      EXPECT_LT((pairs[0] + pairs[2] - on_a).norm(), tolerance) << "step " << step;
      EXPECT_EQ(pairs[4].norm(), 0) << "the upper one is far from the plane";
      // sums of pairs are those of the bodies, forces and moments
      EXPECT_LT((pairs[0] + pairs[2] - bodies[0]).norm(), 1e-9 * (1 + bodies[0].norm()));
      EXPECT_LT((pairs[1] + pairs[3] - bodies[1]).norm(), 1e-9 * (1 + bodies[1].norm()));
      EXPECT_LT((pairs[0] + bodies[2]).norm(), 1e-9 * (1 + bodies[2].norm()));
      largest = std::max(largest, pairs[0].norm());
    }
    EXPECT_GT(largest, 100) << "they have pushed each other";
  }
}

/// Names for readers, and none of obstacles where there are none.
TEST(PairWrenches, PairsHaveNames) {
  const Body box = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1));
  Body above = box, beyond = box;
  above.turn(Mat3::Identity(), Vec3(0, 0, 2)), beyond.turn(Mat3::Identity(), Vec3(3, 0, 0));
  for (const bool with_plane : {false, true}) {
    const Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", box, "") + bodyNode("b", above, "") + bodyNode("c", beyond, "") +
        fmt::format("<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs @c/dofs\" contactDistance=\"0.1\" {}/>",
                    with_plane ? "planes=\"0 0 1 -1\"" : "")));
    std::vector<Component*> all;
    simulation.root().collect(all);
    std::string names;
    for (const Component* component : all)
      if (component->type() == "BarrierContact") names = component->data().find("pairs")->print();
    EXPECT_EQ(names, with_plane ? "/a/dofs /b/dofs /a/dofs /c/dofs /a/dofs obstacles /b/dofs /c/dofs /b/dofs obstacles /c/dofs obstacles"
                                : "/a/dofs /b/dofs /a/dofs /c/dofs /b/dofs /c/dofs");
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
