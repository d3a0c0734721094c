// SPDX-License-Identifier: LGPL-2.1-or-later
// The second test of the paths of threads and points.
#include "components/contact/path_proofs.h"

#include <gtest/gtest.h>

#include "components/contact/longest_step.h"
#include "framework/scene/archive.h"
#include "tests/contact/contact_scenes.h"
#include "tests/contact/exact_pairs.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using contact::isPathFree;
using contact::PathProofs;

/// Pairs that meet by construction, in every degenerate way, are never called free.
TEST(PathProofs, NoMeetingIsCalledFree) {
  exact_pairs::Numbers numbers(7);
  for (int i = 0; i < 6000; ++i) {
    double when = 0;
    FourPoints x, dx;
    const PairKind kind = i % 2 ? PairKind::edge_edge : PairKind::point_triangle;
    exact_pairs::makeMeeting(numbers, kind, i < 3000 ? 0 : unsigned(i / 2 % 64), when, x, dx);
    if (when > 1) continue;
    EXPECT_FALSE(isPathFree(kind, x, dx)) << i;
  }
}

/// What the filter says is free up to the end is proved free: all of it, also pairs that end close to each other.
TEST(PathProofs, WhatIsFreeIsProved) {
  exact_pairs::Numbers numbers(11);
  int free = 0, proved = 0;
  for (int i = 0; i < 40000; ++i) {
    FourPoints x, dx;
    for (std::size_t k = 0; k < 4; ++k) x[k] = numbers.point(), dx[k] = numbers.point();
    const PairKind kind = i % 2 ? PairKind::edge_edge : PairKind::point_triangle;
    const double step = longestStep(kind, x, dx);
    if (step < 1e-3) continue;
    for (Vec3& each : dx) each *= step;
    ++free, proved += isPathFree(kind, x, dx);
  }
  EXPECT_GT(free, 35000);
  EXPECT_EQ(proved, free);
}

/// Long parallel edges close to each other that slide along.
TEST(PathProofs, NearlyParallelEdgesAreProved) {
  for (const double gap : {1e-3, 1e-6, 1e-9})
    for (const double turn : {0., 1e-8, 1e-4, 1e-2}) {
      const FourPoints x{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.1, -turn, gap), Vec3(1.1, turn, gap)};
      const FourPoints dx{Vec3::Zero(), Vec3::Zero(), Vec3(0.5, 0, 0.1 * gap), Vec3(0.5, 0, 0.1 * gap)};
      EXPECT_TRUE(isPathFree(PairKind::edge_edge, x, dx)) << gap << " " << turn;
      EXPECT_FALSE(isPathFree(PairKind::edge_edge, x, dx, 2 * gap)) << gap << " " << turn;
    }
}

/// Two crossed threads: one moves to the other side of the other, or not so far; and a point through a triangle.
TEST(PathProofs, PassagesAreSeen) {
  const std::string scene = contactScene(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 0 0  1 0 0\" edges=\"0 1\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass/></Node><Node name=\"b\"><MeshTopology name=\"mesh\" position=\"0 -1 0.1  0 1 0.1\" edges=\"0 1\"/><MechanicalObject "
      "name=\"dofs\"/><UniformMass/></Node>" + fmt::format(fmt::runtime(between), "stiffness=\"1e4\" contactDistance=\"1e-3\""));
  Simulation simulation = simulationFromText(scene);
  std::vector<State*> states = simulation.states();
  contact::Surfaces surfaces;
  for (State* state : states) {
    std::vector<Topology*> meshes;
    state->node().collect(meshes);
    surfaces.addState(*state, meshes.front()->mesh());
  }
  surfaces.finish();
  for (const bool excluded : {false, true}) {
    if (excluded) surfaces.excluded = {{0, 1}};
    PathProofs paths;
    paths.compile(surfaces, true);
    ASSERT_TRUE(paths.areNeeded());
    const auto doubt = [&](double way, const std::vector<double>& bend) {
      std::vector<Vec3> x = surfaces.rest, all(4, Vec3::Zero());
      paths.startAt(x);
      for (std::size_t v = 2; v < 4; ++v) x[v].z() -= way, all[v].z() = -2 * way;
      if (!bend.empty()) paths.allow(surfaces.rest, all, bend, 0.5);
      paths.moveTo(x);
      paths.noteStep([](int vertex) { return std::to_string(vertex); });
      const std::string found = paths.doubt("/contact", {});
      paths.reset();
      return found;
    };
    EXPECT_EQ(doubt(0.09, {}), "");
    EXPECT_EQ(doubt(0.2, {}).empty(), excluded);
    EXPECT_EQ(doubt(0.09, {0.01, 0.01, 0.01, 0.01}).empty(), excluded);
    if (!excluded) expectContains(doubt(0.2, {}), "last at 0 and 3");
  }
}

std::string numberOf(int vertex) { return std::to_string(vertex); }

/// A triangle passes a thread, a point or a ball that nothing moves, or stops before it.
TEST(PathProofs, WhatStandsStillIsTestedToo) {
  Simulation simulation = simulationFromText(contactScene(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 -1 0  1 -1 0  0 1 0\" triangles=\"0 1 2\"/><MechanicalObject "
      "name=\"dofs\"/><UniformMass/></Node>"));
  State* state = simulation.states().front();
  std::vector<Topology*> meshes;
  state->node().collect(meshes);
  for (const int kind : {0, 1, 2})
    for (const double way : {0.09, 0.2}) {
      contact::Surfaces surfaces;
      surfaces.addState(*state, meshes.front()->mesh());
      if (kind == 0) surfaces.addObstacle({Vec3(0, -3, 0.1), Vec3(0, 3, 0.1)}, {{0, 0, 1}}, 0);
      if (kind == 1) surfaces.addObstacle({Vec3(0, 0, 0.1)}, {{0, 0, 0}}, 0);
      if (kind == 2) surfaces.addObstacles({Vec3(0, 0, 0.1)}, {0.01});
      surfaces.finish();
      PathProofs paths;
      paths.compile(surfaces, true);
      EXPECT_TRUE(paths.areNeeded()) << kind;
      std::vector<Vec3> x = surfaces.rest;
      paths.startAt(x);
      for (std::size_t v = 0; v < 3; ++v) x[v].z() += way;
      paths.moveTo(x);
      paths.noteStep(numberOf);
      EXPECT_EQ(paths.doubt("/contact", {}).empty(), way < 0.1) << kind << " " << way;
      if (way < 0.1) continue;
      Archive archive;
      archive.enter("/contact");
      paths.serialize(archive);
      PathProofs resumed;
      resumed.compile(surfaces, true);
      Archive stored = archive.readable();
      stored.enter("/contact");
      resumed.serialize(stored);
      EXPECT_EQ(resumed.doubt("/contact", {}), paths.doubt("/contact", {})) << "a run that goes on names the vertices too";
    }
}

/// A triangle goes through a thread or a point that nothing moves. What was found on a path that was taken back does not count.
TEST(PathProofs, PassagesOfWhatIsStillAreSeen) {
  Simulation simulation = simulationFromText(contactScene(
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 -1 0.1  1 -1 0.1  0 1 0.1\" triangles=\"0 1 2\"/><MechanicalObject "
      "name=\"dofs\"/><UniformMass/><BarrierContact name=\"contact\" planes=\"0 0 1 -9\" stiffness=\"1e4\"/></Node>"));
  std::vector<Topology*> meshes;
  simulation.root().collect(meshes);
  for (const bool is_point : {true, false}) {
    Mesh still;
    still.position = {Vec3(0, 0, 0), Vec3(0, 3, 0)};
    if (is_point) still.position.pop_back();
    if (!is_point) still.edges = {{0, 1}};
    contact::Surfaces surfaces;
    surfaces.addState(*simulation.states().front(), meshes.front()->mesh());
    surfaces.addObstacle(still, still.position);
    surfaces.finish();
    PathProofs paths;
    paths.compile(surfaces, true);
    ASSERT_TRUE(paths.areNeeded());
    for (const double way : {0.05, 0.2})
      for (const bool taken_back : {false, true}) {
        std::vector<Vec3> x = surfaces.rest;
        paths.startAt(x);
        for (std::size_t v = 0; v < 3; ++v) x[v].z() -= way;
        paths.moveTo(x);
        if (taken_back) paths.startAgain(surfaces.rest);
        paths.noteStep(numberOf);
        EXPECT_EQ(paths.doubt("/contact", {}).empty(), way < 0.1 || taken_back) << is_point << " " << way;
        paths.reset();
      }
  }
}

/// One thread is put to the other side of another. The step then ends, or begins again: from its start, or from there.
TEST(PathProofs, WhatIsTakenBackDoesNotCount) {
  const std::string threads =
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 0 0  1 0 0\" edges=\"0 1\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass/></Node><Node name=\"b\"><MeshTopology name=\"mesh\" position=\"0 -1 0.1  0 1 0.1\" edges=\"0 1\"/>"
      "<MechanicalObject name=\"dofs\"/><UniformMass/></Node>";
  enum class Then { ends, begins_again, goes_on };
  for (const Then then : {Then::ends, Then::begins_again, Then::goes_on}) {
    FieldUnderTest t(contactScene(threads + fmt::format(fmt::runtime(between), "stiffness=\"1e4\" contactDistance=\"1e-3\"")),
                     "BarrierContact");
    auto& limiter = dynamic_cast<StepLimiter&>(t.field());
    Vector passed(t.x.count()), beyond(t.x.count());
    copy(t.x, passed), copy(t.x, beyond);
    for (const Index i : {2, 3}) passed[i] -= Vec3(0, 0, 0.2), beyond[i] -= Vec3(0, 0, 0.3);
    limiter.stepBegins(t.x, 0, 0.01);
    t.forceAt(passed);
    limiter.longestStep(passed, {t.v_zero});
    if (then == Then::begins_again) limiter.stepBegins(t.x, 0, 0.005);
    if (then == Then::goes_on) {  // a second part of the step, whose first attempt is taken back
      limiter.stepBegins(passed, 0.005, 0.01);
      t.forceAt(beyond);
      limiter.longestStep(beyond, {t.v_zero});
      limiter.stepBegins(passed, 0.005, 0.0075);
    }
    limiter.overlap(then == Then::begins_again ? t.x : passed);
    EXPECT_EQ(t.field().data().find("unprovedPaths")->print(), then == Then::begins_again ? "0" : "1") << int(then);
  }
}

/// A thread thrown at another one and at a sheet at 10 m/s, in steps that are many times their distance.
TEST(PathProofs, AreFreeInScenes) {
  const std::string thrown =
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"-1 0 0.1  0 0 0.1  1 0 0.1\" edges=\"0 1 1 2\"/><MechanicalObject "
      "name=\"dofs\" velocity=\"0 0 -10  0 0 -10  0 0 -10\"/><UniformMass vertexMass=\"0.01\"/>"
      "<MeshSpringForceField stiffness=\"100\"/></Node>";
  const std::string thread =
      "<Node name=\"b\"><MeshTopology name=\"mesh\" position=\"0.2 -1 0  0.2 1 0\" edges=\"0 1\"/><MechanicalObject name=\"dofs\"/>"
      "<UniformMass vertexMass=\"0.01\"/><MeshSpringForceField stiffness=\"100\"/></Node>";
  const std::string sheet =
      "<Node name=\"b\"><MeshTopology name=\"mesh\" position=\"-0.5 -1 0  0.5 -1 0  0 1 0\" triangles=\"0 1 2\"/><MechanicalObject "
      "name=\"dofs\"/><UniformMass vertexMass=\"0.01\"/></Node>";
  for (const std::string& other : {thread, sheet}) {
    Simulation simulation = simulationFromText(
        contactScene(thrown + other + fmt::format(fmt::runtime(between), "stiffness=\"1e5\" contactDistance=\"1e-3\"")));
    for (int i = 0; i < 20; ++i) expectCleanStep(simulation, i, false);
    EXPECT_EQ(findComponent(simulation.root(), "contact")->data().find("unprovedPaths")->print(), "0");
  }
}

std::string unprovedAfter(const std::string& scene, int steps, bool must_converge = false) {
  Simulation simulation = simulationFromText(scene);
  for (int i = 0; i < steps; ++i) expectCleanStep(simulation, i, must_converge);
  return findComponent(simulation.root(), "contact")->data().find("unprovedPaths")->print();
}
const std::string chain =
    "<Node name=\"b\"><MeshTopology name=\"mesh\" position=\"-0.5 0 0  -0.2 0 0  0.1 0 0  0.4 0 0\" edges=\"0 1 1 2 2 3\"/>"
    "<MechanicalObject name=\"dofs\"/><UniformMass vertexMass=\"0.01\"/><MeshSpringForceField stiffness=\"100\"/></Node>";

/// A rod on a frame that turns by half a radian in a step hits a chain: paths on arcs, and iterates that go back.
TEST(PathProofs, AreFreeWhereFramesTurn) {
  const std::string rod =
      "<Node name=\"a\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 0.1 0 0 0 1\" velocity=\"0 0 -2 0 50 0\"/>"
      "<UniformMass totalMass=\"0.05\"/><Node name=\"rod\"><MeshTopology name=\"mesh\" position=\"0 -0.3 0.06  0 0.3 0.06\" edges=\"0 1\"/>"
      "<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>";
  const std::string contact = "<BarrierContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" other=\"@a/rod/dofs\" "
                              "stiffness=\"1e5\" contactDistance=\"1e-3\" friction=\"0.3\"/>";
  EXPECT_EQ(unprovedAfter(contactScene(rod + chain + contact), 40), "0");
}

/// A ball as an obstacle pushes a chain, within steps of many times the gap; and explicit steps, in parts.
TEST(PathProofs, AreFreeWithObstaclesAndInParts) {
  const std::string ball = "<BarrierContact name=\"contact\" mstate=\"@b/dofs\" topology=\"@b/mesh\" stiffness=\"1e5\" "
                           "contactDistance=\"1e-3\" spheres=\"0 0 0.06 0.05\" keyTimes=\"0 0.2\" movements=\"0 0 0  0 0 -0.5\"/>";
  EXPECT_EQ(unprovedAfter(contactScene(chain + ball), 20), "0");
  const std::string thrown =
      "<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"0 -1 0.01  0 1 0.01\" edges=\"0 1\"/><MechanicalObject name=\"dofs\" "
      "velocity=\"0 0 -3  0 0 -3\"/><UniformMass vertexMass=\"0.01\"/></Node>";
  const std::string both = thrown + chain + fmt::format(fmt::runtime(between), "stiffness=\"1e5\" contactDistance=\"1e-3\"");
  EXPECT_EQ(unprovedAfter(contactScene(both, 1e-3, Vec3::Zero(), "<EulerExplicitSolver/>"), 40), "0");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
