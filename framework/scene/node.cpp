// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/node.h"

namespace stroma {

Node::Node(std::string name, Node* parent, SourceLocation where) : name_(std::move(name)), parent_(parent), where_(std::move(where)) {}

std::string Node::path() const {
  if (!parent_) return "/";
  const std::string above = parent_->path();
  return above == "/" ? "/" + name_ : above + "/" + name_;
}

Node& Node::root() {
  Node* node = this;
  while (node->parent_) node = node->parent_;
  return *node;
}

Vec3 Node::gravity() const {
  if (own_gravity) return *own_gravity;
  return parent_ ? parent_->gravity() : Vec3(0, -9.81, 0);
}

double Node::dt() const { return parent_ ? parent_->dt() : root_dt; }

Component& Node::add(std::unique_ptr<Component> component) {
  component->node_ = this;
  components_.push_back(std::move(component));
  return *components_.back();
}

Node& Node::addChild(std::unique_ptr<Node> child) {
  child->parent_ = this;
  children_.push_back(std::move(child));
  return *children_.back();
}

Component* Node::findByName(std::string_view name) const {
  for (const auto& component : components_)
    if (component->name() == name) return component.get();
  // SOFA numbers unnamed components from 1; here the first one carries the bare type.
  if (name.size() > 1 && name.back() == '1') {
    name.remove_suffix(1);
    for (const auto& component : components_)
      if (component->name() == name && component->type() == name) return component.get();
  }
  return nullptr;
}

Node* Node::findChild(std::string_view name) const {
  for (const auto& child : children_)
    if (child->name() == name) return child.get();
  return nullptr;
}

void Node::ambiguous(const Component& a, const Component& b) const {
  throw ComponentError("node " + path() + " holds more than one " + a.roleText() + ": " + a.name() + " and " + b.name(),
                       "one, or a link that names the one meant");
}

}  // namespace stroma
