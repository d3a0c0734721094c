// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of nodes mean nothing: a body whose nodes are listed in the opposite order, or that stands behind another body in the
// vectors, moves as before. For each component that names nodes, on points, rigid frames and numbers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Three nodes: numbers of each position, and what their component is called.
struct Kind {
  const char* name;
  std::vector<std::vector<double>> nodes;
  const char* mass;
};
const Kind points{"Vec3", {{0, 0, 0}, {1, 0.2, 0}, {2, 0.1, 0.3}}, ""};
const Kind frames{"Rigid3",
                  {{0, 0, 0, 0, 0, 0, 1}, {1, 0.2, 0, 0, 0.28, 0, 0.96}, {2, 0.1, 0.3, 0.36, 0, 0.48, 0.8}},
                  " inertia=\"0.1 0.2 0.3\""};
const Kind numbers{"Vec1", {{1}, {2}, {4}}, ""};
const Kind pairs{"Vec2", {{1, 2}, {2, 0.5}, {4, -1}}, ""};

/// `#0`, `#1` and `#2` become the numbers of these nodes.
std::string numbered(const std::string& text, bool is_reversed) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '#')
      out += is_reversed ? char('0' + '2' - text[++i]) : text[++i];
    else
      out += text[i];
  return out;
}

/// Places of the three nodes after five steps, in their first order.
std::vector<Vec3> placesAfter(const Kind& kind, const std::string& components, bool is_reversed, bool is_second) {
  std::string positions;
  for (std::size_t i = 0; i < 3; ++i)
    for (const double number : kind.nodes[is_reversed ? 2 - i : i]) positions += fmt::format("{} ", number);
  const std::string other = "<Node name=\"other\"><MechanicalObject template=\"Rigid3\" position=\"9 9 9 0 0 0 1  8 9 9 0 0 0 1\"/>"
                            "<UniformMass vertexMass=\"1\" inertia=\"1 1 1\"/></Node>";
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -1 0\"><EulerImplicitSolver newtonIterations=\"30\"/><EigenSparseLU/>{}"
      "<Node name=\"body\"><MechanicalObject name=\"dofs\" template=\"{}\" position=\"{}\"/><UniformMass vertexMass=\"1\"{}/>{}</Node>"
      "</Node>",
      is_second ? other : "", kind.name, positions, kind.mass, numbered(components, is_reversed)));
  for (int i = 0; i < 5; ++i) {
    const StepReport report = simulation.step();
    EXPECT_TRUE(!report.failed() && !report.unsolved) << components << " " << report.reason;
  }
  const auto& state = dynamic_cast<const State&>(*findComponent(simulation.root(), "/body/dofs"));
  std::vector<Vec3> places;
  for (Index i = 0; i < 3; ++i)
    for (Index k = 0; k < state.rows_per_node; ++k) places.push_back(state.x()[(is_reversed ? 2 - i : i) * state.rows_per_node + k]);
  return places;
}

/// `moves`: the components change the motion of the nodes at all.
void expectTheSame(const Kind& kind, const std::string& components, bool moves = true) {
  SCOPED_TRACE(std::string(kind.name) + " " + components);
  const std::vector<Vec3> first = placesAfter(kind, components, false, false);
  for (const bool is_reversed : {false, true})
    for (const bool is_second : {false, true}) {
      const std::vector<Vec3> places = placesAfter(kind, components, is_reversed, is_second);
      double off = 0;
      for (std::size_t i = 0; i < first.size(); ++i) off = std::max(off, (places[i] - first[i]).norm());
      EXPECT_LT(off, 1e-9) << (is_reversed ? "reversed " : "") << (is_second ? "behind another body" : "");
    }
  if (!moves) return;
  const std::vector<Vec3> free = placesAfter(kind, "", false, false);
  double change = 0;
  for (std::size_t i = 0; i < first.size(); ++i) change = std::max(change, (free[i] - first[i]).norm());
  EXPECT_GT(change, 1e-6) << "it does nothing";
}

const char* const named[] = {"#1", "#2", "#1 #2"};

TEST(Numbering, OfPointsMeansNothing) {
  for (const std::string nodes : named)
    for (const char* component :
         {"<LinearForceField points=\"{}\" times=\"0 1\" forces=\"1 2 3 4 5 6\"/>", "<ConstantForceField indices=\"{}\" force=\"1 2 3\"/>",
          "<RestShapeSpringsForceField points=\"{}\" stiffness=\"100\"/>",
          "<TorsionForceField indices=\"{}\" torque=\"2\" axis=\"0 1 0\"/>",
          "<DiagonalVelocityDampingForceField indices=\"{}\" dampingCoefficient=\"30 40 50\"/>",
          "<PlaneForceField indices=\"{}\" normal=\"0 1 0\" d=\"1\" stiffness=\"50\"/>",
          "<SphereForceField indices=\"{}\" center=\"0 0 0\" radius=\"3\" stiffness=\"10\"/>",
          "<FormulaForceField indices=\"{}\" force=\"1; 2*t; x\"/>",
          "<PolynomialRestShapeSpringsForceField points=\"{}\" polynomialStiffness=\"1e5\" polynomialDegree=\"1\"/>",
          "<FixedProjectiveConstraint indices=\"{}\"/>", "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 1 0\"/>",
          "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" movements=\"0 0 0 1 2 3\"/>",
          "<LinearVelocityProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" velocities=\"1 1 1 1 2 3\"/>",
          "<PartialLinearMovementProjectiveConstraint indices=\"{}\" movedDirections=\"1 0 1\" keyTimes=\"0 1\" "
          "movements=\"0 0 0 1 2 3\"/>",
          "<DirectionProjectiveConstraint indices=\"{}\" direction=\"1 1 0\"/>",
          "<FixedPlaneProjectiveConstraint indices=\"{}\" direction=\"0 1 0\"/>",
          "<ProjectToPlaneProjectiveConstraint indices=\"{}\" origin=\"0 0 0\" normal=\"0 1 0\"/>",
          "<ProjectToLineProjectiveConstraint indices=\"{}\" origin=\"1 0.2 0\" direction=\"1 1 0\"/>",
          "<AffineMovementProjectiveConstraint indices=\"{}\" beginConstraintTime=\"0\" endConstraintTime=\"1\" translation=\"1 0 0\"/>",
          "<FixedLagrangianConstraint indices=\"{}\"/>", "<PositionConstraint indices=\"{}\" value=\"0.1\" valueType=\"displacement\"/>"}) {
      std::string text = component;
      for (std::size_t at; (at = text.find("{}")) != std::string::npos;) text.replace(at, 2, nodes);
      expectTheSame(points, text);
    }
  expectTheSame(points, "<AttachProjectiveConstraint indices1=\"#1\" indices2=\"#0\"/>");
  expectTheSame(points, "<DistanceLagrangianConstraint first_point=\"#1 #2\" second_point=\"#0 #1\"/>"
                        "<FixedProjectiveConstraint indices=\"#0\"/>");
  expectTheSame(points, "<SpringForceField springsIndices1=\"#1 #2\" springsIndices2=\"#0 #0\" lengths=\"0.5 1\" stiffness=\"20 30\"/>");
}

TEST(Numbering, OfFramesMeansNothing) {
  for (const std::string nodes : named)
    for (const char* component :
         {"<LinearForceField points=\"{}\" times=\"0 1\" forces=\"1 2 3 4 5 6  6 5 4 3 2 1\"/>",
          "<ConstantForceField indices=\"{}\" force=\"1 2 3 4 5 6\"/>",
          "<RestShapeSpringsForceField points=\"{}\" stiffness=\"100\" angularStiffness=\"5\"/>",
          "<TorsionForceField indices=\"{}\" torque=\"2\" axis=\"0 1 0\"/>",
          "<DiagonalVelocityDampingForceField indices=\"{}\" dampingCoefficient=\"30 40 50 6 7 8\"/>",
          "<PlaneForceField indices=\"{}\" normal=\"0 1 0\" d=\"1\" stiffness=\"50\"/>", "<FixedProjectiveConstraint indices=\"{}\"/>",
          "<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"1 1 1 0 1 0\"/>",
          "<FixedTranslationProjectiveConstraint indices=\"{}\"/>",
          "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" movements=\"0 0 0 0 0 0  1 2 3 0.1 0.2 0.3\"/>",
          "<LinearVelocityProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" velocities=\"1 1 1 1 1 1  1 2 3 0.1 0.2 0.3\"/>",
          "<FixedLagrangianConstraint indices=\"{}\"/>", "<PositionConstraint indices=\"{}\" value=\"0.1\" valueType=\"displacement\"/>",
          "<Node name=\"c\"><MechanicalObject position=\"0.5 1 0  0 0.3 1\"/><RigidMapping rigidIndexPerPoint=\"#1 #2\"/>"
          "<RestShapeSpringsForceField stiffness=\"50\"/><ConstantForceField indices=\"1\" force=\"1 2 3\"/></Node>"
          "<FixedProjectiveConstraint indices=\"{}\"/>"}) {
      std::string text = component;
      for (std::size_t at; (at = text.find("{}")) != std::string::npos;) text.replace(at, 2, nodes);
      expectTheSame(frames, text);
    }
  expectTheSame(frames, "<AttachProjectiveConstraint indices1=\"#1\" indices2=\"#0\"/>");
  expectTheSame(frames, "<SpringForceField springsIndices1=\"#1 #2\" springsIndices2=\"#0 #0\" lengths=\"0.5 1\" stiffness=\"20 30\"/>");
}

TEST(Numbering, OfNumbersMeansNothing) {
  for (const Kind* kind : {&numbers, &pairs})
    for (const std::string nodes : named)
      for (const char* component :
           {"<LinearForceField points=\"{}\" times=\"0 1\" forces=\"F F\"/>", "<ConstantForceField indices=\"{}\" force=\"F\"/>",
            "<RestShapeSpringsForceField points=\"{}\" stiffness=\"100\"/><ConstantForceField indices=\"{}\" force=\"F\"/>",
            "<FixedProjectiveConstraint indices=\"{}\"/><ConstantForceField indices=\"0 1 2\" force=\"F\"/>",
            "<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" movements=\"Z F\"/>"}) {
        std::string text = component;
        const bool is_pair = kind == &pairs;
        const auto put = [&text](const char* word, const std::string& by) {
          for (std::size_t at; (at = text.find(word)) != std::string::npos;) text.replace(at, std::string(word).size(), by);
        };
        put("\"F", is_pair ? "\"1 2" : "\"1"), put(" F", is_pair ? " 1 2" : " 1"), put("\"Z", is_pair ? "\"0 0" : "\"0"), put("{}", nodes);
        expectTheSame(*kind, text);
      }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
