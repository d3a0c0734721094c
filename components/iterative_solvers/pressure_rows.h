// SPDX-License-Identifier: LGPL-2.1-or-later
// The pressures of a nearly incompressible body, p = E B u. B has a row b_c for each volume c (VolumeTerms), and the diagonal matrix E is
// what its bulk modulus exceeds that of Poisson's ratio 0.3. The pressures are stored three to a row of a vector, neighbours together, so
// that matrices between them have 3x3 blocks. With the nodes i of a volume, n_i pressures at a node and weights l_i [m^5/N],
//
//   L = sum_i l_i (n_i I - 1 1^T)   over the n_i pressures of each node,   l_i = min E^-1 / max_c sum_{i in c} n_i,
//
// is E^-1 times a Laplacian: 0 for a uniform pressure, and about E^-1 for one that alternates between neighbours.
#pragma once
#include <vector>

#include "framework/algebra/block_matrix.h"
#include "framework/algebra/volume_terms.h"

namespace stroma {

class PressureRows {
 public:
  /// Takes the terms whose bulk modulus is far above the shear modulus.
  PressureRows(const VolumeTerms& terms, Index nodes);
  Index count() const { return Index(excess_.size()); }
  /// Of a vector that holds the pressures.
  Index rows() const { return rows_; }
  /// The same pressures at the same places of a vector.
  bool isLike(const PressureRows& other) const { return nodes_ == other.nodes_ && start_ == other.start_; }

  /// out = B u
  void volumes(ConstRows u, Rows out) const;
  /// out += factor B^T p
  void addForces(double factor, ConstRows p, Rows out) const;
  /// p = E p, and p = E^-1 p
  void multiplyByExcess(Rows p) const;
  void divideByExcess(Rows p) const;
  /// out = L p; `sums` has a row for each node.
  void multiplyByLaplacian(ConstRows p, Rows sums, Rows out) const;

  /// k -= B^T E B
  void subtractFrom(BlockMatrix& k) const;
  /// The same of the diagonal blocks, shape (nodes, 9).
  void subtractFrom(std::vector<double>& diagonal) const;
  /// B D^-1 B^T + L, with the blocks of D^-1. Places without a pressure get a diagonal entry of the usual size.
  BlockMatrix products(const std::vector<Mat3>& inverse) const;
  /// The mean |b_i| [m^2].
  double meanGradient() const;

 private:
  void findEntries(Index nodes);
  void group();
  void weighLaplacian();
  Index pressuresAt(Index node) const { return entry_start_[node + 1] - entry_start_[node]; }

  std::vector<Index> start_{0}, nodes_;       ///< the nodes of each volume; shape (count + 1), (entries)
  std::vector<Vec3> gradients_;               ///< b_c at these nodes [m^2]
  std::vector<Index> volume_of_;              ///< of an entry
  std::vector<double> excess_;                ///< E [N/m^5], shape (count)
  std::vector<Index> entry_start_, entries_;  ///< the entries of each node; shape (nodes + 1), (entries)
  std::vector<std::size_t> place_;            ///< of a pressure among the numbers of a vector, shape (count)
  std::vector<double> laplacian_;             ///< l_i, shape (nodes)
  Index rows_ = 0;
};

}  // namespace stroma
