// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshMatrixMass: the consistent mass matrix of the finite element method.
//
//   M_ij = sum over cells of rho * integral of N_i N_j dV  (times the 3x3 identity)
//
// In a tetrahedron rho V / 20 (1 + delta_ij); in a hexahedron the integral by two Gauss points an axis, which is exact
// for parallelepipeds. On a mesh without volumes rho is a mass per area (triangles and quads) or per length (edges).
// With `lumping` the rows are summed onto the diagonal, which gives the masses of DiagonalMass.
//
// Of totalMass, massDensity and vertexMass the first that is given is used (vertexMass gives a diagonal matrix). As in
// SOFA the volumes are those of the initial positions unless computeMassOnRest="true"; the two are the same for a body
// that starts undeformed.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-9" threshold="1e-20"/>
//   <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
//   <MechanicalObject name="dofs"/>
//   <MeshMatrixMass massDensity="1000"/>
// </Node>
#include <algorithm>

#include "framework/algebra/parallel.h"
#include "framework/mechanics/mesh_mass.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshMatrixMass final : public MeshMass {
 public:
  MeshMatrixMass() { compute_on_rest_ = false; }

  void declare(DataTable& table) override {
    MeshMass::declare(table);
    table.add("lumping", lumping_).help("sum the rows onto the diagonal");
    table.addVisualOnly("printMass");
  }

  void init() override {
    MeshMass::init();
    if (isNodal()) {
      lumping_ = true;
      row_sums_ = nodalMasses();
    } else {
      build();
    }
    checkMasses(row_sums_);
    if (lumping_) start_ = columns_ = slots_ = {}, values_ = {};
    finish();
  }

  const std::vector<double>& lumped() const override { return row_sums_; }
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
        for (Index s = start_[std::size_t(i)]; s < start_[std::size_t(i) + 1]; ++s) {
          const double* row = source + std::size_t(columns_[std::size_t(s)]) * row_doubles;
          for (int c = 0; c < row_doubles; ++c) sum[c] += values_[std::size_t(s)] * row[c];
        }
        for (int c = 0; c < row_doubles; ++c) target[std::size_t(i) * row_doubles + std::size_t(c)] += factor * sum[c];
      }
    });
  }

  void addPattern(BlockPattern& pattern) const override {
    if (lumping_) return;
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i)
      for (Index s = start_[std::size_t(i)]; s < start_[std::size_t(i) + 1]; ++s)
        pattern.addBlock(first + i, first + columns_[std::size_t(s)]);
  }

  void prepareAssembly(const BlockMatrix& matrix) override {
    if (lumping_) return;
    slots_.resize(columns_.size());
    const Index first = state().firstRow();
    for (Index i = 0; i < state().size(); ++i)
      for (Index s = start_[std::size_t(i)]; s < start_[std::size_t(i) + 1]; ++s)
        slots_[std::size_t(s)] = matrix.slot(first + i, first + columns_[std::size_t(s)]);
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
      for (Index s = start_[std::size_t(i)]; s < start_[std::size_t(i) + 1]; ++s)
        if (columns_[std::size_t(s)] == i)
          for (int c : {0, 4, 8})
            blocks[std::size_t(first + i) * 9 + std::size_t(c)] += factor * values_[std::size_t(s)];
  }

 private:
  /// Compressed rows over pairs of nodes that share a cell.
  void build() {
    findPairs();
    values_.assign(columns_.size(), 0.0);
    row_sums_.assign(std::size_t(state().size()), 0.0);
    CellMatrix matrix;
    for (std::size_t c = 0; c < cells().size(); ++c) {
      const MassCell& cell = cells()[c];
      cellMassMatrix(cell, geometry(), matrix);
      for (int i = 0; i < cell.count; ++i)
        for (int j = 0; j < cell.count; ++j) {
          const double mass = density(c) * matrix[std::size_t(i * cell.count + j)];
          values_[std::size_t(find(cell.nodes[i], cell.nodes[j]))] += mass;
          row_sums_[std::size_t(cell.nodes[i])] += mass;
        }
    }
  }

  void findPairs() {
    std::vector<std::vector<Index>> neighbours(std::size_t(state().size()));
    for (const MassCell& cell : cells())
      for (int i = 0; i < cell.count; ++i) {
        auto& list = neighbours[std::size_t(cell.nodes[i])];
        list.insert(list.end(), cell.nodes, cell.nodes + cell.count);
      }
    start_.assign(1, 0);
    for (auto& list : neighbours) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      columns_.insert(columns_.end(), list.begin(), list.end());
      start_.push_back(Index(columns_.size()));
    }
  }

  Index find(Index row, Index column) const {
    const auto begin = columns_.begin() + start_[std::size_t(row)],
               end = columns_.begin() + start_[std::size_t(row) + 1];
    return Index(std::lower_bound(begin, end, column) - columns_.begin());
  }

  bool lumping_ = false;
  std::vector<Index> start_, columns_, slots_;
  std::vector<double> values_, row_sums_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_matrix_mass) {
  factory.add<stroma::MeshMatrixMass>("MeshMatrixMass", "Consistent mass matrix of the cells of a mesh");
}
