// SPDX-License-Identifier: LGPL-2.1-or-later
// Which meshes of a scene are derived from another one, and which components take values from it.
#pragma once
#include <string>

#include "framework/mesh/topology.h"
#include "framework/scene/description.h"
#include "framework/scene/node.h"

namespace stroma {

/// A component in the description of a scene.
struct Place {
  NodeDescription* node = nullptr;
  std::size_t index = 0;
  ComponentDescription& written() const { return node->components[index]; }
};

/// The description of the component at `path`; null if it is not written in the scene.
Place placeOf(NodeDescription& root, std::string path);

/// The mapping of a scene that fills a container, or null.
TopologicalMapping* fillerOf(const Topology& topology);
/// The source of a mapping's mesh, or null.
const Topology* inputOf(const TopologicalMapping& mapping);

class MeshChain {
 public:
  MeshChain(const Topology& whole, Node& root, NodeDescription& description)
      : whole_(whole), root_(root), description_(description) {}

  /// Whether a topology has the mesh `whole`: it is that one, or is connected to it by a chain of mappings and links with
  /// the same nodes.
  bool isMadeOf(const Topology& part) const;
  /// Whether attributes of a component are linked to the mesh, or to a state or an engine with values from it.
  bool reaches(const Component& component, int depth = 0) const;

 private:
  bool leadsThere(const Topology& part, int depth) const;
  Component* targetOf(const Component& component, const std::string& link) const;

  const Topology& whole_;
  Node& root_;
  NodeDescription& description_;
};

}  // namespace stroma
