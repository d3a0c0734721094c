// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshMatrixMass: the consistent mass matrix of the finite element method.
//
//   M_ij = sum over cells of rho * integral of N_i N_j dV  (times the 3x3 identity)
//
// In a tetrahedron rho V / 20 (1 + delta_ij); in a hexahedron the integral by two Gauss points per axis, which is exact
// for parallelepipeds, and as much in prisms and pyramids. On a mesh without volumes rho is a mass per area (triangles and
// quads) or per length (edges).
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
// It also works for a state of numbers, such as a quantity that diffuses in the cells whose nodes are those of geometryState.
//
// With matrix="edges" it has entries at vertices and along edges only, as in SOFA: a hexahedron V/20 at each vertex and V/40
// along each of its 12 edges, a quad A/8 and A/16, simplices what they have anyway. Gravity, and the diagonal with lumping,
// take 2.5 times the entry of a vertex in volumes and twice that on surfaces, also where vertexMass gives it. That of
// hexahedra is not definite and not consistent: it is only meant to reproduce SOFA's results.
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
#include <utility>

#include "components/mechanics/mesh_mass.h"
#include "components/mechanics/node_pair_matrix.h"
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
    table.addChoice("matrix", form_, {"consistent", "edges", "pairs"})
        .help("the integrals, or SOFA's entries at vertices and edges, or at all pairs of the corners of a hexahedron");
    table.add("cellFactors", cell_factors_)
        .help("factor of the mass of each cell, or of each of its 8, 64, ... parts (x fastest) with matrix pairs; 1 by default")
        .unit("-")
        .min(0);
    table.addVisualOnly("printMass");
  }

  void init() override {
    MeshMass::init();
    if (!edge_mass_.empty() && !isNodal())
      throw ComponentError("edgeMass has no meaning without the masses of the nodes",
                           "vertexMass beside it, without massDensity and totalMass");
    if (!edge_mass_.empty() && !(lumping_ && form_ == Form::edges)) {
      buildFromEdges();
    } else if (isNodal()) {
      lumping_ = true;
      row_sums_ = weightsOfNodes();
    } else {
      build();
    }
    if (isQuadratic()) masses_.assign(row_sums_.size(), 0.), addLumped(masses_);
    checkMasses(lumped());
    std::vector<double> diagonal = lumped();
    for (Index i = 0; !lumping_ && i < state().size(); ++i) diagonal[i] = matrix_.valueAt(i, i);
    if (lumping_) matrix_ = {};
    finish(std::move(diagonal));
  }

  const std::vector<double>& lumped() const override { return masses_.empty() ? row_sums_ : masses_; }
  const std::vector<double>& rowSums() const override { return lumping_ ? lumped() : row_sums_; }
  bool isDiagonal() const override { return lumping_; }

  void addProduct(ConstRows p, double factor, Rows out) const override {
    if (lumping_) return Mass::addProduct(p, factor, out);
    matrix_.addProduct(state().segment(p), factor, state().segment(out));
  }
  void addPattern(BlockPattern& pattern) const override {
    if (!lumping_) matrix_.addPattern(state().firstRow(), pattern);
  }
  void prepareAssembly(const BlockMatrix& matrix) override {
    if (!lumping_) matrix_.prepare(state().firstRow(), matrix);
  }
  void addTo(double factor, BlockMatrix& matrix) const override {
    if (lumping_) return Mass::addTo(factor, matrix);
    matrix_.addTo(factor, matrix);
  }
  void addDiagonal(double factor, std::vector<double>& blocks) const override {
    if (lumping_) return Mass::addDiagonal(factor, blocks);
    matrix_.addDiagonal(state().firstRow(), factor, blocks);
  }

 protected:
  bool takesAllRows() const override { return !state().hasFrames() && state().rows_per_node == 1; }  // nodes are numbers of rows

 private:
  bool isQuadratic() const { return !cells().empty() && cells().back().kind->order > 1; }
  /// Compressed rows over pairs of nodes that share a cell.
  void build() {
    const bool is_summed = lumping_ && form_ == Form::consistent;  // no pair is asked for
    if (!is_summed) findPairs();
    row_sums_.assign(state().size(), 0.0);
    if (form_ == Form::pairs && !cell_factors_.empty()) findParts();
    if (!cell_factors_.empty() && cell_factors_.size() != cells().size())
      throw ComponentError(fmt::format("cellFactors has {} values for {} cells", cell_factors_.size(), cells().size()),
                           "one for each cell");
    CellMatrix matrix;
    const Data& total = *data().find("totalMass");
    if (!cell_factors_.empty() && total.isSet()) {  // the mass of the body all the same
      double mass = 0;
      for (std::size_t c = 0; c < cells().size(); ++c) mass += massOf(c, matrix);
      scale_ = mass > 0 ? **std::get_if<double*>(&total.pointer()) / mass : 1;
    }
    if (form_ == Form::edges) return buildAlongEdges();
    if (form_ == Form::pairs) return buildOfPairs();
    for (std::size_t c = 0; c < cells().size(); ++c) {
      const auto [kind, nodes] = cells()[c];
      massMatrixOf(c, matrix);
      for (int i = 0; i < kind->nodes; ++i)
        for (int j = 0; j < kind->nodes; ++j) {
          const double mass = densityOf(c) * matrix[std::size_t(i * kind->nodes + j)];
          if (!is_summed) matrix_.at(nodes[i], nodes[j]) += mass;
          row_sums_[nodes[i]] += mass;
        }
    }
  }

  double densityOf(std::size_t cell) const { return density(cell) * (cell_factors_.empty() ? 1 : scale_ * cell_factors_[cell]); }
  double massOf(std::size_t cell, CellMatrix& matrix) const {
    massMatrixOf(cell, matrix);
    double mass = 0;
    const int count = cells()[cell].kind->nodes;
    for (int k = 0; k < count * count; ++k) mass += densityOf(cell) * matrix[std::size_t(k)];
    return mass;
  }

  /// Takes cellFactors apart: the mean of each cell stays there.
  void findParts() {
    for (parts_along_ = 1; parts_along_ <= 64; parts_along_ *= 2)
      if (cell_factors_.size() == std::size_t(parts_along_ * parts_along_ * parts_along_) * cells().size()) break;
    if (parts_along_ == 1) return;
    if (parts_along_ > 64)
      throw ComponentError(fmt::format("cellFactors has {} values for {} cells", cell_factors_.size(), cells().size()),
                           "1, 8, 64, ... for each cell");
    part_factors_ = std::move(cell_factors_);
    const std::size_t parts = part_factors_.size() / cells().size();
    cell_factors_.assign(cells().size(), 0);
    for (std::size_t p = 0; p < part_factors_.size(); ++p) cell_factors_[p / parts] += part_factors_[p] / double(parts);
  }
  /// What all pairs of the corners of its parts, whose nodes follow those of the cell, leave for the pairs i j: the sum over parts
  /// of their factors times 64 N_i N_j at their centres, over the mean factor; 1 for a cell of one part.
  double sharesOfParts(std::size_t cell, int i, int j) const {
    if (part_factors_.empty()) return 1;
    const int n = parts_along_;
    const auto shape = [n](int corner, int part) {
      const int places[3] = {(corner + 1) / 2 % 2, corner / 2 % 2, corner / 4};
      double value = 1;
      for (const int place : places) {
        const double xi = (part % n + 0.5) / n;
        value *= place ? xi : 1 - xi, part /= n;
      }
      return value;
    };
    const int parts = n * n * n;
    double sum = 0;
    for (int p = 0; p < parts; ++p)
      sum += part_factors_[cell * std::size_t(parts) + std::size_t(p)] * 64 * shape(i, p) * shape(j, p) / parts;
    return cell_factors_[cell] > 0 ? sum / cell_factors_[cell] : 0;
  }

  void buildOfPairs() {
    CellMatrix matrix;
    for (std::size_t c = 0; c < cells().size(); ++c) {
      const auto [kind, nodes] = cells()[c];
      if (kind != &cell_kinds::hexahedron)
        throw ComponentError("matrix=\"pairs\" is of hexahedra", "a mesh of hexahedra alone, or another matrix");
      const double mass = massOf(c, matrix), entry = 8. / 27 * mass;
      for (int i = 0; i < 8; ++i) {
        row_sums_[nodes[i]] += mass / 8;
        for (int j = 0; j < 8; ++j) matrix_.at(nodes[i], nodes[lumping_ ? i : j]) += entry * sharesOfParts(c, i, j);
      }
    }
    lumping_ = false;  // the diagonal is not what gravity takes
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
    if (kind.dimension == 3)
      throw ComponentError(fmt::format("matrix=\"edges\" has no entries for {}", kind.plural),
                           "tetrahedra or hexahedra, or another matrix");
    return {1. / 3, 1. / 6, 1.5};
  }

  void buildAlongEdges() {
    CellMatrix matrix;
    if (!cells().empty() && cells()[0].kind->dimension == 1)
      warn("the mass lies on lines: with matrix=\"edges\" it has SOFA's form, and SOFA's MeshMatrixMass has none on lines", "DiagonalMass");
    for (std::size_t c = 0; c < cells().size(); ++c) {
      const auto [kind, nodes] = cells()[c];
      const double mass = massOf(c, matrix);
      const Shares shares = sharesOf(*kind);
      for (int i = 0; i < kind->nodes; ++i) {
        matrix_.at(nodes[i], nodes[i]) += shares.vertex * mass;
        row_sums_[nodes[i]] += shares.vertex * shares.weight * mass;
      }
      for (const auto& [i, j] : kind->edges)
        for (const auto& [row, column] : {std::pair(nodes[i], nodes[j]), std::pair(nodes[j], nodes[i])})
          matrix_.at(row, column) += shares.edge * mass;
    }
  }

  /// vertexMass, or what SOFA takes of it.
  std::vector<double> weightsOfNodes() {
    std::vector<double> weights = nodalMasses();
    if (form_ != Form::edges) return weights;
    const Mesh& m = mesh();
    const bool is_volume = !m.hexahedra.empty() || !m.tetrahedra.empty(), is_surface = !m.quads.empty() || !m.triangles.empty();
    const CellKind& kind = is_volume ? cell_kinds::tetrahedron : is_surface ? cell_kinds::triangle : cell_kinds::edge;
    for (double& weight : weights) weight *= sharesOf(kind).weight;
    return weights;
  }

  /// M from vertexMass and edgeMass.
  void buildFromEdges() {
    const std::vector<Edge>& edges = mesh().edges.empty() ? mesh().allEdges() : mesh().edges;
    spread(edge_mass_, edges.size(), "edgeMass", "edges of the mesh");
    std::vector<std::vector<Index>> neighbours(std::size_t(state().size()));
    for (Index i = 0; i < state().size(); ++i) neighbours[i] = {i};
    for (const Edge& edge : edges)
      for (int end = 0; end < 2; ++end) neighbours[edge[end]].push_back(edge[1 - end]);
    matrix_.build(neighbours);
    row_sums_ = nodalMasses();
    for (Index i = 0; i < state().size(); ++i) matrix_.at(i, i) = nodalMasses()[i];
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
        matrix_.at(row, column) += mass;
        row_sums_[row] += mass;
      }
    }
    if (form_ == Form::edges) row_sums_ = weightsOfNodes();
  }

  void findPairs() {
    const auto nodes = std::size_t(state().size());
    std::vector<std::size_t> start(nodes + 1, 0), around;  // cells around each node
    const auto forEachNode = [this](auto&& visit) {
      for (std::size_t c = 0; c < cells().size(); ++c)
        for (int i = 0; i < cells()[c].kind->nodes; ++i) visit(c, std::size_t(cells()[c].nodes[i]));
    };
    forEachNode([&](std::size_t, std::size_t node) { ++start[node + 1]; });
    for (std::size_t n = 0; n < nodes; ++n) start[n + 1] += start[n];
    around.resize(start[nodes]);
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    forEachNode([&](std::size_t cell, std::size_t node) { around[next[node]++] = cell; });
    std::vector<std::vector<Index>> neighbours(nodes);
    std::vector<std::size_t> found_by(nodes, nodes);
    for (std::size_t n = 0; n < nodes; ++n)
      for (std::size_t k = start[n]; k < start[n + 1]; ++k)
        for (int i = 0; i < cells()[around[k]].kind->nodes; ++i)
          if (const Index other = cells()[around[k]].nodes[i]; std::exchange(found_by[std::size_t(other)], n) != n)
            neighbours[n].push_back(other);
    matrix_.build(neighbours);
  }

  enum class Form : int { consistent, edges, pairs } form_ = Form::consistent;
  std::vector<double> cell_factors_, part_factors_;
  int parts_along_ = 1;
  double scale_ = 1;
  bool lumping_ = false;
  std::vector<double> edge_mass_;       ///< [kg], as given
  NodePairMatrix matrix_;               ///< M [kg]; empty with lumping
  std::vector<double> row_sums_;        ///< [kg], shape (nodes)
  std::vector<double> masses_;          ///< of quadratic cells, whose row sums are negative at corners [kg]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_matrix_mass) {
  factory.add<stroma::MeshMatrixMass>("MeshMatrixMass", "Consistent mass matrix of the cells of a mesh");
}
