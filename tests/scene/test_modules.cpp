// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/abi.h"
#include "framework/scene/modules.h"

#include <algorithm>
#include <cstdlib>
#include <set>

#include "framework/scene/change_table.h"
#include "framework/scene/usual_component.h"
#include "tests/scene/test_components.h"

namespace stroma::testing {
namespace STROMA_TEST_FILE {

const std::string folder_of_modules = STROMA_TEST_MODULES;

std::string openingFails(const std::string& path) {
  Factory factory;
  Modules modules(factory, {});
  try {
    modules.open(path);
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(factory.entries().empty());
    return error.what();
  }
  ADD_FAILURE() << path << " opens";
  return {};
}

TEST(Modules, AnotherVersionIsRefusedWithBothTags) {
  const std::string sentence = openingFails(folder_of_modules + "/other_version.so");
  EXPECT_NE(sentence.find("stroma-0.0.1-gcc1-eigen16"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("stroma-" STROMA_VERSION "-gcc"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("-eigen64-" STROMA_HEADERS_DIGEST), std::string::npos) << sentence;
}

TEST(Modules, WhatIsNoModuleIsRefused) {
  TemporaryFolder folder;
  EXPECT_NE(openingFails(folder.write("text.so", "not a library")).find("cannot be opened"), std::string::npos);
  EXPECT_NE(openingFails(folder.path("absent.so")).find("cannot be opened"), std::string::npos);
  EXPECT_NE(openingFails("libm.so.6").find("is not a module"), std::string::npos);
}

TEST(Modules, ANameThatExistsIsRefusedAsAWhole) {
  Factory factory;
  Modules modules(factory, {});
  modules.open(folder_of_modules + "/sample.so");
  modules.open(folder_of_modules + "/sample.so");  // twice is once
  try {
    modules.open(folder_of_modules + "/duplicate.so");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("'SampleGauge', which the module 'sample' already has"),
              std::string::npos);
  }
  EXPECT_EQ(modules.opened(), std::vector<std::string>{"sample"});
  EXPECT_EQ(factory.entries().size(), 1u);
  EXPECT_EQ(factory.find("SampleGauge")->module, "sample");
}

TEST(Modules, TheIndexOpensAModuleOnlyWhenItIsNamed) {
  TemporaryFolder folder;
  std::filesystem::copy(folder_of_modules + "/sample.so", folder.path("sample.so"));
  folder.write("mine.index", "SampleGauge\tsample\tstores one number\n");
  folder.write("mine.manual", "=== SampleGauge\tsample\nThe page.\nMore.\n");
  Factory factory;
  Modules modules(factory, {folder.path()});
  EXPECT_TRUE(modules.opened().empty());
  EXPECT_EQ(modules.notOpened(), std::vector<std::string>{"sample"});
  EXPECT_EQ(modules.index().at(0).help, "stores one number");
  EXPECT_EQ(modules.manual("SampleGauge"), "The page.\nMore.\n");
  EXPECT_TRUE(modules.opened().empty()) << "neither the index nor the manual needs it";
  EXPECT_FALSE(modules.provide("Unknown"));
  EXPECT_TRUE(modules.provide("SampleGauge"));
  EXPECT_EQ(modules.opened(), std::vector<std::string>{"sample"});
  EXPECT_NE(factory.make("SampleGauge"), nullptr);
}

TEST(Modules, ANameInTheSourcesOfAModuleThatIsNotBuiltIsRefusedWithItsTarget) {
  TemporaryFolder folder;
  const std::string source = folder.write("gauge.cpp", "factory.add<Gauge>(\"Gauge\", \"measures\");");
  folder.write("modules.sources", "built\t" + source + "\ngauges\tabsent.cpp\t" + source + "\n");
  folder.write("built.index", "Scale\tbuilt\tweighs\n");
  Factory factory;
  Modules modules(factory, {folder.path()});
  EXPECT_FALSE(modules.provide("Gaug")) << "a part of a name is not that name";
  try {
    modules.provide("Gauge");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("the module gauges, which has 'Gauge', is not built yet"),
              std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("--target stroma_gauges"), std::string::npos) << error.what();
  }
  folder.write("gauges.index", "Other\tgauges\tmeasures\n");
  EXPECT_FALSE(Modules(factory, {folder.path()}).provide("Gauge")) << "it is built and has no such component";
}

TEST(Modules, TheIndexIsSortedByType) {
  TemporaryFolder folder;
  folder.write("a.index", "Z\ta\tlast\nB\ta\tsecond\n");
  folder.write("b.index", "A\tb\tfirst\nB\tb\tsecond again\n");
  Factory factory;
  const Modules modules(factory, {folder.path()});
  std::string order;
  for (const Modules::IndexEntry& entry : modules.index()) order += std::string(entry.type) + std::string(entry.module) + " ";
  EXPECT_EQ(order, "Ab Ba Bb Za ");
}

TEST(Modules, ABadIndexIsASentence) {
  TemporaryFolder folder;
  folder.write("bad.index", "no tabs here\n");
  Factory factory;
  EXPECT_THROW(Modules(factory, {folder.path()}), std::runtime_error);
}

TEST(Modules, FoldersOfTheVariableHoldModules) {
  const char* const before = std::getenv("STROMA_MODULE_PATH");
  const std::string kept = before ? before : "";
  TemporaryFolder folder;
  const auto problem = [](const std::string& list) -> std::string {
    setenv("STROMA_MODULE_PATH", list.c_str(), 1);
    Factory factory;
    Modules modules(factory);
    ::testing::internal::CaptureStderr();
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(modules.provide("NobodyKnowsThis"));
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(problem(folder.path()).find("where no module lies"), std::string::npos);
  EXPECT_NE(problem(folder.path() + "/nowhere").find("nowhere', which is not a readable folder"), std::string::npos);
  folder.write("a.index", "Z\ta\tlast\n");
  EXPECT_EQ(problem(":" + folder.path() + ":"), "");
  before ? setenv("STROMA_MODULE_PATH", kept.c_str(), 1) : unsetenv("STROMA_MODULE_PATH");
}

TEST(Modules, TheLevelCanOnlyBeLowered) {
  unsetenv("STROMA_LEVEL");
  const std::string machine = instructionLevel();
  EXPECT_TRUE(machine.starts_with("x86-64-v")) << machine;
  setenv("STROMA_LEVEL", "x86-64-v2", 1);
  EXPECT_EQ(instructionLevel(), "x86-64-v2");
  setenv("STROMA_LEVEL", "avx9000", 1);
  EXPECT_THROW(instructionLevel(), std::runtime_error);
  unsetenv("STROMA_LEVEL");
}

/// OpenBLAS reads the variable when the first module that needs it is opened.
TEST(Modules, KernelsOfTheBlasFollowTheLevel) {
  const char* const before = std::getenv("OPENBLAS_CORETYPE");
  const std::string kept = before ? before : "";
  const auto kernels = [](const char* level, const char* preset) -> std::string {
    preset ? setenv("OPENBLAS_CORETYPE", preset, 1) : unsetenv("OPENBLAS_CORETYPE");
    setenv("STROMA_LEVEL", level, 1);
    Factory factory;
    Modules modules(factory, {});
    EXPECT_THROW(modules.open("/nowhere/none.so"), std::runtime_error);
    const char* const chosen = std::getenv("OPENBLAS_CORETYPE");
    return chosen ? chosen : "";
  };
  unsetenv("STROMA_LEVEL");
  const std::string machine = instructionLevel();
  EXPECT_EQ(kernels("x86-64-v2", nullptr), "");
  const std::pair<const char*, const char*> named[] = {{"x86-64-v3", "Haswell"}, {"x86-64-v4", "SkylakeX"}};
  for (const auto& [level, core] : named) {
    if (level > machine) continue;
    EXPECT_EQ(kernels(level, nullptr), core);
    EXPECT_EQ(kernels(level, "Zen"), "Zen") << "what a person set stays";
  }
  unsetenv("STROMA_LEVEL");
  before ? setenv("OPENBLAS_CORETYPE", kept.c_str(), 1) : unsetenv("OPENBLAS_CORETYPE");
}

TEST(Modules, TheBestBuildOfTheMachineIsOpened) {
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("x86-64-v2"));
  std::filesystem::copy(folder_of_modules + "/sample.so", folder.path("x86-64-v2/sample.so"));
  folder.write("mine.index", "SampleGauge\tsample\tx\nOther\tabsent\ty\n");
  Factory factory;
  Modules modules(factory, {folder.path()});
  EXPECT_TRUE(modules.provide("SampleGauge"));
  try {
    modules.provide("Other");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("the module absent is not here"), std::string::npos);
  }
}

TEST_F(SceneTest, APluginByPathBringsItsComponents) {
  const std::string text = "<Node><SampleGauge name='g' reading='4'/><RequiredPlugin pluginName='" + folder_of_modules;
  const Scene scene = load(text + "/sample.so'/></Node>");
  EXPECT_EQ(findComponent(*scene.root, "/g")->data().find("reading")->print(), "4");
  EXPECT_NE(problemsOf("<Node><RequiredPlugin pluginName='nowhere/at_all.so'/></Node>")[0].message.find("not found"),
            std::string::npos);
  EXPECT_NE(problemsOf("<Node><RequiredPlugin pluginName='" + folder_of_modules + "/other_version.so'/></Node>")[0]
                .message.find("was built for"),
            std::string::npos);
}

TEST(IndexTool, WritesTheIndexAndTheManualOfOneModule) {
  TemporaryFolder folder;
  const std::string command = STROMA_BINARY_DIR "/bin/stroma-index " + folder.path() + " sample " + folder_of_modules +
                              "/sample.so " STROMA_SOURCE_DIR "/tests/scene/fixtures/sample_module.cpp";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::filesystem::copy(folder_of_modules + "/sample.so", folder.path("sample.so"));
  Factory factory;
  Modules modules(factory, {folder.path()});
  ASSERT_EQ(modules.index().size(), 1u);
  EXPECT_EQ(modules.index()[0].type, "SampleGauge");
  EXPECT_TRUE(modules.manual("SampleGauge").starts_with("A component of someone else's"));
  EXPECT_NE(modules.manual("SampleGauge").find("Example:\n<Node name=\"root\">"), std::string::npos);
  EXPECT_TRUE(modules.provide("SampleGauge"));
}

TEST(IndexTool, RefusesAModuleOfAnotherVersionOrName) {
  TemporaryFolder folder;
  const std::string start = STROMA_BINARY_DIR "/bin/stroma-index " + folder.path() + " ";
  EXPECT_NE(std::system((start + "other_version " + folder_of_modules + "/other_version.so 2>/dev/null").c_str()), 0);
  EXPECT_NE(std::system((start + "wrong " + folder_of_modules + "/sample.so 2>/dev/null").c_str()), 0);
}

TEST(ChangeTable, IsWellFormed) {
  std::set<std::string_view> old_types;
  for (const TypeChange& change : typeChanges()) {
    EXPECT_TRUE(old_types.insert(change.old_type).second) << change.old_type << " appears twice";
    EXPECT_NE(change.old_type, change.new_type);
    EXPECT_EQ(presentType(change.new_type), change.new_type) << "one step leads to the present name";
  }
  for (const TypeRemoval& removal : typeRemovals()) EXPECT_EQ(old_types.count(removal.type), 0u);
}

TEST(ChangeTable, EveryReplacementExists) {
  // SOFA components that the families to come will bring; their renames are known already.
  const std::set<std::string_view> to_come = {"LinearMovementProjectiveConstraint",
                                              "FixedPlaneProjectiveConstraint",
                                              "AttachProjectiveConstraint",
                                              "FixedTranslationProjectiveConstraint",
                                              "FixedRotationProjectiveConstraint",
                                              "LinearVelocityProjectiveConstraint",
                                              "SpringForceField",
                                              "PCGLinearSolver",
                                              "SparseGridTopology",
                                              "RungeKutta4Solver",
                                              "RungeKutta2Solver",
                                              "CentralDifferenceSolver"};
  if (!std::filesystem::exists(STROMA_BINARY_DIR "/lib/stroma/mechanics.index"))
    GTEST_SKIP() << "the modules are not built";
  Factory factory;
  Modules modules(factory, {STROMA_BINARY_DIR "/lib/stroma"});
  std::set<std::string> existing;
  for (const Modules::IndexEntry& entry : modules.index()) existing.emplace(entry.type);
  for (const TypeChange& change : typeChanges()) {
    EXPECT_TRUE(existing.count(std::string(change.new_type)) || to_come.count(change.new_type)) << change.new_type;
    EXPECT_FALSE(existing.count(std::string(change.old_type))) << change.old_type << " exists: it needs no row";
  }
  for (std::string_view type : acceptedWithoutEffect())
    EXPECT_FALSE(existing.count(std::string(type))) << type << " has an effect after all";
}

/// The components of this build.
class BuiltModules : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(STROMA_BINARY_DIR "/lib/stroma/mechanics.index"))
      GTEST_SKIP() << "the modules are not built";
    modules = std::make_unique<Modules>(factory, std::vector<std::string>{STROMA_BINARY_DIR "/lib/stroma"});
    modules->openAll();
    ASSERT_GT(factory.entries().size(), 20u);
  }
  Factory factory;
  std::unique_ptr<Modules> modules;
};

TEST_F(BuiltModules, RenamedAttributesExist) {
  for (const AttributeChange& change : attributeChanges()) {
    const std::unique_ptr<Component> component = factory.make(std::string(change.type));
    ASSERT_NE(component, nullptr) << change.type;
    EXPECT_NE(component->data().find(change.new_attribute), nullptr) << change.type << "." << change.new_attribute;
    EXPECT_EQ(component->data().find(change.old_attribute), nullptr) << change.type << "." << change.old_attribute;
  }
}

TEST_F(BuiltModules, WhoUsuallyPlaysAPartExistsAndPlaysIt) {
  const std::pair<Part, const char*> roles[] = {
      {Part::state, "mechanical state"},       {Part::mass, "mass"},
      {Part::diagonal_mass, "mass"},           {Part::integrator, "integrator"},
      {Part::solver_in_time, "linear solver"}, {Part::solver_of_equilibria, "linear solver"},
      {Part::ball, "force field"},             {Part::solver_that_chooses, "linear solver"}};
  for (const auto& [part, role] : roles) {
    const std::unique_ptr<Component> component = factory.make(usualComponent(part));
    ASSERT_NE(component, nullptr) << usualComponent(part);
    EXPECT_EQ(component->roleText(), role) << usualComponent(part);
  }
}

TEST_F(BuiltModules, EveryAttributeHasANameOfItsOwnAndALineOfHelp) {
  for (const ComponentEntry* entry : factory.entries()) {
    EXPECT_FALSE(entry->help.empty()) << entry->type;
    EXPECT_FALSE(modules->manual(entry->type).empty()) << entry->type << " has no manual page";
    const std::unique_ptr<Component> component = factory.make(entry->type);
    std::set<std::string> seen;
    for (const std::string& name : component->data().names())
      EXPECT_TRUE(seen.insert(name).second) << entry->type << "." << name << " means two attributes";
    for (const Data& data : component->data().all())
      EXPECT_FALSE(data.helpText().empty()) << entry->type << "." << data.name();
  }
}

TEST_F(BuiltModules, DefaultsReadBack) {
  for (const ComponentEntry* entry : factory.entries()) {
    const std::unique_ptr<Component> component = factory.make(entry->type);
    for (Data& data : component->data().all()) {
      if (data.isOutput() || data.link() || data.defaultText().empty()) continue;
      const auto problem = data.parse(data.defaultText(), DataOrigin::written);
      EXPECT_FALSE(problem) << entry->type << "." << data.name() << ": " << problem->text();
      EXPECT_EQ(data.print(), data.defaultText()) << entry->type << "." << data.name();
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::testing
