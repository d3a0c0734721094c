// SPDX-License-Identifier: LGPL-2.1-or-later
// Changes of attributes in a running scene.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma {

/// A change of one attribute, looked up and checked by the constructor and made by apply(). Every failure is a
/// ComponentError that says what is needed, and leaves the scene unchanged.
class LiveEdit {
 public:
  /// The error for an attribute that needs a restart.
  struct NeedsLoad : ComponentError { using ComponentError::ComponentError; };
  /// `path` names a component or a node, as in `--set`. Throws for unknown names (with the nearest one) and for
  /// attributes that need a restart.
  LiveEdit(Node& root, const std::string& path, const std::string& attribute);

  /// The component whose attribute it is; null for an attribute of a node (gravity, dt).
  Component* component() const { return component_; }
  /// The node whose attribute it is; null for an attribute of a component.
  const Node* node() const { return node_; }
  /// The components to recreate: this one, if its attribute requires it, and in order those linked to it, which must allow it.
  const std::vector<Component*>& recompiled() const { return recompiled_; }
  bool changesTimeStep() const { return !component_ && attribute_ == "dt"; }
  bool changesGravity() const { return !component_ && attribute_ == "gravity"; }
  std::string name() const;  ///< "/liver/fem.youngModulus"
  /// A value in scene notation and its origin: components may check whether an attribute was given.
  struct Value {
    std::string text;
    DataOrigin origin = DataOrigin::by_override;
  };
  Value value() const;  ///< the current value

  /// Parses with the attribute's table and recompiles as declared. Warnings and notes go to `messages`.
  void apply(const Value& value, Diagnostics& messages);

  /// Redirects warnings and notes of a component to `messages` for its lifetime.
  class Listener {
   public:
    Listener(Component& component, Diagnostics& messages) : component_(component), before_(component.diagnostics_) {
      component.diagnostics_ = &messages;
    }
    ~Listener() { component_.diagnostics_ = before_; }
    Listener(const Listener&) = delete;

   private:
    Component& component_;
    Diagnostics* before_;
  };

 private:
  void findAttribute();
  void collectDependents(Component& source, const Data* changed);
  void parseNode(const Value& value, Diagnostics& messages);
  void remake(Diagnostics& messages);
  static void takeLinkedValues(Component& component);

  std::string attribute_;
  Node* node_ = nullptr;
  Component* component_ = nullptr;
  Data* data_ = nullptr;
  std::vector<Component*> recompiled_;
};

}  // namespace stroma
