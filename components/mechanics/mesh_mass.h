// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/mass.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// integral of N_i N_j over a cell, row-major count x count, [m^d] with d the cell's dimension.
using CellMatrix = std::array<double, std::size_t(most_cell_nodes) * most_cell_nodes>;

/// A cell that carries mass: kind->nodes node indices at `nodes`.
struct MassCell {
  const CellKind* kind = nullptr;
  const Index* nodes = nullptr;
};

/// Fills the first count * count numbers. Simplices: V (1 + delta_ij) / ((d + 1)(d + 2)), with the sign of V for a
/// tetrahedron; other cells: a quadrature that is exact for N_i N_j.
void cellMassMatrix(const MassCell& cell, const std::vector<Vec3>& position, CellMatrix& out);

/// What masses given by a mesh share: where the cells and positions are, and how density, total mass and nodal masses
/// go together.
class MeshMass : public Mass {
 public:
  void declare(DataTable& table) override;
  void init() override;

 protected:
  /// True when the nodal masses were given: then nodalMasses() is all there is, and no cell carries mass.
  bool isNodal() const { return source_ == Source::nodes; }
  const std::vector<double>& nodalMasses() const { return vertex_mass_; }  ///< [kg], shape (nodes)
  /// Cells of the highest dimension in the mesh: volumes, else faces, else edges.
  const std::vector<MassCell>& cells() const { return cells_; }
  /// cellMassMatrix() of a cell; with equal shares the area of a quad is that of two triangles.
  void massMatrixOf(std::size_t cell, CellMatrix& out) const;
  /// masses[node] += those of the cells on the diagonal: row sums or equal shares; of quadratic cells, whose row sums are negative
  /// at corners, the mass in proportion to the diagonal (Hinton, Rock and Zienkiewicz 1976).
  void addLumped(std::vector<double>& masses) const;
  /// Mass of a cell over its size, [kg/m^d], the mesh's overlap taken into account.
  double density(std::size_t cell) const { return densities_.size() == 1 ? densities_[0] : densities_[cell]; }
  const std::vector<Vec3>& geometry() const { return *geometry_; }  ///< positions that give the sizes, shape (nodes)
  /// Throws for a node with a mass that is not positive; warns of nodes that no cell uses. `masses` are the row sums.
  void checkMasses(const std::vector<double>& masses) const;
  /// Frees what only init() needs; `nodal` [kg], shape (nodes), is what links to vertexMass read.
  void finish(std::vector<double> nodal);
  /// The mesh of the cells; throws ComponentError when there is none or its nodes are not the state's.
  const Mesh& mesh() {
    if (!mesh_owner_) findMesh();
    return mesh_owner_->mesh();
  }

  bool compute_on_rest_ = true;
  bool absolute_volumes_ = false;
  enum class Cells : int { all, first } which_cells_ = Cells::all;
  enum class Shares : int { integrals, equal } shares_ = Shares::integrals;

 private:
  enum class Source { total, density, nodes };
  Source chooseSource();
  void findMesh();
  void collectCells(const Mesh& mesh);
  void findDensities(double overlap);
  std::string cellName(std::size_t cell) const;

  std::vector<double> mass_density_{1}, vertex_mass_;
  double total_mass_ = 1;
  bool last_for_others_ = false;
  TopologyLink topology_;
  Link<State> geometry_state_{"mechanical state"};

  Source source_ = Source::total;
  const Topology* mesh_owner_ = nullptr;
  const std::vector<Vec3>* geometry_ = nullptr;
  std::vector<Vec3> places_;  ///< of frames
  std::vector<MassCell> cells_;
  std::vector<double> densities_;
};

}  // namespace stroma
