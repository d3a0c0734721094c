// SPDX-License-Identifier: LGPL-2.1-or-later
// Surfaces that are mapped: of rigid frames, free or moved, and embedded ones; ways that bend, thick sheets, surfaces whose
// triangles turn the wrong way.
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "framework/scene/spans.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/step_limits.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

enum class Shape { cells, outwards, inwards, prisms };

/// Two prisms in the place of the box, which list no faces.
std::string prismsOf(const Body& body) {
  const auto [low, high] = std::ranges::minmax(body.points, [](const Vec3& p, const Vec3& q) { return p.sum() < q.sum(); });
  std::string text = "<MeshTopology name=\"mesh\" position=\"";
  for (const double z : {low.z(), high.z()})
    text += fmt::format("{0} {1} {4}  {2} {1} {4}  {2} {3} {4}  {0} {3} {4}  ", low.x(), low.y(), high.x(), high.y(), z);
  return text + "\" prisms=\"0 1 2 4 5 6  0 2 3 4 6 7\"/>";
}

/// The mesh of a box: its cells, triangles that turn outwards or inwards, or prisms.
std::string meshOf(const Body& body, Shape shape) {
  if (shape == Shape::cells) return body.mesh();
  if (shape == Shape::prisms) return prismsOf(body);
  std::string text = "<MeshTopology name=\"mesh\" position=\"";
  for (const Vec3& p : body.points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
  text += "\" triangles=\"";
  std::map<std::array<int, 3>, std::array<int, 3>> sides;  // of cells; inner ones come twice
  for (const auto& c : body.cells)
    for (int left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> side{};
      for (int i = 0, k = 0; i < 4; ++i)
        if (i != left_out) side[std::size_t(k++)] = c[std::size_t(i)];
      std::array<int, 3> key = side;
      std::sort(key.begin(), key.end());
      if (!sides.emplace(key, side).second) sides.erase(key);
    }
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : body.points) middle += p / double(body.points.size());
  for (const auto& [key, side] : sides) {
    const Vec3 &a = body.points[std::size_t(side[0])], &b = body.points[std::size_t(side[1])],
               &c = body.points[std::size_t(side[2])];
    const bool out = (b - a).cross(c - a).dot(a - middle) > 0;
    text += out == (shape == Shape::outwards) ? fmt::format("{} {} {}  ", side[0], side[1], side[2])
                                              : fmt::format("{} {} {}  ", side[0], side[2], side[1]);
  }
  return text + "\"/>";
}

/// A frame with the surface of `body`, whose points are in its axes.
std::string rigid(const std::string& name, const Body& body, const std::string& frame, double mass, double inertia,
                  const std::string& more = "", Shape shape = Shape::cells) {
  return fmt::format(
      "<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" {}/><UniformMass totalMass=\"{}\" "
      "inertia=\"{} {} {}\"/>{}<Node name=\"skin\">{}<MechanicalObject name=\"dofs\"/><RigidMapping/></Node></Node>",
      name, frame, mass, inertia, inertia, inertia, more, meshOf(body, shape));
}

const State& stateAt(const Simulation& simulation, const std::string& path) {
  for (const State* state : simulation.states())
    if (state->path() == path) return *state;
  throw std::runtime_error("no " + path);
}

/// A rigid box of weight W on a plane: p = W/A everywhere, whatever its surface is made of.
TEST(MappedSurfaces, ARigidBoxRestsAtTheGapOfItsWeight) {
  const double range = 0.02, weight = 100 * 9.81;
  for (const Shape shape : {Shape::cells, Shape::outwards, Shape::inwards, Shape::prisms}) {
    SCOPED_TRACE(int(shape));
    const Body box = boxOf(Vec3(-.5, -.5, -.25), Vec3(.5, .5, .25), {2, 2, 1});
    Simulation simulation = simulationFromText(contactScene(
        rigid("tool", box, fmt::format("position=\"0 0 {}  0 0 0 1\"", 0.25 + 0.9 * range), 100, 10, "", shape) +
            fmt::format("<BarrierContact mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" "
                        "stiffness=\"{}\"/>",
                        range, 10 * weight),
        0.05, Vec3(0, 0, -9.81)));
    for (int i = 0; i < 60; ++i) expectCleanStep(simulation, i, false);
    const double gap = (stateAt(simulation, "/tool/frame").x()[0].z() - 0.25) / range;
    if (shape == Shape::inwards) {  // both sides of its triangles count, the sides of the box hardly
      EXPECT_NEAR(gap, 0.8285, 0.02);
    } else {
      EXPECT_NEAR(gap, 0.8285, 1e-3);
    }
    EXPECT_NEAR(numbersOf(simulation, "wrenches")[2], weight, 0.01 * weight);
  }
}

/// The same of a surface that is embedded in one hexahedron.
TEST(MappedSurfaces, AnEmbeddedSurfaceRestsAtTheGapOfItsWeight) {
  const double range = 0.02, pressure = 1000 * 9.81 * 0.5;
  const double low = 0.9 * range;
  const Body box = boxOf(Vec3(0, 0, low), Vec3(1, 1, low + 0.5), {4, 4, 2});
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<Node name=\"body\"><RegularGridTopology n=\"2 2 2\" min=\"0 0 {0}\" max=\"1 1 {1}\"/><MechanicalObject "
                  "name=\"dofs\"/><UniformMass totalMass=\"500\"/><HexahedronFEMForceField youngModulus=\"1e7\" "
                  "poissonRatio=\"0\"/><PartialFixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7\" fixedDirections=\"1 1 "
                  "0\"/><Node name=\"skin\">{2}<MechanicalObject name=\"dofs\"/><BarycentricMapping/></Node></Node>",
                  low, low + 0.5, meshOf(box, Shape::outwards)) +
          fmt::format("<BarrierContact mstate=\"@body/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"{}\" "
                      "stiffness=\"{}\"/>",
                      range, 10 * pressure),
      0.05, Vec3(0, 0, -9.81)));
  for (int i = 0; i < 60; ++i) expectCleanStep(simulation, i, false);
  const State& body = stateAt(simulation, "/body/dofs");
  double least = 1e300;
  for (Index i = 0; i < 8; ++i) least = std::min(least, body.x()[i].z() / range);
  EXPECT_NEAR(least, 0.8285, 2e-3);
}

/// Boxes that turn by up to three radians in a step fly into each other.
TEST(MappedSurfaces, SpinningBodiesDoNotCross) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int met = 0;
  for (int pair = 0; pair < 20; ++pair) {
    std::string bodies;
    for (int side = 0; side < 2; ++side) {
      const Body box = boxOf(Vec3(-.5, -.2, -.1), Vec3(.5, .2, .1));
      bodies += rigid(side == 0 ? "a" : "b", box,
                      fmt::format("position=\"{} {} {}  0 0 0 1\" velocity=\"0 0 {}  {} {} {}\"", 0.3 * uniform(random),
                                  0.3 * uniform(random), 1.2 * side, side == 0 ? 2 : -20, 300 * uniform(random),
                                  300 * uniform(random), 300 * uniform(random)),
                      10, 1);
    }
    Simulation simulation = simulationFromText(contactScene(
        bodies + "<BarrierContact mstate=\"@a/skin/dofs\" other=\"@b/skin/dofs\" contactDistance=\"0.01\" "
                 "stiffness=\"1e5\"/>",
        0.01));
    bool touched = false;
    for (int i = 0; i < 10; ++i) {
      const StepReport report = simulation.step();
      ASSERT_FALSE(report.diverged) << "pair " << pair << " step " << i << ": " << report.reason;
      ASSERT_TRUE(report.constraints_converged) << "pair " << pair << " step " << i << ": " << report.constraint_reason;
      touched = touched || outputOf(simulation, "smallestGap") > 0;
    }
    met += touched;
  }
  EXPECT_GT(met, 12);
}

/// A tool that is moved farther in a step than its gap to what it meets pushes that before it, and is where its path says:
/// a frame that carries its surface, and nodes.
TEST(MappedSurfaces, WhatIsMovedGoesAllItsWay) {
  const Body tool = boxOf(Vec3(-.2, -.2, -.1), Vec3(.2, .2, .1)), block = boxOf(Vec3(-.5, -.5, 0), Vec3(.5, .5, .5), {3, 3, 2});
  std::string ground, all;
  for (int i = 0; i < 16; ++i) ground += fmt::format("{} ", i);
  for (int i = 0; i < 8; ++i) all += fmt::format("{} ", i);
  const auto path = [](const std::string& nodes) {
    return fmt::format("<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" movements=\"{}\"/>", nodes,
                       nodes == "0" ? "0 0 0 0 0 0  0 0 -2 0.3 0 0" : "0 0 0  0 0 -2");
  };
  Body there = tool;
  there.turn(Mat3::Identity(), Vec3(0, 0, 0.61));
  const std::string soft =
      bodyNode("b", block, "<FixedProjectiveConstraint indices=\"" + ground + "\"/>", "", 1e5, 0.3);
  for (const bool frame : {true, false}) {
    SCOPED_TRACE(frame);
    const std::string moved = frame ? rigid("a", tool, "position=\"0 0 0.61  0 0 0 1\"", 1, 1, path("0"))
                                    : bodyNode("a", there, path(all));
    Simulation simulation = simulationFromText(contactScene(
        moved + soft + fmt::format("<BarrierContact mstate=\"@b/dofs\" other=\"@a/{}dofs\" contactDistance=\"0.02\"/>",
                                   frame ? "skin/" : ""),
        0.02));
    const State& driven = stateAt(simulation, frame ? "/a/frame" : "/a/dofs");
    const double start = driven.x()[0].z();
    for (int i = 1; i <= 3; ++i) {
      expectCleanStep(simulation, i, false);
      EXPECT_NEAR(driven.x()[0].z(), start - 0.04 * i, 1e-9) << "step " << i;
    }
    EXPECT_GT(numbersOf(simulation, "wrenches")[8], 10) << "the block resists";
  }
}

/// Points of a sheet that are nearer than its thickness at rest do not stop it.
TEST(MappedSurfaces, AThickSheetFlies) {
  std::string positions, triangles, velocity;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) {
      positions += fmt::format("{} {} 0  ", 0.1 * i, 0.1 * j), velocity += "1 2 3  ";
      if (i < 4 && j < 4) {
        const int a = 5 * i + j;
        triangles += fmt::format("{} {} {}  {} {} {}  ", a, a + 5, a + 6, a, a + 6, a + 1);
      }
    }
  Simulation simulation = simulationFromText(contactScene(
      fmt::format("<Node name=\"a\"><MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/><MechanicalObject "
                  "name=\"dofs\" velocity=\"{}\"/><UniformMass totalMass=\"1\"/><TriangularFEMForceField "
                  "youngModulus=\"1e5\" poissonRatio=\"0.3\"/><BarrierContact thickness=\"0.25\" "
                  "contactDistance=\"0.01\"/></Node>",
                  positions, triangles, velocity),
      0.01));
  for (int i = 0; i < 5; ++i) expectCleanStep(simulation, i);
  EXPECT_NEAR(stateAt(simulation, "/a/dofs").x()[0].z(), 0.15, 1e-9);
}

/// Two sheets with a thickness rest that far apart, and the gap of their pressure more.
TEST(MappedSurfaces, ThicknessAddsToTheGap) {
  const double range = 0.01, thickness = 0.05;
  const Body box = boxOf(Vec3(-.5, -.5, -.25), Vec3(.5, .5, .25), {2, 2, 1});
  Simulation simulation = simulationFromText(contactScene(
      rigid("a", box, "position=\"0 0 0  0 0 0 1\"", 10, 10, "<FixedProjectiveConstraint indices=\"0\"/>") +
          rigid("b", box, fmt::format("position=\"0 0 {}  0 0 0 1\"", 0.5 + thickness + 0.9 * range), 100, 10,
                "<PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"1 1 0 1 1 1\"/>") +
          fmt::format("<BarrierContact mstate=\"@a/skin/dofs\" other=\"@b/skin/dofs\" contactDistance=\"{}\" "
                      "thickness=\"{}\" stiffness=\"9810\"/>",
                      range, thickness),
      0.05, Vec3(0, 0, -9.81)));
  for (int i = 0; i < 60; ++i) expectCleanStep(simulation, i, false);
  EXPECT_NEAR((stateAt(simulation, "/b/frame").x()[0].z() - 0.5 - thickness) / range, 0.8285, 2e-3);
  const std::vector<double> wrenches = numbersOf(simulation, "wrenches");
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(wrenches[std::size_t(k)], -wrenches[std::size_t(k + 6)], 1e-6 * 981);
}

/// A prism of 64 sides whose sides lie within and whose corners lie outside of the cylinder by 0.0006 of the radius.
TEST(MappedSurfaces, ACylinderIsRound) {
  for (const double angle : {0., 0.3, 1.1}) {
    Body tip{{{0, 0, 0}, {-.2, -.2, 1}, {.2, -.2, 1}, {0, .3, 1}}, {{0, 1, 2, 3}}};
    tip.turn(Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix(), Vec3::Zero());
    const Vec3 out = Vec3(std::sin(angle), 0, std::cos(angle)) * 1.005;
    tip.turn(Mat3::Identity(), out);
    Simulation simulation = simulationFromText(contactScene(bodyNode(
        "a", tip, "<BarrierContact name=\"contact\" stiffness=\"1e-6\" contactDistance=\"0.02\" cylinders=\"0 -2 0  0 2 0  1\"/>")));
    expectCleanStep(simulation, 1, false);
    EXPECT_NEAR(outputOf(simulation, "smallestGap"), 0.005, 0.0008) << angle;
  }
}

/// What one solve with the forces of the step before leaves is said, and more solves bring it down.
TEST(MappedSurfaces, FrictionThatHasNotSettledIsSaid) {
  for (const int solves : {1, 100}) {
    const Body box = boxOf(Vec3(-.5, -.5, -.05), Vec3(.5, .5, .05));
    Simulation simulation = simulationFromText(contactScene(
        rigid("tool", box, "position=\"0 0 0.1  0 0 0 1\" velocity=\"3 0 -3  0 0 0\"", 100, 10) +
            fmt::format("<BarrierContact mstate=\"@tool/skin/dofs\" planes=\"0 0 1 0\" contactDistance=\"0.02\" "
                        "stiffness=\"1e5\" friction=\"0.2\" frictionIterations=\"{}\"/>",
                        solves),
        0.02, Vec3(0, 0, -9.81)));
    for (int i = 0; i < 6; ++i) expectCleanStep(simulation, i, false);
    std::string said;
    for (ForceField* field : simulation.systems()[0]->forceFields()) said += field->doubt(simulation.systems()[0]->x);
    if (solves == 1)
      expectContains(said, "had not settled");
    else
      EXPECT_EQ(said, "");
  }
}

struct CountsMaps final : SpanListener {
  CountsMaps() { span_listener = this; }
  ~CountsMaps() override { span_listener = nullptr; }
  void begin(const char* what, const Component*) override { maps += std::string_view(what) == "map"; }
  void end(long) override {}
  std::atomic<long> maps = 0;
};

/// A tool comes down on a block. Until it touches, products of the solves leave out its mapping, and with forces of constraint always.
/// A load of zero on the tool keeps the mapping in: what follows differs by round-off, which grows where things touch.
TEST(MappedSurfaces, ProductsLeaveOutWhatDoesNotAct) {
  for (const std::string contact : {"BarrierContact", "ConstraintContact"}) {
    const auto scene = [&contact](const std::string& load) {
      const std::string tool = rigid("tool", boxOf(Vec3(-.2, -.2, -.1), Vec3(.2, .2, .1)),
                                     "position=\"0.5 0.5 1.25  0 0 0 1\" velocity=\"0 0 -1.5  0.3 0 0\"", 100, 1);
      std::string text = contactScene(
          bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), "<FixedProjectiveConstraint indices=\"0 1 2 3\"/>") + tool +
              fmt::format("<{} name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@tool/skin/dofs\" "
                          "contactDistance=\"0.02\"/>",
                          contact),
          0.01, Vec3(0, 0, -1));
      text.replace(text.find("<SparseLDLSolver/>"), 18,  // products, where it would otherwise choose a matrix
                   "<CGLinearSolver template=\"GraphScattered\" iterations=\"400\" tolerance=\"1e-10\"/>");
      text.replace(text.find("<RigidMapping/>"), 0, load);
      return simulationFromText(text);
    };
    Simulation without = scene(""), with = scene("<ConstantForceField indices=\"0\" forces=\"0 0 0\"/>");
    const auto mapsOfStep = [](Simulation& simulation, int i) {
      const CountsMaps counts;
      expectCleanStep(simulation, i, false);
      return counts.maps.load();
    };
    long first = 0, last = 0;  // where nothing touches, and when something did last
    bool has_met = false;
    for (int i = 0; i < 20; ++i) {
      const long less = mapsOfStep(without, i), more = mapsOfStep(with, i);
      const std::string place = contact == "BarrierContact" ? "smallestGap" : "forces";
      bool meets = false;
      for (Component* each : without.systems()[0]->components())
        if (each->type() == contact) meets = each->data().find(place)->print().find_first_of("123456789") != std::string::npos;
      if (i == 0) first = less;
      if (i == 0 || contact == "ConstraintContact") EXPECT_LT(2 * less, more) << contact << ", step " << i;
      if (meets) last = less;
      has_met = has_met || meets;
      const Vector &x = without.systems()[0]->x, &same = with.systems()[0]->x;
      EXPECT_LT(distance(x, same), has_met ? 1e-6 : 1e-11) << contact << ", step " << i;
    }
    ASSERT_TRUE(has_met) << contact;
    if (contact == "BarrierContact") EXPECT_GT(last, 3 * first) << "what is pushed is in the products";
  }
}

/// Where no force acts on what is carried, none is handed on; any other is, however small.
TEST(MappedSurfaces, NoForceIsNotPulledBack) {
  Simulation simulation = simulationFromText(contactScene(
      rigid("tool", boxOf(Vec3(-.2, -.2, -.1), Vec3(.2, .2, .1)), "position=\"0.5 0.5 1.25  0 0 0 1\"", 100, 1) +
          "<BarrierContact mstate=\"@tool/skin/dofs\" topology=\"@tool/skin/mesh\" planes=\"0 0 1 0\" contactDistance=\"0.02\" "
          "stiffness=\"1e4\"/>",
      0.01, Vec3::Zero()));
  System& system = *simulation.systems()[0];
  const auto mapsOf = [](const auto& what) {
    const CountsMaps counts;
    what();
    return counts.maps.load();
  };
  EXPECT_EQ(mapsOf([&] { system.computeForce(system.x, system.v, system.f); }), 2) << "places and velocities";
  Vector forces(system.allRows());
  EXPECT_EQ(mapsOf([&] { system.mappingChain().pullBack(forces); }), 0);
  for (const double size : {1e-300, std::numeric_limits<double>::quiet_NaN()}) {
    clear(forces);
    forces[system.allRows() - 1] = Vec3(0, 0, size);
    EXPECT_EQ(mapsOf([&] { system.mappingChain().pullBack(forces); }), 1) << size;
    EXPECT_TRUE(forces[0].z() == size || std::isnan(forces[0].z())) << size;
  }
}

/// Of a way that mappings bend, its middle and its ends are placed; where what they follow stays, its start and its direction are enough.
TEST(MappedSurfaces, AWayIsPlacedInPartsWhereItBends) {
  const std::string tool = rigid("tool", boxOf(Vec3(-.2, -.2, -.1), Vec3(.2, .2, .1)), "position=\"0.5 0.5 1.25  0 0 0 1\"", 100, 1);
  Simulation simulation = simulationFromText(contactScene(
      bodyNode("a", boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1), {2, 2, 2}), "<FixedProjectiveConstraint indices=\"0 1 2 3\"/>") + tool +
          "<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@tool/skin/dofs\" contactDistance=\"0.02\"/>",
      0.01, Vec3::Zero()));
  expectCleanStep(simulation, 0, false);
  System& system = *simulation.systems()[0];
  StepLimits limits;
  limits.compile(system);
  Vector way(system.independentRows()), before(system.allRows());
  copy(system.x, before);
  const auto rise = [&](double height) {
    for (const State* state : system.states())
      if (state->path() == "/a/dofs")
        for (Index i = 0; i < state->size(); ++i) way[state->firstRow() + i] = Vec3(0, 0, height);
  };
  const auto ask = [&](long& placings) {
    const CountsMaps counts;
    const double longest = limits.longest(way);
    placings = counts.maps.load();
    return longest;
  };
  long placings = 0;
  rise(0.6);
  const double straight = ask(placings);
  EXPECT_NEAR(straight, 0.15 / 0.6, 0.03);
  EXPECT_EQ(placings, 2);
  for (const State* state : system.states())
    if (state->hasFrames() && state->firstRow() < system.independentRows()) way[state->firstRow() + 1] = Vec3(1e-7, 0, 0);
  const double bent = ask(placings);
  EXPECT_LT(bent, straight + 1e-5);
  EXPECT_GT(bent, 0.8 * straight);
  rise(0.05);
  EXPECT_EQ(ask(placings), 1);
  EXPECT_EQ(placings, 3);
  EXPECT_EQ(distance(system.x, before), 0);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
