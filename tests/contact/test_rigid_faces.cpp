// SPDX-License-Identifier: LGPL-2.1-or-later
// Faces of rigid bodies that lie flat on each other, by forces of constraint: a disc that spins, a stack of boxes, squares that are
// turned by a little, what is tipped or round, and a run that goes on from a checkpoint.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double range = 1e-3, gravity = 9.81;

std::string rigid(const std::string& name, const std::string& mesh, const Vec3& place, double angle, double mass, const Vec3& inertia,
                  const std::string& more = "") {
  return fmt::format(
      "<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} {} {}  0 0 {} {}\" {}/><UniformMass "
      "totalMass=\"{}\" inertia=\"{} {} {}\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
      name, place.x(), place.y(), place.z(), std::sin(angle / 2), std::cos(angle / 2), more, mass, inertia.x(), inertia.y(), inertia.z(),
      mesh);
}

/// Triangles outward, of `around` x `rings` cells on each side.
std::string disc(int around, int rings, double radius, double height) {
  std::string points, triangles;
  const int each = 1 + around * rings;
  for (const double z : {-height / 2, height / 2}) {
    points += fmt::format("0 0 {}  ", z);
    for (int k = 1; k <= rings; ++k)
      for (int i = 0; i < around; ++i) {
        const double a = 2 * M_PI * i / around, r = radius * k / rings;
        points += fmt::format("{} {} {}  ", r * std::cos(a), r * std::sin(a), z);
      }
  }
  const auto add = [&](int side, int a, int b, int c) {
    const int from = side * each;
    triangles += fmt::format("{} {} {}  ", from + a, from + (side == 1 ? b : c), from + (side == 1 ? c : b));
  };
  for (int i = 0; i < around; ++i) {
    const int j = (i + 1) % around, rim = 1 + (rings - 1) * around;
    for (const int side : {0, 1}) {
      add(side, 0, 1 + i, 1 + j);
      for (int k = 1; k < rings; ++k) {
        const int a = 1 + (k - 1) * around, b = a + around;
        add(side, a + i, b + i, b + j), add(side, a + i, b + j, a + j);
      }
    }
    triangles += fmt::format("{} {} {}  {} {} {}  ", rim + i, rim + j, each + rim + j, rim + i, each + rim + j, each + rim + i);
  }
  return fmt::format("<MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/>", points, triangles);
}

/// The torque of an even pressure is 2/3 mu N R; here over that of the disc.
double torqueOf(int around, int rings) {
  constexpr double radius = 0.05, height = 0.02, mu = 0.3, dt = 1e-3, inertia = radius * radius / 2;
  constexpr int steps = 8;
  Simulation simulation = simulationFromText(contactScene(
      rigid("a", disc(around, rings, radius, height), Vec3(0, 0, height / 2 + 1.0005 * range), 0, 1, Vec3(inertia, inertia, inertia),
            "velocity=\"0 0 0  0 0 20\"") +
          fmt::format("<ConstraintContact mstate=\"@a/skin/dofs\" contactDistance=\"{}\" friction=\"{}\" planes=\"0 0 1 0\"/>", range, mu),
      dt, Vec3(0, 0, -gravity), "<EulerImplicitSolver/>"));
  for (int step = -2; step < 0; ++step) expectCleanStep(simulation, step);  // it comes down, and stops
  const double first = simulation.states().front()->v()[1].z();
  for (int step = 0; step < steps; ++step) expectCleanStep(simulation, step);
  const double last = simulation.states().front()->v()[1].z();
  return (first - last) / (steps * dt) * inertia / (2. / 3 * mu * gravity * radius);
}

/// The error is that of the cells: a polygon in the place of a circle, and points in the place of a pressure.
TEST(RigidFaces, ADiscThatSpinsIsSlowedByAnEvenPressure) {
  const double coarse = torqueOf(8, 2), middle = torqueOf(16, 4), fine = torqueOf(32, 8);
  RecordProperty("torque", fmt::format("{:.5f} {:.5f} {:.5f}", coarse, middle, fine));
  EXPECT_NEAR(middle, 1, 0.005);
  EXPECT_NEAR(fine, 1, 0.001);
  EXPECT_LT(std::abs(fine - 1), 0.4 * std::abs(middle - 1));
  EXPECT_LT(std::abs(middle - 1), 0.4 * std::abs(coarse - 1));
}

std::string boxes(int count, double angle, double aside) {
  std::string content, others;
  for (int i = 0; i < count; ++i) {
    const Body box = boxOf(Vec3(-0.05, -0.05, -0.05), Vec3(0.05, 0.05, 0.05));
    const Vec3 place(aside * (i % 2), 0.7 * aside * (i % 3), 0.05 + 1.0005 * range + i * (0.1 + 1.0005 * range));
    content += rigid(fmt::format("b{}", i), box.mesh(), place, angle * (i % 2), 1, Vec3::Constant(0.01 / 6));
    if (i > 0) others += fmt::format("@b{}/skin/dofs ", i);
  }
  content += fmt::format("<ConstraintContact mstate=\"@b0/skin/dofs\" other=\"{}\" contactDistance=\"{}\" friction=\"0.5\" "
                         "planes=\"0 0 1 0\" selfContact=\"0\"/>",
                         others, range);
  return contactScene(content, 0.01, Vec3(0, 0, -gravity), "<EulerImplicitSolver/>");
}

/// Vertices of squares that are turned against each other lie outside of the other one: their rims carry, at any small angle.
/// Where rims are nearly parallel, or lie above each other, no force is open.
TEST(RigidFaces, StacksOfBoxesStand) {
  for (const double angle : {0.0, 1e-7, 1e-4, 0.01, 0.05, 0.4})
    for (const double aside : {0.0, 1e-6, 1e-3, 0.02}) {
      SCOPED_TRACE(fmt::format("turned by {}, aside by {}", angle, aside));
      constexpr int count = 4;
      Simulation simulation = simulationFromText(boxes(count, angle, aside));
      std::vector<Vec3> start;
      for (const State* state : simulation.states()) start.push_back(Vec3(state->x()[0]));
      for (int step = 0; step < 10; ++step) {
        expectCleanStep(simulation, step);
        if (HasFatalFailure()) return;
      }
      for (std::size_t i = 0; i < start.size(); ++i)
        EXPECT_LT((Vec3(simulation.states()[i]->x()[0]) - start[i]).norm(), 0.01 * range) << simulation.states()[i]->path();
      const std::vector<double> wrench = constraintOutput(simulation, "wrenches");
      for (int i = 0; i < count; ++i) EXPECT_NEAR(wrench.at(std::size_t(6 * i + 2)), gravity, 1e-6) << i;
    }
}

std::string fixedTable(const Vec3& half) {
  const Body table = boxOf(-half, half);
  return fmt::format(
      "<Node name=\"table\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 {}  0 0 0 1\"/><UniformMass "
      "totalMass=\"1\"/><FixedProjectiveConstraint indices=\"0\"/><Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/>"
      "<RigidMapping/></Node></Node>",
      -half.z(), table.mesh());
}

std::string freeOnTable(const std::string& body, const Vec3& table) {
  return contactScene(body + fixedTable(table) +
                          fmt::format("<ConstraintContact mstate=\"@a/skin/dofs\" other=\"@table/skin/dofs\" "
                                      "contactDistance=\"{}\" selfContact=\"0\"/>",
                                      range),
                      1e-3, Vec3(0, 0, -gravity), "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-10\"/>");
}

const State& frameOf(const Simulation& simulation, const std::string& name) {
  for (const State* state : simulation.states())
    if (state->path() == "/" + name + "/frame") return *state;
  throw std::runtime_error("no frame of " + name);
}

/// Nothing rubs and the table is level, so that no force is aside: on an edge that is tipped, and later flat on its face.
TEST(RigidFaces, ATippedBoxIsNotPushedAside) {
  for (const double degrees : {10.0, 3.0, 0.3}) {
    SCOPED_TRACE(degrees);
    const double angle = degrees * M_PI / 180, half = 0.05;
    Body box = boxOf(Vec3::Constant(-half), Vec3::Constant(half));
    box.turn(Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix(), Vec3::Zero());
    const double height = 1.0005 * range - box.lowest(2);
    Simulation simulation =
        simulationFromText(freeOnTable(rigid("a", box.mesh(), Vec3(0.01, 0, height), 0, 1, Vec3::Constant(0.01 / 6)), Vec3(0.5, 0.5, 0.1)));
    const State& frame = frameOf(simulation, "a");
    double turns = 0;
    for (int step = 0; step < 80; ++step) {
      expectCleanStep(simulation, step);
      if (HasFatalFailure()) return;
      ASSERT_LT(frame.v()[0].head<2>().norm(), 1e-9) << "step " << step;
      turns += 1e-3 * frame.v()[1].y();
    }
    EXPECT_NEAR(std::abs(turns), angle, 1e-4) << "it has come to lie on its face";
  }
}

/// A ball of triangles: a cube of cells drawn out, with the middle of a side down. `reversed`: triangles in the other order.
std::string ball(int cells, double radius, bool reversed) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  const auto numberOf = [&](const Vec3& p) {
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((points[i] - p).norm() < 1e-9 * radius) return int(i);
    points.push_back(p);
    return int(points.size()) - 1;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1})
      for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
          std::array<int, 4> v{};
          for (int k = 0; k < 4; ++k) {
            Vec3 p = Vec3::Constant(side);
            p[(axis + 1) % 3] = std::tan(M_PI / 4 * (2. * (i + (k == 1 || k == 2)) / cells - 1));
            p[(axis + 2) % 3] = std::tan(M_PI / 4 * (2. * (j + k / 2) / cells - 1));
            v[std::size_t(k)] = numberOf(radius * p.normalized());
          }
          // diagonals towards the middle of the side, so that the ball is its own mirror image
          const bool turns = (2 * i < cells) != (2 * j < cells);
          std::array<std::array<int, 3>, 2> two{{{v[0], v[1], v[2]}, {v[0], v[2], v[3]}}};
          if (turns) two = {{{v[0], v[1], v[3]}, {v[1], v[2], v[3]}}};
          for (std::array<int, 3>& t : two) {
            if (side < 0) std::swap(t[1], t[2]);
            triangles.push_back(t);
          }
        }
  if (reversed) std::reverse(triangles.begin(), triangles.end());
  std::string text = "<MeshTopology name=\"mesh\" position=\"";
  for (const Vec3& p : points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
  text += "\" triangles=\"";
  for (const auto& t : triangles) text += fmt::format("{} {} {}  ", t[0], t[1], t[2]);
  return text + "\"/>";
}

/// Its facets are no faces that lie flat: it is pushed along the table's normal, whichever triangle comes first.
TEST(RigidFaces, ABallOfTrianglesIsPushedUpright) {
  constexpr double radius = 0.05, aside = 0.0007;
  for (const int cells : {6, 12}) {
    SCOPED_TRACE(cells);
    std::vector<std::vector<Vec3>> ways;
    for (const bool reversed : {false, true}) {
      const std::string body = rigid("a", ball(cells, radius, reversed), Vec3(aside, 2 * aside, radius + 1.0005 * range), 0, 1,
                                     Vec3::Constant(0.4 * radius * radius), "velocity=\"0 0 -0.05  0.3 0.2 0\"");
      Simulation simulation = simulationFromText(freeOnTable(body, Vec3(0.5, 0.5, 0.1)));
      const State& frame = frameOf(simulation, "a");
      ways.emplace_back();
      for (int step = 0; step < 30; ++step) {
        expectCleanStep(simulation, step);
        if (HasFatalFailure()) return;
        ASSERT_LT(frame.v()[0].head<2>().norm(), 1e-9) << "step " << step;
        ways.back().push_back(Vec3(frame.x()[0]));
        ways.back().push_back(Vec3(frame.v()[1]));
      }
      EXPECT_NEAR(frame.x()[0].z(), radius + range, 0.02 * radius) << "the table carries it";
    }
    for (std::size_t i = 0; i < ways[0].size(); ++i) ASSERT_LT((ways[0][i] - ways[1][i]).norm(), 1e-9) << i;
  }
}

/// What finds the forces of many equal conditions counts as a search, and where nothing meets there is none.
TEST(RigidFaces, SearchesForForcesAreCounted) {
  const auto outputOf = [](const Simulation& simulation, const char* name) {
    std::vector<Component*> all;
    simulation.root().collect(all);
    for (const Component* component : all)
      if (component->type() == "EulerImplicitSolver") return std::stod(component->data().find(name)->print());
    return -1.0;
  };
  Simulation stands = simulationFromText(boxes(2, 0.01, 1e-3));
  expectCleanStep(stands, 0);
  EXPECT_GT(outputOf(stands, "conditionIterations"), 0);
  EXPECT_LT(outputOf(stands, "conditionResidual"), 1e-9);
  Simulation falls = simulationFromText(
      freeOnTable(rigid("a", boxOf(Vec3::Constant(-0.05), Vec3::Constant(0.05)).mesh(), Vec3(0, 0, 0.2), 0, 1, Vec3::Constant(0.01 / 6)),
                  Vec3(0.5, 0.5, 0.1)));
  expectCleanStep(falls, 0);
  EXPECT_EQ(outputOf(falls, "conditionIterations"), 0);
  EXPECT_EQ(outputOf(falls, "conditionResidual"), 0);
}

/// A search that costs more than it may ends the step with a sentence that names what would let it go on.
TEST(RigidFaces, ASearchBeyondItsBudgetSaysSo) {
  std::string text = boxes(2, 0.01, 1e-3);
  const std::string rule = "<EulerImplicitSolver";
  text.insert(text.find(rule) + rule.size(), " conditionBudget=\"1e-9\" ");
  Simulation simulation = simulationFromText(text);
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  EXPECT_NE(report.reason.find("finds no forces of Lagrangian constraints within the budget of a step"), std::string::npos)
      << report.reason;
  EXPECT_NE(report.reason.find("conditionBudget, now 1e-09, lets it search longer"), std::string::npos) << report.reason;
}

/// Forces of the step before are in a checkpoint: what goes on from it is the same to the bit.
TEST(RigidFaces, GoOnFromACheckpoint) {
  const std::string text = boxes(5, 0.01, 1e-3);
  Simulation whole = simulationFromText(text), restored = simulationFromText(text);
  for (int step = 0; step < 5; ++step) expectCleanStep(whole, step);
  restored.restore(whole.checkpoint());
  for (int step = 0; step < 5; ++step) expectCleanStep(whole, step), expectCleanStep(restored, step);
  for (std::size_t i = 0; i < whole.states().size(); ++i)
    for (Index row = 0; row < whole.states()[i]->size(); ++row)
      EXPECT_EQ(whole.states()[i]->x()[row], restored.states()[i]->x()[row]) << whole.states()[i]->path();
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
