// SPDX-License-Identifier: LGPL-2.1-or-later
// Which meshes of a scene are made of another one, and what takes values from it.
#pragma once
#include <string>

#include "framework/mesh/topology.h"
#include "framework/scene/description.h"
#include "framework/scene/node.h"

namespace stroma {

/// A component as the scene has it.
struct Place {
  NodeDescription* node = nullptr;
  std::size_t index = 0;
  ComponentDescription& written() const { return node->components[index]; }
};

/// Of the component at `path`; null where nobody wrote it.
Place placeOf(NodeDescription& root, std::string path);

/// The mapping of a scene that fills a container, or null.
TopologicalMapping* fillerOf(const Topology& topology);
/// What a mapping takes its mesh from, or null.
const Topology* inputOf(const TopologicalMapping& mapping);

class MeshChain {
 public:
  MeshChain(const Topology& whole, Node& root, NodeDescription& description)
      : whole_(whole), root_(root), description_(description) {}

  /// Whether a topology has the mesh `whole`: it is that one, or a chain of mappings and links leads from it there, and its
  /// nodes are the same.
  bool isMadeOf(const Topology& part) const;
  /// Whether attributes of a component are linked to the mesh, or to a state or an engine that has its values from there.
  bool reaches(const Component& component, int depth = 0) const;

 private:
  bool leadsThere(const Topology& part, int depth) const;
  Component* targetOf(const Component& component, const std::string& link) const;

  const Topology& whole_;
  Node& root_;
  NodeDescription& description_;
};

}  // namespace stroma
