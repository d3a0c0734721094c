// SPDX-License-Identifier: LGPL-2.1-or-later
// Every form of a link, in any order of siblings, and what happens when one is broken.
#include <algorithm>
#include <random>

#include "tests/scene/test_components.h"

namespace stroma::testing {
namespace STROMA_TEST_FILE {

using Links = SceneTest;

/// A tree with a mesh above, beside and below the place of the link.
std::string around(const std::string& link) {
  return "<Node name='root'>"
         "  <TestMesh name='top' position='1 0 0'/>"
         "  <Node name='liver'>"
         "    <TestMesh name='mesh' position='2 0 0'/>"
         "    <TestState name='dofs' position='" +
         link +
         "'/>"
         "    <Node name='skin'><TestMesh name='inner' position='3 0 0'/></Node>"
         "  </Node>"
         "  <Node name='other'><TestMesh name='mesh' position='4 0 0'/></Node>"
         "</Node>";
}

TEST_F(Links, EveryFormOfADataLink) {
  const std::vector<std::pair<std::string, double>> forms = {{"@mesh.position", 2},
                                                             {"@./mesh.position", 2},
                                                             {"@top.position", 1},
                                                             {"@../top.position", 1},
                                                             {"@skin/inner.position", 3},
                                                             {"@./skin/inner.position", 3},
                                                             {"@../other/mesh.position", 4},
                                                             {"@other/mesh.position", 4},
                                                             {"@/top.position", 1},
                                                             {"@/liver/mesh.position", 2},
                                                             {"@/root/liver/mesh.position", 2},
                                                             {"@/root/top.position", 1},
                                                             {"@[-1].position", 2},
                                                             {"@[-1]", 2},
                                                             {"@mesh", 2},
                                                             {"@../top", 1},
                                                             {"@/liver/skin/inner", 3},
                                                             {"@skin/../mesh.position", 2},
                                                             {"@.position", 2},
                                                             {"@../.position", 1},
                                                             {"@../other/.position", 4},
                                                             {"@../other.position", 4},
                                                             {"  @mesh.position  ", 2},
                                                             {"@.//mesh.position", 2}};
  for (const auto& [form, expected] : forms) {
    SCOPED_TRACE(form);
    const Scene scene = load(around(form));
    const auto& state = get<TestState>(scene, "/liver/dofs");
    ASSERT_EQ(state.position.size(), 1u);
    EXPECT_EQ(state.position[0][0], expected);
    EXPECT_EQ(state.data().find("position")->origin(), DataOrigin::linked);
  }
}

std::string withForce(const std::string& link) {
  return "<Node name='root'>"
         "  <TestState name='above' position='0 0 0'/>"
         "  <Node name='liver'>"
         "    <TestMesh name='mesh'/>"
         "    <TestState name='dofs' position='0 0 0'/>"
         "    <TestForce name='force' youngModulus='1' mstate='" +
         link +
         "'/>"
         "  </Node>"
         "</Node>";
}

TEST_F(Links, EveryFormOfAComponentLink) {
  const std::vector<std::pair<std::string, std::string>> forms = {
      {"@dofs", "/liver/dofs"},  {"@./dofs", "/liver/dofs"},
      {"@./", "/liver/dofs"},    {"@.", "/liver/dofs"},
      {"@../", "/above"},        {"@..", "/above"},
      {"@../above", "/above"},   {"@above", "/above"},
      {"@/above", "/above"},     {"@/root/liver/dofs", "/liver/dofs"},
      {"@[-1]", "/liver/dofs"},  {"@/", "/above"},
      {"dofs", "/liver/dofs"},   {"", "/liver/dofs"},
      {"@/liver", "/liver/dofs"}};
  for (const auto& [form, expected] : forms) {
    SCOPED_TRACE(form);
    const Scene scene = load(withForce(form));
    EXPECT_EQ(get<TestForce>(scene, "/liver/force").state->path(), expected);
  }
}

TEST_F(Links, BrokenOnesNameTheNearest) {
  EXPECT_EQ(problemOf(around("@mehs.position")).suggestion, "@mesh.position");
  EXPECT_EQ(problemOf(around("@../otehr/mesh.position")).suggestion, "@../other/mesh.position");
  EXPECT_EQ(problemOf(around("@mesh.postion")).suggestion, "@mesh.position");
  EXPECT_EQ(problemOf(around("mesh.position")).suggestion, "@mesh.position") << "without its sign";
  EXPECT_EQ(problemOf(around("1.5 2")).suggestion, "");
  EXPECT_NE(problemOf(around("@../../../mesh.position")).message.find("above the root"), std::string::npos);
  EXPECT_NE(problemOf(around("@[-5].position")).message.find("no component at that place"), std::string::npos);
  EXPECT_NE(problemOf(around("@[x].position")).message.find("number in brackets"), std::string::npos);
  EXPECT_NE(problemOf("<Node><TestMesh name='a'/><TestMesh name='b'/><TestState position='@.position'/></Node>")
                .message.find("holds more than one component with an attribute 'position': a, b"),
            std::string::npos);
  EXPECT_NE(problemOf("<Node><TestState position='@./'/></Node>").message.find("holds no component"),
            std::string::npos);
}

TEST_F(Links, AComponentLinkToTheWrongRole) {
  const Problem problem = problemOf(withForce("@mesh"));
  EXPECT_NE(problem.message.find("/liver/mesh is a mesh (TestMesh)"), std::string::npos);
  EXPECT_EQ(problem.expected, "mechanical state");
  EXPECT_EQ(problem.path, "/liver/force.mstate");
  EXPECT_NE(problemOf(withForce("@dofs.position")).message.find("names a component, not an attribute"),
            std::string::npos);
  EXPECT_EQ(problemOf(withForce("@dosf")).suggestion, "@dofs");
}

TEST_F(Links, AValueOfAnotherTypeIsReportedWhereItIsLinked) {
  const Problem problem = problemOf(
      "<Node>\n<TestMesh name='mesh' tetrahedra='0 1 2 3'/>\n<TestState position='@mesh.tetrahedra'/>\n</Node>");
  EXPECT_EQ(problem.path, "/TestState.position");
  EXPECT_EQ(problem.where.line, 3);
  EXPECT_EQ(problem.where.column, 12);
  EXPECT_EQ(problem.expected, "list of 3 reals");
}

TEST_F(Links, SrcTakesWhatNobodyWrote) {
  folder.write("mesh.txt", "12345");
  const Scene scene = load(
      "<Node><TestState name='dofs' src='@loader' velocity='1 1 1'/><TestMesh src='@loader' position='9 9 9'/>"
      "<TestLoader name='loader' filename='mesh.txt' translation='10 0 0'/></Node>");
  const auto& state = get<TestState>(scene, "/dofs");
  ASSERT_EQ(state.position.size(), 5u);
  EXPECT_EQ(state.position[1], Vec3(11, 0, 0)) << "the loader's translation is applied once";
  EXPECT_EQ(state.velocity.size(), 1u);
  const auto& mesh = get<TestMesh>(scene, "/TestMesh");
  EXPECT_EQ(mesh.position[0], Vec3(9, 9, 9));
  EXPECT_EQ(mesh.tetrahedra.size(), 1u);
}

TEST_F(Links, SrcThatGivesNothingOrLeadsNowhere) {
  EXPECT_NE(problemOf("<Node><TestForce name='f' youngModulus='1' mstate='@s'/><TestState name='s'/>"
                      "<TestMesh src='@f'/></Node>")
                .message.find("no attribute in common"),
            std::string::npos);
  EXPECT_EQ(problemOf("<Node><TestState name='loader'/><TestMesh src='@laoder'/></Node>").suggestion, "@loader");
}

TEST_F(Links, ACircleOfValuesIsPrinted) {
  const std::vector<Problem> problems = problemsOf(
      "<Node>\n<TestState name='a' position='@b.position'/>\n<TestState name='b' position='@c.position'/>\n"
      "<TestMesh name='c' position='@a.position'/>\n</Node>");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].message.find("/a.position -> /b.position -> /c.position -> /a"), std::string::npos)
      << problems[0].text();
  EXPECT_NE(problemOf("<Node><TestState name='a' position='@a.velocity'/></Node>").message.find("/a.position -> /a"),
            std::string::npos);
}

/// Needs its partner's init() and the partner needs its own.
class Needy : public Component {
 public:
  void declare(DataTable& table) override { table.addLink("partner", partner_); }
  void init() override { partner_.get(); }
  std::string roleText() const override { return "partner"; }

 private:
  Link<Needy> partner_{"partner"};
};

TEST_F(Links, ACircleOfComponentsIsPrinted) {
  factory.add<Needy>("Needy", "needs another");
  const Problem problem = problemOf(
      "<Node><Needy name='a' partner='@b'/><Needy name='b' partner='@c'/><Needy name='c' partner='@b'/></Node>");
  EXPECT_NE(problem.message.find("/b -> /c -> /b"), std::string::npos) << problem.text();
}

TEST_F(Links, TheOrderOfSiblingsDoesNotMatter) {
  folder.write("mesh.txt", "1234567");
  std::vector<std::string> lines = {"<TestLoader name='loader' filename='mesh.txt'/>",
                                    "<TestMesh name='mesh' src='@loader'/>",
                                    "<TestState name='dofs' position='@mesh.position' translation='1 0 0'/>",
                                    "<TestRoi name='roi' box='2 0 0 4 1 1' position='@dofs.position'/>",
                                    "<TestForce name='force' youngModulus='10' mstate='@dofs' indices='@roi.indices'/>",
                                    "<Node name='below'><TestMesh name='copy' position='@dofs.position'/></Node>"};
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    std::shuffle(lines.begin(), lines.end(), random);
    std::string text = "<Node name='root'>";
    for (const std::string& line : lines) text += line;
    const Scene scene = load(text + "</Node>");
    ASSERT_EQ(get<TestForce>(scene, "/force").indices, (std::vector<int>{1, 2, 3}));
    ASSERT_EQ(get<TestMesh>(scene, "/below/copy").position.size(), 7u);
    ASSERT_EQ(get<TestMesh>(scene, "/below/copy").position[0], Vec3(1, 0, 0));
    ASSERT_EQ(get<TestState>(scene, "/dofs").init_count, 1);
  }
}

TEST_F(Links, SofasNumberedNamesReachUnnamedComponents) {
  const Scene scene = load(
      "<Node><TestMesh position='1 0 0'/><TestMesh position='2 0 0'/>"
      "<TestState name='a' position='@TestMesh1.position'/><TestState name='b' "
      "position='@TestMesh2.position'/></Node>");
  EXPECT_EQ(get<TestState>(scene, "a").position[0][0], 1);
  EXPECT_EQ(get<TestState>(scene, "b").position[0][0], 2);
  EXPECT_NE(findComponent(*scene.root, "/TestMesh2"), nullptr);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::testing
