// SPDX-License-Identifier: LGPL-2.1-or-later
// Rolling: a cylinder and a ball on a slope, and a cylinder without friction that swings in a ring.
#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Skin {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;

  std::string mesh() const {
    std::string text = "<MeshTopology name=\"mesh\" position=\"";
    for (const Vec3& p : points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
    text += "\" triangles=\"";
    for (const auto& t : triangles) text += fmt::format("{} {} {}  ", t[0], t[1], t[2]);
    return text + "\"/>";
  }
};

/// A prism of n sides about the y axis; its corners are on the cylinder. `inner`: a ring's inner side, without ends.
Skin prism(double radius, double width, int n, bool inner = false) {
  Skin skin;
  for (int k = 0; k < n; ++k)
    for (const double y : {-0.5 * width, 0.5 * width})
      skin.points.emplace_back(radius * std::cos(2 * M_PI * k / n), y, radius * std::sin(2 * M_PI * k / n));
  for (int k = 0; k < n; ++k) {
    const int a = 2 * k, b = 2 * ((k + 1) % n);
    skin.triangles.push_back({a, a + 1, b}), skin.triangles.push_back({a + 1, b + 1, b});
    if (!inner) skin.triangles.push_back({2 * n, a, b}), skin.triangles.push_back({2 * n + 1, b + 1, a + 1});
  }
  if (!inner) skin.points.emplace_back(0, -0.5 * width, 0), skin.points.emplace_back(0, 0.5 * width, 0);
  if (inner)
    for (auto& t : skin.triangles) std::swap(t[1], t[2]);
  return skin;
}

/// An icosahedron whose triangles are cut into four `levels` times, on the sphere.
Skin ball(double radius, int levels) {
  const double g = 0.5 * (1 + std::sqrt(5.0));
  Skin skin{{{-1, g, 0},
             {1, g, 0},
             {-1, -g, 0},
             {1, -g, 0},
             {0, -1, g},
             {0, 1, g},
             {0, -1, -g},
             {0, 1, -g},
             {g, 0, -1},
             {g, 0, 1},
             {-g, 0, -1},
             {-g, 0, 1}},
            {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
             {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::array<int, 2>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, int(skin.points.size()));
      if (is_new) skin.points.push_back(skin.points[std::size_t(a)].normalized() + skin.points[std::size_t(b)].normalized());
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : skin.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    skin.triangles = finer;
  }
  for (Vec3& p : skin.points) p = radius * p.normalized();
  return skin;
}

/// The way in a second of what rolls from rest along x, over g sin q/2.
double rollingOf(const Skin& skin, double radius, const Vec3& inertia, double mu) {
  constexpr double dt = 0.005, mass = 10, g = 9.81;
  const double q = M_PI / 6, range = 0.01 * radius;
  Simulation simulation = simulationFromText(contactScene(
      fmt::format(
          "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\"/><UniformMass "
          "totalMass=\"{}\" inertia=\"{} {} {}\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node>"
          "</Node><BarrierContact mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" stiffness=\"{}\" "
          "friction=\"{}\" frictionIterations=\"30\" selfContact=\"0\"/>",
          radius + 0.7 * range, mass, mass * inertia.x(), mass * inertia.y(), mass * inertia.z(), skin.mesh(), range, 2e5, mu),
      dt, g * Vec3(std::sin(q), 0, -std::cos(q)), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-8\"/>"));
  const int n = int(std::lround(1 / dt));
  for (int i = 0; i < n; ++i) {
    expectCleanStep(simulation, i, false);
    if (::testing::Test::HasFatalFailure()) break;
  }
  return simulation.states()[0]->x()[0].x() / (0.5 * g * std::sin(q) * n * (n + 1) * dt * dt);
}

/// 30 degrees: a cylinder rolls with 2/3 g sin q where mu is 1/3 tan q = 0.19 or more, and slides with g (sin q - mu cos q) where it is
/// less; a ball with 5/7 g sin q where mu is 2/7 tan q = 0.165 or more.
TEST(Rolling, ACylinderAndABallRollDownASlope) {
  const Skin cylinder = prism(1, 1, 128), sphere = ball(1, 4);
  const Vec3 of_cylinder(0.25 + 1. / 12, 0.5, 0.25 + 1. / 12);
  const double rolls = rollingOf(cylinder, 1, of_cylinder, 0.5), slides = rollingOf(cylinder, 1, of_cylinder, 0.1);
  const double ball_rolls = rollingOf(sphere, 1, Vec3::Constant(0.4), 0.5);
  RecordProperty("cylinder", std::to_string(rolls));
  RecordProperty("cylinder that slides", std::to_string(slides));
  RecordProperty("ball", std::to_string(ball_rolls));
  EXPECT_NEAR(rolls, 2. / 3, 0.01 * 2 / 3);
  EXPECT_NEAR(slides, 1 - 0.1 / std::tan(M_PI / 6), 0.015) << "it bounces a little";
  EXPECT_NEAR(ball_rolls, 5. / 7, 0.01 * 5 / 7);
}

/// A cylinder of 0.4 and 4 pi kg beside the middle of a ring of 1.8, without friction; its centre swings on a circle of 0.7 m.
std::string ringScene(const Skin& cylinder, const Skin& ring, double dt, const std::string& integrator) {
  constexpr double g = 9.81, orbit = 0.7, mass = 4 * M_PI, range = 2e-3;
  return contactScene(
      fmt::format(
          "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} 0 0  0 0 0 1\"/><UniformMass "
          "totalMass=\"{}\" inertia=\"0.2 0.25 0.2\"/><PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"0 1 0 1 0 "
          "1\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node><Node name=\"ring\">{}</Node>"
          "<BarrierContact mstate=\"@tool/skin/dofs\" meshes=\"@ring/mesh\" contactDistance=\"{}\" stiffness=\"1e7\" "
          "selfContact=\"0\"/>",
          orbit - range, mass, cylinder.mesh(), ring.mesh(), range),
      dt, Vec3(0, 0, -g), integrator);
}

/// Without friction, let go beside the middle of a ring (inner diameter 1.8, cylinder 0.4 and 4 pi kg): the centre swings on a circle of
/// 0.7 m like a pendulum, with a period of 4 K(1/2) (R/g)^(1/2) = 1.98108 s and 3.706 m/s at the bottom; the energy stays.
TEST(Rolling, ACylinderSwingsInARing) {
  constexpr double dt = 0.001, g = 9.81, orbit = 0.7;
  const std::string rule = "<EulerImplicitSolver trapezoidalScheme=\"true\" newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>";
  Simulation simulation = simulationFromText(ringScene(prism(0.2, 0.2, 96), prism(0.9, 0.6, 384, true), dt, rule));
  const State& frame = *simulation.states()[0];
  double fastest = 0, back = 0;
  for (int i = 1; i <= 2000; ++i) {
    const double rising = frame.v()[0].z();
    expectCleanStep(simulation, i, false);
    if (HasFatalFailure()) return;
    fastest = std::max(fastest, Vec3(frame.v()[0]).norm());
    // it comes to rest on the other side and starts back: half of a period
    if (back == 0 && i > 500 && rising >= 0 && frame.v()[0].z() < 0) back = i * dt;
  }
  RecordProperty("fastest", std::to_string(fastest));
  RecordProperty("half a period", std::to_string(back));
  EXPECT_NEAR(fastest, std::sqrt(2 * g * orbit), 0.005 * std::sqrt(2 * g * orbit)) << "the energy is its square";
  EXPECT_NEAR(back, 1.98108 / 2, 0.01);
}

/// Steps that are longer than the contact swings: 6 ms. The cylinder bounces over the facets, and has no more energy than at the start, by
/// rules that damp nothing too. Of their force's mean at both ends of a step alone it had up to 1.8 times as much.
TEST(Rolling, EnergyStaysInARing) {
  constexpr double g = 9.81, orbit = 0.7, drop = 4 * M_PI * g * orbit, most = 2e-3;
  for (const std::string name : {"TrapezoidalRuleSolver", "NewmarkImplicitSolver"})
    for (const double dt : {0.002, 0.004}) {
      SCOPED_TRACE(fmt::format("{}, {} s", name, dt));
      const std::string rule = fmt::format("<{} newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>", name);
      Simulation simulation = simulationFromText(ringScene(prism(0.2, 0.3, 72), prism(0.9, 0.5, 289, true), dt, rule));
      const System& system = *simulation.systems()[0];
      const auto energy = [&] { return system.kineticEnergy() + system.potentialEnergy(system.x); };
      const double start = energy();
      double high = start, fastest = 0;
      for (int i = 1; i * dt <= 2.2; ++i) {
        expectCleanStep(simulation, i, false);
        if (HasFatalFailure()) return;
        high = std::max(high, energy()), fastest = std::max(fastest, Vec3(system.v[0]).norm());
      }
      EXPECT_LT(high - start, most * drop);
      EXPECT_GT(energy() - start, -most * drop);
      EXPECT_NEAR(fastest, std::sqrt(2 * g * orbit), 0.005 * std::sqrt(2 * g * orbit));
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
