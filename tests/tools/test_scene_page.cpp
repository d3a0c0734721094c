// SPDX-License-Identifier: LGPL-2.1-or-later
// What docs/scene.md says of the file format is so: its scenes run, those that are refused are refused with these words,
// and the rules of its tables hold.
#include <regex>
#include <tuple>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using ScenePage = CommandTest;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string page() { return readText(STROMA_SOURCE_DIR "/docs/scene.md"); }

TEST_F(ScenePage, ItsScenesRunAndItsMistakesAreRefused) {
  const std::regex block("(?:<!-- refused: ([^\n]*) -->\n)?```xml title=\"([^\"]+)\"\n([^`]*)```");
  const std::string text = page();
  int run = 0, refused = 0;
  for (int pass = 0; pass < 2; ++pass)  // a scene may include one that comes later
    for (std::sregex_iterator at(text.begin(), text.end(), block), end; at != end; ++at) {
      const std::string words = (*at)[1], name = (*at)[2];
      write(name, (*at)[3]);
      if (pass == 0 || name == "part.xml") continue;
      const Finished finished = stroma("run " + name + " -n 3 --quiet");
      EXPECT_EQ(finished.code, words.empty() ? 0 : 2) << name << "\n" << finished.err;
      EXPECT_TRUE(has(finished.err, words)) << finished.err;
      words.empty() ? ++run : ++refused;
    }
  EXPECT_GE(run, 4);
  EXPECT_GE(refused, 3);
  const std::regex command("```sh\n(stroma [^`]*)```");
  int commands = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), command), end; at != end; ++at, ++commands) {
    const std::string line = (*at)[1].str();
    const Finished finished = stroma(line.substr(7, line.find('\n') - 7));
    EXPECT_EQ(finished.code, 0) << line << finished.err;
  }
  EXPECT_GE(commands, 1);
}

/// Two nodes that fall, and what a case adds.
std::string falling(const std::string& more, const std::string& node = "") {
  return "<Node" + node +
         "><EulerExplicitSolver/><MechanicalObject name='d' position='0 0 0  1 0 0'/><UniformMass name='m' "
         "totalMass='1'/>" +
         more + "</Node>";
}

TEST_F(ScenePage, ItsRulesHold) {
  const std::tuple<const char*, std::string, int, const char*> cases[] = {
      {"a name occurs once", falling("<FixedProjectiveConstraint name='d' indices='0'/>"), 2, "has the same name"},
      {"text is warned of", falling("hello"), 0, "has no meaning"},
      {"Object",
       "<Node><Object type='EulerExplicitSolver'/><MechanicalObject position='0 0 0'/><UniformMass "
       "totalMass='1'/></Node>",
       0, ""},
      {"types of nodes", "<Node><EulerExplicitSolver/><MechanicalObject template='Rigid4'/></Node>", 2, "Rigid4"},
      {"dt of a child", "<Node><Node dt='0.1'/></Node>", 2, "a child node cannot have its own time step"},
      {"gravity of a child", "<Node gravity='0 0 0'>" + falling("", " gravity='0 -1 0'") + "</Node>", 0, ""},
      {"a node that is off", falling("<Node activated='false'><Nonsense/></Node>"), 0, "it is left out with its contents"},
      {"an attribute of a node", falling("", " dtt='1'"), 2, "did you mean 'dt'?"},
      {"ranges", falling("<FixedProjectiveConstraint indices='1-0'/>"), 2, "not an ascending range"},
      {"whole values", falling("", " gravity='0 -9.81 0 1'"), 2, "4 numbers instead of 3"},
      {"the component before",
       falling("<BoxROI box='-1 -1 -1 .5 1 1'/><FixedProjectiveConstraint "
               "indices='@[-1].indices'/>"),
       0, ""},
      {"the node above",
       falling("<Node><MechanicalObject position='0 0 0'/><SubsetMapping input='@..' output='@.' "
               "indices='0'/></Node>"),
       0, ""},
      {"an absolute link",
       falling("<Node name='n'><MechanicalObject position='@/root/d.position'/><IdentityMapping "
               "input='@/d'/></Node>"),
       0, ""},
      {"a circle",
       falling("<BoxROI name='a' box='0 0 0 1 1 1' position='@b.pointsInROI'/><BoxROI name='b' box='0 0 0 1 1 1' "
               "position='@a.pointsInROI'/>"),
       2, "between components: /a.position -> /b.position"},
      {"an empty selection", falling("<BoxROI box='5 5 5 6 6 6'/>"), 2, "the selection is empty"},
      {"one that may be", falling("<BoxROI box='5 5 5 6 6 6' allowEmpty='true'/>"), 0, ""},
      {"what only draws", falling("<OglModel/><DefaultAnimationLoop/><Node><OglModel/><IdentityMapping/></Node>"), 0,
       "accepted without effect: OglModel, DefaultAnimationLoop, node /Node"},
      {"attributes that draw",
       "<Node><EulerExplicitSolver/><MechanicalObject position='0 0 0' showObject='1' drawAll='1' "
       "_foo='3' NOx='1' printLog='1' tags='x'/><UniformMass totalMass='1'/></Node>",
       0, "accepted without effect: MechanicalObject.showObject, MechanicalObject.drawAll\n"},
      {"an attribute twice",
       "<Node><EulerExplicitSolver/><MechanicalObject position='0 0 0'/><UniformMass totalMass='1' "
       "totalmass='2'/></Node>",
       2, "given twice"},
      {"an old name", falling("<FixedConstraint indices='0'/>"), 0, "is called FixedProjectiveConstraint"},
      {"a file", falling("<MeshGmshLoader filename='no.msh'/>"), 2, "folder"},
      {"an include that replaces", falling("<include href='p.xml' totalMass='3'/>"), 0, ""},
      {"an include that replaces nothing", falling("<include href='p.xml' totalmess='3'/>"), 2, "totalMass"},
      {"an include of itself", falling("<include href='scene.xml'/>"), 2, "a file includes itself"},
      {"a prefab", falling("<Leg name='left'/>"), 0, ""},
  };
  const std::string part = "<Node name='p'><MechanicalObject position='0 0 0'/><UniformMass totalMass='1'/></Node>";
  write("p.xml", part);
  std::filesystem::create_directories(folder_ / "Objects");
  write("Objects/Leg.xml", part);
  for (const auto& [what, scene, code, words] : cases) {
    write("scene.xml", scene);
    const Finished finished = stroma("check scene.xml");
    EXPECT_EQ(finished.code, code) << what << "\n" << finished.err;
    EXPECT_TRUE(has(finished.err, words)) << what << "\n" << finished.err;
  }
}

TEST_F(ScenePage, TheCommandPrintsItAndItsSections) {
  const Finished all = stroma("doc scene");
  EXPECT_EQ(all.code, 0);
  for (const char* part : {"The scene file\n=====", "Links\n-----", "@roi.indices", "    <Node name=\"root\""})
    EXPECT_TRUE(has(all.out, part)) << part;
  for (const char* mark : {"```", "**", "<!-- refused", "](#"}) EXPECT_FALSE(has(all.out, mark)) << mark;
  const Finished links = stroma("doc scene links");
  EXPECT_TRUE(links.out.starts_with("Links\n"));
  EXPECT_FALSE(has(links.out, "Files"));
  EXPECT_EQ(stroma("doc scene nonsense").code, 2);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
