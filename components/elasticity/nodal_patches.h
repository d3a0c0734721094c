// SPDX-License-Identifier: LGPL-2.1-or-later
// Matrices -sum_a c_a b_a (x) d_a with one number c_a per node, where b_a and d_a sum over the elements around node a:
// what an average at the nodes adds to a stiffness. Where it has an energy sum_a 1/2 c_a (b_a . x)^2, d_a is b_a.
#pragma once
#include <array>
#include <vector>

#include "framework/algebra/block_matrix.h"

namespace stroma {

/// The nodes of all elements around each node (its patch), and the vectors b_a and d_a over them.
class NodalPatches {
 public:
  NodalPatches() = default;
  /// `cells`: rows of the nodes of tetrahedra; `rows`: of all their nodes, ascending: node a below is rows[a].
  NodalPatches(const std::vector<std::array<Index, 4>>& cells, const std::vector<Index>& rows);
  bool empty() const { return cells_.empty(); }

  void addPattern(BlockPattern& pattern) const;
  /// Slots of all pairs of each patch, patch after patch, row by row.
  std::vector<Index> slots(const BlockMatrix& matrix) const;
  std::size_t slotCount() const;

  /// Sets b to zero; then, for each cell, add() its part of b_a for its four nodes: gradient[i] for node i of the cell.
  void clear() {
    std::fill(b_.begin(), b_.end(), Vec3(Vec3::Zero()));
    std::fill(d_.begin(), d_.end(), Vec3(Vec3::Zero()));
  }
  void add(std::size_t cell, const std::array<Vec3, 4>& gradient) { addTo(b_, cell, gradient); }
  /// The same for d_a, which is b_a without.
  void addDerivative(std::size_t cell, const std::array<Vec3, 4>& gradient) {
    d_.resize(b_.size(), Vec3::Zero());
    addTo(d_, cell, gradient);
  }

  /// values -= factor c_a b_a (x) d_a, summed over the nodes; `slots` begins with those of slots().
  void assemble(double factor, const std::vector<double>& c, const Index* slots, std::vector<double>& values) const;
  /// The same for the diagonal blocks of rows, shape (rows, 9).
  void assembleDiagonal(double factor, const std::vector<double>& c, std::vector<double>& blocks) const;

 private:
  void addTo(std::vector<Vec3>& vectors, std::size_t cell, const std::array<Vec3, 4>& gradient) const;
  std::size_t size(std::size_t a) const { return start_[a + 1] - start_[a]; }

  std::vector<std::size_t> start_;                    ///< shape (nodes + 1), into nodes_
  std::vector<Index> nodes_;                          ///< rows of each patch, ascending
  std::vector<Vec3> b_, d_;                           ///< shape of nodes_ [m^2]; d_ empty where it is b_
  std::vector<std::array<Index, 4>> cells_;           ///< numbers a of the nodes of each cell
  std::vector<std::array<std::uint32_t, 16>> place_;  ///< [cell][a, i]: where node i of the cell is in the patch of a
};

}  // namespace stroma
