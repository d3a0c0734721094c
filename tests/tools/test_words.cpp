// SPDX-License-Identifier: LGPL-2.1-or-later
// The words that people look for lead to components, commands and pages that exist.
#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/scene/change_table.h"
#include "framework/scene/modules.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Words = CommandTest;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

struct Entry {
  std::string head;
  std::vector<std::string> lines;
};

/// The blocks of a table: a line that is not indented, and the indented ones below it.
std::vector<Entry> tableOf(const std::string& file) {
  std::istringstream in(readText(std::string(STROMA_SOURCE_DIR "/tools/command/words/") + file));
  std::vector<Entry> entries;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (line[0] != ' ')
      entries.push_back({line, {}});
    else
      entries.back().lines.push_back(line.substr(line.find_first_not_of(' ')));
  }
  return entries;
}

/// What stands after "key: " in the lines of an entry.
std::vector<std::string> listOf(const Entry& entry, const std::string& key, char mark) {
  std::vector<std::string> words;
  for (const std::string& line : entry.lines) {
    if (!line.starts_with(key + ": ")) continue;
    std::istringstream in(line.substr(key.size() + 2));
    for (std::string word; std::getline(in, word, mark);)
      if (const auto first = word.find_first_not_of(' '); first != std::string::npos)
        words.push_back(word.substr(first));
  }
  return words;
}

std::string nameOf(const Entry& entry) { return entry.head.substr(0, entry.head.find(" (not yet)")); }

std::set<std::string> allComponents() {
  Factory factory;
  const Modules modules(factory);
  std::set<std::string> types;
  for (const auto& entry : modules.index()) types.emplace(entry.type);
  return types;
}

TEST_F(Words, ATopicNamesOnlyWhatIsThere) {
  const auto types = allComponents();
  const std::string help = stroma("--help").out;
  for (const Entry& topic : tableOf("topics.txt")) {
    for (const std::string& type : listOf(topic, "components", ' '))
      EXPECT_TRUE(types.count(type)) << topic.head << " names the component " << type;
    for (const std::string& command : listOf(topic, "commands", ' '))
      EXPECT_TRUE(has(help, "\n  " + command + " ")) << topic.head << " names the subcommand " << command;
    for (const std::string& page : listOf(topic, "pages", ' '))
      EXPECT_TRUE(std::filesystem::exists(STROMA_SOURCE_DIR "/" + page)) << topic.head << " names the page " << page;
    EXPECT_TRUE(has(topic.head, "(not yet)") || !listOf(topic, "components", ' ').empty() ||
                !listOf(topic, "commands", ' ').empty())
        << topic.head << " leads nowhere";
  }
}

TEST_F(Words, EveryComponentIsReachedByATopic) {
  std::set<std::string> reached;
  for (const Entry& topic : tableOf("topics.txt"))
    for (const std::string& type : listOf(topic, "components", ' ')) reached.insert(type);
  for (const std::string& type : allComponents())
    EXPECT_TRUE(reached.count(type)) << "no topic in tools/command/words/topics.txt names " << type;
}

TEST_F(Words, EveryWordOfATopicLeadsToIt) {
  const auto types = allComponents();
  std::map<std::string, std::string> topic_of;
  for (const Entry& topic : tableOf("topics.txt")) {
    auto words = listOf(topic, "also", ',');
    words.push_back(nameOf(topic));
    const Finished list = stroma("list \"" + nameOf(topic) + "\"");
    EXPECT_TRUE(has(list.out, nameOf(topic))) << list.out << list.err;
    for (const std::string& word : words) {
      const auto [other, is_new] = topic_of.emplace(word, nameOf(topic));
      EXPECT_TRUE(is_new) << word << " is a word of " << other->second << " and of " << nameOf(topic);
      EXPECT_FALSE(types.count(word)) << word << " is a component";
      if (word.starts_with("scene") || presentType(word) != word) continue;  // they have pages
      const Finished doc = stroma("doc \"" + word + "\"");
      EXPECT_EQ(doc.code, 0) << word << "\n" << doc.err;
      EXPECT_TRUE(has("\n" + doc.out, "\n" + nameOf(topic)) || has(doc.out, "without effect")) << word << "\n"
                                                                                               << doc.out;
    }
  }
}

TEST_F(Words, PeopleFindWhatTheySearchFor) {
  for (const char* word : {"contact",
                           "collision",
                           "gravity",
                           "material",
                           "viewer",
                           "GUI",
                           "SOFA",
                           "plugin",
                           "python",
                           "cutting",
                           "GPU",
                           "units",
                           "stress",
                           "strain",
                           "plasticity",
                           "damping",
                           "Rayleigh",
                           "friction",
                           "mesh",
                           "tetrahedron",
                           "hexahedron",
                           "beam",
                           "shell",
                           "cloth",
                           "rope",
                           "cable",
                           "muscle",
                           "fluid",
                           "incompressible",
                           "nu=0.5",
                           "viscoelastic",
                           "Prony",
                           "Dirichlet",
                           "fix",
                           "clamp",
                           "force",
                           "pressure",
                           "traction",
                           "dt",
                           "integrator",
                           "implicit",
                           "solver",
                           "direct solver",
                           "preconditioner",
                           "statics",
                           "equilibrium",
                           "restart",
                           "checkpoint",
                           "export",
                           "VTK",
                           "ParaView",
                           "CSV",
                           "picture",
                           "movie",
                           "threads",
                           "parallel",
                           "OpenMP",
                           "speed",
                           "convergence",
                           "NaN",
                           "inverted",
                           "regression test",
                           "time step",
                           "boundary conditions",
                           "Boundary-Condition",
                           "tets",
                           "neo hookean"}) {
    EXPECT_EQ(stroma("doc \"" + std::string(word) + "\"").code, 0) << word;
    EXPECT_EQ(stroma("list \"" + std::string(word) + "\"").code, 0) << word;
  }
  EXPECT_TRUE(has(stroma("doc boundary conditions").out, "FixedProjectiveConstraint"));
  EXPECT_TRUE(has(stroma("doc contact").out, "BarrierContact"));
  EXPECT_TRUE(has(stroma("doc cutting").out, "cutting: not yet\n"));
  EXPECT_TRUE(has(stroma("list gravity").out, "UniformMass"));
  const Finished misspelt = stroma("doc contatc");
  EXPECT_EQ(misspelt.code, 2);
  EXPECT_TRUE(has(misspelt.err, "did you mean contact?")) << misspelt.err;
}

/// A list that has values per cell is declared so, and says so: meshes that change follow the declaration.
TEST_F(Words, ListsOfCellsAreDeclaredAndSaidToBe) {
  Factory factory;
  Modules modules(factory);
  modules.openAll();
  std::set<std::string> found;
  for (const ComponentEntry* entry : factory.entries())
    if (const auto component = factory.make(entry->type))
      for (const Data& data : component->data().all()) {
        const bool is_list = std::holds_alternative<std::vector<double>*>(data.pointer()) ||
                             std::holds_alternative<std::vector<Vec3>*>(data.pointer());
        if (!is_list || data.isOutput()) continue;
        EXPECT_EQ(data.cellWidth() > 0, has(data.helpText(), "per cell")) << entry->type << "." << data.name();
        if (data.cellWidth() > 0) found.insert(data.name());
      }
  for (const char* name : {"youngModulus", "massDensity", "initialStrain", "AnisotropyDirections"})
    EXPECT_EQ(found.count(name), 1u) << name;
}

/// Every field of cells that some component offers is a word of the topic on them.
TEST_F(Words, FieldsOfCellsAreNamed) {
  Factory factory;
  Modules modules(factory);
  modules.openAll();
  const std::string page = stroma("doc stress").out;
  std::set<std::string> fields;
  for (const ComponentEntry* entry : factory.entries())
    if (const auto component = factory.make(entry->type))
      if (const auto* field = dynamic_cast<const ForceField*>(component.get()))
        for (const std::string& name : field->cellFields()) fields.insert(name);
  EXPECT_GE(fields.size(), 4u);
  for (const std::string& name : fields) EXPECT_TRUE(has(page, name)) << name << "\n" << page;
  EXPECT_TRUE(has(page, "stroma picture")) << page;
}

TEST_F(Words, ComponentsOfSofaThatAreNotHereAreAnswered) {
  const auto types = allComponents();
  std::set<std::string> names;
  for (const Entry& topic : tableOf("topics.txt")) names.insert(nameOf(topic));
  for (const Entry& answer : tableOf("sofa.txt")) {
    const std::string topic = answer.head.substr(0, answer.head.find(": "));
    EXPECT_TRUE(names.count(topic)) << answer.head << ": there is no topic '" << topic << "'";
    for (const std::string& line : answer.lines) {
      std::istringstream in(line);
      for (std::string type; in >> type;) {
        if (has(type, "*")) continue;
        EXPECT_FALSE(types.count(type)) << type << " is a component now: it goes from words/sofa.txt";
        const Finished doc = stroma("doc " + type);
        EXPECT_EQ(doc.code, 0) << type;
        EXPECT_TRUE(has(doc.out, type + " is a component of SOFA that Stroma does not have. ")) << doc.out;
      }
    }
  }
  const std::pair<const char*, const char*> others[] = {
      {"OglModel", "accepted without effect"},
      {"DefaultAnimationLoop", "accepted without effect"},
      {"GenericConstraintCorrection", "Forces of constraint are found"},
      {"FixedConstraint", "is now called FixedProjectiveConstraint"},
      {"SparseGrid", "is now called SparseGridTopology"},
      {"BoxConstraint", "write a BoxROI"},
      {"ShapeMatching", "ShapeMemoryForceField"},
      {"HyperReducedRestShapeSpringsForceField", "without HyperReduced"},
      {"BuoyantForceField", "ForceFieldVec3d"},
      {"FCLCollisionMethod", "LocalMinDistance"},
      {"MeanComputation", "AverageCoord"},
      {"TransformEngine", "\nAttributes"},
      {"TransformPosition", "\nAttributes"},
      {"TriangularAnisotropicFEMForceField", "\nAttributes"},
      {"OscillatorConstraint", "OscillatorProjectiveConstraint"},
      {"MeshSTLLoader", "\nAttributes"},
      {"TriangleCollisionModel", "where contacts are looked for"}};
  for (const auto& [type, expected] : others) {
    const Finished doc = stroma(std::string("doc ") + type);
    EXPECT_EQ(doc.code, 0) << type << doc.err;
    EXPECT_TRUE(has(doc.out, expected)) << type << "\n" << doc.out;
  }
  for (const std::string_view idle : acceptedWithoutEffect())
    EXPECT_TRUE(has(stroma("doc " + std::string(idle)).out, "without effect")) << idle;
}

/// The sentence of `stroma doc` stands in the error itself, for every component of SOFA that is known as missing.
TEST_F(Words, AMissingComponentOfSofaIsRefusedWithWhatToDoInstead) {
  write("scene.xml",
        "<Node name=\"root\">\n  <BruteForceBroadPhase/>\n  <LCPConstraintSolver/>\n  <CollisionPipelin/></Node>");
  const Finished run = stroma("check scene.xml");
  EXPECT_EQ(run.code, 2);
  EXPECT_TRUE(has(run.err,
                  "scene.xml:2:3: error: /BruteForceBroadPhase: there is no component 'BruteForceBroadPhase' (a component of "
                  "SOFA that Stroma does not have. Leave it out: CollisionPipeline finds contacts"))
      << run.err;
  EXPECT_TRUE(has(run.err, "Forces of constraint are found with the matrix of the step")) << run.err;
  EXPECT_TRUE(has(run.err, "there is no component 'CollisionPipelin' (expected a name from 'stroma list'")) << run.err;
}

/// Who blows up a cavity reads the sign first, with the lines of a scene.
TEST_F(Words, ThePageOfThePressureSaysFirstWhichSignInflatesACavity) {
  const std::string page = stroma("doc SurfacePressureForceField").out;
  const auto sign = page.find("A cavity is inflated by a NEGATIVE pressure"), selection = page.find("groupTriangleIndices");
  ASSERT_NE(sign, std::string::npos) << page;
  ASSERT_NE(selection, std::string::npos) << page;
  EXPECT_LT(sign, page.find("Loaded are"));
  EXPECT_LT(selection, page.find("Loaded are"));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
