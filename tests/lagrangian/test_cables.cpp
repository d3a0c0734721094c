// SPDX-License-Identifier: LGPL-2.1-or-later
// Cables against closed forms: tension and length do not depend on the time step, and stay within their bounds.
#include <fstream>
#include <iterator>

#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

/// Springs of 100 N/m against a cable that is pulled by 0.1 m: 10 N, and the other way round, with any step.
TEST(Cables, ACableHasOneTensionWithAnyStep) {
  for (const double dt : {1e-1, 1e-2, 1e-3})
    for (const char* type : {"displacement", "force"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      Simulation simulation = simulationFromText(sceneOf(
          fmt::format("<MechanicalObject position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"3\"/>"
                      "<RestShapeSpringsForceField stiffness=\"100\"/><CableConstraint indices=\"1 2\" pullPoint=\"-1 0 0\" "
                      "valueType=\"{}\" value=\"{}\"/>",
                      type, type[0] == 'd' ? 0.1 : 10),
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"10\"/>"));
      run(simulation, int(std::lround(4 / dt)));
      EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "force").at(0), 10, 1e-6);
      EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "displacement").at(0), 0.1, 1e-8);
      EXPECT_NEAR(at(simulation, 2).x(), 1.9, 1e-8);
      EXPECT_NEAR(at(simulation, 1).x(), 1, 1e-8) << "the cable slides through it";
    }
}

/// A cable that cannot push hangs loose where its body comes nearer by itself.
TEST(Cables, ACableDoesNotPushWhereItMayNot) {
  Simulation simulation =
      simulationFromText(sceneOf("<MechanicalObject position=\"1 0 0\" velocity=\"-1 0 0\"/><UniformMass totalMass=\"1\"/>"
                                 "<CableConstraint indices=\"0\" pullPoint=\"0 0 0\" value=\"0\" minForce=\"0\"/>",
                                 0.01, "0 0 0"));
  run(simulation, 10);
  EXPECT_NEAR(at(simulation, 0).x(), 0.9, 1e-12);
  EXPECT_EQ(numbersOf(simulation, "CableConstraint", "force").at(0), 0);
}

/// L_0 = 2 m by rest positions: a body that starts at 1 m hangs loose. A mapped point, written as (0.5 0 0) in the axes of its
/// frame, is measured where it is.
TEST(Cables, TheFirstLengthIsThatOfTheRestShape) {
  Simulation loose = simulationFromText(
      sceneOf("<MechanicalObject position='1 0 0' rest_position='2 0 0' velocity='-1 0 0'/><UniformMass totalMass='1'/>"
              "<CableConstraint indices='0' pullPoint='0 0 0' value='0'/>",
              0.01, "0 0 0"));
  run(loose, 1);
  EXPECT_NEAR(at(loose, 0).x(), 2, 1e-10);
  Simulation mapped = simulationFromText(
      sceneOf("<MechanicalObject template='Rigid3' position='10 0 0 0 0 0 1'/><UniformMass totalMass='1' inertia='1 1 1'/>"
              "<Node name='m'><MechanicalObject name='tip' position='0.5 0 0'/><RigidMapping/>"
              "<CableConstraint name='cable' indices='0' pullPoint='0 0 0' value='0'/></Node>",
              0.01, "0 0 0"));
  run(mapped, 2);
  EXPECT_NEAR(at(mapped, 0).x(), 10, 1e-10);
}

/// Where it is pulled may move: the cable keeps its length, and what it is pulled by follows.
TEST(Cables, APullPointThatMovesPulls) {
  Simulation simulation = simulationFromText(
      sceneOf("<MechanicalObject position=\"1 0 0\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField stiffness=\"10\"/>"
              "<CableConstraint name=\"cable\" indices=\"0\" pullPoint=\"0 0 0\" value=\"0\"/>",
              1, "0 0 0", "<EulerImplicitSolver rayleighMass=\"5\"/>"));
  run(simulation, 3);
  simulation.setAttribute("/cable", "pullPoint", "-0.25 0 0");
  run(simulation, 60);
  EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "cableInitialLength").at(0), 1, 1e-14);
  EXPECT_NEAR(at(simulation, 0).x(), 0.75, 1e-9);
  EXPECT_NEAR(numbersOf(simulation, "CableConstraint", "force").at(0), 2.5, 1e-6);
}

/// A cable beside the axis of a beam, drawn in by `pull` [m].
std::string bentBeam(double pull, double dt, const std::string& solver) {
  return sceneOf(
      fmt::format("<RegularGridTopology n=\"9 3 3\" min=\"0 0 0\" max=\"0.1 0.02 0.02\"/><MechanicalObject/><UniformMass "
                  "totalMass=\"0.04\"/><HexahedronFEMForceField method=\"svd\" youngModulus=\"1e5\" poissonRatio=\"0.3\"/>"
                  "<FixedProjectiveConstraint indices=\"0 9 18 27 36 45 54 63 72\"/><CableConstraint "
                  "indices=\"64 65 66 67 68 69 70 71\" pullPoint=\"-0.01 0.01 0.02\" value=\"{}\" minForce=\"0\"/>",
                  pull),
      dt, "0 0 0", solver);
}

/// It is bent by more than its thickness, in one step of a second as in statics.
TEST(Cables, ABeamIsBentByTheSameForceInStepsOfAnyLength) {
  double expected = 0;
  const std::string euler = "<EulerImplicitSolver newtonIterations=\"40\" newtonTolerance=\"1e-10\"/>";
  struct Case {
    std::string solver;
    double dt;
    int steps;
  };
  for (const Case& c : {Case{"<StaticSolver newton_iterations=\"100\"/>", 1, 1}, Case{euler, 1, 20}, Case{euler, 0.1, 60},
                        Case{"<EulerImplicitSolver/>", 1, 20}}) {
    SCOPED_TRACE(fmt::format("{}, dt {}", c.solver, c.dt));
    Simulation simulation = simulationFromText(bentBeam(0.005, c.dt, c.solver));
    run(simulation, c.steps);
    if (testing::Test::HasFatalFailure()) return;
    const double force = numbersOf(simulation, "CableConstraint", "force").at(0);
    if (expected == 0) expected = force;
    EXPECT_NEAR(force, expected, 1e-6 * expected);
    EXPECT_GT(at(simulation, 71).z(), 0.03) << "it is bent";
  }
}

/// A bar of nu = 0 along x under four cables at the corners of its end: E A u / L, a quarter each, with any step.
TEST(Cables, CablesShortenABar) {
  constexpr double young = 1000, length = 3, shortening = 0.05, tension = young * shortening / length / 4;
  for (const double dt : {1e-1, 1e-2, 1e-3, 1e-4})
    for (const char* type : {"displacement", "force"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      std::string cables;
      for (int corner = 0; corner < 4; ++corner)
        cables += fmt::format("<CableConstraint indices=\"{}\" pullPoint=\"-1 {} {}\" valueType=\"{}\" value=\"{}\"/>",
                              3 + 4 * corner, corner % 2, corner / 2, type, type[0] == 'd' ? shortening : tension);
      Simulation simulation = simulationFromText(sceneOf(
          "<RegularGridTopology n=\"4 2 2\" min=\"0 0 0\" max=\"3 1 1\"/><MechanicalObject/><UniformMass totalMass=\"0.01\"/>"
          "<HexahedronFEMForceField method=\"small\" youngModulus=\"1000\" poissonRatio=\"0\"/>"
          "<FixedProjectiveConstraint indices=\"0 4 8 12\"/>" +
              cables,
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"600\"/>"));
      run(simulation, std::max(30, int(std::lround(0.15 / dt))));
      for (const double found : numbersOf(simulation, "CableConstraint", "force")) EXPECT_NEAR(found, tension, 1e-8 * tension);
      for (const double found : numbersOf(simulation, "CableConstraint", "displacement")) EXPECT_NEAR(found, shortening, 1e-10);
      EXPECT_NEAR(at(simulation, 1).x(), 1 - shortening / 3, 1e-9) << "the strain is the same everywhere";
    }
}

/// A tendon at the height e above a cantilever: its tension has the moment T e at the tip, which turns by T e L / EI.
TEST(Cables, ATendonBendsABeam) {
  constexpr double young = 1e9, radius = 0.01, e = 0.02, tension = 1e-3;
  const double inertia = M_PI * std::pow(radius, 4) / 4;
  std::string frames, edges, points, order;
  constexpr int n = 10;
  for (int i = 0; i <= n; ++i) {
    frames += fmt::format("{} 0 0  0 0 0 1  ", 0.1 * i);
    points += fmt::format("0 {} 0  ", e), order += fmt::format("{} ", i);
    if (i < n) edges += fmt::format("{} {}  ", i, i + 1);
  }
  Simulation simulation = simulationFromText(sceneOf(
      fmt::format(
          "<MeshTopology edges=\"{}\"/><MechanicalObject template=\"Rigid3\" position=\"{}\"/><UniformMass totalMass=\"0.1\" "
          "inertia=\"1e-5 1e-5 1e-5\"/><BeamFEMForceField youngModulus=\"{}\" poissonRatio=\"0.3\" radius=\"{}\"/>"
          "<FixedProjectiveConstraint indices=\"0\"/><Node name=\"tendon\"><MechanicalObject position=\"{}\"/>"
          "<RigidMapping rigidIndexPerPoint=\"{}\"/><CableConstraint indices=\"{}\" hasPullPoint=\"0\" valueType=\"force\" "
          "value=\"{}\"/></Node>",
          edges, frames, young, radius, points, order, order, tension),
      1, "0 0 0"));
  run(simulation, 40);
  const double turn = 2 * std::asin(simulation.states()[0]->x().data[std::size_t(2 * n + 1) * row_doubles + 2]);
  const double expected = tension * e / (young * inertia);
  EXPECT_NEAR(turn, expected, 1e-3 * expected);
  EXPECT_GT(turn, 0);
}

/// A point that a soft transverse pair of springs holds, geometrically not linear: T = 2 k (l - l_0) x / l. Newton's method finds
/// that rest state with any step, by force and by displacement.
TEST(Cables, NewtonsMethodFindsTheSameRestWithAnyStep) {
  constexpr double k = 100, rest = 0.5, x = 0.7;
  const double l = std::hypot(1, x), tension = 2 * k * (l - rest) * x / l;
  for (const double dt : {1.0, 1e-1, 1e-2})
    for (const char* type : {"displacement", "force"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      Simulation simulation = simulationFromText(sceneOf(
          fmt::format(
              "<MechanicalObject position=\"0 1 0  0 0 0  0 -1 0\"/><UniformMass totalMass=\"3\"/><FixedProjectiveConstraint "
              "indices=\"0 2\"/><SpringForceField springsIndices1=\"0 1\" springsIndices2=\"1 2\" lengths=\"{} {}\" "
              "stiffness=\"{} {}\"/><CableConstraint indices=\"1\" pullPoint=\"2 0 0\" valueType=\"{}\" value=\"{}\"/>",
              rest, rest, k, k, type, type[0] == 'd' ? x : tension),
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"30\" newtonIterations=\"50\" newtonTolerance=\"1e-10\"/>"));
      run(simulation, std::max(60, int(std::lround(6 / dt))));
      EXPECT_NEAR(at(simulation, 1).x(), x, 1e-7);
      EXPECT_NEAR(numberOf(simulation, "CableConstraint", "force"), tension, 1e-6 * tension);
    }
}

/// A soft finger that a cable of half its thickness off the axis bends by almost a radian in four steps: the tension at rest is
/// far above the load under which the finger would buckle. Steps of any size come to the same, with one linear solve or with
/// Newton's method.
TEST(Cables, AFingerBendsTheSameWithAnyStep) {
  std::vector<double> tensions;
  for (const std::string newton : {"", "newtonIterations=\"50\" newtonTolerance=\"1e-9\""})
    for (const double dt : {0.1, 0.02}) {
      SCOPED_TRACE(fmt::format("{} {}", dt, newton));
      Simulation simulation = simulationFromText(sceneOf(
          "<RegularGridTopology name=\"grid\" n=\"9 3 3\" min=\"0 -0.01 -0.01\" max=\"0.08 0.01 0.01\"/><Node name=\"body\">"
          "<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@mesh\" "
          "swapping=\"true\"/><MechanicalObject/><UniformMass totalMass=\"0.03\"/><TetrahedronFEMForceField "
          "youngModulus=\"1e5\" poissonRatio=\"0.3\" method=\"large\"/><BoxROI name=\"base\" box=\"-0.001 -1 -1 0.001 1 1\"/>"
          "<FixedProjectiveConstraint indices=\"@base.indices\"/><CableConstraint indices=\"64 65 66 67 68 69 70 71\" "
          "pullPoint=\"-0.01 0 0.01\" value=\"0.008\" maxDispVariation=\"0.002\"/></Node>",
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"20\" " + newton + "/>"));
      int unconverged = 0;
      for (int i = 0; i < std::lround(3 / dt); ++i) {
        const StepReport report = simulation.step();
        ASSERT_FALSE(report.failed()) << report.reason;
        ASSERT_TRUE(report.constraints_converged) << report.constraint_reason;
        unconverged += !report.newton_converged;
      }
      EXPECT_EQ(unconverged, 0);
      EXPECT_NEAR(numberOf(simulation, "CableConstraint", "displacement"), 0.008, 1e-10);
      tensions.push_back(numberOf(simulation, "CableConstraint", "force"));
      EXPECT_NEAR(tensions.back(), tensions.front(), 1e-6 * tensions.front());
    }
  constexpr double young = 1e5, inertia = 0.02 * 0.02 * 0.02 * 0.02 / 12, length = 0.08;
  EXPECT_GT(tensions[0], 2 * M_PI * M_PI * young * inertia / (4 * length * length)) << "twice the load of Euler";
}

/// The stitch of the example: short pieces of a cable turn much within a step, which must not swing from one to the next.
TEST(Cables, AStitchComesToRestWithAnyStep) {
  std::ifstream file(STROMA_SOURCE_DIR "/scenes/examples/suture.xml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_NE(text.find("dt=\"0.02\""), std::string::npos);
  double first = 0;
  for (const double dt : {0.02, 0.005}) {
    std::string scene = text;
    scene.replace(scene.find("dt=\"0.02\""), 9, fmt::format("dt=\"{}\"", dt));
    Simulation simulation = simulationFromText(scene);
    run(simulation, int(std::lround(1.6 / dt)));
    const double found = numberOf(simulation, "CableConstraint", "displacement");
    if (first == 0) first = found;
    EXPECT_NEAR(found, first, 1e-8);
    for (Index node = 0; node < 12; ++node) EXPECT_LT(simulation.states()[0]->v()[node].norm(), 1e-6) << node;
    for (const double force : numbersOf(simulation, "SlidingLagrangianConstraint", "forces")) EXPECT_NEAR(force, 0, 1e-6);
  }
  EXPECT_GT(first, 0.03);
}

struct Limit {
  const char* attributes;
  double force, way;  ///< expected
};

/// A spring of 100 N/m: what is imposed gives way where a bound is met, and both stay on the line f = 100 s.
TEST(Cables, ACableStaysWithinItsBounds) {
  for (const Limit& limit : std::initializer_list<Limit>{
           {"value=\"0.1\" maxForce=\"5\"", 5, 0.05},
           {"value=\"0.1\" maxForce=\"50\"", 10, 0.1},
           {"value=\"0\" minForce=\"2\"", 2, 0.02},
           {"value=\"0.1\" minForce=\"2\" maxForce=\"5\"", 5, 0.05},
           {"value=\"0.03\" minForce=\"2\" maxForce=\"5\"", 3, 0.03},
           {"value=\"0.01\" minForce=\"2\" maxForce=\"5\"", 2, 0.02},
           {"value=\"-0.1\" minForce=\"0\"", 0, 0},
           {"value=\"0.1\" minForce=\"4\" maxForce=\"4\"", 4, 0.04},
           {"value=\"-0.1\" maxForce=\"-3\"", -10, -0.1},
           {"value=\"0.1\" maxPositiveDisp=\"0.04\"", 4, 0.04},
           {"value=\"-0.1\" maxNegativeDisp=\"0.04\"", -4, -0.04},
           {"value=\"0 0.1\" valueIndex=\"1\" cableInitialLength=\"1.95\"", 15, 0.1},
           {"valueType=\"force\" value=\"10\" maxForce=\"6\"", 6, 0.06},
           {"valueType=\"force\" value=\"-10\" minForce=\"-6\"", -6, -0.06},
           {"valueType=\"force\" value=\"0.2\" impulses=\"1\"", 10, 0.1},
           {"value=\"0.1\" maxForce=\"0.1\" impulses=\"1\"", 5, 0.05},
           {"valueType=\"force\" value=\"10\" maxPositiveDisp=\"0.03\"", 3, 0.03},
           {"valueType=\"force\" value=\"-10\" maxNegativeDisp=\"0.03\" maxPositiveDisp=\"0.02\"", -3, -0.03}}) {
    SCOPED_TRACE(limit.attributes);
    Simulation simulation = simulationFromText(
        sceneOf(fmt::format("<MechanicalObject position=\"1 0 0\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField "
                            "stiffness=\"100\"/><CableConstraint indices=\"0\" pullPoint=\"-1 0 0\" {}/>",
                            limit.attributes),
                0.02, "0 0 0", "<EulerImplicitSolver rayleighMass=\"10\"/>"));
    run(simulation, 300);
    const bool are_impulses = std::string(limit.attributes).find("impulses") != std::string::npos;
    EXPECT_NEAR(numberOf(simulation, "CableConstraint", "force"), limit.force * (are_impulses ? 0.02 : 1), 1e-6);
    EXPECT_NEAR(numberOf(simulation, "CableConstraint", "displacement"), limit.way, 1e-8);
    EXPECT_NEAR(1 - at(simulation, 0).x(), limit.force / 100, 1e-8);
  }
}

/// The imposed displacement, growth and pressure change by so much in a step and no more.
TEST(Cables, WhatIsImposedMayChangeSlowly) {
  Simulation simulation = simulationFromText(sceneOf(
      "<MechanicalObject position=\"1 0 0\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField stiffness=\"100\"/>"
      "<CableConstraint indices=\"0\" pullPoint=\"-1 0 0\" value=\"0.05\" maxDispVariation=\"0.01\"/>",
      0.02, "0 0 0"));
  for (int i = 1; i < 8; ++i) {
    run(simulation, 1);
    EXPECT_NEAR(numberOf(simulation, "CableConstraint", "displacement"), std::min(0.01 * i, 0.05), 1e-12);
  }
}

TEST(Cables, WhatCannotBeMeantIsRefused) {
  const auto problem = [](const std::string& constraint) {
    return problemsOf(
        sceneOf("<MechanicalObject position=\"0 0 0  1 0 0  0 1 0  0 0 1\"/><UniformMass totalMass=\"4\"/>" + constraint));
  };
  const auto cable = [&](const std::string& more) { return problem("<CableConstraint " + more + "/>"); };
  const auto cavity = [&](const std::string& more) { return problem("<SurfacePressureConstraint " + more + "/>"); };
  expectContains(cable("indices=\"1\" value=\"1 2\" valueIndex=\"2\""), "valueIndex is 2, and value has 2 numbers");
  expectContains(cable("indices=\"1\" minForce=\"3\" maxForce=\"2\""), "the least force is 3 and the largest 2");
  expectContains(cable("indices=\"1 1\""), "indices has point 1 twice in a row");
  expectContains(cable("indices=\"1\" method=\"sphere\""), "method is sphere");
  expectContains(cable("indices=\"1\" valueType=\"length\""), "expected one of: displacement, force");
  expectContains(cable("indices=\"1\" hasPullPoint=\"0\""), "the cable has no length");
  expectContains(cable("indices=\"1\" object2=\"@.\""), "object2");
  expectContains(cavity("triangles=\"0 1 2\" valueType=\"volumeGrowth\" value=\"1\""),
                 "the surface has no volume: at the edge of nodes");
  expectContains(cavity("triangles=\"0 1 2\" maxVolumeGrowth=\"1\" value=\"1\""), "the surface has no volume");
  expectContains(cavity("triangles=\"0 2 1  0 1 3  0 3 2  1 3 2\" valueType=\"volumeGrowth\""), "turned the other way");
  EXPECT_EQ(cavity("triangles=\"0 2 1  0 1 3  0 3 2  1 2 3\" valueType=\"volumeGrowth\" value=\"0.1\""), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
