// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene with the edits of a run: read again it is the edited scene, and all that was not edited is the same.
#include "tools/scene_writer/changed_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "framework/scene/names.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/scene_text.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string body =
    "  <TestIntegrator/>\n"
    "  <!-- four corners -->\n"
    "  <MechanicalObject name='dofs' position='0 0 0 1 0 0 0 1 0 0 0 1'/>\r\n"
    "  <MeshTopology tetrahedra='0 1 2 3'/>\n"
    "  <UniformMass   totalMass = '4'/>\n"
    "  <TetrahedronFEMForceField name='fem'\n"
    "      youngModulus = '1e3'   poissonRatio=\"0.3\" />\n";

class ChangedSceneTest : public FolderTest {
 protected:
  Simulation& load(const std::string& text, const std::vector<Override>& overrides = {}) {
    scene_ = write("scene.xml", text);
    return loadAgain(overrides);
  }
  Simulation& loadAgain(const std::vector<Override>& overrides = {}) {
    simulation_ = std::make_unique<Simulation>(loadScene(scene_, overrides, factory(), modules()));
    return *simulation_;
  }
  std::string scene_;
  std::unique_ptr<Simulation> simulation_;
};

std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const auto at = text.find(part);
  EXPECT_NE(at, text.npos) << part;
  return text.replace(at, part.size(), by);
}

std::string listed(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

TEST_F(ChangedSceneTest, EditsStandInTheTextAndNothingElseChanges) {
  const std::string text = "<Node name='root' dt='0.01'>\n" + body + "</Node>\n";
  Simulation& simulation = load(text);
  EXPECT_EQ(changedScene(simulation).texts.at(scene_), text);
  EXPECT_TRUE(changedScene(simulation).changed.empty());
  simulation.setAttribute("/fem", "youngModulus", " 2e3 ");
  simulation.setAttribute("fem", "youngModulus", "2e3");  // another path of the same one
  simulation.setAttribute("/", "dt", "0.02");
  simulation.setAttribute("/", "gravity", "0 0 -1");
  const ChangedScene changed = changedScene(simulation);
  std::string expected = replaced(text, "'1e3'", "'2e3'");
  expected = replaced(expected, "dt='0.01'", "dt='0.02' gravity=\"0 0 -1\"");
  EXPECT_EQ(changed.texts.at(scene_), expected);
  EXPECT_EQ(listed(changed.changed), scene_ + "\n");
  EXPECT_EQ(listed(changed.not_written) + listed(changed.notes), "");
}

TEST_F(ChangedSceneTest, AValueThatIsThereAlreadyStaysAsItIsSpelt) {
  const std::string text = "<Node>\n" + replaced(body, "'1e3'", "'1&#48;00'") + "</Node>\n";
  Simulation& simulation = load(text);
  simulation.setAttribute("/fem", "youngModulus", "7");
  simulation.setAttribute("/fem", "youngModulus", "1000");
  EXPECT_EQ(changedScene(simulation).texts.at(scene_), text);
}

TEST_F(ChangedSceneTest, AnotherNameOfAnAttributeIsKept) {
  const std::string springs =
      "<SpringForceField name='springs' stiffness='10' indices1='0' indices2='1' length='0.9'/>";
  const std::string text = "<Node>\n" + replaced(body, "totalMass", "totalmass") + springs + "</Node>\n";
  Simulation& simulation = load(text);
  simulation.setAttribute("/UniformMass", "totalMass", "5");  // a name it once had
  simulation.setAttribute("/springs", "lengths", "0.8");      // another accepted one
  const std::string changed = changedScene(simulation).texts.at(scene_);
  EXPECT_EQ(changed, replaced(replaced(text, "'4'", "'5'"), "'0.9'", "'0.8'"));
}

TEST_F(ChangedSceneTest, AnEditOfAnIncludedElementGoesToItsFile) {
  const std::string part = "<Node name='part'>\n" + body + "</Node>";
  const std::string part_file = write("parts/part.xml", part);
  const std::string text = "<Node><include name='a' href='parts/part.xml' fem__poissonRatio='0.2'/></Node>";
  Simulation& simulation = load(text);
  simulation.setAttribute("/a/fem", "youngModulus", "5");
  simulation.setAttribute("/a/fem", "poissonRatio", "0.1");  // which <include> gives
  simulation.setAttribute("/a", "gravity", "1 2 3");
  const ChangedScene changed = changedScene(simulation);
  EXPECT_EQ(listed(changed.not_written), "");
  ASSERT_EQ(changed.texts.size(), 2u);
  EXPECT_EQ(changed.changed.size(), 2u);
  EXPECT_EQ(changed.texts.at(scene_), replaced(text, "'0.2'", "'0.1'"));
  std::string included;
  for (const auto& [file, each] : changed.texts)
    if (file != scene_) included = each;
  EXPECT_EQ(included, replaced(replaced(part, "'1e3'", "'5'"), "name='part'", "name='part' gravity=\"1 2 3\""));
}

TEST_F(ChangedSceneTest, AFileThatIsIncludedTwiceChangesForBothOrNotAtAll) {
  const std::string part = "<Node name='part'>\n" + body + "</Node>";
  write("part.xml", part);
  const std::string text = "<Node><include name='a' href='part.xml'/><include name='b' href='./part.xml'/></Node>";
  Simulation& simulation = load(text);
  simulation.setAttribute("/a/fem", "youngModulus", "5");
  ChangedScene changed = changedScene(simulation);
  EXPECT_TRUE(changed.changed.empty());
  ASSERT_EQ(changed.not_written.size(), 1u);
  expectContains(changed.not_written[0], "/a/fem.youngModulus = '5' is not written");
  expectContains(changed.not_written[0], "makes /b/fem too");
  expectContains(changed.not_written[0], "part.xml:");
  simulation.setAttribute("/b/fem", "youngModulus", "6");
  EXPECT_EQ(changedScene(simulation).not_written.size(), 2u);
  simulation.setAttribute("/b/fem", "youngModulus", "5");
  changed = changedScene(simulation);
  EXPECT_EQ(listed(changed.not_written), "");
  EXPECT_EQ(changed.changed.size(), 1u);
}

TEST_F(ChangedSceneTest, WhatThePrefabMadeIsNotWritten) {
  const std::string part = "<Node name='Leg'>\n" + body + "</Node>";
  write("Objects/Leg.xml", part);
  const std::string text = "<Node>\n<Leg name='left' fem__poissonRatio='0.2'/></Node>";
  Simulation& simulation = load(text);
  simulation.setAttribute("/left/fem", "youngModulus", "5");
  simulation.setAttribute("/left/fem", "poissonRatio", "0.1");
  const ChangedScene changed = changedScene(simulation);
  ASSERT_EQ(changed.not_written.size(), 1u) << listed(changed.not_written);
  expectContains(changed.not_written[0], "/left/fem.youngModulus = '5' is not written");
  expectContains(changed.not_written[0], "prefab");
  EXPECT_EQ(changed.texts.at(scene_), replaced(text, "'0.2'", "'0.1'"));
}

TEST_F(ChangedSceneTest, WhatNoElementMadeIsNotWritten) {
  const std::string text =
      "<Node>\n" + replaced(body, "<TestIntegrator/>", "<EulerImplicitSolver name='step'/>") + "</Node>";
  Simulation& simulation = load(text);
  simulation.setAttribute("/PCGLinearSolver", "iterations", "50");  // the integrator brings it
  simulation.setAttribute("/step", "rayleighMass", "0.5");
  const ChangedScene changed = changedScene(simulation);
  ASSERT_EQ(changed.not_written.size(), 1u);
  expectContains(changed.not_written[0],
                 "/PCGLinearSolver.iterations = '50' is not written: no element of the scene is");
  expectContains(changed.not_written[0], "<PCGLinearSolver name='PCGLinearSolver'>");
  EXPECT_EQ(changed.texts.at(scene_), replaced(text, "name='step'", "name='step' rayleighMass=\"0.5\""));
}

TEST_F(ChangedSceneTest, OverridesOfTheStartAreNamed) {
  const std::string text = "<Node>\n" + body + "</Node>\n";
  Simulation& simulation =
      load(text, {{"/fem", "youngModulus", "30"}, {"/fem", "poissonRatio", "0.1"}, {"/", "dt", "0.5"}});
  simulation.setAttribute("/fem", "youngModulus", "40");
  simulation.setAttribute("/", "dt", "0.25");
  const ChangedScene changed = changedScene(simulation);
  EXPECT_EQ(changed.texts.at(scene_), replaced(replaced(text, "'1e3'", "'40'"), "<Node>", "<Node dt=\"0.25\">"));
  EXPECT_EQ(listed(changed.notes), "--set /fem.poissonRatio=0.1 of the start of the run is not in the text\n");
}

TEST_F(ChangedSceneTest, AFileThatChangedOnDiskIsNamedAndNotUsed) {
  const std::string text = "<Node>\n" + body + "</Node>\n";
  Simulation& simulation = load(text);
  simulation.setAttribute("/fem", "youngModulus", "40");
  EXPECT_TRUE(changedScene(simulation).notes.empty());
  write("scene.xml", "<Node/>");
  ChangedScene changed = changedScene(simulation);
  EXPECT_EQ(changed.texts.at(scene_), replaced(text, "'1e3'", "'40'"));
  EXPECT_EQ(listed(changed.notes), scene_ + " has changed since it was loaded: the text is the one that was loaded\n");
  std::filesystem::remove(scene_);
  changed = changedScene(simulation);
  EXPECT_EQ(changed.texts.at(scene_), replaced(text, "'1e3'", "'40'"));
  expectContains(listed(changed.notes), "cannot be read any more");
}

TEST_F(ChangedSceneTest, ATextFromAProgramHasNoFile) {
  const std::string text = "<Node>\n" + body + "</Node>\n";
  Simulation simulation(loadSceneText(text, file("none.xml"), {}, factory(), modules()));
  simulation.setAttribute("/fem", "youngModulus", "40");
  EXPECT_EQ(changedScene(simulation).texts.at(file("none.xml")), replaced(text, "'1e3'", "'40'"));
  EXPECT_TRUE(changedScene(simulation).notes.empty());
  Simulation described = simulationFromText(text);
  described.setAttribute("/fem", "youngModulus", "40");
  const ChangedScene changed = changedScene(described);
  EXPECT_TRUE(changed.texts.empty());
  expectContains(listed(changed.not_written), "the scene was not read from a text");
}

// ---- the example scenes ----

/// Path and attribute to value, of all elements; the type stands beside the path.
void collectValues(const NodeDescription& node, const std::string& path, std::map<std::string, std::string>& values) {
  const std::vector<std::string> components = componentNames(node), children = childNames(node);
  const auto add = [&](const std::string& element, const std::vector<AttributeDescription>& attributes) {
    for (const AttributeDescription& attribute : attributes) values[element + "." + attribute.name] = attribute.value;
  };
  add(path + " Node", node.attributes);
  for (std::size_t i = 0; i < components.size(); ++i)
    add(joinPath(path, components[i]) + " " + node.components[i].type, node.components[i].attributes);
  for (std::size_t i = 0; i < children.size(); ++i)
    collectValues(node.children[i], joinPath(path, children[i]), values);
}

/// Another value that the attribute may have, in the scene's notation; the present one where none is at hand.
std::string anotherValue(Data& data) {
  const auto print = [&data](auto* value, auto other) {
    std::swap(*value, other);
    const std::string text = data.print();
    std::swap(*value, other);
    return text;
  };
  const DataPointer& pointer = data.pointer();
  if (auto* const* real = std::get_if<double*>(&pointer)) return print(*real, **real == 0 ? 1e-3 : 0.9 * **real);
  if (auto* const* whole = std::get_if<int*>(&pointer)) return print(*whole, **whole + 2);  // one Newton iteration has a meaning of its own
  if (auto* const* flag = std::get_if<bool*>(&pointer)) return print(*flag, !**flag);
  if (auto* const* point = std::get_if<Vec3*>(&pointer)) return print(*point, Vec3(**point + Vec3(0.01, 0.02, 0)));
  return data.print();
}

/// Sets every attribute that can change in the run, one after the other, and after each compares the text read again
/// with the one before. How many were set.
int changeEverything(const std::string& scene_file, Simulation& simulation) {
  std::vector<Component*> components;
  simulation.root().collect(components);
  std::map<std::string, std::string> before;
  collectValues(simulation.scene().description.root, "/", before);
  int count = 0;
  const auto check = [&](const std::string& key, const std::string& element, const std::string& value) {
    const ChangedScene changed = changedScene(simulation);
    if (changed.texts.size() > 1) return;  // read again at the end
    if (!changed.not_written.empty()) return ADD_FAILURE() << listed(changed.not_written);
    std::map<std::string, std::string> after;
    Diagnostics diagnostics;
    collectValues(readXml(changed.texts.at(scene_file), scene_file, {}, diagnostics), "/", after);
    EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.text();
    EXPECT_EQ(after[element + "." + key], value);
    before[element + "." + key] = value;
    EXPECT_EQ(after, before) << element << "." << key;
  };
  for (Component* component : components) {
    for (Data& data : component->data().all()) {
      if (data.changeEffect() == ChangeEffect::restart || data.isOutput()) continue;
      const std::string value = anotherValue(data);
      try {
        simulation.setAttribute(component->path(), data.name(), value);
      } catch (const ComponentError&) {
        continue;
      }
      ++count;
      check(data.name(), component->path() + " " + component->type(), value);
    }
  }
  return count;
}

class ChangedExample : public FolderTest, public testing::WithParamInterface<std::string> {};

TEST_P(ChangedExample, EveryChangeableAttributeIsTheNewOneAndAllOthersAreTheSame) {
  const std::string file = STROMA_SOURCE_DIR "/scenes/examples/" + GetParam();
  Simulation simulation(loadScene(file, {}, factory(), modules()));
  simulation.dropObservers();
  for (const auto& [name, text] : changedScene(simulation).texts) {
    std::ifstream in(name, std::ios::binary);
    EXPECT_EQ(text, std::string(std::istreambuf_iterator<char>(in), {})) << name;
  }
  const auto& systems = simulation.systems();
  const bool follows = std::any_of(systems.begin(), systems.end(),
                                   [](const auto& system) { return !system->integrator().stateOwner(); });
  EXPECT_EQ(changeEverything(file, simulation) > 0, follows);
  const ChangedScene changed = changedScene(simulation);
  // beside the meshes, as the scenes are
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes/meshes", folder_ / "meshes");
  for (const auto& [name, text] : changed.texts)
    write(std::filesystem::relative(name, STROMA_SOURCE_DIR "/scenes").string(), text);
  const Simulation again(loadScene(this->file("examples/" + GetParam()), {}, factory(), modules()));
  const std::string not_written = listed(changed.not_written);
  EXPECT_TRUE(not_written.empty() || changed.texts.size() > 1) << not_written;
  std::vector<Component*> edited, read;
  simulation.root().collect(edited);
  again.root().collect(read);
  ASSERT_EQ(edited.size(), read.size());
  for (std::size_t i = 0; i < edited.size(); ++i)
    for (const Data& data : edited[i]->data().all()) {
      const std::string name = edited[i]->path() + "." + data.name();
      if (not_written.find(name + " ") != std::string::npos) continue;
      if (data.isOutput() && data.name() == "moved") continue;  // obstacles go there in the next step; what is read starts there
      EXPECT_EQ(read[i]->data().find(data.name())->print(), data.print()) << name;
    }
  EXPECT_EQ(again.dt(), simulation.dt());
}

std::vector<std::string> exampleScenes() {
  std::vector<std::string> all;
  for (const auto& entry : std::filesystem::directory_iterator(STROMA_SOURCE_DIR "/scenes/examples"))
    if (entry.path().extension() == ".xml") all.push_back(entry.path().filename().string());
  std::sort(all.begin(), all.end());
  return all;
}

INSTANTIATE_TEST_SUITE_P(AllScenes, ChangedExample, testing::ValuesIn(exampleScenes()), [](const auto& each) {
  std::string name = each.param.substr(0, each.param.find('.'));
  std::replace(name.begin(), name.end(), '_', 'X');
  return name;
});

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
