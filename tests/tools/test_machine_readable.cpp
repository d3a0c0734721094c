// SPDX-License-Identifier: LGPL-2.1-or-later
// What programs read: components, their attributes and the compiled plan as JSON. It says what the text says.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Json = nlohmann::json;
using MachineReadable = CommandTest;

Json parsed(const Finished& finished) {
  EXPECT_EQ(finished.code, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  return Json::parse(finished.out);
}

/// The object of `list` with this name.
Json named(const Json& list, const std::string& name) {
  for (const Json& each : list)
    if (each.at("name") == name) return each;
  ADD_FAILURE() << "nothing is called " << name;
  return {};
}

std::set<std::string> namesIn(const Json& list) {
  std::set<std::string> names;
  for (const Json& each : list) names.insert(each.at("name"));
  return names;
}

TEST_F(MachineReadable, TheListIsThatOfTheText) {
  const Json list = parsed(stroma("list solver --json"));
  std::istringstream text(stroma("list solver").out);
  std::set<std::string> names;
  for (std::string line; std::getline(text, line);)
    if (!line.starts_with("topics: ")) names.insert(line.substr(0, line.find(' ')));
  EXPECT_EQ(namesIn(list), names);
  const Json solver = named(list, "CGLinearSolver");
  EXPECT_EQ(solver.at("role"), "linear solver");
  EXPECT_EQ(solver.at("module"), "iterative_solvers");
  EXPECT_NE(solver.at("help"), "");
  EXPECT_EQ(solver.size(), 4u);
}

TEST_F(MachineReadable, AComponentWithItsAttributes) {
  const Json page = parsed(stroma("doc TetrahedronFEMForceField --json"));
  EXPECT_EQ(page.at("role"), "force field");
  EXPECT_NE(page.at("manual").get<std::string>().find("Example:"), std::string::npos);
  const Json modulus = named(page.at("attributes"), "youngModulus");
  EXPECT_EQ(modulus.at("kind"), "reals");
  EXPECT_EQ(modulus.at("unit"), "Pa");
  EXPECT_EQ(modulus.at("physical"), true);
  EXPECT_EQ(modulus.at("required"), false);
  const Json ratio = named(page.at("attributes"), "poissonRatio");
  EXPECT_EQ(ratio.at("range"), "(-1, 0.5)");
  const Json method = named(page.at("attributes"), "method");
  EXPECT_EQ(method.at("kind"), "choice");
  for (const char* word : {"small", "large", "polar", "svd", "nodal"})
    EXPECT_NE(std::ranges::find(method.at("choices"), word), method.at("choices").end()) << word;
  const Json state = named(page.at("attributes"), "mstate");
  EXPECT_EQ(state.at("kind"), "link");
  EXPECT_NE(state.at("link"), "");
  EXPECT_EQ(modulus.at("link"), "");
  for (const Json& attribute : page.at("attributes")) EXPECT_NE(attribute.at("help"), "") << attribute;
  // every attribute of the text is there
  std::istringstream text(stroma("doc TetrahedronFEMForceField").out);
  std::set<std::string> names = namesIn(page.at("attributes")), listed;
  names.merge(namesIn(page.at("outputs")));
  bool in_attributes = false;
  for (std::string line; std::getline(text, line);) {
    if (in_attributes && line.starts_with("  ") && line[2] != ' ' && line.find(" (") != std::string::npos)
      listed.insert(line.substr(2, line.find(" (") - 2));
    in_attributes = in_attributes || line.starts_with("Attributes");
  }
  EXPECT_EQ(listed, names);
}

TEST_F(MachineReadable, AllComponentsInOneGo) {
  const Json all = parsed(stroma("doc --all --json"));
  EXPECT_EQ(namesIn(all), namesIn(parsed(stroma("list --json"))));
  EXPECT_EQ(named(all, "BoxROI"), parsed(stroma("doc BoxROI --json")));
  bool any_choice = false, any_required = false, any_alias = false, any_shorthand = false, any_visual = false;
  for (const Json& page : all) {
    any_shorthand |= !page.at("shorthands").empty();
    any_visual |= !page.at("visual_only").empty();
    for (const Json& attribute : page.at("attributes")) {
      EXPECT_EQ(attribute.at("kind") == "choice", !attribute.at("choices").empty() && attribute.at("link") == "");
      any_choice |= attribute.at("kind") == "choice";
      any_required |= bool(attribute.at("required"));
      any_alias |= !attribute.at("aliases").empty();
    }
  }
  EXPECT_TRUE(any_choice && any_required && any_alias && any_shorthand && any_visual);
}

TEST_F(MachineReadable, AnOldNameGivesTheComponentThatItNames) {
  EXPECT_EQ(parsed(stroma("doc FixedConstraint --json")).at("name"), "FixedProjectiveConstraint");
}

TEST_F(MachineReadable, MistakesAreSentences) {
  const std::pair<const char*, const char*> cases[] = {{"doc --all", "--all needs --json"},
                                                       {"doc BoxROI --all --json", "exclude each other"},
                                                       {"doc BoxRoi --json", "did you mean BoxROI?"},
                                                       {"doc --json", "NAME is missing"},
                                                       {"list nothing_like_it --json", "no component matches"},
                                                       {"explain absent.xml --json", "absent.xml"}};
  for (const auto& [arguments, expected] : cases) {
    const Finished run = stroma(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find(expected), std::string::npos) << arguments << "\n" << run.err;
    EXPECT_EQ(run.out, "") << arguments;
  }
}

TEST_F(MachineReadable, ThePlanIsThatOfTheText) {
  const std::string scene = std::string(STROMA_SOURCE_DIR) + "/scenes/examples/cantilever_polar.xml";
  const Json plan = parsed(stroma("explain " + scene + " --json"));
  EXPECT_EQ(plan.at("scene"), scene);
  EXPECT_GT(plan.at("dt"), 0);
  ASSERT_FALSE(plan.at("systems").empty());
  const Finished text = stroma("explain " + scene);
  std::set<std::string> kinds;
  for (const Json& system : plan.at("systems"))
    for (const Json& item : system.at("items")) {
      kinds.insert(item.at("kind"));
      EXPECT_NE(text.out.find(item.at("says").get<std::string>()), std::string::npos) << item;
      EXPECT_NE(text.out.find(item.at("path").get<std::string>()), std::string::npos) << item;
    }
  for (const char* kind : {"state", "mass", "gravity", "force", "constraint", "integrator", "linear solver"})
    EXPECT_TRUE(kinds.contains(kind)) << kind;
  const auto item = [&](const std::string& kind) {
    for (const Json& each : plan.at("systems")[0].at("items"))
      if (each.at("kind") == kind) return each;
    return Json();
  };
  EXPECT_EQ(item("force").at("when"), "each evaluation");
  EXPECT_EQ(item("force").at("type"), "TetrahedronFEMForceField");
  EXPECT_EQ(item("gravity").at("when"), "once");
  EXPECT_EQ(item("state").at("nodes"), plan.at("systems")[0].at("nodes"));
  EXPECT_GT(item("mass").at("mass"), 0);
  EXPECT_FALSE(plan.at("modules_opened").empty());
  EXPECT_FALSE(plan.at("modules_not_opened").empty());
}

TEST_F(MachineReadable, WhatASceneDoesNotNeedIsSkippedAndSaid) {
  write("fall.xml", falling_scene);
  const Json plan = parsed(stroma("explain fall.xml --json"));
  std::set<std::string> skipped;
  for (const Json& item : plan.at("systems")[0].at("items"))
    if (item.at("when") == "skipped") skipped.insert(item.at("kind"));
  EXPECT_TRUE(skipped.contains("forces"));
  EXPECT_TRUE(skipped.contains("mappings"));
  EXPECT_TRUE(plan.at("observers").empty());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
