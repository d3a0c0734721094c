// SPDX-License-Identifier: LGPL-2.1-or-later
// `check` refuses what `run` refuses at its start, and nothing else: in every example scene, and in the example of every
// manual page, each attribute of each component is made wrong in turn, in each way that its type allows.
//
// Both commands load alike, so a scene that does not load agrees. One that loads and that check lets pass must begin and
// make a step, whatever the step then is: a step that diverges is a result.
//
// Left out, for time:
// - a value that the table of parameters refuses by itself, where another manual page has had it, and in the example
//   scenes: no scene plays a part in that;
// - of each attribute all values but one or two, unless the scene is the example of its component's own page: a hash of the scene
//   and the attribute says which. So values meet many scenes, and a scene that is tried alone has the same ones;
// - so many nodes that a mesh or a rod of them takes minutes: 100000 of a mesh, a densityOfBeams of 1000000.
// And of the example scenes:
// - a component that repeats another one of the scene, of the same type and name (the five beams of cantilever.xml);
// - meshes of many nodes: the organs and the leg have a block of few, some of them in each of their regions, grids and the
//   skin have fewer, the bowl has four sides, and two balls meet in it;
// - all but the first precomputation of leg.xml's matrix: it is kept in a cache folder.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>

#include "tests/support/manual_examples.h"
#include "tests/support/shell.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

namespace fs = std::filesystem;

/// Values that a sound scene does not have there, by the type of the attribute. Some are right for some attributes.
struct WrongValues {
  using List = std::vector<std::string>;
  bool is_input;

  List operator()(const bool*) const { return {"perhaps", "true", "false"}; }
  List operator()(const int*) const { return {"-1", "0", "100000", "1.5", "nan"}; }  // some of them are counts of iterations
  List operator()(const double*) const { return {"-1", "0", "1e300", "-1e300", "nan", "inf", "much", ""}; }
  List operator()(const std::string*) const { return {"", "no_such_word"}; }
  List operator()(const Vec3*) const { return {"0 0 0", "1e300 0 0", "-1 -1 -1", "1 2", "nan 0 0"}; }
  List operator()(const std::array<int, 3>*) const { return {"0 0 0", "-1 2 2", "1 1 1", "2 2"}; }
  List operator()(const std::array<double, 16>*) const { return {"0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0", "1 2 3"}; }
  List operator()(const std::vector<bool>*) const { return {"", "0 0 0", "1 0 1 0 1 0 1", "perhaps"}; }
  List operator()(const std::vector<int>*) const { return {"", "-1", "1000000", "0 0", "0 1 2", "one"}; }
  List operator()(const std::vector<double>*) const { return {"", "-1", "0", "1e300", "1 2 3 4 5 6 7", "inf"}; }
  List operator()(const std::vector<Vec3>*) const {
    return {"", "0 0 0", "1e300 0 0", "0 0 0  0 0 0  0 0 0  0 0 0  0 0 0", "1 2 3 4"};
  }
  List operator()(const std::vector<std::string>*) const { return {"", "no_such_word", "no=such.word", "strain"}; }
  template <std::size_t n>
  List operator()(const std::vector<std::array<Index, n>>*) const {
    std::string same, far, one;
    for (std::size_t i = 0; i < n; ++i) same += "0 ", far += "1000000 ", one += std::to_string(i) + " ";
    return {"", same, far, one, "0", one + "-1"};
  }
  List operator()(const FileName*) const {
    if (is_input) return {"", "no_such_file.msh", "."};
    return {"", ".", "/dev/null/none", std::string(300, 'x')};
  }
  List operator()(const ChoiceRef& choice) const {
    List words = choice.words;
    words.push_back("no_such_word");
    return words;
  }
  List operator()(const LinkBase*) const { return {"", "@nowhere", "@/", "@.", "no_such_word"}; }
};

/// One value of one attribute.
struct Change {
  std::string type, path, attribute, value;
  bool parses = true;    ///< the table of parameters takes it
  bool repeats = false;  ///< another component of this type and name has had its turn
  std::string text() const { return fmt::format("{}.{}='{}'", path, attribute, value.substr(0, 40)); }
};

/// So many nodes are no wrong value of a mesh that is made, or of a rod that is divided, and take minutes.
bool makesNodes(const Component& component, const Data& data, const std::string& value) {
  if (data.name() == "densityOfBeams") return value == "1000000";
  const bool is_mesh = component.roleText() == "mesh engine" || component.roleText() == "topology";
  return is_mesh && value == "100000" && std::holds_alternative<int*>(data.pointer());
}

std::vector<Change> changesOf(const Simulation& simulation, Factory& factory) {
  std::vector<Change> changes;
  std::vector<Component*> components;
  simulation.root().collect(components);
  std::set<std::pair<std::string, std::string>> seen;
  for (const Component* component : components) {
    const bool repeats = !seen.insert({component->type(), component->name()}).second;
    const auto scratch = factory.make(component->type());
    for (const Data& data : component->data().all()) {
      if (data.isOutput()) continue;
      std::vector<std::string> values = std::visit(WrongValues{data.isInputFile()}, data.pointer());
      if (!data.link()) values.push_back("@nowhere.position");
      for (const std::string& value : values) {
        if (makesNodes(*component, data, value)) continue;
        const bool parses = !value.starts_with("@nowhere.") &&
                            !scratch->data().find(data.name())->parse(value, DataOrigin::written).has_value();
        changes.push_back({component->type(), component->path(), data.name(), value, parses, repeats});
      }
    }
  }
  for (const char* dt : {"0", "-1", "1e300", "1e-300", "soon"}) changes.push_back({"Node", "/", "dt", dt});
  for (const char* gravity : {"0 0", "1e300 0 0", "0 0 0"}) changes.push_back({"Node", "/", "gravity", gravity});
  for (const char* time : {"-1", "1e300", "now"}) changes.push_back({"Node", "/", "time", time});
  return changes;
}

/// A block of nodes at all of these coordinates, six tetrahedra in each cell, with the groups that the leg has.
std::string blockMesh(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z) {
  std::string nodes, elements;
  int count = 0;
  const auto add = [&](int type, std::size_t group, std::initializer_list<std::size_t> corners) {
    elements += fmt::format("{} {} 2 {} {}", ++count, type, group, group);
    for (const std::size_t corner : corners) elements += fmt::format(" {}", corner + 1);
    elements += "\n";
  };
  const std::size_t step[] = {1, x.size(), x.size() * y.size()};
  for (std::size_t k = 0; k < z.size(); ++k)
    for (std::size_t j = 0; j < y.size(); ++j)
      for (std::size_t i = 0; i < x.size(); ++i) {
        const std::size_t node = i + step[1] * j + step[2] * k, last = node + step[0] + step[1] + step[2];
        nodes += fmt::format("{} {} {} {}\n", node + 1, x[i], y[j], z[k]);
        if (i + 1 == x.size() || j + 1 == y.size() || k + 1 == z.size()) continue;
        if (k == 0) add(2, 1, {node, node + step[1], node + step[0] + step[1]});
        for (std::size_t c = 0; c < 3; ++c) {  // along c and another direction to the opposite corner
          const std::size_t first = node + step[c], next = first + step[(c + 1) % 3], other = first + step[(c + 2) % 3];
          add(4, 1 + i % 3, {node, first, next, last});
          add(4, 1 + i % 3, {node, other, first, last});
        }
      }
  return fmt::format(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"soft.outside\"\n3 1 \"soft\"\n3 2 \"tibia\"\n"
      "3 3 \"fibula\"\n$EndPhysicalNames\n$Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
      x.size() * y.size() * z.size(), nodes, count, elements);
}

/// What makes an example scene small, see above; `folder` has organ.msh, leg.msh and skin.msh.
std::vector<Override> overridesOf(const std::string& scene, const std::string& folder, const std::string& cache) {
  const std::string organ = folder + "/organ.msh";
  if (scene == "leg.xml") return {{"/leg/loader", "filename", folder + "/leg.msh"}, {"/leg/solver", "cacheFolder", cache}};
  if (scene == "liver.xml") return {{"/liver/loader", "filename", organ}};
  if (scene == "organ_embedded.xml")
    return {{"/organ/loader", "filename", organ}, {"/organ/fine/loader", "filename", organ}};
  if (scene == "mesh_matrix_mass.xml") return {{"/block/loader", "filename", organ}};
  if (scene == "contact_tool.xml") return {{"/block/mesh", "n", "4 3 2"}};
  if (scene == "lifted_cube.xml") return {{"/cube/mesh", "n", "3 3 3"}};
  if (scene == "folded_sheet.xml") return {{"/grid", "n", "5 3 1"}};
  if (scene == "balls_in_a_bowl.xml")
    return {{"/bowl/mesh", "position", "0 0 0  0.11 0.05 0  0 0.05 0.11  -0.11 0.05 0  0 0.05 -0.11"},
            {"/bowl/mesh", "triangles", "0 2 1  0 3 2  0 4 3  0 1 4"},
            {"/balls/dofs", "position", "0.04 0.06 0.005  -0.03 0.08 0.02"}};
  if (scene == "skin.xml") return {{"/patch/loader", "filename", folder + "/skin.msh"}};
  if (scene == "carving.xml") return {{"/tissue/mesh", "n", "7 3 4"}};
  if (scene == "cartilage.xml") return {{"/block/grid", "n", "4 4 3"}};
  if (scene == "quadratic.xml") return {{"/grid", "n", "3 3 3"}};
  if (scene.starts_with("organ")) return {{"/organ/loader", "filename", organ}};
  return {};
}

/// Both as they are in one process: check is Session::load() and Simulation::checkOutputs(), run goes on from there.
class CheckAndRunAgree : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    before_ = fs::current_path();
    fs::current_path(folder_);
    fs::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", "scenes");
    writeExampleFiles("meshes");
    write("organ.msh", blockMesh({-0.1, -0.035, 0.03, 0.11}, {-0.05, 0, 0.045}, {-0.06, -0.025, 0.02, 0.06}));
    write("leg.msh", blockMesh({-0.05, -0.02, 0.01, 0.05}, {-0.05, -0.01, 0.021, 0.05}, {0.03, 0.17, 0.235, 0.33}));
  }
  void TearDown() override {
    session_.unload();
    fs::current_path(before_);
    fs::remove_all(cache());
    CommandTest::TearDown();
  }
  std::string cache() const { return folder_.string() + ".cache"; }

  /// What check says: empty when it lets the scene pass.
  std::string check(const std::string& scene, const std::vector<Override>& overrides) {
    try {
      session_.load(scene, overrides).checkOutputs();
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  /// What run says then, the end of its files included: of a step that diverges nothing.
  std::string run() {
    try {
      const RunReport report = session_.run({.steps = 1});
      session_.unload();
      return report.end == RunEnd::output_failed ? report.reason : "";
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  /// How many files and folders the test's folder has.
  std::ptrdiff_t entries() const {
    return std::distance(fs::recursive_directory_iterator(folder_), fs::recursive_directory_iterator());
  }
  /// `whole`: types that have all values here; `text` tells scenes apart.
  void tryAll(const std::string& scene, const std::string& text, const std::set<std::string>& whole, bool is_example,
              const std::vector<Override>& overrides);
  void leaveOut(std::vector<Change>& changes, const std::string& text, const std::set<std::string>& whole, bool is_example);

  Session session_;
  fs::path before_;
  long tried_ = 0, refused_ = 0;
  using Attribute = std::pair<std::string, std::string>;   ///< type and name
  std::set<std::array<std::string, 3>> refused_by_table_;  ///< type, attribute and value
  static constexpr std::size_t of_page = 1, of_example = 2;  ///< values of an attribute that has all in another scene
};

/// FNV-1a: the same in every build and every process, which std::hash need not be.
std::size_t hashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ std::uint8_t(c)) * 1099511628211u;
  return std::size_t(hash >> 16);
}

/// What the head of this file says.
void CheckAndRunAgree::leaveOut(std::vector<Change>& changes, const std::string& text, const std::set<std::string>& whole,
                                bool is_example) {
  std::map<Attribute, std::size_t> count, place;
  for (const Change& change : changes) ++count[{change.type, change.attribute}];
  std::erase_if(changes, [&](const Change& change) {
    const Attribute attribute{change.type, change.attribute};
    if (whole.count(change.type)) return false;
    const std::size_t all = count[attribute], first = hashOf(text + change.type + change.attribute) % all, turn = place[attribute]++;
    return (turn + all - first) % all >= (is_example ? of_example : of_page);
  });
  std::erase_if(changes, [&](const Change& change) {
    if (is_example && (!change.parses || change.repeats)) return true;
    return !change.parses && !refused_by_table_.insert({change.type, change.attribute, change.value}).second;
  });
}

void CheckAndRunAgree::tryAll(const std::string& scene, const std::string& text, const std::set<std::string>& whole, bool is_example,
                              const std::vector<Override>& overrides) {
  SCOPED_TRACE(scene);
  ASSERT_EQ(check(scene, overrides), "");
  std::vector<Change> changes = changesOf(session_.simulation(), session_.factory());
  leaveOut(changes, text, whole, is_example);
  ASSERT_EQ(run(), "");
  std::ptrdiff_t entries_before = -1;  // not known
  for (const Change& change : changes) {
    ++tried_;
    std::vector<Override> with = overrides;
    with.push_back({change.path, change.attribute, change.value});
    if (entries_before < 0) entries_before = entries();
    const std::string refusal = check(scene, with);
    // the folder of a precomputation, which run then finds, is all that check may write
    const std::ptrdiff_t entries_now = entries();
    if (change.attribute != "cacheFolder")
      EXPECT_EQ(entries_now, entries_before) << change.text() << ": check has written";
    entries_before = entries_now;
    if (!refusal.empty()) {
      ++refused_;
      continue;
    }
    entries_before = -1;  // what run leaves is counted then
    if (const std::string said = run(); !said.empty())
      ADD_FAILURE() << change.text() << ": check lets it pass, and run says: " << said;
  }
}

TEST_F(CheckAndRunAgree, OnTheExampleOfEveryManualPage) {
  Factory factory;
  const Modules modules(factory);
  std::map<std::string, std::set<std::string>> examples;  // with the types of whose pages they are
  for (const auto& entry : modules.index())
    examples[exampleIn(modules.manual(std::string(entry.type)))].insert(std::string(entry.type));
  ASSERT_GT(examples.size(), 50u);
  for (const auto& [example, types] : examples) {
    write("example.xml", example);
    tryAll("example.xml", example, types, false, {});
  }
  EXPECT_GT(refused_, tried_ / 3) << "most values are not wrong";
  EXPECT_LT(refused_, tried_) << "nothing ran";
}

/// A test for each scene: they take longest.
class CheckAndRunAgreeOn : public CheckAndRunAgree, public testing::WithParamInterface<std::string> {};

TEST_P(CheckAndRunAgreeOn, EveryWrongAttribute) {
  if (GetParam() == "skin.xml")
    ASSERT_EQ(shell("python3 " STROMA_SOURCE_DIR "/scenes/meshes/make_skin.py --cells 4 --out skin.msh").code, 0);
  tryAll("scenes/examples/" + GetParam(), GetParam(), {}, true, overridesOf(GetParam(), folder_.string(), cache()));
  EXPECT_GT(refused_, 0);
  EXPECT_LT(refused_, tried_) << "nothing ran";
}

std::vector<std::string> exampleScenes() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(STROMA_SOURCE_DIR "/scenes/examples"))
    if (entry.path().extension() == ".xml") names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Examples, CheckAndRunAgreeOn, testing::ValuesIn(exampleScenes()),
                         [](const auto& tested) { return tested.param.substr(0, tested.param.find('.')); });

// ---- the commands themselves ----

const char* const block = R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver/>{}
  <RegularGridTopology name="grid" n="{}" min="0 0 0" max="1 1 1"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField name="fem" youngModulus="1000" poissonRatio="0.3"/>{}</Node>)";

struct Refused {
  std::string scene, expected;
};

class TheCommandsAgree : public CommandTest {};

/// What loading alone does not show: each is refused in the same words, with nothing written.
TEST_F(TheCommandsAgree, OnWhatKeepsARunFromItsFirstStep) {
  write("file", "");
  std::string recording = "T= 0\n  X=";
  for (int i = 0; i < 27 * 3; ++i) recording += " 0";
  write("results/scene/last/run.instants", recording + "\n");
  fs::create_directory(folder_ / "folder");
  const auto with = [](const std::string& what) { return fmt::format(fmt::runtime(block), "", "3 3 3", what); };
  const std::string other =
      R"(<Node name="other"><EulerExplicitSolver/><RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/>
    <MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField name="fem" youngModulus="1" poissonRatio="0"/></Node>)";
  const std::string surface = R"(<Node name="skin"><MeshTopology position="@../grid.position" triangles="0 1 3"/>
    <VTKExporter cellsDataFields="strain=@../fem.strain")";
  const std::string lone = R"(<Node><Node name="a"><MechanicalObject name="dofs" position="0 0 0"/>)";
  const std::vector<Refused> cases = {
      {with(surface + "/></Node>"), "gives 'strain' for 8 hexahedra, but the exported mesh has 0"},
      {with(surface + " exportEveryNumberOfSteps='50'/></Node>"), "gives 'strain' for 8 hexahedra"},
      {lone + R"(<Monitor indices="0" ExportPositions="1"/></Node></Node>)", "no integrator moves the state /a/dofs"},
      {lone + R"(<WriteState filename="a.state"/></Node></Node>)", "no integrator moves the state /a/dofs"},
      {with(R"(<WriteState filename="file/a.state"/>)"), "file: cannot make the folder (Not a directory)"},
      {with(R"(<WriteState filename="folder"/>)"), "folder: cannot open for writing (Is a directory)"},
      {with(R"(<EnergyMonitor filename="file/a/b/energy.txt"/><VTKExporter filename="file/a"/>)"), "2 errors"},
      {with(R"(<VTKExporter filename=")" + std::string(300, 'x') + R"("/>)"), "File name too long"},
      {with(R"(<ReadState filename="results/scene/last/run.instants"/>)"), "what the run leaves to be looked at"},
      {fmt::format(fmt::runtime(block), "<CholeskySolver/>", "16 16 16", ""), "4096 nodes are too many for the dense"},
      {fmt::format(fmt::runtime(block), "<SVDLinearSolver/>", "16 16 16", ""), "4096 nodes are too many for the dense"},
      {R"(<Node>)" + other + R"(<Node>)" + with(R"(<VTKExporter cellsDataFields="stress=@/other/fem.vonMises"/>)") +
           "</Node></Node>",
       "/other/fem acts on /other/dofs, which"},
      {R"(<Node time="1e300">)" + other + "</Node>", "is lost in round-off of the time"},
  };
  for (const auto& [scene, expected] : cases) {
    write("scene.xml", scene);
    const auto entries = [this] {
      std::set<std::string> all;
      for (const auto& entry : fs::recursive_directory_iterator(folder_)) all.insert(entry.path());
      return all;
    };
    stroma("list");
    const auto before = entries();
    const Finished check = stroma("check scene.xml"), json = stroma("check scene.xml --json"),
                   run = stroma("run scene.xml -n 1");
    EXPECT_EQ(check.code, 2) << expected << check.err;
    EXPECT_EQ(json.code, 2) << expected << json.out;
    EXPECT_EQ(run.code, 2) << expected << run.err;
    EXPECT_EQ(check.err, run.err);
    EXPECT_NE(check.err.find(expected), std::string::npos) << expected << "\nis missing in\n" << check.err;
    EXPECT_NE(json.out.find("\"ok\": false"), std::string::npos) << json.out;
    EXPECT_EQ(entries(), before) << expected;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
