// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

/// A node of the scene tree: owns components and child nodes. Gravity is inherited; a child's own value wins below it.
/// The time step belongs to the root.
class Node {
 public:
  Node(std::string name, Node* parent, SourceLocation where);

  const std::string& name() const { return name_; }
  std::string path() const;  ///< "/" for the root, "/liver/skin"
  Node* parent() const { return parent_; }
  Node& root();
  const SourceLocation& where() const { return where_; }
  const std::vector<std::unique_ptr<Component>>& components() const { return components_; }
  const std::vector<std::unique_ptr<Node>>& children() const { return children_; }

  Vec3 gravity() const;  ///< own value, else the parent's; root default (0, -9.81, 0) m/s^2
  double dt() const;     ///< the root's time step, default 0.01 s
  /// As written in the scene [m/s^2]; empty: inherited.
  std::optional<Vec3> own_gravity;
  /// [s], of the root; other nodes ignore theirs.
  double root_dt = 0.01;
  /// Start time [s], of the root.
  double root_time = 0;

  /// Takes ownership and sets the node of the component.
  Component& add(std::unique_ptr<Component> component);
  Node& addChild(std::unique_ptr<Node> child);
  /// In this node only; null if there is none.
  Component* findByName(std::string_view name) const;
  Node* findChild(std::string_view name) const;

  /// See Component::find. `self` is not returned.
  template <class Role>
  Role* find(const Component* self, bool upwards) const {
    Component* found = nullptr;
    for (const auto& component : components_) {
      if (component.get() == self || !dynamic_cast<Role*>(component.get()) || !component->answersLookup()) continue;
      if (found) ambiguous(*found, *component);
      found = component.get();
    }
    if (found) {
      found->ensureReady();
      return dynamic_cast<Role*>(found);
    }
    return upwards && parent_ ? parent_->find<Role>(self, true) : nullptr;
  }
  /// Every component of a role in this node and below, in document order.
  template <class Role>
  void collect(std::vector<Role*>& out) const {
    for (const auto& component : components_)
      if (auto* role = dynamic_cast<Role*>(component.get())) out.push_back(role);
    for (const auto& child : children_) child->collect(out);
  }

 private:
  /// Throws ComponentError: two components of this node have the role, and a search cannot choose.
  [[noreturn]] void ambiguous(const Component& a, const Component& b) const;
  std::string name_;
  Node* parent_;
  SourceLocation where_;
  std::vector<std::unique_ptr<Component>> components_;
  std::vector<std::unique_ptr<Node>> children_;
};

template <class Role>
Role* Component::find(bool upwards) const {
  return node_->find<Role>(this, upwards);
}

}  // namespace stroma
