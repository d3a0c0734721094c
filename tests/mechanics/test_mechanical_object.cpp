// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string scene(const std::string& attributes, const std::string& more = "") {
  return fmt::format("<Node name='root'>{}<MechanicalObject name='dofs' {}/></Node>", more, attributes);
}

/// The state of a scene that is never stepped.
struct Loaded {
  explicit Loaded(const std::string& xml) : loaded(sceneFromText(xml)) {
    state = dynamic_cast<State*>(findComponent(*loaded.root, "/dofs"));
  }
  Scene loaded;
  State* state;
};

void expectNear(const Vec3& found, const Vec3& expected) {
  EXPECT_LT((found - expected).norm(), 1e-14) << found.transpose() << " is not " << expected.transpose();
}

TEST(MechanicalObject, TakesPositionsFromAttributeRestMeshOrSize) {
  EXPECT_EQ(Loaded(scene("position='1 2 3 4 5 6'")).state->size(), 2);
  const Loaded rest(scene("rest_position='1 2 3 4 5 6'"));
  expectNear(rest.state->position[1], Vec3(4, 5, 6));
  const Loaded mesh(scene("", "<TestMesh size='1 2 3'/>"));
  ASSERT_EQ(mesh.state->size(), 8);
  expectNear(mesh.state->rest_position[7], Vec3(1, 2, 3));
  EXPECT_EQ(Loaded(scene("size='3'")).state->size(), 3);
  const Loaded none(scene(""));
  EXPECT_EQ(none.state->size(), 1);
  expectContains(none.loaded.diagnostics.text(), "one node at the origin");
  EXPECT_EQ(Loaded(scene("useTopology='false'", "<TestMesh/>")).state->size(), 1);
}

TEST(MechanicalObject, ScalesThenRotatesThenTranslates) {
  const Loaded a(scene("position='1 0 0' scale3d='2 1 1' rotation='0 0 90' translation='0 0 5'"));
  expectNear(a.state->position[0], Vec3(0, 2, 5));
  expectNear(a.state->rest_position[0], Vec3(0, 2, 5));
  // about x first, then y, then z: y -> z -> x -> y
  const auto placed = [](const std::string& attributes) { return Loaded(scene(attributes)).state->position[0]; };
  expectNear(placed("position='0 1 0' rotation='90 90 90'"), Vec3(0, 1, 0));
  expectNear(placed("position='0 1 0' rotation='90 90 0'"), Vec3(1, 0, 0));
  expectNear(placed("position='1 1 1' scale='3' dx='1' ry='180' rz='0'"), Vec3(-2, 3, -3));
}

TEST(MechanicalObject, SecondTransformLeavesTheRestShape) {
  const Loaded a(scene("position='1 0 0' translation='1 0 0' rotation2='0 0 90' translation2='0 0 1'"));
  expectNear(a.state->position[0], Vec3(0, 2, 1));
  expectNear(a.state->rest_position[0], Vec3(2, 0, 0));
  const Loaded scaled(scene("position='1 2 3' restScale='0.5'"));
  expectNear(scaled.state->rest_position[0], Vec3(0.5, 1, 1.5));
  expectNear(scaled.state->position[0], Vec3(1, 2, 3));
  const Loaded given(scene("position='1 2 3' rest_position='7 8 9' translation='1 0 0'"));
  expectNear(given.state->rest_position[0], Vec3(7, 8, 9));
  expectNear(given.state->position[0], Vec3(2, 2, 3));
}

TEST(MechanicalObject, SaysWhatIsWrong) {
  expectContains(problemsOf(scene("position='1 2 3 4 5 6 7 8 9' velocity='1 2 3 4 5 6'")),
                 "velocity has 2 entries and there are 3");
  expectContains(problemsOf(scene("position='1 2 3 4 5 6' rest_position='1 2 3'")), "rest_position has 1 entries");
  expectContains(problemsOf(scene("position='0 0 0' scale='2' scale3d='1 1 1'")), "scale and scale3d are both given");
  expectContains(problemsOf(scene("position='0 0 0' dx='2' translation='1 1 1'")), "dx and translation are both given");
  expectContains(problemsOf(scene("position='0 0 0' sx='0'")), "a scale of zero");
  expectContains(problemsOf(scene("position='0 0 0' size='4'")), "size is 4 and there are 1 positions");
  expectContains(problemsOf(scene("position='0 0 0' template='Rigid3'")), "Rigid3");
  expectContains(problemsOf(scene("positon='0 0 0'")), "position");
  EXPECT_EQ(problemsOf(scene("position='0 0 0' template='Vec3d' showObject='1'")), "");
}

/// SOFA's scenes often have the grid in the node of the solver, above those of the bodies. A mesh that belongs to another
/// state, and a size, keep it out.
TEST(MechanicalObject, TakesTheMeshAboveThatNoOtherStateHas) {
  const auto above = [](const std::string& beside, const std::string& attributes) {
    return "<Node name='root' gravity='0 0 0'><RegularGridTopology name='grid' n='3 2 2' min='0 0 0' max='2 1 1'/>" +
           beside + "<Node name='body'><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject name='dofs' " +
           attributes + "/><UniformMass totalMass='1'/></Node></Node>";
  };
  const auto nodes = [](const std::string& text) {
    const Scene loaded = sceneFromText(text);
    return dynamic_cast<State&>(*findComponent(*loaded.root, "/body/dofs")).size();
  };
  EXPECT_EQ(nodes(above("", "")), 12);
  EXPECT_EQ(nodes(above("", "size='4'")), 4);
  EXPECT_EQ(nodes(above("", "useTopology='false'")), 1);
  EXPECT_EQ(nodes(above("<MechanicalObject name='other'/>", "")), 1);
  Scene loaded = sceneFromText(above("", "translation='0 0 5'"));
  EXPECT_EQ(loaded.diagnostics.text(), "");
  expectNear(dynamic_cast<State&>(*findComponent(*loaded.root, "/body/dofs")).position[11], Vec3(2, 1, 6));
}

TEST(MechanicalObject, TakesTheNodesOfAMappingThatNamesItFromElsewhere) {
  const auto told = [](const std::string& output) {
    Scene loaded = sceneFromText("<Node name='root'><Node name='a'><MechanicalObject name='dofs' position='0 0 0  1 0 0'/>" +
                                 output + "</Node><Node name='b'><MechanicalObject name='dofs'/></Node></Node>");
    const auto& follower = dynamic_cast<const State&>(*findComponent(*loaded.root, "/b/dofs"));
    return std::pair(follower.size(), loaded.diagnostics.text());
  };
  const auto [nodes, text] = told("<IdentityMapping input='@dofs' output='@../b/dofs'/>");
  EXPECT_EQ(nodes, 2);
  EXPECT_EQ(text, "");
  expectContains(told("").second, "one node at the origin");
}

TEST(MechanicalObject, SaysWhatSevenNumbersMayBe) {
  const std::string told = problemsOf(scene("position='0 0 0 0 0 0 1'"));
  expectContains(told, "7 numbers are not a multiple of 3");
  expectContains(told, "template=\"Rigid3\"");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
