// SPDX-License-Identifier: LGPL-2.1-or-later
// Degenerate cases (Erleben 2018) and drops at random: nothing crosses, everything is a number.
#include <Eigen/Geometry>
#include <map>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

Vec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return {uniform(random), uniform(random), uniform(random)};
}
Mat3 randomRotation(std::mt19937& random) {
  return Eigen::Quaterniond(Eigen::Vector4d(randomPoint(random).x(), randomPoint(random).y(), randomPoint(random).z(),
                                            randomPoint(random).x())
                                .normalized())
      .toRotationMatrix();
}

/// Ten thousand pairs of tetrahedra of any shape fly into each other.
TEST(Drops, OfRandomPairsAreClean) {
  std::mt19937 random(1);
  int met = 0, unconverged = 0, steps = 0;
  for (int pair = 0; pair < 10000; ++pair) {
    Body body;
    for (int side = 0; side < 2; ++side) {
      const int first = int(body.points.size());
      Body one{{randomPoint(random), randomPoint(random), randomPoint(random), randomPoint(random)}, {{0, 1, 2, 3}}};
      const Vec3 a = one.points[0];
      if (std::abs((one.points[1] - a).cross(one.points[2] - a).dot(one.points[3] - a)) < 0.2)
        one = boxOf(Vec3(-.5, -.5, -.5), Vec3(.5, .5, .5));
      one.turn(randomRotation(random), Vec3::Zero());
      one.turn(Mat3::Identity(), Vec3(0.3 * side, 0, side == 0 ? 0 : 3.0 - one.lowest(2)));
      if (side == 0) {
        double high = -1e300;
        for (const Vec3& p : one.points) high = std::max(high, p.z());
        one.turn(Mat3::Identity(), Vec3(0, 0, 2.97 - high));
      }
      for (const Vec3& p : one.points) body.points.push_back(p);
      for (auto c : one.cells) {
        for (int& node : c) node += first;
        body.cells.push_back(c);
      }
    }
    std::string velocity = "velocity=\"";
    for (const Vec3& p : body.points) velocity += p.z() >= 2.99 ? "0 0 -5 " : "0 0 0 ";
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", body, "<BarrierContact name=\"contact\" contactDistance=\"0.02\"/>", velocity + "\""), 0.01));
    for (int i = 0; i < 8; ++i) {
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.diverged) << "pair " << pair << " step " << i << ": " << report.reason;
      ASSERT_TRUE(report.constraints_converged) << "pair " << pair << " step " << i << ": " << report.constraint_reason;
      unconverged += !report.newton_converged, ++steps;
    }
    met += outputOf(simulation, "smallestGap") > 0;
  }
  RecordProperty("steps that did not converge", std::to_string(unconverged) + " of " + std::to_string(steps));
  EXPECT_GT(met, 1000);
}

struct Case {
  const char* name;
  Body falls, stands;
  double start;        ///< height of what falls above the ground of the other
  double sliding = 0;  ///< velocity of what falls along x [m/s]
  double young = 1e6;
};

/// Each tetrahedron in eight, at the middles of its edges.
Body refined(const Body& coarse) {
  Body fine{coarse.points, {}};
  std::map<std::array<int, 2>, int> middle_of;
  const auto middle = [&](int a, int b) {
    const auto [at, is_new] = middle_of.try_emplace({std::min(a, b), std::max(a, b)}, int(fine.points.size()));
    if (is_new) fine.points.push_back(0.5 * (coarse.points[std::size_t(a)] + coarse.points[std::size_t(b)]));
    return at->second;
  };
  for (const auto& [a, b, c, d] : coarse.cells) {
    const int ab = middle(a, b), ac = middle(a, c), ad = middle(a, d), bc = middle(b, c), bd = middle(b, d),
              cd = middle(c, d);
    fine.cells.insert(fine.cells.end(), {{a, ab, ac, ad}, {ab, b, bc, bd}, {ac, bc, c, cd}, {ad, bd, cd, d}});
    fine.cells.insert(fine.cells.end(), {{ab, ac, ad, bd}, {ab, ac, bc, bd}, {ac, ad, cd, bd}, {ac, bc, cd, bd}});
  }
  return fine;
}

/// The ten of Erleben; what falls starts farther above what it hits than contacts act.
std::vector<Case> cases() {
  constexpr double above = 2e-3;
  std::vector<Case> list;
  const Body cube = boxOf(Vec3(-.5, 0, -.5), Vec3(.5, 1, .5));
  Body across = wedge(true), cliff = boxOf(Vec3(-.5, -.5, -.5), Vec3(.5, .5, .5));
  for (Vec3& p : cliff.points)
    if (p.y() < 0) p.x() *= 1.5, p.z() *= 1.5;
  for (Vec3& p : across.points) p = Vec3(p.z(), p.y(), p.x());
  Body pit = boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {2, 1, 2}), groove = boxOf(Vec3(-1, -.5, -2), Vec3(1, .5, 2), {2, 1, 2});
  for (Vec3& p : pit.points)
    if (p.x() == 0 && p.z() == 0 && p.y() > 0) p.y() = 0;
  for (Vec3& p : groove.points)
    if (p.x() == 0 && p.y() > 0) p.y() = 0;
  const Body plate = boxOf(Vec3(-1, -.5, -1), Vec3(1, .5, 1), {4, 1, 4});
  list.push_back({"spikes", spike(true), spike(), 6 + above});
  list.push_back({"spike on wedge", spike(true), wedge(), 6 + above});
  list.push_back({"wedges", across, wedge(), 6 + above});
  list.push_back({"spike in a hole", spike(true), pit, 3 + above});
  list.push_back({"spike in a crack", spike(true), groove, 3 + above});
  list.push_back({"wedge in a crack", wedge(true), groove, 3 + above});
  list.push_back({"sliding spike", spike(true), plate, 3.5 + above, 10, 2e11});
  list.push_back({"sliding wedge", wedge(true), plate, 3.5 + above, 10, 2e11});
  list.push_back({"cliff edges", cube, cliff, 0.5 + above});
  list.push_back({"inner edges", cube, plate, 0.5 + above});
  return list;
}

double kineticEnergyOf(Simulation& simulation) {
  double sum = 0;
  for (const auto& system : simulation.systems()) sum += system->kineticEnergy();
  return sum;
}

double energyOf(Simulation& simulation) {
  double sum = 0;
  for (const auto& system : simulation.systems()) sum += system->kineticEnergy() + system->potentialEnergy(system->x);
  return sum;
}

/// A step of backward Euler is a minimum of V(x) + |x - x_0 - h v_0|^2/(2 h^2), so that V + |v - v_0|^2/2 is at most V_0 + |v_0|^2/2,
/// also where something tips over and the energy itself grows by the size of the step.
double excessOfStep(Simulation& simulation, int step) {
  std::vector<Vector> before;
  for (const auto& system : simulation.systems()) copy(system->v, before.emplace_back(system->v.count()));
  const double start = energyOf(simulation);
  expectCleanStep(simulation, step, false);
  double end = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const System& system = *simulation.systems()[i];
    axpy(-1, system.v, before[i]);
    end += system.kineticEnergy(before[i]) + system.potentialEnergy(system.x);
  }
  return end - start;
}

/// No crossing, no number lost, and no energy that was not there, after the first touch too.
TEST(Drops, OfErlebensDegenerateCasesAreClean) {
  for (const Case& each : cases())
    for (const bool fine : {false, true})
      for (const double dt : {0.001, 0.025, 0.1}) {
        SCOPED_TRACE(fmt::format("{}, {}, dt {}", each.name, fine ? "fine" : "coarse", dt));
        Body falls = fine ? refined(each.falls) : each.falls;
        const Body stands = fine ? refined(each.stands) : each.stands;
        falls.turn(Mat3::Identity(), Vec3(0, each.start, 0));
        const double speed = dt == 0.001 ? 1 : 0;  // else nothing would meet within the steps that are made
        std::string ground, velocity;
        const double low = stands.lowest(1);
        for (std::size_t i = 0; i < stands.points.size(); ++i)
          if (stands.points[i].y() < low + 1e-9) ground += fmt::format("{} ", i);
        for (std::size_t i = 0; i < falls.points.size(); ++i) velocity += fmt::format("{} {} 0 ", each.sliding, -speed);
        Simulation simulation = simulationFromText(contactScene(
            bodyNode("a", falls, "", "velocity=\"" + velocity + "\"", each.young) +
                bodyNode("b", stands, "<FixedProjectiveConstraint indices=\"" + ground + "\"/>", "", each.young) +
                fmt::format(fmt::runtime(between), fmt::format("contactDistance=\"1e-3\" stiffness=\"{}\"", 0.1 * each.young)),
            dt, Vec3(0, -9.81, 0), "<EulerImplicitSolver newtonIterations=\"20\" newtonTolerance=\"1e-6\"/>"));
        const double start = energyOf(simulation);
        double fastest = kineticEnergyOf(simulation);
        bool touched = false;
        for (int i = 0; i < (fine ? 4 : 12); ++i) {
          const double excess = excessOfStep(simulation, i);
          if (HasFatalFailure()) return;
          fastest = std::max(fastest, kineticEnergyOf(simulation));
          EXPECT_LE(excess, 1e-3 * fastest) << "step " << i;
          touched = touched || outputOf(simulation, "smallestGap") > 0;
        }
        EXPECT_TRUE(touched) << "a gap within contactDistance, in which nothing starts";
        EXPECT_LE(energyOf(simulation) - start, 0.01 * fastest);
      }
}

/// Steps that are too long for a plate that falls onto a spike and rubs: one of them finds no balance. Euler's rule takes
/// energy away, and so does what is left of a solve that has not converged.
TEST(Drops, OfAPlateOntoASpikeGainNoEnergy) {
  const Body stands{{{-0.125239324, 2.987586139, 0.6959179324},
                     {0.6916565063, 2.912367024, 0.124058433},
                     {0.125239324, 2.994891782, -0.6959179324},
                     {-0.6916565063, 3.070110898, -0.124058433},
                     {-0.3266113925, 0.01, -0.07442619341}},
                    {{0, 2, 1, 4}, {0, 3, 2, 4}}};
  Body plate = boxOf(Vec3(-1, -.02, -1), Vec3(1, .02, 1), {3, 1, 3});
  plate.turn(Eigen::AngleAxisd(1.5004084, Vec3(0.3560507, 0.9043407, 0.2353629).normalized()).toRotationMatrix(),
             Vec3(0.0713922, 3.7881399, -0.0128725));
  const auto node = [](const char* name, const Body& body, double mass) {
    return fmt::format("<Node name='{}'>{}<MechanicalObject name='dofs'/><UniformMass totalMass='{}'/>"
                       "<TetrahedronHyperelasticityFEMForceField materialName='StableNeoHookean' "
                       "ParameterSet='357143 1.66667e+06'/></Node>",
                       name, body.mesh(), mass);
  };
  Simulation simulation = simulationFromText(contactScene(
      node("a", stands, 1000) + node("b", plate, 16000) +
          fmt::format(fmt::runtime(between), "planes='0 1 0 0' friction='0.3' contactDistance='0.01' stiffness='1e5'"),
      0.1, Vec3(0, -9.81, 0), "<EulerImplicitSolver newtonIterations='50' newtonTolerance='1e-4'/>"));
  const double start = energyOf(simulation);
  double unconverged = 0;
  for (int i = 0; i < 12; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << "step " << i << ": " << report.reason;
    unconverged += !report.newton_converged;
    EXPECT_LE(energyOf(simulation), start) << "step " << i;
  }
  EXPECT_GT(unconverged, 0) << "else this says nothing";
}

/// A ball that is driven at 10 m/s into a thin sheet, a tenth of a metre in each step, takes it along.
TEST(Drops, AToolDrivenIntoAThinSheetDoesNotGoThrough) {
  std::string positions, triangles, held;
  constexpr int n = 8;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      positions += fmt::format("{} {} 0  ", double(i) / n, double(j) / n);
      const int a = (n + 1) * i + j;
      if (i < n && j < n) triangles += fmt::format("{} {} {}  {} {} {}  ", a, a + n + 1, a + n + 2, a, a + n + 2, a + 1);
      if (i == 0 || j == 0 || i == n || j == n) held += fmt::format("{} ", a);
    }
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/><MechanicalObject "
                  "name=\"dofs\"/><UniformMass totalMass=\"0.1\"/><MeshSpringForceField stiffness=\"100\"/>"
                  "<FixedProjectiveConstraint indices=\"{}\"/><BarrierContact contactDistance=\"0.01\" stiffness=\"1e4\" "
                  "spheres=\"0.5 0.5 0.23 0.2\" keyTimes=\"0 1\" movements=\"0 0 0  0 0 -10\"/></Node>",
                  positions, triangles, held),
      0.01));
  for (int i = 0; i < 2; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
    EXPECT_GT(outputOf(simulation, "smallestGap"), 0);
  }
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
  EXPECT_LT(simulation.systems()[0]->x[(n + 1) * (n / 2) + n / 2].z(), -0.1) << "the middle is taken along";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
