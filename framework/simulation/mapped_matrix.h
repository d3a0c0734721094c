// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/mapping.h"

namespace stroma {

/// The matrix of a system with mappings. Masses and force fields add to full(), over all rows. reduce() computes
/// J^T A J over the independent rows, where J is the product of the mappings' Jacobians.
class MappedMatrix {
 public:
  /// `pattern`: blocks over all rows, including geometric stiffnesses. `mappings`: parents first, already applied.
  void prepare(BlockPattern&& pattern, const std::vector<Mapping*>& mappings, Index independent_rows);
  BlockMatrix& full() { return full_; }
  /// Gives its memory back; cost() stays.
  void release() { full_ = {}, jacobian_ = {}, places_ = {}; }
  /// An empty matrix with the pattern of J^T A J.
  BlockMatrix reducedPattern() const;
  /// Updates the Jacobians of mappings that are not constant.
  void updateJacobian(const std::vector<Mapping*>& mappings);
  /// out = J^T full() J
  void reduce(BlockMatrix& out);
  /// Estimated nanoseconds of reduce(), after prepare().
  double cost() const { return 5. * double(sums_.own) + 14. * double(sums_.mapped); }

 private:
  /// Adds to out[row][column]; `place` is its slot the last time, or -1.
  static void add(BlockMatrix& out, Index row, Index column, const Mat3& block, Index& place);
  /// An entry of J: a block and its independent row.
  struct Term {
    Index row = 0;
    Mat3 block = Mat3::Identity();
  };
  Index independent_rows_ = 0;
  BlockMatrix full_;
  std::vector<std::vector<Term>> jacobian_;  ///< shape (all rows)
  std::vector<JacobianBlock> blocks_;
  /// How many blocks reduce() adds: those of independent rows, and products of mapped ones.
  struct Sums {
    std::size_t own = 0, mapped = 0;
  };
  Sums sums_;
  std::vector<Index> places_;  ///< of what reduce() adds, in its order: nothing is searched for in the next one
};

}  // namespace stroma
