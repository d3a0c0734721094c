// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "components/hyperelasticity/porous_sponge.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/mesh.h"

namespace stroma::porous {

/// The cells that hold a fluid, one at a time and in plain numbers: for matrices of nodes, checks and output. Mesh and
/// rest positions are kept by reference. Volumes are those at rest, over the mesh's overlap.
class PorousCells {
 public:
  /// `kind`: tetrahedron or hexahedron.
  PorousCells(const CellKind& kind, const Mesh& mesh, const std::vector<Vec3>& rest)
      : kind_(kind), mesh_(mesh), rest_(rest) {}
  const CellKind& kind() const { return kind_; }
  const Mesh& mesh() const { return mesh_; }
  const std::vector<Vec3>& rest() const { return rest_; }
  std::size_t count() const { return isTetrahedra() ? mesh_.tetrahedra.size() : mesh_.hexahedra.size(); }
  std::span<const Index> nodes(std::size_t cell) const;
  /// What makes a cell useless at rest ("is flat at rest"), or empty.
  std::string fault(std::size_t cell) const;

  template <class T>
  using OfNodes = std::array<T, most_cell_nodes>;
  /// int N_a dV: how much of the cell's volume each node has [m^3].
  OfNodes<double> shares(std::size_t cell) const;
  /// The shares over their sum.
  OfNodes<double> fractions(std::size_t cell) const;
  /// int grad N_a . grad N_b dV [m]
  std::array<OfNodes<double>, most_cell_nodes> gradients(std::size_t cell) const;
  /// alpha w^1/2 dv/dx_a [m^2], v the volume with the cell's nodes at x and w = d ln J/dJ at J = v/V.
  OfNodes<Vec3> areas(std::size_t cell, const Vec3* x, const Sponge& sponge) const;

 private:
  bool isTetrahedra() const { return kind_.type == CellType::tetrahedron; }
  OfNodes<Vec3> corners(std::size_t cell) const;

  const CellKind& kind_;
  const Mesh& mesh_;
  const std::vector<Vec3>& rest_;
};

}  // namespace stroma::porous
