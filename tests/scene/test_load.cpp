// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes as a whole: planted mistakes, nodes, overrides, includes, what is accepted without effect.
#include <cstdlib>

#include "tests/scene/test_components.h"

namespace stroma::testing {
namespace STROMA_TEST_FILE {

using Load = SceneTest;

const Problem* find(const std::vector<Problem>& problems, const std::string& path) {
  for (const Problem& problem : problems)
    if (problem.path == path) return &problem;
  return nullptr;
}

TEST_F(Load, TenMistakesAreReportedInOneRun) {
  const std::vector<Problem> problems = problemsOf(
      "<Node name='root' gravty='0 0 0'>\n"  // 1: attribute of Node
      "  <TestState name='dofs' position='0 0 0 1 0 0'/>\n"
      "  <TestMehs name='typo'/>\n"                                        // 2: component
      "  <TestMesh name='attribute' positoin='0 0 0'/>\n"                  // 3: attribute
      "  <TestForce name='type' youngModulus='soft'/>\n"                   // 4: wrong type
      "  <TestForce name='word' youngModulus='1' method='lrage'/>\n"       // 5: wrong word
      "  <TestForce name='ratio' youngModulus='1' poissonRatio='0.6'/>\n"  // 6: out of range
      "  <TestMesh name='link' position='@dosf.position'/>\n"              // 7: broken link
      "  <TestMesh name='a' position='@b.position'/>\n"                    // 8: circle
      "  <TestMesh name='b' position='@a.position'/>\n"
      "  <TestLoader name='file' filename='no-such.msh'/>\n"                     // 9: missing file
      "  <TestRoi name='empty' box='5 0 0 6 1 1' position='@dofs.position'/>\n"  // 10: empty selection
      "</Node>\n");
  EXPECT_EQ(problems.size(), 10u);
  for (const Problem& problem : problems) {
    EXPECT_GT(problem.where.line, 0) << problem.text();
    EXPECT_FALSE(problem.path.empty()) << problem.text();
    EXPECT_FALSE(problem.expected.empty() && problem.suggestion.empty()) << problem.text();
  }
  const auto expect = [&](const std::string& path, int line, const std::string& suggestion) {
    const Problem* problem = find(problems, path);
    ASSERT_NE(problem, nullptr) << path;
    EXPECT_EQ(problem->where.line, line) << problem->text();
    EXPECT_NE(problem->suggestion.find(suggestion), std::string::npos) << problem->text();
  };
  expect("/.gravty", 1, "gravity");
  expect("/typo", 3, "TestMesh");
  expect("/attribute.positoin", 4, "position");
  expect("/type.youngModulus", 5, "");
  expect("/word.method", 6, "large");
  expect("/ratio.poissonRatio", 7, "");
  expect("/link.position", 8, "@dofs.position");
  expect("/b", 10, "break the circle");
  expect("/file.filename", 11, folder.path());
  expect("/empty", 12, "");
}

TEST_F(Load, AnAttributeWithoutACounterpartGetsAdviceAndNoGuess) {
  const Problem problem = problemOf(
      "<Node><TestState name='dofs'/><TestForce youngModulus='1' mstate='@dofs' updateStiffness='1'/></Node>");
  EXPECT_NE(problem.message.find("no attribute 'updateStiffness'"), std::string::npos) << problem.text();
  EXPECT_NE(problem.expected.find("read once"), std::string::npos) << problem.text();
  EXPECT_TRUE(problem.suggestion.empty()) << problem.text();
}

TEST_F(Load, AMisspeltComponentSilencesWhatNeedsIt) {
  const Problem problem = problemOf(
      "<Node><TestStaet name='dofs'/><TestForce youngModulus='1'/>"
      "<TestForce name='f' youngModulus='1' mstate='@dofs'/>"
      "<TestMesh position='@dofs.position'/></Node>");
  EXPECT_EQ(problem.suggestion, "TestState");
  EXPECT_EQ(problemsOf("<Node><Zzzzzzzz name='x'/><TestMesh position='@x.position'/></Node>").size(), 1u);
}

TEST_F(Load, RequiredPhysicalAndTwiceGivenAttributes) {
  const Problem problem = problemOf("<Node><TestLoader name='l'/></Node>");
  EXPECT_EQ(problem.path, "/l.filename");
  try {
    load("<Node><TestState/><TestForce youngModulus='soft'/></Node>");
    ADD_FAILURE();
  } catch (const SceneError& error) {
    EXPECT_EQ(error.diagnostics().problems().size(), 1u) << "a wrong value is not also a missing one";
  }
  const Scene scene = load("<Node><TestState/><TestForce name='f'/></Node>");
  ASSERT_EQ(scene.diagnostics.problems().size(), 1u);
  EXPECT_NE(scene.diagnostics.text().find("youngModulus is not given: the default 5000 Pa is used"), std::string::npos);
  EXPECT_NE(problemOf("<Node><TestMesh position='0 0 0' tetras='0 1 2 3' tetrahedra='0 1 2 3'/></Node>")
                .message.find("given twice"),
            std::string::npos);
}

TEST_F(Load, DuplicateNames) {
  const Problem problem = problemOf("<Node>\n<TestMesh name='m'/>\n<TestState name='m'/></Node>");
  EXPECT_EQ(problem.where.line, 3);
  EXPECT_NE(problem.message.find("scene.xml:2:1"), std::string::npos);
  problemOf("<Node><Node name='a'/><Node name='a'/></Node>");
  load("<Node><TestMesh name='a'/><Node name='a'/></Node>");
}

TEST_F(Load, GravityIsInheritedAndTheTimeStepIsTheRoots) {
  const Scene scene = load(
      "<Node dt='0.5' time='2' gravity='0 0 -1'><Node name='a'/><Node name='b' gravity='1 0 0'>"
      "<Node name='c'/></Node></Node>");
  EXPECT_EQ(scene.root->findChild("a")->gravity(), Vec3(0, 0, -1));
  EXPECT_EQ(scene.root->findChild("b")->findChild("c")->gravity(), Vec3(1, 0, 0));
  EXPECT_EQ(scene.root->findChild("b")->findChild("c")->dt(), 0.5);
  EXPECT_EQ(scene.root->root_time, 2);
  EXPECT_EQ(load("<Node/>").root->gravity(), Vec3(0, -9.81, 0));
  EXPECT_NE(problemOf("<Node><Node name='a' dt='0.1'/></Node>").message.find("child node"), std::string::npos);
  EXPECT_NE(problemOf("<Node dt='-1'/>").message.find("time step"), std::string::npos);
  for (const std::string dt : {"1e308", "1e-200"}) {
    const Problem problem = problemOf("<Node dt='" + dt + "'/>");
    EXPECT_NE(problem.message.find("its square is not a finite number"), std::string::npos) << problem.message;
    EXPECT_EQ(problem.expected, "a value from 1e-150 to 1e+150 s");
  }
  EXPECT_EQ(problemOf("<Node gravity='0 0'/>").path, "/.gravity");
}

TEST_F(Load, Templates) {
  load("<Node><TestState template='Vec3d'/><TestMesh template='CompressedRowSparseMatrixMat3x3d'/></Node>");
  EXPECT_NE(problemOf("<Node><TestState template='Rigid4'/></Node>").expected.find("Vec3"), std::string::npos);
}

TEST_F(Load, VisualsHaveNoEffectAndAreSummedUp) {
  const Scene scene = load(
      "<Node name='root' showBoundingTree='1'>"
      "  <RequiredPlugin name='Sofa.Component.Mass'/><VisualStyle displayFlags='showAll'/><DefaultAnimationLoop/>"
      "  <TestState showObject='1' name='s' _position='junk' NOvelocity='junk' printLog='1' tags='a b' listening='1'/>"
      "  <TestForce glow='1' youngModulus='1'/>"
      "  <Node name='visual'><MeshOBJLoader name='m' filename='absent.obj'/><OglModel "
      "src='@m'/><IdentityMapping/></Node>"
      "</Node>");
  const std::vector<std::string> expected = {"Node.showBoundingTree", "RequiredPlugin",       "VisualStyle",
                                             "DefaultAnimationLoop",  "TestState.showObject", "TestForce.glow",
                                             "node /visual"};
  EXPECT_EQ(scene.no_effect, expected);
  EXPECT_EQ(scene.root->children().size(), 0u);
  EXPECT_TRUE(scene.diagnostics.problems().empty()) << scene.diagnostics.text();
}

TEST_F(Load, AVisualNodeThatHoldsMechanicsIsNotPassedOver) {
  EXPECT_EQ(problemOf("<Node><Node name='v'><OglModel/><Unheard/></Node></Node>").path, "/v/Unheard");
}

TEST_F(Load, AnInactiveNodeTakesNoPartAndIsSaidSo) {
  const Scene scene = load("<Node><Node name='off' activated='false'><Whatever/></Node></Node>");
  EXPECT_TRUE(scene.root->children().empty());
  EXPECT_NE(scene.diagnostics.text().find("/off: the node is not activated"), std::string::npos);
}

TEST_F(Load, RenamedAndRemovedComponents) {
  EXPECT_NE(problemOf("<Node><BoxConstraint/></Node>").suggestion.find("BoxROI"), std::string::npos);
  EXPECT_EQ(problemOf("<Node><FixConstraint/></Node>").suggestion, "FixedProjectiveConstraint") << "by an older name";
  EXPECT_NE(problemOf("<Node><SparseGrid/></Node>").message.find("now called SparseGridTopology"), std::string::npos);
  factory.add<TestMesh>("MeshTopology", "stands for the real one");
  const Scene scene = load("<Node><Mesh position='1 2 3'/></Node>");
  EXPECT_EQ(get<TestMesh>(scene, "/MeshTopology").type(), "MeshTopology");
  EXPECT_NE(scene.diagnostics.text().find("Mesh is called MeshTopology since SOFA 24.12"), std::string::npos);
}

/// Stands for the mass whose attributes were renamed.
class OldMass : public Component {
 public:
  void declare(DataTable& table) override { table.add("totalMass", total_mass_).help("mass").unit("kg"); }
  std::string roleText() const override { return "mass"; }

 private:
  double total_mass_ = 1;
};

TEST_F(Load, RenamedAttributes) {
  factory.add<OldMass>("UniformMass", "mass");
  const Scene scene = load("<Node><UniformMass totalmass='3'/></Node>");
  EXPECT_EQ(findComponent(*scene.root, "/UniformMass")->data().find("totalMass")->print(), "3");
  EXPECT_NE(scene.diagnostics.text().find("called totalMass now"), std::string::npos);
  EXPECT_NE(problemOf("<Node><UniformMass totalmass='3' totalMass='4'/></Node>").message.find("given twice"),
            std::string::npos);
}

TEST_F(Load, Overrides) {
  const std::string text =
      "<Node name='root'><TestState position='0 0 0'/><Node name='liver'>"
      "<TestState position='0 0 0'/><TestForce name='fem' youngModulus='1' method='small'/></Node></Node>";
  Scene scene =
      load(text, {Override::parse("/liver/fem.method=polar"), Override::parse("/root/liver/fem.youngModulus=2 3"),
                  Override::parse("liver/TestState.velocity=1 1 1"), Override::parse("dt=0.25"),
                  Override::parse("/liver.gravity=0 0 1")});
  const auto& fem = get<TestForce>(scene, "/liver/fem");
  EXPECT_EQ(fem.method, TestForce::Method::polar);
  EXPECT_EQ(fem.young, (std::vector<double>{2, 3}));
  EXPECT_EQ(fem.data().find("method")->origin(), DataOrigin::by_override);
  EXPECT_EQ(get<TestState>(scene, "/liver/TestState").velocity.size(), 1u);
  EXPECT_EQ(scene.root->dt(), 0.25);
  EXPECT_EQ(scene.root->findChild("liver")->gravity(), Vec3(0, 0, 1));

  EXPECT_EQ(problemOf(text, {Override::parse("/livre/fem.method=polar")}).suggestion, "/liver/fem");
  const Problem problem = problemOf(text, {Override::parse("/liver/fem.method=ploar")});
  EXPECT_EQ(problem.suggestion, "polar");
  EXPECT_NE(problem.text().find("--set /liver/fem.method"), std::string::npos);
  EXPECT_EQ(problemOf(text, {Override::parse("/liver/fem.metod=polar")}).suggestion, "method");
  for (const char* bad : {"nothing", "/liver/fem=1", "/liver/fem.=1", ""})
    EXPECT_THROW(Override::parse(bad), std::invalid_argument) << bad;
}

/// The component has the name of the one that it stands for, whatever the order in which things are set.
TEST_F(Load, AnOverridePutsAnotherComponentInThePlaceOfOne) {
  const std::string text =
      "<Node name='root'><TestState position='0 0 0'/><TestMesh name='part' position='0 0 0'/>"
      "<Node name='liver'><TestState position='0 0 0'/><TestForce youngModulus='1' method='small'/></Node></Node>";
  const Scene scene = load(text, {Override::parse("/part.method=small"), Override::parse("/part = TestForce youngModulus=2 3 method=polar"),
                                  Override::parse("/root/liver/TestForce=TestMesh position=1 2 3")});
  const auto& part = get<TestForce>(scene, "/part");
  EXPECT_EQ(part.young, (std::vector<double>{2, 3}));
  EXPECT_EQ(part.method, TestForce::Method::small);
  EXPECT_EQ(get<TestMesh>(scene, "/liver/TestForce").position.size(), 1u);

  EXPECT_EQ(problemOf(text, {Override::parse("/part=TestFroce youngModulus=1")}).suggestion, "TestForce");
  EXPECT_NE(problemOf(text, {Override::parse("/part=TestFroce youngModulus=1")}).text().find("--set /part"), std::string::npos);
  EXPECT_EQ(problemOf(text, {Override::parse("part=TestForce youngModulus=1")}).suggestion, "/part=TestForce youngModulus=1");
  EXPECT_NE(problemOf(text, {Override::parse("/part=TestMesh lonely")}).message.find("lonely"), std::string::npos);
  EXPECT_NE(problemOf(text, {Override::parse("/liver=TestForce")}).message.find("this is a node"), std::string::npos);
}

TEST_F(Load, AnOverrideReplacesAnAttributeWrittenUnderItsAlias) {
  const Scene scene =
      load("<Node><TestMesh name='m' tetras='@nothing.at.all'/></Node>", {Override::parse("/m.tetrahedra=0 1 2 3")});
  EXPECT_EQ(get<TestMesh>(scene, "/m").tetrahedra.size(), 1u);
}

TEST_F(Load, FilesAreSearchedInOrder) {
  TemporaryFolder data;
  data.write("mesh.txt", "12");
  const std::string text = "<Node><TestLoader name='l' filename='mesh.txt'/></Node>";
  setenv("SOFA_DATA_PATH", data.path().c_str(), 1);
  EXPECT_EQ(get<TestLoader>(load(text), "/l").position.size(), 2u);
  TemporaryFolder nearer;
  nearer.write("mesh.txt", "123");
  setenv("STROMA_DATA_PATH", nearer.path().c_str(), 1);
  EXPECT_EQ(get<TestLoader>(load(text), "/l").position.size(), 3u);
  folder.write("mesh.txt", "1234");
  EXPECT_EQ(get<TestLoader>(load(text), "/l").position.size(), 4u);
  const Problem problem = problemOf("<Node><TestLoader name='l' filename='none.txt'/></Node>");
  for (const TemporaryFolder* searched : {&folder, &nearer, &data})
    EXPECT_NE(problem.suggestion.find(searched->path()), std::string::npos) << problem.text();
  unsetenv("STROMA_DATA_PATH");
  unsetenv("SOFA_DATA_PATH");
  EXPECT_NE(problemOf("<Node><TestLoader name='l' filename='.'/></Node>").suggestion.find("where it is a folder"), std::string::npos);
  TemporaryFolder third;
  third.write("far.txt", "12345");
  EXPECT_EQ(get<TestLoader>(load("<Node><TestLoader name='l' filename='far.txt'/><AddResourceRepository path='" +
                                 third.path() + "'/></Node>"),
                            "/l")
                .position.size(),
            5u);
}

TEST_F(Load, AMissingSceneFileIsASentence) {
  try {
    loadScene(folder.path("absent.scn"), {}, factory, modules);
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("absent.scn: error: the scene file is not found"), std::string::npos);
  }
}

// ---- includes ----

TEST_F(Load, IncludesAsNodeGroupAndMerge) {
  std::filesystem::create_directory(folder.path("parts"));
  folder.write("parts/points.txt", "123");
  folder.write("parts/organ.xml",
               "<Node name='organ'><TestLoader name='l' filename='points.txt'/>"
               "<TestState name='s' position='@l.position'/></Node>");
  folder.write("parts/group.xml", "<Group><TestMesh name='g1'/><Node name='g2'/></Group>");
  folder.write("parts/merge.xml",
               "<Node name='_Merge_'><TestState name='mine' velocity='1 1 1'/><TestMesh name='new'/></Node>");
  const Scene scene = load(
      "<Node><TestState name='mine' position='0 0 0'/><include href='parts/organ.xml'/>"
      "<include href='parts/organ.xml' name='second'/><include href='parts/group.xml'/><include "
      "href='parts/merge.xml'/></Node>");
  EXPECT_EQ(get<TestState>(scene, "/organ/s").position.size(), 3u) << "files are found beside the included file";
  EXPECT_EQ(get<TestState>(scene, "/second/s").position.size(), 3u);
  EXPECT_NE(findComponent(*scene.root, "/g1"), nullptr);
  EXPECT_NE(scene.root->findChild("g2"), nullptr);
  const auto& merged = get<TestState>(scene, "/mine");
  EXPECT_EQ(merged.position.size(), 1u);
  EXPECT_EQ(merged.velocity.size(), 1u);
  EXPECT_NE(findComponent(*scene.root, "/new"), nullptr);
  EXPECT_EQ(scene.description.files.size(), 5u);
}

TEST_F(Load, IncludeReplacesAttributesThatTheFileWrites) {
  folder.write("part.xml",
               "<Node name='part'><TestForce name='f' youngModulus='1' scale='1'/>"
               "<TestForce name='g' youngModulus='1' scale='1'/><TestState/></Node>");
  const Scene scene = load(
      "<Node><include href='part.xml' name='x' youngModulus='7' g__scale='3'/>"
      "<include href='part.xml' name='y'/></Node>");
  EXPECT_EQ(get<TestForce>(scene, "/x/f").young[0], 7);
  EXPECT_EQ(get<TestForce>(scene, "/x/g").young[0], 7);
  EXPECT_EQ(get<TestForce>(scene, "/x/f").scale, 1);
  EXPECT_EQ(get<TestForce>(scene, "/x/g").scale, 3);
  EXPECT_EQ(get<TestForce>(scene, "/y/g").scale, 1);
  EXPECT_EQ(problemOf("<Node><include href='part.xml' youngModulos='7'/></Node>").suggestion, "youngModulus");
  EXPECT_EQ(problemsOf("<Node><include href='part.xml' youngModulus='soft'/></Node>").size(), 2u);
}

TEST_F(Load, IncludesThatCannotBe) {
  folder.write("self.xml", "<Node><include href='other.xml'/></Node>");
  folder.write("other.xml", "<Node>\n  <include href='self.xml'/></Node>");
  const Problem circle = problemOf("<Node><include href='self.xml'/></Node>");
  EXPECT_NE(circle.message.find("includes itself"), std::string::npos);
  EXPECT_NE(circle.message.find("self.xml -> "), std::string::npos);
  EXPECT_EQ(circle.where.line, 2);
  EXPECT_NE(problemOf("<Node><include href='scene.xml'/></Node>").message.find("includes itself"), std::string::npos);
  EXPECT_NE(problemOf("<Node><include href='absent.xml'/></Node>").suggestion.find(folder.path()), std::string::npos);
  EXPECT_NE(problemOf("<Node><include/></Node>").message.find("name a file"), std::string::npos);
  folder.write("broken.xml", "<Node><A");
  EXPECT_NE(problemOf("<Node><include href='broken.xml'/></Node>").where.file.find("broken.xml"), std::string::npos);
}

TEST_F(Load, AnUnknownTypeMayBeAPrefab) {
  std::filesystem::create_directories(folder.path("Objects"));
  folder.write("Objects/Leg.xml", "<Node name='leg'><TestForce name='f' youngModulus='1'/><TestState/></Node>");
  folder.write("Objects/TestMesh.xml", "<Node name='never'/>");
  const Scene scene = load("<Node><Leg/><Leg name='left' youngModulus='7'/><TestMesh name='mesh'/></Node>");
  EXPECT_EQ(get<TestForce>(scene, "/leg/f").young[0], 1);
  EXPECT_EQ(get<TestForce>(scene, "/left/f").young[0], 7);
  EXPECT_NE(findComponent(*scene.root, "/mesh"), nullptr) << "a component comes before a prefab";
  EXPECT_EQ(problemOf("<Node><TestMehs/></Node>").suggestion, "TestMesh");

  std::filesystem::create_directories(folder.path("library/Objects"));
  folder.write("library/Objects/Arm.xml", "<Group><TestState name='arm'/></Group>");
  folder.write("library/Objects/Circle.xml", "<Node><Circle/></Node>");
  EXPECT_EQ(problemsOf("<Node><Arm/></Node>").size(), 1u);
  setenv("SOFA_DATA_PATH", folder.path("library").c_str(), 1);
  const Scene with_path = load("<Node><Arm/></Node>");
  EXPECT_NE(problemOf("<Node><Circle/></Node>").message.find("includes itself"), std::string::npos);
  unsetenv("SOFA_DATA_PATH");
  EXPECT_NE(findComponent(*with_path.root, "/arm"), nullptr);
}

TEST_F(Load, ATowerOfIncludesIsBounded) {
  for (int i = 0; i < 40; ++i)
    folder.write("f" + std::to_string(i) + ".xml", "<Group><include href='f" + std::to_string(i + 1) +
                                                       ".xml'/><include href='f" + std::to_string(i + 1) +
                                                       ".xml'/></Group>");
  ReadLimits limits;
  limits.file_bytes = 1u << 20;
  Diagnostics diagnostics;
  readScene(folder.path("f0.xml"), {}, limits, diagnostics);
  EXPECT_TRUE(diagnostics.hasErrors());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::testing
