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
  /// "tetrahedra" for a container of one kind of cell, which a topological mapping may fill; else empty.
  virtual std::string mainCells() const { return {}; }

 protected:
  Mesh mesh_;
};

/// A topology made from another one. With an output (linked, or a container in its node) it fills that container, and
/// look-ups in its node find the container; without one it is the topology of its node itself.
class TopologicalMapping : public Topology {
 public:
  std::string roleText() const override { return "topological mapping"; }
  /// The container that this mapping fills, or null; known before init().
  Topology* output() const;
  bool answersLookup() const override { return output() == nullptr; }

 protected:
  Link<Topology> input_{"topology"}, output_{"topology"};
};

/// The role of a component that reads a mesh from a file; found by `src`, never by searching a node.
class MeshSource : public Component {
 public:
  std::string roleText() const override { return "mesh loader"; }
};

}  // namespace stroma
