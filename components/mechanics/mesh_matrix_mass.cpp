// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshMatrixMass: the consistent mass matrix of the finite element method.
//
//   M_ij = sum over cells of rho * integral of N_i N_j dV  (times the 3x3 identity)
//
// In a tetrahedron rho V / 20 (1 + delta_ij); in a hexahedron the integral by two Gauss points per axis, which is exact
// for parallelepipeds. On a mesh without volumes rho is a mass per area (triangles and quads) or per length (edges).
// With `lumping` the rows are summed onto the diagonal, which gives the masses of DiagonalMass. In a quadratic
// tetrahedron the integral is by fourteen points, exact where edges are straight (V/420 times 6 at a corner, 32 at the
// middle of an edge); its weight is the consistent one, M g: -m/20 at a corner and m/5 at a middle. Lumped it has the
// masses of DiagonalMass.
//
// Of totalMass, massDensity and vertexMass the first that is given is used. vertexMass m_i gives the diagonal matrix of
// them; with edgeMass, one for each of the mesh's edges (those that it lists, else all of its cells, ascending),
// M_ii = m_i and M_ij = the mass of the edge i j. Links to vertexMass read M_ii, whatever it came from. As in
// SOFA the volumes are those of the initial positions unless computeMassOnRest="true"; the two are the same for a body
// that starts undeformed.
//
// With matrix="edges" it has entries at vertices and along edges only, as in SOFA: a hexahedron V/20 at each vertex and V/40
// along each of its 12 edges, a quad A/8 and A/16, simplices what they have anyway. Gravity, and the diagonal with lumping,
// take 2.5 times the entry of a vertex in volumes and twice that on surfaces. That of hexahedra is not definite, and it is
// not consistent: it is there to repeat SOFA's results.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-9" threshold="1e-20"/>
//   <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
//   <MechanicalObject name="dofs"/>
//   <MeshMatrixMass massDensity="1000"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/mechanics/mesh_mass.h"
#include "framework/algebra/parallel.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshMatrixMass final : public MeshMass {
 public:
  MeshMatrixMass() { compute_on_rest_ = false; }

  void declare(DataTable& table) override {
    MeshMass::declare(table);
    table.add("lumping", lumping_).help("sum the rows onto the diagonal");
    table.add("edgeMass", edge_mass_)
        .help("with vertexMass: what couples the two nodes of each edge, one for all or one per edge")
        .unit("kg");
    table.addChoice("matrix", form_, {"consistent", "edges"}).help("the integrals, or SOFA's entries at vertices and edges");
    table.addVisualOnly("printMass");
  }

  void init() override {
    MeshMass::init();
    if (!edge_mass_.empty() && !isNodal())
      throw ComponentError("edgeMass has no meaning without the masses of the nodes",
                           "vertexMass beside it, without massDensity and totalMass");
    if (!edge_mass_.empty()) {
      buildFromEdges();
    } else if (isNodal()) {
      lumping_ = true;
      row_sums_ = nodalMasses();
    } else {
      build();
    }
    if (isQuadratic()) masses_.assign(row_sums_.size(), 0.), addLumped(masses_);
    checkMasses(lumped());
    std::vector<double> diagonal = lumped();
    for (Index i = 0; !lumping_ && i < state().size(); ++i) diagonal[i] = values_[find(i, i)];
    if (lumping_) start_ = columns_ = slots_ = {}, values_ = {};
    finish(std::move(diagonal));
  }

  const std::vector<double>& lumped() const override { return masses_.empty() ? row_sums_ : masses_; }
  const std::vector<double>& rowSums() const override { return lumping_ ? lumped() : row_sums_; }
  bool isDiagonal() const override { return lumping_; }

  /// Node by node: 12 bytes and 6 flops for each pair of neighbours.
  void addProduct(ConstRows p, double factor, Rows out) const override {
    if (lumping_) return Mass::addProduct(p, factor, out);
    constexpr Index piece_rows = 4096;
    const Index size = state().size();
    const double* __restrict source = p.data + std::size_t(state().firstRow()) * row_doubles;
    double* __restrict target = out.data + std::size_t(state().firstRow()) * row_doubles;
    parallelFor(int((size + piece_rows - 1) / piece_rows), [&, source, target](int piece) {
      const Index end = std::min(size, (piece + 1) * piece_rows);
      for (Index i = piece * piece_rows; i < end; ++i) {
        double sum[row_doubles] = {};
        for (Index s = start_[i]; s < start_[i + 1]; ++s) {
          const double* row = source + std::size_t(columns_[s]) * row_doubles;
          for (int c = 0; c < row_doubles; ++c) sum[c] += values_[s] * row[c];
        }
        for (int c = 0; c < row_doubles; ++c) target[std::size_t(i) * row_doubles + std::size_t(c)] += factor * sum[c];
      }
    });
  }

  void addPattern(BlockPattern& pattern) const override {
    if (lumping_) return;
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i)
      for (Index s = start_[i]; s < start_[i + 1]; ++s) pattern.addBlock(first + i, first + columns_[s]);
  }

  void prepareAssembly(const BlockMatrix& matrix) override {
    if (lumping_) return;
    slots_.resize(columns_.size());
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i)
      for (Index s = start_[i]; s < start_[i + 1]; ++s) slots_[s] = matrix.slot(first + i, first + columns_[s]);
  }

  void addTo(double factor, BlockMatrix& matrix) const override {
    if (lumping_) return Mass::addTo(factor, matrix);
    for (std::size_t s = 0; s < slots_.size(); ++s) {
      double* block = matrix.values().data() + std::size_t(slots_[s]) * 9;
      for (int c : {0, 4, 8}) block[c] += factor * values_[s];
    }
  }

  void addDiagonal(double factor, std::vector<double>& blocks) const override {
    if (lumping_) return Mass::addDiagonal(factor, blocks);
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i)
      for (Index s = start_[i]; s < start_[i + 1]; ++s)
        if (columns_[s] == i)
          for (int c : {0, 4, 8}) blocks[std::size_t(first + i) * 9 + std::size_t(c)] += factor * values_[s];
  }

 private:
  bool isQuadratic() const { return !cells().empty() && cells().back().kind->order > 1; }
  /// Compressed rows over pairs of nodes that share a cell.
  void build() {
    findPairs();
    values_.assign(columns_.size(), 0.0);
    row_sums_.assign(state().size(), 0.0);
    if (form_ == Form::edges) return buildAlongEdges();
    forEachEntry([this](Index i, Index j, double mass) {
      values_[find(i, j)] += mass;
      row_sums_[i] += mass;
    });
  }

  /// Shares of a cell's mass at a vertex and along an edge, and what a vertex weighs over its entry.
  struct Shares {
    double vertex, edge, weight;
  };
  static Shares sharesOf(const CellKind& kind) {
    if (&kind == &cell_kinds::hexahedron) return {1. / 20, 1. / 40, 2.5};
    if (&kind == &cell_kinds::tetrahedron) return {1. / 10, 1. / 20, 2.5};
    if (&kind == &cell_kinds::quad) return {1. / 8, 1. / 16, 2};
    if (&kind == &cell_kinds::triangle) return {1. / 6, 1. / 12, 2};
    return {1. / 3, 1. / 6, 1.5};
  }

  void buildAlongEdges() {
    CellMatrix matrix;
    for (std::size_t c = 0; c < cells().size(); ++c) {
      const auto [kind, nodes] = cells()[c];
      cellMassMatrix(cells()[c], geometry(), matrix);
      double mass = 0;
      for (int k = 0; k < kind->nodes * kind->nodes; ++k) mass += density(c) * matrix[std::size_t(k)];
      const Shares shares = sharesOf(*kind);
      for (int i = 0; i < kind->nodes; ++i) {
        values_[find(nodes[i], nodes[i])] += shares.vertex * mass;
        row_sums_[nodes[i]] += shares.vertex * shares.weight * mass;
      }
      for (const auto& [i, j] : kind->edges)
        for (const auto& [row, column] : {std::pair(nodes[i], nodes[j]), std::pair(nodes[j], nodes[i])})
          values_[find(row, column)] += shares.edge * mass;
    }
  }

  /// M from vertexMass and edgeMass.
  void buildFromEdges() {
    const std::vector<Edge>& edges = mesh().edges.empty() ? mesh().allEdges() : mesh().edges;
    spread(edge_mass_, edges.size(), "edgeMass", "edges of the mesh");
    std::vector<std::vector<Index>> neighbours(std::size_t(state().size()));
    for (Index i = 0; i < state().size(); ++i) neighbours[i] = {i};
    for (const Edge& edge : edges)
      for (int end = 0; end < 2; ++end) neighbours[edge[end]].push_back(edge[1 - end]);
    compress(neighbours);
    values_.assign(columns_.size(), 0.0);
    row_sums_ = nodalMasses();
    for (Index i = 0; i < state().size(); ++i) values_[find(i, i)] = nodalMasses()[i];
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [a, b] = edges[e];
      const double mass = edge_mass_[e], limit = nodalMasses()[a] * nodalMasses()[b];
      if (!(mass * mass < limit))
        throw ComponentError(
            fmt::format("edge {} (nodes {} {}) couples with {:.3g} kg, so the mass matrix is not "
                        "positive definite",
                        e, a, b, mass),
            fmt::format("less than the root of the product of its nodes' masses, {:.3g} kg", std::sqrt(limit)));
      for (const auto& [row, column] : {std::pair(a, b), std::pair(b, a)}) {
        values_[find(row, column)] += mass;
        row_sums_[row] += mass;
      }
    }
  }

  void findPairs() {
    std::vector<std::vector<Index>> neighbours(std::size_t(state().size()));
    for (const MassCell& cell : cells())
      for (int i = 0; i < cell.kind->nodes; ++i) {
        auto& list = neighbours[cell.nodes[i]];
        list.insert(list.end(), cell.nodes, cell.nodes + cell.kind->nodes);
      }
    compress(neighbours);
  }

  /// `neighbours` of each row, with repetitions and in any order, become start_ and columns_.
  void compress(std::vector<std::vector<Index>>& neighbours) {
    start_.assign(1, 0);
    columns_.clear();
    for (auto& list : neighbours) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      columns_.insert(columns_.end(), list.begin(), list.end());
      start_.push_back(Index(columns_.size()));
    }
  }

  Index find(Index row, Index column) const {
    const auto begin = columns_.begin() + start_[row], end = columns_.begin() + start_[row + 1];
    return Index(std::lower_bound(begin, end, column) - columns_.begin());
  }

  enum class Form : int { consistent, edges } form_ = Form::consistent;
  bool lumping_ = false;
  std::vector<double> edge_mass_;       ///< [kg], as given
  std::vector<Index> start_, columns_;  ///< compressed rows of M: shapes (nodes + 1), (pairs)
  std::vector<Index> slots_;            ///< blocks of the system's matrix, shape (pairs)
  std::vector<double> values_;          ///< M_ij [kg], shape (pairs)
  std::vector<double> row_sums_;        ///< [kg], shape (nodes)
  std::vector<double> masses_;          ///< of quadratic cells, whose row sums are negative at corners [kg]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_matrix_mass) {
  factory.add<stroma::MeshMatrixMass>("MeshMatrixMass", "Consistent mass matrix of the cells of a mesh");
}
