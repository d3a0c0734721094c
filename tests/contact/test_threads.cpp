// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies without a triangle: threads of edges, and points. A thread stands for a strip as wide as contactDistance + thickness.
#include <cmath>
#include <numeric>

#include "framework/mechanics/open_choices.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A chain of points, with a mass of 1 g and a spring of 100 N/m for each edge.
struct Thread {
  std::vector<Vec3> points;
  Thread(const Vec3& from, const Vec3& to, int edges) {
    for (int i = 0; i <= edges; ++i) points.push_back(from + double(i) / edges * (to - from));
  }
  std::string mesh() const {
    std::string text = "<MeshTopology name=\"mesh\" position=\"", edges;
    for (std::size_t i = 0; i < points.size(); ++i) {
      text += fmt::format("{} {} {}  ", points[i].x(), points[i].y(), points[i].z());
      if (i > 0) edges += fmt::format("{} {}  ", i - 1, i);
    }
    return text + "\" edges=\"" + edges + "\"/>";
  }
  std::string node(const std::string& name, const std::string& more, const std::string& state = "") const {
    return fmt::format("<Node name=\"{}\">{}<MechanicalObject name=\"dofs\" {}/><UniformMass vertexMass=\"1e-3\"/>"
                       "<MeshSpringForceField stiffness=\"100\"/>{}</Node>",
                       name, mesh(), state, more);
  }
};

/// The gap [m] at which a barrier has this part of its stiffness as a pressure.
double gapOf(double part, double range) {
  double low = 1e-9, high = 1;
  for (int i = 0; i < 100; ++i) {
    const double r = 0.5 * (low + high), pressure = 2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r;
    (pressure > part ? low : high) = r;
  }
  return low * range;
}

const std::string damped = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\" rayleighMass=\"10\"/>";
constexpr double gravity = 9.81;

/// Each node on a plane carries its own weight: those at the ends on half a strip. `thickness` lifts and widens.
TEST(Threads, LieAtTheGapOfTheirWeight) {
  constexpr double range = 1e-3, stiffness = 1e4, h = 0.01;
  for (const double thickness : {0., 5e-4})
    for (const bool is_penalty : {false, true}) {
      const Thread thread(Vec3(0, 0, 3e-3), Vec3(4 * h, 0, 3e-3), 4);
      Simulation simulation = simulationFromText(contactScene(
          thread.node("a", fmt::format("<{} contactDistance=\"{}\" thickness=\"{}\" stiffness=\"{}\" planes=\"0 0 1 0\" />",
                                       is_penalty ? "PenaltyContact" : "BarrierContact", range, thickness, stiffness)),
          0.01, Vec3(0, 0, -gravity), damped));
      for (int i = 0; i < 200; ++i) expectCleanStep(simulation, i);
      for (Index node = 0; node < 5; ++node) {
        const double area = (node == 0 || node == 4 ? 0.5 : 1) * h * (range + thickness), part = 1e-3 * gravity / area / stiffness;
        const double gap = is_penalty ? range * (1 - part) : gapOf(part, range);
        EXPECT_NEAR(simulation.systems()[0]->x[node].z(), thickness + gap, 1e-5 * range) << node;
      }
    }
}

/// Points are squares of that width.
TEST(Threads, PointsLieAtTheGapOfTheirWeight) {
  constexpr double range = 1e-3, stiffness = 1e5;
  Simulation simulation = simulationFromText(contactScene(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 0 0.002  1 0 0.002\"/><MechanicalObject name=\"dofs\"/><UniformMass "
      "vertexMass=\"1e-3\"/><BarrierContact contactDistance=\"1e-3\" stiffness=\"1e5\" planes=\"0 0 1 0\"/></Node>",
      0.01, Vec3(0, 0, -gravity), damped));
  for (int i = 0; i < 200; ++i) expectCleanStep(simulation, i);
  for (Index node = 0; node < 2; ++node)
    EXPECT_NEAR(simulation.systems()[0]->x[node].z(), gapOf(1e-3 * gravity / (range * range) / stiffness, range), 1e-5 * range);
}

/// Where a thread of nodes 0 to first - 1 and one of the others cross seen from above, the other is higher.
void expectAbove(ConstRows x, Index first, const std::string& when) {
  int crossings = 0;
  for (Index i = 0; i + 1 < first; ++i)
    for (Index j = first; j + 1 < x.count; ++j) {
      const Vec3 p = x[i], u = x[i + 1] - x[i], q = x[j], v = x[j + 1] - x[j];
      const auto cross = [](const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); };
      const double s = cross(q - p, v) / cross(u, v), t = cross(q - p, u) / cross(u, v);
      if (s < 0 || s > 1 || t < 0 || t > 1) continue;
      ++crossings;
      EXPECT_GT(q.z() + t * v.z(), p.z() + s * u.z()) << when;
    }
  EXPECT_GT(crossings, 0) << when;
}

/// Two threads, of which one falls across the other, which is held at its ends. They move by thirty times their distance in a step.
/// Only an edge meets an edge: no vertex is near, and no triangle is there.
TEST(Threads, ThatCrossDoNotPassEachOther) {
  for (const double dt : {1e-3, 1e-2, 1e-1})
    for (const double shift : {-0.017, 0., 0.013})
      for (const double angle : {0.3, 1.1, M_PI / 2, 2.5}) {
        const Thread held(Vec3(-0.1, 0, 0), Vec3(0.1, 0, 0), 5);
        const Vec3 half = 0.2 * Vec3(std::cos(angle), std::sin(angle), 0), over(shift, 0, 0.03);
        const Thread thrown(over - half, over + half, 7);
        std::string velocity = "velocity=\"";
        for (std::size_t i = 0; i < thrown.points.size(); ++i) velocity += "0 0 -10  ";
        Simulation simulation = simulationFromText(contactScene(
            held.node("a", "<FixedProjectiveConstraint indices=\"0 5\"/>") + thrown.node("b", "", velocity + "\"") +
                fmt::format(fmt::runtime(between), "contactDistance=\"0.001\" stiffness=\"1e5\""),
            dt, Vec3::Zero(), "<EulerImplicitSolver newtonIterations=\"100\" newtonTolerance=\"1e-6\"/>"));
        double deepest = 0;
        for (double t = 0; t < 0.0101; t += dt) {
          expectCleanStep(simulation, int(t / dt), false);
          const auto& x = simulation.systems()[0]->x;
          for (Index node = 0; node < 6; ++node) deepest = std::min(deepest, x[node].z());
          expectAbove(x, simulation.systems()[0]->allRows() - 8, fmt::format("dt {}, shift {}, angle {}, t {}", dt, shift, angle, t));
        }
        EXPECT_LT(deepest, -1e-3) << "nothing was hit: dt " << dt << ", shift " << shift << ", angle " << angle;
      }
}

/// What pushes them down pushes the block, and nothing goes through it.
TEST(Threads, LieOnASoftBlock) {
  Body block = boxOf(Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.05), {3, 3, 2});
  const Thread thread(Vec3(0.011, 0.013, 0.052), Vec3(0.087, 0.081, 0.052), 8);
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("b", block,
               "<BoxROI name=\"foot\" box=\"-1 -1 -1  2 2 0.001\"/><FixedProjectiveConstraint indices=\"@foot.indices\"/>", "", 1e4) +
          thread.node("a", "") + fmt::format(fmt::runtime(between), "contactDistance=\"0.001\" stiffness=\"1e4\" friction=\"0.3\""),
      0.02, Vec3(0, 0, -gravity), damped));
  for (int i = 0; i < 150; ++i) expectCleanStep(simulation, i);
  EXPECT_EQ(outputOf(simulation, "crossings"), 0);
  const std::vector<double> wrenches = numbersOf(simulation, "wrenches");  // of a, then of b: three numbers of force, three of moment
  EXPECT_NEAR(wrenches[2], 9 * 1e-3 * gravity, 1e-4 * 9 * 1e-3 * gravity);
  EXPECT_NEAR(wrenches[2] + wrenches[8], 0, 1e-12);
  for (const int i : {0, 1}) EXPECT_NEAR(wrenches[std::size_t(i)], 0, 1e-5);
}

/// Force, energy, derivative and products belong together, of threads and points over a block.
TEST(Threads, ForceIsTheSlopeOfTheEnergy) {
  int checked = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const auto aside = [&] { return 0.3 * betweenOnes(random); };
    Thread thread(Vec3(-0.1 + aside(), 0.2 + aside(), 1.004), Vec3(0.9 + aside(), 0.7 + aside(), 1.04), 5);
    std::string body = thread.node("a", "");
    if (seed % 3 == 0) {  // its points alone
      const std::size_t edges = body.find(" edges="), springs = body.find("<MeshSpring");
      body.erase(springs, body.find("/>", springs) + 2 - springs);
      body.erase(edges, body.find("/>") - edges);
    }
    FieldUnderTest t(contactScene(bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 1}), "") + body +
                                  fmt::format(fmt::runtime(between), "contactDistance=\"0.05\" stiffness=\"1e4\"")),
                     "BarrierContact");
    if (const Vector f = t.force(); dot(f, f) == 0) continue;
    ++checked;
    expectForceOfEnergy(t, 1e-7, seed);
    for (int i = 0; i < 6; ++i) t.force();  // shares stay from then on
    EXPECT_LT(relativeDifference(t.differenceOfForces(1e-7), t.product(t.direction)), 1e-5) << "seed " << seed;
    expectMatrixOfProducts(t);
    expectSymmetricProducts(t);
  }
  EXPECT_GT(checked, 8);
}

/// Forces of constraint keep a thread at its gap and carry its weight.
TEST(Threads, OfConstraintContactKeepTheirGap) {
  const Thread thread(Vec3(0, 0, 3e-3), Vec3(0.04, 0, 3e-3), 4);
  Simulation simulation = simulationFromText(contactScene(
      thread.node("a", "<ConstraintContact name=\"contact\" contactDistance=\"0.001\" planes=\"0 0 1 0\"/>"), 0.01,
      Vec3(0, 0, -gravity), damped));
  for (int i = 0; i < 100; ++i) expectCleanStep(simulation, i);
  for (Index node = 0; node < 5; ++node) EXPECT_NEAR(simulation.systems()[0]->x[node].z(), 1e-3, 1e-9);
  EXPECT_NEAR(constraintOutput(simulation, "wrenches")[2], 5e-3 * gravity, 1e-9);
}

/// Who has forgotten triangles sees in the plan what meets.
TEST(Threads, AreNamedInThePlan) {
  const Thread thread(Vec3(0, 0, 3e-3), Vec3(0.04, 0, 3e-3), 4);
  const auto choiceOf = [](const std::string& body) {
    FieldUnderTest t(contactScene(body), "BarrierContact");
    return dynamic_cast<OpenChoices&>(t.field()).choice();
  };
  const std::string contact = "<BarrierContact contactDistance=\"0.001\" stiffness=\"1e5\" planes=\"0 0 1 0\"/>";
  expectContains(choiceOf(thread.node("a", contact)), "/a/dofs (its edges) and 1 obstacle");
  expectContains(choiceOf("<Node name=\"a\"><MeshTopology position=\"0 0 1\"/><MechanicalObject name=\"dofs\"/><UniformMass "
                          "vertexMass=\"1\"/>" + contact + "</Node>"),
                 "/a/dofs (its points) and 1 obstacle");
}

TEST(Threads, SayWhatIsWrong) {
  expectContains(problemsOf(contactScene("<Node name=\"a\"><MeshTopology position=\"0 0 1  1 0 1\"/><MechanicalObject/><UniformMass/>"
                                         "<BarrierContact stiffness=\"1e4\" planes=\"0 0 1 0\"/></Node>")),
                 "points have no edges of which contactDistance would be a part");
  const auto with = [](const Thread& thread) {
    return problemsOf(contactScene(bodyNode("b", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)), "") + thread.node("a", "") +
                                   fmt::format(fmt::runtime(between), "contactDistance=\"0.02\" stiffness=\"1e4\"")));
  };
  expectContains(with(Thread(Vec3(-0.5, 0.4, 0.3), Vec3(0.5, 0.45, 0.35), 2)), "start in one another");
  EXPECT_EQ(with(Thread(Vec3(-0.5, 0.4, 1.3), Vec3(0.5, 0.45, 1.35), 2)), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
