// SPDX-License-Identifier: LGPL-2.1-or-later
// What a surface counts for: where more than two triangles share an edge, where pieces share a vertex alone, of quadratic
// cells; the stiffness that is taken when none is given.
#include <Eigen/Geometry>
#include <cmath>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/state_topology.h"
#include "tests/contact/contact_scenes.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace contact;

/// A tetrahedron with its tip at a height above a point (x, 0, 0) of a sheet; the force on the tip.
Vec3 forceOnTip(double x, const std::string& positions, const std::string& triangles) {
  const double range = 0.2, height = 0.1;
  const Body a{{{x, 0, height}, {x - .3, -.2, 1}, {x + .3, -.2, 1}, {x, .3, 1}}, {{0, 1, 2, 3}}};
  FieldUnderTest t(contactScene(bodyNode("a", a, "") +
                                fmt::format("<Node name=\"b\"><MeshTopology name=\"mesh\" position=\"{}\" triangles=\"{}\"/>"
                                            "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/></Node>",
                                            positions, triangles) +
                                fmt::format(fmt::runtime(between),
                                            fmt::format("contactDistance=\"{}\" stiffness=\"1000\" selfContact=\"0\"", range))),
                   "BarrierContact");
  const Vector f = t.force();
  return f[0];
}

/// Above an edge of three triangles one of them counts, as above an edge of two.
TEST(Surfaces, AFinUnderASheetAddsNothing) {
  const std::string places = "-1 0 0  1 0 0  0 -1.5 0  0 1.5 0  0 0 -1";
  const Vec3 without = forceOnTip(0.1, places, "0 1 2  1 0 3"), with = forceOnTip(0.1, places, "0 1 2  1 0 3  0 1 4");
  EXPECT_GT(without.z(), 1);
  EXPECT_LT((with - without).norm(), 1e-9 * without.norm());
}

/// Above a vertex in which two triangles meet without an edge. The tip stands for a third of its triangles' area seen from
/// below, 0.15/3, the vertex of the sheet for a third of 0.09 of each triangle, and half of both counts.
TEST(Surfaces, TrianglesThatShareAVertexCountOnce) {
  const std::string places = "0 0 0  .3 -.3 0  .3 .3 0  -.3 .3 0  -.3 -.3 0";
  const double one = forceOnTip(0, places, "0 1 2").z(), two = forceOnTip(0, places, "0 1 2  0 3 4").z();
  EXPECT_GT(one, 1);
  EXPECT_NEAR(two / one, (0.15 + 2 * 0.09) / (0.15 + 0.09), 1e-9);
}

/// The boundary of cells says what is outside, also where two of its parts share an edge.
TEST(Surfaces, OfCellsHaveOneSideAlsoAtAnEdgeOfFourTriangles) {
  const Body two{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                 {{0, 1, 2, 3}, {0, 1, 4, 5}}};  // on both sides of the edge from 0 to 1
  const Simulation simulation = simulationFromText(contactScene(bodyNode("a", two, "")));
  Surfaces surfaces;
  const State& state = *simulation.states()[0];
  surfaces.addState(state, topologyOf(state)->mesh());
  surfaces.finish();
  ASSERT_EQ(surfaces.faces.size(), 8u);
  EXPECT_TRUE(surfaces.isOneSided(0));
  int most = 0;
  for (const int surplus : surfaces.edge_surplus) most = std::max(most, surplus);
  EXPECT_EQ(most, 3);
}

/// A body of quadratic tetrahedra has a surface, and rests on a plane with its weight.
TEST(Surfaces, OfQuadraticCellsMeetToo) {
  Simulation simulation = simulationFromText(contactScene(
      "<RegularGridTopology name=\"grid\" n=\"3 3 2\" min=\"0 0 0.019\" max=\"1 1 0.519\"/><Node name=\"a\">"
      "<Hexa2TetraTopologicalMapping name=\"tetrahedra\" input=\"@../grid\" swapping=\"true\"/>"
      "<Linear2QuadraticTopologicalMapping name=\"mesh\" input=\"@tetrahedra\"/><MechanicalObject name=\"dofs\" src=\"@mesh\"/>"
      "<UniformMass totalMass=\"20\"/><QuadraticTetrahedronFEMForceField topology=\"@mesh\" youngModulus=\"1e6\" "
      "poissonRatio=\"0.3\"/><BarrierContact name=\"contact\" topology=\"@mesh\" planes=\"0 0 1 0\" contactDistance=\"0.02\" "
      "stiffness=\"1e5\"/></Node>",
      0.05, Vec3(0, 0, -9.81)));
  for (int i = 0; i < 60; ++i) expectCleanStep(simulation, i, false);
  EXPECT_GT(outputOf(simulation, "smallestGap"), 0);
  EXPECT_NEAR(numbersOf(simulation, "wrenches")[2], 20 * 9.81, 0.02 * 20 * 9.81);
}

/// kappa is a tenth of the Young's modulus of the hardest body, whichever it is: under a thousandth of that the gap is 0.9819.
TEST(Surfaces, StiffnessIsThatOfTheHardestBody) {
  const double range = 0.02, young[2] = {1e5, 1e7}, pressure = 1e3;
  for (const int soft : {0, 1}) {
    const double start = 0.5 + 0.99 * range;
    const Body low = boxOf(Vec3(0, 0, 0), Vec3(1, 1, 0.5)), high = boxOf(Vec3(0, 0, start), Vec3(1, 1, start + 0.5));
    const std::string held = "<FixedProjectiveConstraint indices=\"0 1 2 3\"/><PartialFixedProjectiveConstraint "
                             "indices=\"4 5 6 7\" fixedDirections=\"1 1 0\"/>";
    const std::string upright = "<PartialFixedProjectiveConstraint indices=\"0 1 2 3 4 5 6 7\" fixedDirections=\"1 1 0\"/>";
    const std::string load =
        fmt::format("<SurfacePressureForceField pressure=\"{}\" min=\"-1 -1 0.99\" max=\"2 2 2\"/>", -pressure);
    Simulation simulation = simulationFromText(contactScene(
        bodyNode("a", low, held, "", young[soft], 0) + bodyNode("b", high, upright + load, "", young[1 - soft], 0) +
            fmt::format(fmt::runtime(between), fmt::format("contactDistance=\"{}\"", range)),
        1, Vec3::Zero(), "<StaticSolver/>"));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_NEAR(outputOf(simulation, "smallestGap") / range, 0.9819, 1e-4) << "mstate has " << young[soft];
  }
}

TEST(Surfaces, ABarrierPushesAlsoWhereItHasNoBound) {
  const Barrier touching(0, 1), near(1e-9, 1);
  EXPECT_LT(near.slope, 0);
  EXPECT_EQ(touching.slope, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(touching.value, std::numeric_limits<double>::infinity());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
