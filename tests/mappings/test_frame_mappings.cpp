// SPDX-License-Identifier: LGPL-2.1-or-later
// What frames carry, and what carries frames: positions, orientations and their signs against closed forms; messages.
#include <numbers>

#include "framework/mechanics/frames.h"
#include "tests/mappings/mapping_scenes.h"
#include "tests/support/random_rows.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(FrameMappings, PointsFollowTheirFrames) {
  Simulation simulation = simulationFromText(
      underFrames("<MechanicalObject name=\"dofs\" position=\"0.1 0 0  0 0.2 0\"/><RigidMapping index=\"2\"/>"));
  System& system = *simulation.systems()[0];
  EXPECT_LT((system.x[6] - Vec3(2.1, 0, 1)).norm(), 1e-15);
  Motion::turnBy(Vec3(0, 0, std::numbers::pi / 2), system.x.rows().data + 5 * row_doubles);
  system.applyMappings();
  EXPECT_LT((system.x[6] - Vec3(2, 0.1, 1)).norm(), 1e-15);
  EXPECT_LT((system.x[7] - Vec3(1.8, 0, 1)).norm(), 1e-15);
}

/// A body that is stretched, turned and moved: x = Q S X + c takes an embedded frame to Q q_0 at Q S X + c.
TEST(FrameMappings, EmbeddedFramesTurnWithTheBody) {
  for (const std::string cells : {"hexahedra=\"0 1 2 3 4 5 6 7\"", "tetrahedra=\"0 1 3 4  1 2 3 6  1 4 5 6  3 4 6 7  1 3 4 6\""}) {
    Simulation simulation = simulationFromText(embeddedFrames(cells, rest_cube, rest_cube));
    System& system = *simulation.systems()[0];
    const Quaternion q = turnedBy(Vec3(0.3, -2, 1)), start = Quaternion(0.9, 0.1, 0.2, 0.3).normalized();
    Mat3 stretch;
    stretch << 1.5, 0.2, 0.1, 0.2, 0.7, -0.1, 0.1, -0.1, 1.1;
    const Mat3 a = q.toRotationMatrix() * stretch;
    const Vec3 c(1, 2, 3);
    for (Index i = 0; i < 8; ++i) system.x[i] = a * Vec3(system.x[i]) + c;
    system.applyMappings();
    EXPECT_LT((Vec3(system.x[8]) - (a * Vec3(0.2, 0.3, 0.1) + c)).norm(), 1e-14);
    EXPECT_LT(orientationIn(system.x, 9).angularDistance(q * start), 1e-7);
    EXPECT_LT((Vec3(system.x[10]) - (a * Vec3(0.5, 0.4, 0.3) + c)).norm(), 1e-14);
    EXPECT_LT(orientationIn(system.x, 11).angularDistance(q), 1e-7);
  }
}

/// The rotation of a cell has no past, but its frame's quaternion goes on through w = 0.
TEST(FrameMappings, EmbeddedFramesKeepTheirSign) {
  Simulation simulation = simulationFromText(embeddedFrames("hexahedra=\"0 1 2 3 4 5 6 7\"", rest_cube, rest_cube));
  System& system = *simulation.systems()[0];
  const Quaternion start = orientationIn(system.x, 9);
  std::vector<Vec3> rest;
  for (Index i = 0; i < 8; ++i) rest.push_back(system.x[i]);
  for (int k = 1; k <= 40; ++k) {  // three turns and more
    const Quaternion q = turnedBy(0.5 * k * Vec3(0.6, 0, 0.8));
    for (Index i = 0; i < 8; ++i) system.x[i] = q * rest[std::size_t(i)];
    system.applyMappings();
    EXPECT_LT((orientationIn(system.x, 9).coeffs() - (q * start).coeffs()).norm(), 1e-12) << k;
  }
}

TEST(FrameMappings, EmbeddedFramesNeedAVolume) {
  const std::string problems = problemsOf(embeddedFrames("quads=\"0 1 2 3\"", rest_cube, rest_cube));
  EXPECT_NE(problems.find("no cell with a volume"), std::string::npos) << problems;
}

/// What limits steps knows no bound of the ways of what embedded frames carry; of embedded points it does.
TEST(FrameMappings, EmbeddedFramesCarryNoBarriers) {
  const auto problems = [](const std::string& carrier) {
    return problemsOf("<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver newtonIterations=\"30\"/><SparseLDLSolver/><MeshTopology "
                      "position=\"" + rest_cube + "\" hexahedra=\"0 1 2 3 4 5 6 7\"/><MechanicalObject/><UniformMass totalMass=\"8\"/>"
                      "<HexahedronFEMForceField youngModulus=\"1e4\" poissonRatio=\"0.3\"/>" + carrier + "</Node>");
  };
  const std::string surface =
      "<MeshTopology position=\"0 0 0  1 0 0  0 1 0\" triangles=\"0 1 2\"/><MechanicalObject name=\"skin\" position=\"0 0 0  1 0 0  0 "
      "1 0\"/>", contact = "<BarrierContact contactDistance=\"0.01\" planes=\"0 0 1 -9\"/>";
  const std::string frames = "<Node name=\"frames\"><MechanicalObject template=\"Rigid3\" position=\"0.5 0.5 0.5 0 0 0 1\"/>"
                             "<BarycentricMapping/><Node name=\"tool\">" + surface + "<RigidMapping/>{}</Node></Node>";
  EXPECT_NE(problems(fmt::format(fmt::runtime(frames), contact)).find("which embedded frames carry"), std::string::npos);
  EXPECT_EQ(problems(fmt::format(fmt::runtime(frames), "")), "");
  EXPECT_EQ(problems("<Node name=\"points\">" + surface + "<BarycentricMapping/>" + contact + "</Node>"), "");
}

/// Nodes of one body are those of two parents, one of them carried by a frame: both feel what acts on them.
TEST(FrameMappings, ABodyIsGluedToAFrame) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver iterations="200" tolerance="1e-14"/>
      <Node name="rigid"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0 0 0 1"/>
        <UniformMass totalMass="1" inertia="0.1 0.1 0.1"/><FixedTranslationProjectiveConstraint indices="0"/>
        <Node name="end"><MechanicalObject name="dofs" position="1 0 0"/><RigidMapping/></Node></Node>
      <Node name="free"><MechanicalObject name="dofs" position="1 1 0"/><UniformMass totalMass="1"/>
        <FixedProjectiveConstraint indices="0"/></Node>
      <Node name="both"><MechanicalObject name="dofs" position="1 0 0  1 1 0"/>
        <SubsetMultiMapping input="@../rigid/end/dofs @../free/dofs" indexPairs="0 0  1 0"/>
        <SpringForceField springsIndices1="0" springsIndices2="1" lengths="0.5" stiffness="100" damping="0"/></Node></Node>)");
  ASSERT_FALSE(simulation.step().diverged);
  System& system = *simulation.systems()[0];
  // a tension of 50 N at an arm of 1 m: h 50 / (J + h^2 k), J = 0.1 kg m^2
  EXPECT_NEAR(system.v[1][2], 0.01 * 50 / (0.1 + 1e-4 * 100), 1e-9);
  EXPECT_NEAR(system.v[1][0], 0, 1e-12);
}

/// On demand what nothing acts on is placed only when somebody asks; what springs read as their targets always.
TEST(FrameMappings, PointsThatNobodyReadsAreLeftBehind) {
  const std::string text = R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/>
      <CGLinearSolver iterations="50" tolerance="1e-12"/>
      <Node name="a"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" velocity="1 0 0 0 0 0"/>
        <UniformMass totalMass="1" inertia="1 1 1"/>
        <Node name="seen"><MechanicalObject name="dofs" position="0 1 0"/><RigidMapping/></Node>
        <Node name="target"><MechanicalObject name="dofs" position="0 2 0"/><RigidMapping/></Node></Node>
      <Node name="b"><MechanicalObject name="dofs" position="0 2 0"/><UniformMass totalMass="1"/>
        <RestShapeSpringsForceField points="0" stiffness="1e6" external_rest_shape="@../a/target/dofs"/></Node></Node>)";
  Simulation simulation = simulationFromText(text);
  simulation.computeOnDemand(true);
  const System& system = *simulation.systems()[0];
  EXPECT_EQ(system.actors().passive_mappings.size(), 1u);
  const auto stateAt = [&](const std::string& path) {
    for (const State* state : simulation.states())
      if (state->path() == path) return state;
    return static_cast<const State*>(nullptr);
  };
  for (int i = 0; i < 20; ++i) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_EQ(stateAt("/a/seen/dofs")->x()[0][0], 0);
  EXPECT_NEAR(stateAt("/a/target/dofs")->x()[0][0], 0.2, 1e-14);
  EXPECT_NEAR(stateAt("/b/dofs")->x()[0][0], 0.19, 1e-3) << "it follows where the target was when the step began";
  simulation.complete();
  EXPECT_NEAR(stateAt("/a/seen/dofs")->x()[0][0], 0.2, 1e-14);
  EXPECT_NEAR(stateAt("/a/seen/dofs")->v()[0][0], 1, 1e-14);
}

/// A point in the middle of two frames, of which one moves by 0.1.
TEST(FrameMappings, OfFramesAsNearTheFirstCarriesASkinAndFromRestTheLast) {
  for (const bool from_rest : {false, true}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node dt="0.1" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject template="Rigid3" position="-1 0 0 0 0 0 1  1 0 0 0 0 0 1"
        velocity="1 0 0 0 0 0  0 0 0 0 0 0"/><UniformMass totalMass="1"/><Node name="skin"><MechanicalObject name="dofs" position="0 0 0"/>
        <SkinningMapping nbRef="1" fromRest="{}"/></Node></Node>)", from_rest));
    ASSERT_FALSE(simulation.step().failed());
    simulation.complete();
    for (const State* state : simulation.states())
      if (state->path() == "/skin/dofs") EXPECT_NEAR(state->x()[0][0], from_rest ? 0 : 0.1, 1e-14);
  }
}

TEST(FrameMappings, SayWhatTheyNeed) {
  expectContains(problemsOf(underPoints("<MechanicalObject position=\"0 0 0\"/><RigidMapping/>")),
                 "has no frames");
  expectContains(problemsOf(underFrames("<MechanicalObject position=\"0 0 0\"/><RigidMapping index=\"7\"/>")),
                 "there is no frame 7");
  expectContains(problemsOf("<Node name=\"root\"><EulerImplicitSolver/><CGLinearSolver/>" + frames +
                            "<SphereForceField center=\"0 0 0\" radius=\"1\"/></Node>"),
                 "has rigid frames");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
