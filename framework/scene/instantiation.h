// SPDX-License-Identifier: LGPL-2.1-or-later
// From a description to a tree of initialised components, in three passes: create every component and read its
// attributes; resolve links, when all their targets exist; initialise in document order, each component after the
// ones that it reads.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma {

class Instantiation {
 public:
  Instantiation(Scene& scene, Factory& factory, Modules& modules);
  /// Fills scene.root. Problems are collected in scene.diagnostics, as many as can be found at once.
  void run();
  /// The first two passes: components with their attributes and links, not initialised. Each is initialised on demand
  /// (Component::ensureReady()), as long as the scene object is not moved.
  void makeTree();

 private:
  /// An attribute that refers to something in the tree, kept until the whole tree exists.
  struct PendingLink {
    Component* component;
    Data* data;  ///< null for `src`
    std::string text;
    SourceLocation where;
  };

  // ---- instantiate.cpp: the tree ----
  /// Opens the modules that RequiredPlugin names by path, in the whole tree, before any component is made.
  void prepare(const NodeDescription& node);
  void openPlugins(const ComponentDescription& component);
  /// Attributes, components and children of one node, in the order of the file.
  void build(const NodeDescription& description, Node& node);
  void buildChild(const NodeDescription& description, const std::string& name, Node& parent);
  void reportDuplicates(const NodeDescription& description, const Node& node);
  void addMissingPartners(Node& node);
  void makeComponent(const ComponentDescription& description, const std::string& name, Node& node);
  /// The component of a type, of its old name or, with `misspelt`, of the most similar name: never null.
  std::unique_ptr<Component> create(const ComponentDescription& description, const std::string& path, bool& misspelt);
  std::unique_ptr<Component> createUnknown(const ComponentDescription& description, const std::string& path);
  /// Records once what was accepted without effect.
  void noEffect(const std::string& what);

  // ---- attributes.cpp ----
  void readNodeAttributes(const NodeDescription& description, Node& node);
  void readNodeAttribute(const AttributeDescription& attribute, Node& node);
  void readAttributes(const ComponentDescription& description, Component& component);
  void checkWord(const AttributeDescription& attribute, const LinkBase& link, Component& component);
  void readAttribute(const AttributeDescription& attribute, Component& component);
  Data* findAttribute(const std::string& name, Component& component);
  void unknownAttribute(const AttributeDescription& attribute, Component& component);
  bool readCommonAttribute(const AttributeDescription& attribute, Component& component);
  void checkTemplate(const AttributeDescription& attribute, Component& component);
  void findInputFile(const AttributeDescription& attribute, Data& data, Component& component);
  bool isSwitchedOffOrVisual(const AttributeDescription& attribute, const std::string& owner,
                             const Component* component);
  /// Reports required and physical attributes that were not set.
  void checkGiven(Component& component);

  // ---- links.cpp ----
  void resolveLinks();
  void resolveComponentLink(const PendingLink& link);
  void resolveDataLink(const PendingLink& link);
  /// Links every attribute that is not written to the source's attribute of the same name.
  void resolveSrc(const PendingLink& link);
  void linkData(const PendingLink& link, Component& source, const Data& from);

  /// Reports the problem and marks the component, so that its users print no further message.
  void fail(Component& component, Problem problem);
  void initialise(const Node& node);
  void release(const Node& node);

  Scene& scene_;
  Factory& factory_;
  Modules& modules_;
  Diagnostics& diagnostics_;
  std::vector<PendingLink> pending_;
};

/// A placeholder for a component that could not be created, so that links to it do not raise a second message.
class UnknownComponent final : public Component {
 public:
  void declare(DataTable&) override {}
  std::string roleText() const override { return "unknown component"; }
};

}  // namespace stroma
