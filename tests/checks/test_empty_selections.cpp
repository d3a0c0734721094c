// SPDX-License-Identifier: LGPL-2.1-or-later
// No component takes an empty list of nodes or cells in silence: the factory says which have such lists.
#include "tools/checks/empty_selections.h"

#include <algorithm>

#include "framework/simulation/simulation.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/manual_examples.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

bool isSelection(const Data& data) {
  const auto& pointer = data.pointer();
  if (data.name() == "group") return false;  // numbers that models have or not
  return !data.isOutput() &&
         (std::holds_alternative<std::vector<int>*>(pointer) || std::holds_alternative<std::vector<Edge>*>(pointer) ||
          std::holds_alternative<std::vector<Triangle>*>(pointer) ||
          std::holds_alternative<std::vector<Quad>*>(pointer) ||
          std::holds_alternative<std::vector<Hexahedron>*>(pointer));
}

/// Meshes have kinds of cells that they do not have; regions say themselves what they select; the sets of an engine may be
/// empty, and what reads its output says so.
bool holdsCells(const Component& component) {
  const std::string role = component.roleText();
  return role == "topology" || role == "mesh loader" || role == "selection" || role == "engine" || role.find("mesh") == 0;
}

class EmptySelections : public FolderTest {
 protected:
  /// What the scene says of `path` with its list `attribute` empty: errors and warnings.
  std::string saidOf(const std::string& scene, const std::string& path, const std::string& attribute) {
    std::string text;
    const auto add = [&](const Diagnostics& diagnostics) {
      for (const Problem& problem : diagnostics.problems())
        if (problem.severity != Severity::note && problem.path.starts_with(path)) text += problem.text() + "\n";
    };
    try {
      Simulation simulation(loadSceneText(scene, file("example.xml"), {{path, attribute, ""}}, factory(), modules()));
      warnOfEmptySelections(simulation.root(), simulation.diagnostics());
      add(simulation.scene().diagnostics);
    } catch (const SceneError& error) {
      add(error.diagnostics());
    }
    return text;
  }
};

TEST_F(EmptySelections, AreSaidOfEveryComponentThatHasThem) {
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  writeExampleFiles(folder_ / "meshes");
  int tried = 0;
  for (const auto& entry : modules().index()) {
    const std::string type(entry.type);
    const std::string example = exampleIn(modules().manual(type));
    const Simulation whole(loadSceneText(example, file("example.xml"), {}, factory(), modules()));
    std::vector<Component*> components;
    whole.root().collect(components);
    const auto found = std::ranges::find(components, type, &Component::type);
    if (found == components.end() || holdsCells(**found)) continue;
    for (const Data& data : (*found)->data().all()) {
      if (!isSelection(data)) continue;
      ++tried;
      const std::string said = saidOf(example, (*found)->path(), data.name());
      EXPECT_FALSE(said.empty()) << type << "." << data.name();
      EXPECT_NE(said.find("example.xml:"), std::string::npos) << said;
    }
  }
  EXPECT_GT(tried, 25);
}

TEST_F(EmptySelections, ThatAreNotGivenAreNone) {
  writeExampleFiles(folder_ / "meshes");
  const std::string example = exampleIn(modules().manual("ContractileForceField"));
  const std::string whole = saidOf(example, "/ContractileForceField", "edges");
  EXPECT_NE(whole.find("edges is empty ("), std::string::npos) << whole;
  for (const char* type : {"ConstantForceField", "WriteState", "UniformMass"}) {
    const Simulation simulation(
        loadSceneText(exampleIn(modules().manual(type)), file("example.xml"), {}, factory(), modules()));
    EXPECT_EQ(simulation.scene().diagnostics.text().find(" is empty ("), std::string::npos) << type;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
