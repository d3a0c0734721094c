// SPDX-License-Identifier: LGPL-2.1-or-later
// Whatever acts, acts wherever it is written, or the scene is refused with its name. Every component of the factory that
// can act is taken out of the example of its manual page and put to the root, above, beside and below its node.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "framework/mesh/topology.h"
#include "framework/scene/names.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/manual_examples.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/xml_writer.h"
#include "tools/plan/plan.h"

namespace stroma::test {
namespace {

/// The scene of an example below two nodes, so that there is something above its root.
const std::string inner = "/parent/body";

bool actsByItself(const Component& component) {
  const auto is = [&]<class... Roles>() { return (... || dynamic_cast<const Roles*>(&component)); };
  return is.operator()<ForceField, Mass, ProjectiveConstraint, PositionConstraint, Mapping, Integrator, LinearSolver>();
}

/// An absolute path for what `value`, "@../grid.position", names from a node of the example.
std::string absolute(const std::string& value, const std::string& node, Node& root) {
  if (value.empty() || value[0] != '@') return value;
  std::string path = value.substr(1), from = node;
  if (path[0] == '/') return "@" + inner + path;
  const auto up = [&from] { from = from.find_last_of('/') == 0 ? "/" : from.substr(0, from.find_last_of('/')); };
  bool climbs = false;
  for (; path.starts_with("../"); path = path.substr(3)) up(), climbs = true;
  const std::string component = path.substr(0, path.find('.'));
  while (!climbs && from != "/" && !findComponent(root, joinPath(from, component))) up();
  return "@" + joinPath(inner + (from == "/" ? "" : from), path);
}

/// What a component found by looking around, as an attribute that says it.
std::vector<AttributeDescription> foundLinks(Component& component) {
  std::vector<AttributeDescription> links;
  const auto add = [&](const char* attribute, const Component* target) {
    const Data* data = component.data().find(attribute);
    if (target && data && data->link() && !data->isSet())
      links.push_back({attribute, "@" + inner + target->path(), component.where()});
  };
  const bool names_objects = component.data().find("object1") && component.data().find("object1")->isSet();
  if (!names_objects) {
    if (const auto* field = dynamic_cast<ForceField*>(&component)) add("mstate", &field->state());
    if (const auto* mass = dynamic_cast<Mass*>(&component)) add("mstate", &mass->state());
    if (const auto* held = dynamic_cast<ProjectiveConstraint*>(&component)) add("mstate", &held->state());
    if (const auto* held = dynamic_cast<PositionConstraint*>(&component)) add("mstate", &held->state());
  }
  if (const auto* mapping = dynamic_cast<Mapping*>(&component))
    add("input", &mapping->input()), add("output", &mapping->output());
  try {
    add("topology", component.find<Topology>(true));
  } catch (const ComponentError&) {  // there are several
  }
  return links;
}

enum class Place { root, above, beside, below };

class Placements : public FolderTest {
 protected:
  /// All placements of each component of `types` in an example.
  void look(const std::string& example, const std::vector<std::string>& types, const std::string& folder) {
    Diagnostics diagnostics;
    SceneDescription description;
    description.file = folder + "/example.xml";
    description.root = readXml(example, description.file, {}, diagnostics);
    Scene scene = instantiate(description, factory(), modules());
    lookBelow(description, description.root, "/", types, scene);
  }

  int placements_ = 0, acted_ = 0, refused_ = 0;
  std::map<std::string, int> types_, dropped_;

 private:
  void lookBelow(const SceneDescription& description, const NodeDescription& node, const std::string& path,
                 const std::vector<std::string>& types, Scene& scene) {
    for (std::size_t i = 0; i < node.components.size(); ++i) {
      const std::string type = node.components[i].type;
      if (std::find(types.begin(), types.end(), type) == types.end()) continue;
      Component* component = findComponent(*scene.root, joinPath(path, componentNames(node)[i]));
      if (!component || !actsByItself(*component)) continue;
      ++types_[type];
      for (const Place place : {Place::root, Place::above, Place::beside, Place::below})
        for (const bool linked : {false, true}) tryAt(description, path, i, *component, place, linked, scene);
    }
    for (std::size_t i = 0; i < node.children.size(); ++i)
      lookBelow(description, node.children[i], joinPath(path, childNames(node)[i]), types, scene);
  }

  static NodeDescription& nodeAt(NodeDescription& root, const std::string& path) {
    NodeDescription* node = &root;
    for (std::size_t at = 1; at < path.size();) {
      const std::size_t end = std::min(path.find('/', at), path.size());
      const std::vector<std::string> names = childNames(*node);
      const auto child = std::find(names.begin(), names.end(), path.substr(at, end - at));
      node = &node->children.at(std::size_t(child - names.begin()));
      at = end + 1;
    }
    return *node;
  }

  static NodeDescription named(const std::string& name) {
    NodeDescription node;
    node.attributes.push_back({"name", name, {}});
    return node;
  }

  void tryAt(SceneDescription description, const std::string& path, std::size_t number, Component& original,
             Place place, bool linked, Scene& scene) {
    NodeDescription body = description.root;
    NodeDescription& node = nodeAt(body, path);
    ComponentDescription moved = node.components[number];
    node.components.erase(node.components.begin() + std::ptrdiff_t(number));
    std::erase_if(moved.attributes, [](const auto& attribute) { return attribute.name == "name"; });
    for (AttributeDescription& attribute : moved.attributes)
      attribute.value = absolute(attribute.value, path, *scene.root);
    moved.attributes.push_back({"name", original.name(), {}});
    if (linked) {
      const auto links = foundLinks(original);
      if (links.empty()) return;
      moved.attributes.insert(moved.attributes.end(), links.begin(), links.end());
    }
    NodeDescription root = named("root"), parent = named("parent"), beside = named("beside"), below = named("below");
    root.attributes = body.attributes;
    body.attributes = {{"name", "body", {}}};
    std::string moved_path;
    if (place == Place::below) {
      below.components.push_back(moved);
      moved_path = joinPath(inner + (path == "/" ? "" : path), "below");
      node.children.push_back(below);
    }
    if (place == Place::beside) beside.components.push_back(moved), moved_path = "/parent/beside";
    if (place == Place::above) parent.components.push_back(moved), moved_path = "/parent";
    if (place == Place::root) root.components.push_back(moved), moved_path = "/";
    moved_path = joinPath(moved_path, original.name());
    parent.children = {body, beside};
    root.children = {parent};
    description.root = root;
    judge(std::move(description), original, moved_path,
          fmt::format("{} at {}{}", original.type(), moved_path, linked ? ", linked" : ""));
  }

  void judge(SceneDescription description, const Component& original, const std::string& path,
             const std::string& what) {
    ++placements_;
    const std::string text = writeXml(description.root);
    try {
      const Simulation simulation(instantiate(std::move(description), factory(), modules()));
      int plans = 0;
      for (const SystemPlan& plan : planOf(simulation).systems)
        for (const PlanItem& item : plan.items) plans += item.path == path && item.when != PlanWhen::skipped;
      EXPECT_EQ(plans, 1) << what << " is in " << plans << " plans:\n" << text;
      plans > 0 ? void(++acted_) : void(++dropped_[original.type()]);
    } catch (const SceneError& error) {
      ++refused_;
      expectContains(error.diagnostics().text(), path);
    }
  }
};

TEST_F(Placements, EverythingActsOrIsRefused) {
  modules().openAll();
  std::map<std::string, std::vector<std::string>> types_of;
  for (const auto& entry : modules().index()) {
    const std::string type(entry.type);
    const std::string example = exampleIn(modules().manual(type));
    if (!example.empty()) types_of[example].push_back(type);
  }
  const std::string folder = folder_.string();
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  writeExampleFiles(folder + "/meshes");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  for (const auto& [example, types] : types_of) look(example, types, folder);
  std::filesystem::current_path(before);
  for (const auto& [type, count] : dropped_) std::printf("dropped: %s %d\n", type.c_str(), count);
  std::printf("%zu types, %d placements: %d act, %d are refused, %zu types were dropped\n", types_.size(), placements_,
              acted_, refused_, dropped_.size());
  EXPECT_GT(types_.size(), 60u);
  EXPECT_GT(acted_, 100);
}

}  // namespace
}  // namespace stroma::test
