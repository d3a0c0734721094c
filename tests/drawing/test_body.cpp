// SPDX-License-Identifier: LGPL-2.1-or-later
// What of a scene is drawn: closed surfaces that face outwards, cells behind their faces, nodes numbered from the surface in.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/scene_fixture.h"
#include "tools/drawing/body.h"
#include "tools/drawing/held_nodes.h"

namespace stroma::drawing {
namespace {

using test::simulationFromText;

std::string block(const std::string& cells, const std::string& more = "") {
  return "<Node name=\"root\" dt=\"0.01\"><Node name=\"block\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<RegularGridTopology name=\"grid\" n=\"4 3 5\" min=\"0 0 0\" max=\"3 2 4\"/><MechanicalObject name=\"dofs\"/>"
         "<UniformMass totalMass=\"1\"/>" +
         cells + more + "</Node></Node>";
}
const std::string hexahedra = "<HexahedronFEMForceField youngModulus=\"1000\" poissonRatio=\"0.3\"/>";
const std::string tetrahedra =
    "<TetrahedronSetTopologyContainer name=\"tetras\"/><Hexa2TetraTopologicalMapping input=\"@grid\" "
    "output=\"@tetras\"/>"
    "<TetrahedronFEMForceField youngModulus=\"1000\" poissonRatio=\"0.3\"/>";

Vec3 restOf(const Body& body, Index page) {
  return body.state->rest_position[std::size_t(body.node[std::size_t(page)])];
}

/// By the divergence theorem, positive when the faces look outwards.
double enclosedVolume(const Body& body) {
  double volume = 0;
  for (const Triangle& face : body.triangles)
    volume += restOf(body, face[0]).dot(restOf(body, face[1]).cross(restOf(body, face[2]))) / 6;
  return volume;
}

template <class Cell>
bool hasFace(const Cell& cell, const Body& body, const Triangle& face) {
  return std::all_of(face.begin(), face.end(), [&](Index page) {
    return std::find(cell.begin(), cell.end(), body.node[std::size_t(page)]) != cell.end();
  });
}

TEST(Bodies, ABlockOfHexahedraHasAClosedSurfaceAndItsInsideComesLast) {
  const Simulation simulation = simulationFromText(block(hexahedra));
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 1u);
  const Body& body = drawing.bodies[0];
  EXPECT_NEAR(enclosedVolume(body), 24, 1e-12);
  EXPECT_EQ(body.triangles.size(), 2u * 2 * (3 * 2 + 3 * 4 + 2 * 4));
  EXPECT_EQ(body.node.size(), 60u);
  EXPECT_EQ(body.surface, 60 - 2 * 1 * 3);
  // Euler's formula for the quads: V - E + F = 2
  EXPECT_EQ(body.surface - Index(body.edges.size()) + Index(body.triangles.size() / 2), 2);
  EXPECT_TRUE(body.points.empty());
  for (std::size_t i = 0; i < body.triangles.size(); ++i) {
    EXPECT_TRUE(hasFace(body.mesh->hexahedra[std::size_t(body.owner[i])], body, body.triangles[i])) << i;
    for (const Index page : body.triangles[i]) EXPECT_LT(page, body.surface);
  }
  for (Index page = 0; page < Index(body.node.size()); ++page)
    EXPECT_EQ(body.page[std::size_t(body.node[std::size_t(page)])], page);
}

/// Each face of six nodes is four triangles, and each half of an edge a line.
TEST(Bodies, QuadraticTetrahedraAreDrawnWithTheirCurves) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><RegularGridTopology name=\"grid\" n=\"3 2 2\" min=\"0 0 0\" max=\"3 2 4\"/>"
      "<Node name=\"body\"><EulerImplicitSolver/><CGLinearSolver/><Hexa2TetraTopologicalMapping name=\"tets\" "
      "input=\"@../grid\"/><Linear2QuadraticTopologicalMapping name=\"mesh\" input=\"@tets\"/>"
      "<MechanicalObject src=\"@mesh\"/><UniformMass totalMass=\"1\"/><QuadraticTetrahedronFEMForceField "
      "youngModulus=\"1000\" poissonRatio=\"0.3\" topology=\"@mesh\"/></Node></Node>");
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 1u);
  const Body& body = drawing.bodies[0];
  EXPECT_NEAR(enclosedVolume(body), 24, 1e-12);
  EXPECT_EQ(body.triangles.size(), 4 * body.mesh->boundaryQuadraticTriangles().size());
  EXPECT_EQ(body.triangles.size(), 4u * 2 * (2 + 2 + 1) * 2);
  // three edges a face, shared by two faces, of two halves; and three lines within each face are not drawn
  EXPECT_EQ(body.edges.size(), 2 * 3 * body.mesh->boundaryQuadraticTriangles().size() / 2);
  EXPECT_EQ(body.cells(), 12);
  for (std::size_t i = 0; i < body.triangles.size(); ++i)
    EXPECT_TRUE(hasFace(body.mesh->quadratic_tetrahedra[std::size_t(body.owner[i])], body, body.triangles[i])) << i;
  std::vector<double> work;
  std::vector<float> values;
  ASSERT_GT(drawing.fields.size(), 1u);
  EXPECT_TRUE(cellValues(drawing.fields[1], body, work, values));
  EXPECT_EQ(values.size(), 12u);
}

TEST(Bodies, TetrahedraCutFromAGridAreWhatIsDrawnOfIt) {
  const Simulation simulation = simulationFromText(block(tetrahedra));
  const Drawing drawing = drawingOf(simulation);
  const Body& body = drawing.bodies.at(0);
  EXPECT_NEAR(enclosedVolume(body), 24, 1e-12);
  EXPECT_FALSE(body.mesh->tetrahedra.empty());
  EXPECT_TRUE(body.mesh->hexahedra.empty());
  for (std::size_t i = 0; i < body.triangles.size(); ++i)
    EXPECT_TRUE(hasFace(body.mesh->tetrahedra[std::size_t(body.owner[i])], body, body.triangles[i])) << i;
}

TEST(Bodies, FieldsOfCellsHaveAValueForEachCell) {
  Simulation simulation = simulationFromText(block(hexahedra));
  for (int i = 0; i < 3; ++i) simulation.step();
  const Drawing drawing = drawingOf(simulation);
  std::vector<double> work;
  std::vector<float> values;
  int fields = 0;
  for (const Field& field : drawing.fields) {
    if (!field.source) continue;
    ++fields;
    ASSERT_TRUE(cellValues(field, drawing.bodies[0], work, values)) << field.name;
    ASSERT_EQ(values.size(), 24u);
    std::vector<double> direct;
    field.source->cellField(field.name, simulation.systems()[0]->x, direct);
    const std::size_t width = direct.size() / values.size();
    for (std::size_t i = 0; i < values.size(); ++i) {
      double squares = 0;
      for (std::size_t k = 0; k < width; ++k)  // a shear of a symmetric tensor stands for two
        squares += (width == 6 && k > 2 ? 2 : 1) * direct[width * i + k] * direct[width * i + k];
      if (field.name.starts_with("principal")) {
        EXPECT_EQ(values[i], float(direct[width * i])) << "the largest, with its sign";
        EXPECT_GE(direct[width * i], direct[width * i + 2]);
      } else {
        EXPECT_FLOAT_EQ(std::abs(values[i]), float(std::sqrt(squares)));
      }
    }
  }
  EXPECT_GT(fields, 0);
}

TEST(Bodies, FieldsAreOnTheCellsOfTheirForceFieldWhereThereAreAsManyOfAnotherKind) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" gravity="0 0 0" dt="1"><StaticSolver/><SparseLDLSolver/>
      <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 2"
                    hexahedra="0 1 2 3 4 5 6 7" tetrahedra="4 5 6 8"/><MechanicalObject/>
      <HexahedronFEMForceField method="small" youngModulus="1000" poissonRatio="0"/>
      <FixedProjectiveConstraint indices="0 1 2 3"/><ConstantForceField indices="4 5 6 7" totalForce="0 0 100"/></Node>)");
  simulation.step();
  const Drawing drawing = drawingOf(simulation);
  std::vector<double> work;
  std::vector<float> values;
  const auto stress = std::find_if(drawing.fields.begin(), drawing.fields.end(),
                                   [](const Field& field) { return field.name == "vonMises"; });
  ASSERT_NE(stress, drawing.fields.end());
  ASSERT_TRUE(cellValues(*stress, drawing.bodies.at(0), work, values));
  ASSERT_EQ(values.size(), 2u);
  EXPECT_TRUE(std::isnan(values[0])) << "the tetrahedron";
  EXPECT_NEAR(values[1], 100, 1e-4);
}

/// A pull of 10 % along an axis strains by E = diag((1.1^2 - 1) / 2, 0, 0), wherever the axis points.
TEST(Bodies, TheNormOfATensorDoesNotTurnWithTheAxes) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><Node "
      "name=\"block\"><EulerImplicitSolver/><CGLinearSolver/><TetrahedronSetTopologyContainer "
      "position=\"0 0 0  1 0 0  0 1 0  0 0 1\" tetrahedra=\"0 1 2 3\"/><MechanicalObject name=\"dofs\"/><UniformMass "
      "totalMass=\"1\"/><TetrahedronHyperelasticityFEMForceField materialName=\"StableNeoHookean\" "
      "youngModulus=\"1000\" "
      "poissonRatio=\"0.3\"/></Node></Node>");
  const Drawing drawing = drawingOf(simulation);
  const auto strain = std::find_if(drawing.fields.begin(), drawing.fields.end(),
                                   [](const Field& field) { return field.name == "strain"; });
  ASSERT_NE(strain, drawing.fields.end());
  const Body& body = drawing.bodies.at(0);
  std::vector<double> work;
  std::vector<float> values;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, -2, 3)}) {
    const Vec3 along = axis.normalized();
    auto x = const_cast<State*>(body.state)->x();
    for (Index row = 0; row < body.state->size(); ++row) {
      const Vec3 rest = body.state->rest_position[std::size_t(row)];
      x[row] = Vec3(rest + 0.1 * along.dot(rest) * along);
    }
    ASSERT_TRUE(cellValues(*strain, body, work, values));
    EXPECT_NEAR(values.at(0), 0.105, 1e-6) << axis.transpose();
  }
}

TEST(Bodies, PointsWithoutCellsAreDrawnAsPoints) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><EulerExplicitSolver/><MechanicalObject name=\"dofs\" position=\"0 0 0  1 0 0  2 0 0\"/>"
      "<UniformMass totalMass=\"1\"/></Node>");
  const Drawing drawing = drawingOf(simulation);
  EXPECT_EQ(drawing.bodies.at(0).points.size(), 3u);
  EXPECT_EQ(drawing.bodies.at(0).surface, 3);
}

TEST(Bodies, SpringsAreDrawnWithinABodyAndBetweenTwo) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver/><Node name=\"a\"><MechanicalObject name=\"dofs\" "
      "position=\"0 0 0  1 0 0  2 0 0\"/><UniformMass totalMass=\"1\"/>"
      "<SpringForceField spring=\"0 2 100 0 2\"/></Node><Node name=\"b\"><MechanicalObject name=\"dofs\" "
      "position=\"0 1 0  1 1 0\"/><UniformMass totalMass=\"1\"/></Node>"
      "<SpringForceField object1=\"@a/dofs\" object2=\"@b/dofs\" spring=\"1 0 100 0 1\"/></Node>");
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 2u);
  ASSERT_EQ(drawing.bodies[0].springs.size(), 1u);
  const auto [from, to] = drawing.bodies[0].springs[0];
  EXPECT_EQ(drawing.bodies[0].node[std::size_t(from)], 0);
  EXPECT_EQ(drawing.bodies[0].node[std::size_t(to)], 2);
  ASSERT_EQ(drawing.links.size(), 1u);
  EXPECT_EQ(drawing.links[0].body_a, 0);
  EXPECT_EQ(drawing.bodies[0].node[std::size_t(drawing.links[0].node_a)], 1);
  EXPECT_EQ(drawing.links[0].body_b, 1);
  EXPECT_EQ(drawing.bodies[1].node[std::size_t(drawing.links[0].node_b)], 0);
  EXPECT_FALSE(drawing.links[0].is_tie);
}

TEST(Bodies, HeldAndGuidedNodesAreToldApart) {
  const Simulation simulation = simulationFromText(
      block(hexahedra,
            "<FixedProjectiveConstraint indices=\"0 1\"/>"
            "<PartialFixedProjectiveConstraint indices=\"5\" fixedDirections=\"1 0 0\"/>"
            "<LinearMovementProjectiveConstraint indices=\"59\" keyTimes=\"0 1\" movements=\"0 0 0  1 0 0\"/>"));
  const Drawing drawing = drawingOf(simulation);
  const auto holdings = holdingsOf(simulation, drawing, simulation.time());
  const auto nodes = [&](Holding how) {
    std::vector<Index> out;
    for (std::size_t page = 0; page < holdings.at(0).size(); ++page)
      if (holdings[0][page] == how) out.push_back(drawing.bodies[0].node[page]);
    return out;
  };
  EXPECT_EQ(nodes(Holding::held), (std::vector<Index>{0, 1}));
  EXPECT_EQ(nodes(Holding::guided), (std::vector<Index>{5, 59}));
}

TEST(Bodies, BeamsBendBetweenFramesAndTakeThePlaceOfTheirEdges) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver/><MeshTopology edges=\"0 1  1 2\"/>"
      "<MechanicalObject template=\"Rigid3\" position=\"0 0 0 0 0 0 1  1 0 0 0 0 0.70710678 0.70710678  2 0 0 0 0 0 1\"/>"
      "<UniformMass totalMass=\"1\"/><BeamFEMForceField radius=\"0.05\" listSegment=\"0\"/>"
      "<Node name=\"angles\"><MechanicalObject template=\"Vec1\" position=\"1 2\"/><UniformMass totalMass=\"1\"/></Node></Node>");
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 1u) << "numbers are nowhere";
  const Body& body = drawing.bodies[0];
  EXPECT_EQ(body.node.size(), 3u);
  ASSERT_EQ(body.frames.size(), 3u);
  EXPECT_EQ(body.frames[1], (std::array<Index, 2>{1, 3}));
  ASSERT_EQ(body.beams.size(), 1u);
  EXPECT_EQ(body.edges, (std::vector<Edge>{{1, 2}}));
  EXPECT_TRUE(body.springs.empty());
  EXPECT_TRUE(body.points.empty());
  const Beam& beam = body.beams[0];
  EXPECT_EQ(beam.nodes, (std::array<Index, 2>{0, 1}));
  EXPECT_EQ(beam.frames, (std::array<Index, 2>{0, 1}));
  EXPECT_EQ(beam.radius, 0.05);
  EXPECT_LT((beam.chord[1] - Vec3(0, -1, 0)).norm(), 1e-7) << "in the axes of the turned end";
  EXPECT_GT(body.axis, 0.1);
  EXPECT_LT(body.axis, 0.5) << "axes of neighbours stay apart";
  const Quaternion turned = turnedBy(Vec3(0, 0, M_PI / 2));
  for (const Vec3& place : beamCurve(beam, Vec3::Zero(), Vec3::UnitX(), Quaternion::Identity(), turned, 8))
    EXPECT_NEAR(place.y(), 0, 1e-7) << "straight at rest";
  const std::vector<Vec3> bent =
      beamCurve(beam, Vec3::Zero(), Vec3(0.6, 0.6, 0), Quaternion::Identity(), turnedBy(Vec3(0, 0, M_PI)), 100);
  EXPECT_LT((bent[1] - bent[0]).normalized().y(), 0.02) << "it leaves along x";
  EXPECT_LT((bent[100] - bent[99]).normalized().x(), 0.02) << "and arrives along y";
  EXPECT_GT((bent[100] - bent[99]).y(), 0);
}

/// What others touch is seen where it stands, and points with a sphere around them are as large as it.
TEST(Bodies, WhatOthersTouchIsDrawnWhereNothingMovesIt) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><CollisionPipeline/><MinProximityIntersection/>"
      "<Node name=\"balls\"><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject position=\"0 1 0  0 3 0\"/>"
      "<UniformMass totalMass=\"1\"/><SphereCollisionModel radius=\"0.5\" listRadius=\"0.25\"/></Node>"
      "<Node name=\"floor\"><MeshTopology position=\"-1 0 -1  1 0 -1  0 0 1\" triangles=\"0 2 1\"/><MechanicalObject/>"
      "<TriangleCollisionModel simulated=\"false\" moving=\"false\"/></Node>"
      "<Node name=\"unseen\"><MechanicalObject position=\"9 9 9\"/></Node></Node>");
  const Drawing drawing = drawingOf(simulation);
  ASSERT_EQ(drawing.bodies.size(), 2u) << "a state that nothing moves and nothing touches is not drawn";
  const Body &balls = drawing.bodies[0], &floor = drawing.bodies[1];
  ASSERT_EQ(balls.balls.size(), 2u);
  EXPECT_EQ(balls.balls[0].radius, 0.25);
  EXPECT_EQ(balls.balls[1].radius, 0.5);
  EXPECT_EQ(balls.node[std::size_t(balls.balls[1].node)], 1);
  EXPECT_TRUE(balls.points.empty()) << "a ball takes the place of its point";
  EXPECT_EQ(floor.system, nullptr);
  EXPECT_EQ(floor.triangles.size(), 1u);
  EXPECT_EQ(Vec3(floor.x()[1]), Vec3(1, 0, -1));
  EXPECT_EQ(Vec3(floor.v()[1]), Vec3(0, 0, 0));
  EXPECT_NEAR(floor.size, std::sqrt(8), 1e-12);
  for (const Field& field : drawing.fields) EXPECT_EQ(field.body, 0) << field.name;
}

TEST(Bodies, ASinglePointHasTheSizeOfTheScene) {
  const Simulation simulation = simulationFromText(
      "<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver/>"
      "<Node name=\"one\"><MechanicalObject position=\"0 0 0\"/><UniformMass totalMass=\"1\"/></Node>"
      "<Node name=\"other\"><MechanicalObject position=\"0 3 4\"/><UniformMass totalMass=\"1\"/></Node></Node>");
  for (const Body& body : drawingOf(simulation).bodies) EXPECT_EQ(body.size, 5);
}

}  // namespace
}  // namespace stroma::drawing
