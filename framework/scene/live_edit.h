// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that change while a scene runs.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma {

/// A change of one attribute: looked up and checked by the constructor, made by apply(). Every rejection is a
/// ComponentError that says what would be needed, and leaves the scene as it was.
class LiveEdit {
 public:
  /// The error for an attribute that can only change by loading the scene again.
  struct NeedsLoad : ComponentError { using ComponentError::ComponentError; };
  /// `path` names a component or a node, as in `--set`. Rejects what does not exist (with the nearest name) and what
  /// only a restart can change.
  LiveEdit(Node& root, const std::string& path, const std::string& attribute);

  /// The component whose attribute it is; null for an attribute of a node (gravity, dt).
  Component* component() const { return component_; }
  /// The node whose attribute it is; null for an attribute of a component.
  const Node* node() const { return node_; }
  /// What is rebuilt: the component, if its attribute asks for that, then in order those with links to it, which must allow it.
  const std::vector<Component*>& recompiled() const { return recompiled_; }
  bool changesTimeStep() const { return !component_ && attribute_ == "dt"; }
  bool changesGravity() const { return !component_ && attribute_ == "gravity"; }
  std::string name() const;  ///< "/liver/fem.youngModulus"
  /// A value in the scene's notation and how it came there: components ask whether an attribute was given.
  struct Value {
    std::string text;
    DataOrigin origin = DataOrigin::by_override;
  };
  Value value() const;  ///< the present one

  /// Parses with the attribute's table and rebuilds what recompiled() says. Warnings and notes go to `messages`.
  void apply(const Value& value, Diagnostics& messages);

  /// As long as this lives, warnings and notes of a component go to `messages`, and then where they went before.
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
