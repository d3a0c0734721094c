// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Core>
#include <vector>

#include "framework/mechanics/motion.h"
#include "framework/mechanics/projective_constraint.h"

namespace stroma {

/// One of a list of 3x3 blocks.
inline Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> blockAt(std::vector<double>& values, Index slot) {
  return Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data() + std::size_t(slot) * 9);
}

/// Groups of rows with a common velocity. With the projector Q onto the directions free for all n rows of a group, P is Q/n
/// in each of its blocks. P M P then has the mass of the group, so the merged body is solved exactly for any masses.
class NodeGroups {
 public:
  /// Builds groups of rows connected by ties. Returns true if the groups have changed.
  bool set(const std::vector<Tie>& ties, Index rows);
  bool empty() const { return start_.size() == 1; }
  Index count() const { return Index(start_.size()) - 1; }
  /// The rows of a group, ascending.
  const Index* begin(Index group) const { return rows_.data() + start_[group]; }
  const Index* end(Index group) const { return rows_.data() + start_[group + 1]; }
  Index size(Index group) const { return Index(end(group) - begin(group)); }
  /// The group of a row, -1 if it has none.
  Index of(Index row) const { return group_of_row_.empty() ? -1 : group_of_row_[row]; }

  /// Gives all rows of a group their common projector. `list`: sorted, at most one per row, and stays so.
  void share(std::vector<NodeProjector>& list) const;
  /// Replaces each row by the mean of its group.
  void average(Rows vector) const;
  /// The same for positions. The mean of orientations is the normalised mean of their quaternions.
  void averagePositions(const Motion& motion, Rows x) const;
  /// Replaces each number by the mean of its group; shape (rows).
  void average(std::vector<double>& numbers) const;

  /// `matrix` (empty) with all blocks that average() can fill.
  BlockMatrix withFill(const BlockMatrix& matrix) const;
  /// Replaces A by P A P + s (I - P), with s of held_size.h, for groups without fixed directions; withFill() made the pattern
  /// of `matrix`. Call it before projectors are eliminated.
  void average(BlockMatrix& matrix) const;
  /// Adds s (I - P) of the groups to a matrix whose projectors have been eliminated, including s (I - Q) on the diagonals.
  void complete(const std::vector<NodeProjector>& projectors, BlockMatrix& matrix) const;
  /// The diagonal blocks of P A P + s (I - P) from those of A, shape (rows, 9). Blocks between rows of one group are assumed
  /// to be zero, which holds unless an element contains both.
  void completeDiagonal(const std::vector<NodeProjector>& projectors, std::vector<double>& blocks) const;

 private:
  Mat3 sharedProjector(Index group, const std::vector<NodeProjector>& projectors) const;
  std::vector<Tie> ties_;
  std::vector<Index> start_{0}, rows_;
  std::vector<Index> group_of_row_;  ///< shape (rows) or empty
};

/// Sorts by row and merges the projectors of each row into their intersection.
void mergeByRow(std::vector<NodeProjector>& list);

/// The projector onto the directions that are free in both.
Mat3 intersection(const Mat3& a, const Mat3& b);

}  // namespace stroma
