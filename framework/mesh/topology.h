// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "framework/mesh/mesh.h"
#include "framework/scene/component.h"

namespace stroma {

/// The role of a component that holds a mesh: containers, grids, loaders, topological mappings.
class Topology : public Component {
 public:
  std::string roleText() const override { return "topology"; }
  /// Positions [m] and cells; valid after init().
  const Mesh& mesh() const { return mesh_; }

 protected:
  Mesh mesh_;
};

/// The role of a component that reads a mesh from a file; found by `src`, never by searching a node.
class MeshSource : public Component {
 public:
  std::string roleText() const override { return "mesh loader"; }
};

}  // namespace stroma
