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

/// Groups of rows that have one velocity. With Q the projector that all of a group's n rows allow, P is Q/n in each of
/// its blocks; P M P then carries the group's mass, so that the merged body is solved exactly, whatever the masses.
class NodeGroups {
 public:
  /// Rows that hang together through ties. Returns true when the groups have changed.
  bool set(const std::vector<Tie>& ties, Index rows);
  bool empty() const { return start_.size() == 1; }
  Index count() const { return Index(start_.size()) - 1; }
  /// The rows of a group, ascending.
  const Index* begin(Index group) const { return rows_.data() + start_[group]; }
  const Index* end(Index group) const { return rows_.data() + start_[group + 1]; }
  Index size(Index group) const { return Index(end(group) - begin(group)); }
  /// The group of a row, -1 when it is in none.
  Index of(Index row) const { return group_of_row_.empty() ? -1 : group_of_row_[row]; }

  /// Gives all rows of a group the projector that they all allow. `list`: sorted, at most one per row; stays so.
  void share(std::vector<NodeProjector>& list) const;
  /// Each row becomes the mean of its group.
  void average(Rows vector) const;
  /// The same of positions. The mean of orientations is that of their quaternions, of length one.
  void averagePositions(const Motion& motion, Rows x) const;
  /// Each number becomes the mean of its group; shape (rows).
  void average(std::vector<double>& numbers) const;

  /// `matrix` (empty) with all blocks that average() can fill.
  BlockMatrix withFill(const BlockMatrix& matrix) const;
  /// A becomes P A P + s (I - P), s of held_size.h, for groups without held directions; withFill() made the pattern of
  /// `matrix`. To be called before projectors are eliminated.
  void average(BlockMatrix& matrix) const;
  /// Adds s (I - P) of the groups to a matrix whose projectors have been eliminated, s (I - Q) on the diagonals included.
  void complete(const std::vector<NodeProjector>& projectors, BlockMatrix& matrix) const;
  /// The diagonal blocks of P A P + s (I - P) from those of A, shape (rows, 9): the blocks between rows of one group are
  /// taken for zero, as they are unless an element has both.
  void completeDiagonal(const std::vector<NodeProjector>& projectors, std::vector<double>& blocks) const;

 private:
  Mat3 sharedProjector(Index group, const std::vector<NodeProjector>& projectors) const;
  std::vector<Tie> ties_;
  std::vector<Index> start_{0}, rows_;
  std::vector<Index> group_of_row_;  ///< shape (rows) or empty
};

/// Sorts by row and leaves one projector per row, the intersection of all.
void mergeByRow(std::vector<NodeProjector>& list);

/// The projector onto the directions that both leave free.
Mat3 intersection(const Mat3& a, const Mat3& b);

}  // namespace stroma
