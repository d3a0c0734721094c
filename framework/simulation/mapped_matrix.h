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
  /// An empty matrix with the pattern of J^T A J.
  BlockMatrix reducedPattern() const;
  /// Updates the Jacobians of mappings that are not constant.
  void updateJacobian(const std::vector<Mapping*>& mappings);
  /// out = J^T full() J
  void reduce(BlockMatrix& out) const;

 private:
  /// An entry of J: a block and its independent row.
  struct Term {
    Index row = 0;
    Mat3 block = Mat3::Identity();
  };
  Index independent_rows_ = 0;
  BlockMatrix full_;
  std::vector<std::vector<Term>> jacobian_;  ///< shape (all rows)
  std::vector<JacobianBlock> blocks_;
};

}  // namespace stroma
