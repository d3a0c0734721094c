// SPDX-License-Identifier: LGPL-2.1-or-later
// The first and the last pass over a scene: the tree of components, and its initialisation.
#include <algorithm>
#include <filesystem>

#include "framework/scene/change_table.h"
#include "framework/scene/files.h"
#include "framework/scene/instantiation.h"
#include "framework/scene/missing_types.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {

namespace {

bool contains(const std::vector<std::string_view>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool hasNoEffect(const ComponentDescription& component) { return contains(acceptedWithoutEffect(), component.type); }
bool isVisualModel(const ComponentDescription& component) { return contains(visualModels(), component.type); }

bool holdsVisualModel(const NodeDescription& node) {
  return std::any_of(node.components.begin(), node.components.end(), isVisualModel) ||
         std::any_of(node.children.begin(), node.children.end(), holdsVisualModel);
}

bool holdsOnlyVisuals(const NodeDescription& node) {
  return std::all_of(node.components.begin(), node.components.end(),
                     [](const auto& component) { return hasNoEffect(component) || servesVisualModels(component.type); }) &&
         std::all_of(node.children.begin(), node.children.end(), holdsOnlyVisuals);
}

MissingTypeAdvice& missingTypeAdvice() {
  static MissingTypeAdvice advice;
  return advice;
}

bool isOff(const NodeDescription& node) {
  const AttributeDescription* activated = node.find("activated");
  return activated && (trimmed(activated->value) == "false" || trimmed(activated->value) == "0");
}

}  // namespace

void adviseOnMissingTypes(MissingTypeAdvice advice) { missingTypeAdvice() = std::move(advice); }
std::string adviceOnMissingType(const std::string& type) { return missingTypeAdvice() ? missingTypeAdvice()(type) : std::string(); }

Instantiation::Instantiation(Scene& scene, Factory& factory, Modules& modules)
    : scene_(scene), factory_(factory), modules_(modules), diagnostics_(scene.diagnostics) {}

void Instantiation::makeTree() {
  const NodeDescription& description = scene_.description.root;
  prepare(description);
  const std::string name = description.name();
  scene_.root = std::make_unique<Node>(name.empty() ? "root" : name, nullptr, description.where);
  build(description, *scene_.root);
  resolveLinks();
}

void Instantiation::run() {
  makeTree();
  std::vector<Component*> components;
  scene_.root->collect(components);
  for (Component* component : components) checkGiven(*component);
  initialise(*scene_.root);
  release(*scene_.root);
}

/// Plugins by path come before everything: what they bring may be used anywhere.
void Instantiation::prepare(const NodeDescription& node) {
  for (const ComponentDescription& component : node.components)
    if (component.type == "RequiredPlugin") openPlugins(component);
  for (const NodeDescription& child : node.children) prepare(child);
}

void Instantiation::openPlugins(const ComponentDescription& component) {
  for (const char* attribute_name : {"pluginName", "name"}) {
    const AttributeDescription* attribute = component.find(attribute_name);
    if (!attribute) continue;
    Words words(attribute->value);
    for (std::string word(words.next()); !word.empty(); word = words.next()) {
      if (!word.ends_with(".so")) continue;  // SOFA's own plugins: their components come from the module index
      std::vector<std::string> searched;
      const std::string file = findFileIn(word, component.folder, scene_.description.data_paths, &searched);
      if (file.empty()) {
        diagnostics_.error(attribute->where, {}, "the plugin " + inQuotes(word) + " is not found", {}, searchedText(searched));
        continue;
      }
      try {
        modules_.open(file);
      } catch (const std::exception& error) {
        diagnostics_.error(attribute->where, {}, error.what());
      }
    }
  }
}

void Instantiation::build(const NodeDescription& description, Node& node) {
  readNodeAttributes(description, node);
  const std::vector<std::string> names = componentNames(description), children = childNames(description);
  reportDuplicates(description, node);
  for (std::size_t i = 0; i < names.size(); ++i) makeComponent(description.components[i], names[i], node);
  addMissingPartners(node);
  for (std::size_t i = 0; i < children.size(); ++i) buildChild(description.children[i], children[i], node);
}

void Instantiation::buildChild(const NodeDescription& description, const std::string& name, Node& parent) {
  const std::string path = joinPath(parent.path(), name);
  if (isOff(description)) {
    diagnostics_.note(description.where, path, "the node is not activated: it is left out with its contents");
  } else if (holdsVisualModel(description) && holdsOnlyVisuals(description)) {
    noEffect("node " + path);
  } else {
    build(description, parent.addChild(std::make_unique<Node>(name, &parent, description.where)));
  }
}

void Instantiation::makeComponent(const ComponentDescription& description, const std::string& name, Node& node) {
  if (hasNoEffect(description) && !factory_.find(description.type)) return noEffect(description.type);
  bool misspelt = false;
  std::unique_ptr<Component> made = create(description, joinPath(node.path(), name), misspelt);
  made->name_ = name;
  made->where_ = description.where;
  made->folder_ = description.folder;
  made->diagnostics_ = &diagnostics_;
  Component& component = node.add(std::move(made));
  if (misspelt) {
    component.markFailed();  // reported once; what needs it stays silent
  } else {
    readAttributes(description, component);
  }
}

/// As if the scene had written it after the component that misses it, without attributes.
void Instantiation::addMissingPartners(Node& node) {
  for (std::size_t i = 0; i < node.components().size(); ++i) {
    const Component& component = *node.components()[i];
    if (component.hasFailed()) continue;
    ComponentDescription description;
    description.type = component.missingPartner();
    if (description.type.empty()) continue;
    description.where = component.where();
    description.folder = component.folder_;
    std::string name = description.type;
    while (node.findByName(name)) name += "_";
    makeComponent(description, name, node);
    if (Component* made = node.findByName(name)) made->is_made_for_another_ = true;
  }
}

std::unique_ptr<Component> Instantiation::create(const ComponentDescription& description, const std::string& path, bool& misspelt) {
  const std::string present(presentType(description.type));
  try {
    if (modules_.provide(description.type)) {
      if (std::unique_ptr<Component> component = factory_.make(description.type)) return component;
      for (const TypeChange& change : typeChanges())
        if (change.old_type == description.type)
          diagnostics_.note(description.where, path,
                            description.type + " is called " + present + " since SOFA " + std::string(change.since));
      return factory_.make(present);
    }
    misspelt = true;
    return createUnknown(description, path);
  } catch (const std::runtime_error& error) {  // the module cannot be opened
    misspelt = true;
    diagnostics_.error(description.where, path, error.what());
    return std::make_unique<UnknownComponent>();
  }
}

void Instantiation::noEffect(const std::string& what) {
  if (std::find(scene_.no_effect.begin(), scene_.no_effect.end(), what) == scene_.no_effect.end()) scene_.no_effect.push_back(what);
}

void Instantiation::fail(Component& component, Problem problem) {
  component.markFailed();
  diagnostics_.add(std::move(problem));
}

void Instantiation::initialise(const Node& node) {
  for (const auto& component : node.components()) {
    try {
      component->ensureReady();
    } catch (const DependencyFailed&) {  // reported where it happened
    }
  }
  for (const auto& child : node.children()) initialise(*child);
}

/// The diagnostics move with the scene; components must not keep their address.
void Instantiation::release(const Node& node) {
  for (const auto& component : node.components()) component->diagnostics_ = nullptr;
  for (const auto& child : node.children()) release(*child);
}

}  // namespace stroma
