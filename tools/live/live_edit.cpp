// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/live_edit.h"

#include <algorithm>

#include "framework/scene/gravity.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "framework/scene/time_step.h"

namespace stroma {
namespace {

/// Every path of the tree, for suggestions.
void collectPaths(const Node& node, std::vector<std::string>& paths) {
  paths.push_back(node.path());
  for (const auto& component : node.components()) paths.push_back(component->path());
  for (const auto& child : node.children()) collectPaths(*child, paths);
}

Node* findNode(Node& root, std::string_view path) {
  if (path.empty() || path == "/" || path == root.name() || path == "/" + root.name()) return &root;
  if (path.starts_with("/")) path.remove_prefix(1);
  Node* node = &root;
  while (node && !path.empty()) {
    const auto slash = std::min(path.size(), path.find('/'));
    node = node->findChild(path.substr(0, slash));
    path.remove_prefix(std::min(path.size(), slash + 1));
  }
  return node;
}

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
  throw LiveEdit::NeedsLoad(name + " cannot change while the scene runs: " + why, "an attribute that may change",
                            "load the scene again with the new value (--set " + name + "=...)");
}

}  // namespace

LiveEdit::LiveEdit(Node& root, const std::string& path, const std::string& attribute) : attribute_(attribute) {
  component_ = findComponent(root, path);
  if (component_) {
    findAttribute();
    return;
  }
  node_ = findNode(root, path);
  if (!node_) {
    std::vector<std::string> paths;
    collectPaths(root, paths);
    throw ComponentError("the scene has no node or component " + inQuotes(path), "a path of the scene",
                         nearest(path, paths));
  }
  if (attribute != "gravity" && attribute != "dt")
    throw ComponentError("a node has no attribute " + inQuotes(attribute) + " that may change while the scene runs",
                         "gravity or dt", nearest(attribute, {"gravity", "dt"}));
  if (attribute == "dt" && node_->parent())
    throw ComponentError("a child node cannot have its own time step", "dt of the outermost node");
}

void LiveEdit::findAttribute() {
  data_ = component_->data().find(attribute_);
  if (!data_)
    throw ComponentError(component_->type() + " has no attribute " + inQuotes(attribute_),
                         "one of those that 'stroma doc " + component_->type() + "' lists",
                         nearest(attribute_, component_->data().names()));
  if (data_->isOutput()) throw ComponentError(name() + " is computed by the component: it cannot be set");
  if (data_->changeEffect() == ChangeEffect::restart)
    refuse(name(), "the component makes use of it only when the scene is loaded");
  const bool is_remade = data_->changeEffect() == ChangeEffect::recompile;
  collectDependents(*component_, is_remade ? nullptr : data_);
  if (is_remade) recompiled_.insert(recompiled_.begin(), component_);
}

/// `changed`: the one attribute with a new value; null when outputs may have one too. Depth first; each is inserted at
/// the front after its followers (reverse post-order, a topological sort).
void LiveEdit::collectDependents(Component& source, const Data* changed) {
  std::vector<Component*> all;
  source.node().root().collect(all);
  for (Component* component : all)
    for (const Component::DataLink& link : component->data_links_) {
      if (link.source != &source || (changed && link.from != changed)) continue;
      if (link.target->changeEffect() == ChangeEffect::restart)
        refuse(name(), component->path() + " takes its " + link.target->name() +
                           " from there, and makes use of it only when the scene is loaded");
      if (std::find(recompiled_.begin(), recompiled_.end(), component) != recompiled_.end()) continue;
      collectDependents(*component, nullptr);
      recompiled_.insert(recompiled_.begin(), component);
    }
}

std::string LiveEdit::name() const {
  if (component_) return component_->path() + "." + data_->name();
  return (node_->parent() ? node_->path() : std::string()) + "/." + attribute_;
}

LiveEdit::Value LiveEdit::value() const {
  if (data_) return {data_->print(), data_->origin()};
  if (changesTimeStep()) return {printReal(node_->dt()), DataOrigin::written};
  Vec3 gravity = node_->gravity();
  return {Data("gravity", &gravity).print(), node_->own_gravity ? DataOrigin::written : DataOrigin::by_default};
}

void LiveEdit::parseNode(const Value& value, Diagnostics& messages) {
  if (!changesTimeStep() && value.origin == DataOrigin::by_default) return node_->own_gravity.reset();
  double dt = 0;
  Vec3 gravity = Vec3::Zero();
  std::string note;
  const std::optional<Problem> problem =
      changesTimeStep()
          ? Data("dt", &dt).min(shortest_time_step).max(longest_time_step).unit("s").parse(value.text, value.origin)
          : readGravity(value.text, gravity, note);
  if (problem) throw ComponentError(name() + ": " + problem->message, problem->expected, problem->suggestion);
  if (changesTimeStep()) {
    node_->root_dt = dt;
  } else {
    node_->own_gravity = gravity;
  }
  if (!note.empty()) messages.note(node_->where(), name(), note);
}

void LiveEdit::takeLinkedValues(Component& component) {
  for (const Component::DataLink& link : component.data_links_) {
    if (link.by_src && !link.from->isSet() && !link.from->isOutput()) continue;
    if (const std::optional<Problem> problem = link.target->copyFrom(*link.from))
      throw ComponentError(component.path() + "." + link.target->name() + ", linked from " + link.source->path() +
                               ": " + problem->message,
                           problem->expected, problem->suggestion);
  }
}

void LiveEdit::remake(Diagnostics& messages) {
  for (Component* component : recompiled_) {
    const Listener listener(*component, messages);
    if (component != component_) takeLinkedValues(*component);
    component->recompile();
  }
}

void LiveEdit::apply(const Value& value, Diagnostics& messages) {
  if (!data_) return parseNode(value, messages);
  if (value.origin == DataOrigin::by_override && trimmed(value.text).starts_with("@"))
    refuse(name(), inQuotes(value.text) + " is a link, and links are made when the scene is loaded");
  const std::optional<Problem> problem = data_->parse(value.text, value.origin);
  if (problem) throw ComponentError(name() + ": " + problem->message, problem->expected, problem->suggestion);
  remake(messages);
}

}  // namespace stroma
