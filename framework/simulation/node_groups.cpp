// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/node_groups.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "framework/simulation/held_size.h"

namespace stroma {

namespace {

bool byRow(const NodeProjector& a, const NodeProjector& b) { return a.row < b.row; }

const NodeProjector* findRow(const std::vector<NodeProjector>& list, std::size_t count, Index row) {
  const auto last = list.begin() + std::ptrdiff_t(count);
  const auto at = std::lower_bound(list.begin(), last, NodeProjector{row, Mat3::Zero()}, byRow);
  return at != last && at->row == row ? &*at : nullptr;
}

}  // namespace

// The null space of (I - P_a) + (I - P_b).
Mat3 intersection(const Mat3& a, const Mat3& b) {
  if (a.isZero(0) || b.isZero(0)) return Mat3::Zero();
  if (a.isIdentity(0)) return b;
  if (b.isIdentity(0)) return a;
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(2 * Mat3::Identity() - a - b);
  Mat3 result = Mat3::Zero();
  for (int i = 0; i < 3; ++i)
    if (std::abs(eigen.eigenvalues()[i]) < 1e-7) result += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).transpose();
  return result;
}

void mergeByRow(std::vector<NodeProjector>& list) {
  std::sort(list.begin(), list.end(), byRow);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (kept > 0 && list[kept - 1].row == list[i].row) {
      list[kept - 1].projector = intersection(list[kept - 1].projector, list[i].projector);
    } else {
      list[kept++] = list[i];
    }
  }
  list.resize(kept);
}

bool NodeGroups::set(const std::vector<Tie>& ties, Index rows) {
  if (ties == ties_) return false;
  ties_ = ties;
  start_ = {0};
  rows_.clear();
  group_of_row_.assign(ties.empty() ? 0 : std::size_t(rows), -1);
  std::vector<Index> lowest(rows, 0);
  std::iota(lowest.begin(), lowest.end(), 0);
  const auto root = [&lowest](Index row) {
    while (lowest[row] != row) row = lowest[row];
    return row;
  };
  for (const Tie& tie : ties) {
    const Index a = root(tie.a), b = root(tie.b);
    lowest[std::max(a, b)] = std::min(a, b);
  }
  std::vector<Edge> members;  // lowest row of the group, row
  for (const Tie& tie : ties)
    for (Index row : {tie.a, tie.b}) members.push_back({root(row), row});
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  for (std::size_t i = 0; i < members.size(); ++i) {
    group_of_row_[members[i][1]] = count();
    rows_.push_back(members[i][1]);
    if (i + 1 == members.size() || members[i + 1][0] != members[i][0]) start_.push_back(Index(rows_.size()));
  }
  return true;
}

void NodeGroups::share(std::vector<NodeProjector>& list) const {
  const std::size_t given = list.size();
  for (Index g = 0; g < count(); ++g) {
    const Mat3 shared = [&] {
      Mat3 all = Mat3::Identity();
      for (const Index* row = begin(g); row != end(g); ++row)
        if (const NodeProjector* held = findRow(list, given, *row)) all = intersection(all, held->projector);
      return all;
    }();
    if (shared.isIdentity(0)) continue;
    for (const Index* row = begin(g); row != end(g); ++row) {
      if (const NodeProjector* held = findRow(list, given, *row)) {
        list[held - list.data()].projector = shared;
      } else {
        list.push_back({*row, shared});
      }
    }
  }
  if (list.size() > given) std::sort(list.begin(), list.end(), byRow);
}

void NodeGroups::average(Rows vector) const {
  for (Index g = 0; g < count(); ++g) {
    Vec3 mean = Vec3::Zero();
    for (const Index* row = begin(g); row != end(g); ++row) mean += vector[*row];
    mean /= double(size(g));
    for (const Index* row = begin(g); row != end(g); ++row) vector[*row] = mean;
  }
}

void NodeGroups::averagePositions(const Motion& motion, Rows x) const {
  if (!motion.turns()) return average(x);
  for (Index g = 0; g < count(); ++g) {
    const bool turns = motion.kindOf(*begin(g)) == RowKind::turn;
    const auto at = [x](Index row) { return Eigen::Map<Eigen::Vector4d>(x.data + std::size_t(row) * row_doubles); };
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (const Index* row = begin(g); row != end(g); ++row) sum += (turns && at(*row).dot(sum) < 0 ? -1 : 1) * at(*row);
    sum = turns ? sum.normalized() : sum / double(size(g));
    for (const Index* row = begin(g); row != end(g); ++row) at(*row) = turns && at(*row).dot(sum) < 0 ? -sum : sum;
  }
}

void NodeGroups::average(std::vector<double>& numbers) const {
  for (Index g = 0; g < count(); ++g) {
    double mean = 0;
    for (const Index* row = begin(g); row != end(g); ++row) mean += numbers[std::size_t(*row)] / double(size(g));
    for (const Index* row = begin(g); row != end(g); ++row) numbers[std::size_t(*row)] = mean;
  }
}

BlockMatrix NodeGroups::withFill(const BlockMatrix& matrix) const {
  BlockPattern pattern(matrix.rows());
  const auto together = [this](const Index& row) {
    const Index group = of(row);
    return group < 0 ? std::pair(&row, &row + 1) : std::pair(begin(group), end(group));
  };
  std::vector<Index> neighbours;  // the first row of each group or single row that a group or single row meets
  for (Index first = 0; first < matrix.rows(); ++first) {
    const auto [left, left_end] = together(first);
    if (*left != first) continue;
    neighbours.clear();
    for (const Index* row = left; row != left_end; ++row)
      for (Index slot = matrix.rowStart()[*row]; slot < matrix.rowStart()[*row + 1]; ++slot)
        neighbours.push_back(*together(matrix.columns()[slot]).first);
    std::sort(neighbours.begin(), neighbours.end());
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    for (const Index& neighbour : neighbours) {
      const auto [right, right_end] = together(neighbour);
      for (const Index* i = left; i != left_end; ++i)
        for (const Index* j = right; j != right_end; ++j) pattern.addBlock(*i, *j);
    }
  }
  return BlockMatrix(std::move(pattern));
}

void NodeGroups::average(BlockMatrix& matrix) const {
  std::vector<double>& values = matrix.values();
  for (Index g = 0; g < count(); ++g) {  // rows: those of a group have blocks in the same columns
    const Index first = matrix.rowStart()[std::size_t(*begin(g))];
    const Index blocks = matrix.rowStart()[std::size_t(*begin(g)) + 1] - first;
    for (Index k = 0; k < blocks; ++k) {
      Mat3 mean = Mat3::Zero();
      for (const Index* row = begin(g); row != end(g); ++row)
        mean += blockAt(values, matrix.rowStart()[std::size_t(*row)] + k) / double(size(g));
      for (const Index* row = begin(g); row != end(g); ++row) blockAt(values, matrix.rowStart()[std::size_t(*row)] + k) = mean;
    }
  }
  for (Index g = 0; g < count(); ++g) {  // columns: the pattern is symmetric
    const Index head = *begin(g);
    for (Index k = matrix.rowStart()[head]; k < matrix.rowStart()[head + 1]; ++k) {
      const Index row = matrix.columns()[k];
      Mat3 mean = Mat3::Zero();
      for (const Index* column = begin(g); column != end(g); ++column) mean += blockAt(values, matrix.slot(row, *column)) / double(size(g));
      for (const Index* column = begin(g); column != end(g); ++column) blockAt(values, matrix.slot(row, *column)) = mean;
    }
  }
}

Mat3 NodeGroups::sharedProjector(Index group, const std::vector<NodeProjector>& projectors) const {
  const NodeProjector* held = findRow(projectors, projectors.size(), *begin(group));
  return held ? held->projector : Mat3::Identity();
}

void NodeGroups::complete(const std::vector<NodeProjector>& projectors, BlockMatrix& matrix) const {
  for (Index g = 0; g < count(); ++g) {
    const Index own = matrix.diagonal()[std::size_t(*begin(g))];
    const double held = heldSize(double(size(g)) * diagonalSize(blockAt(matrix.values(), own)));
    const Mat3 shared = held * sharedProjector(g, projectors);
    for (const Index* i = begin(g); i != end(g); ++i)
      for (const Index* j = begin(g); j != end(g); ++j) matrix.add(*i, *j, ((i == j ? 1. : 0.) - 1. / double(size(g))) * shared);
  }
}

void NodeGroups::completeDiagonal(const std::vector<NodeProjector>& projectors, std::vector<double>& blocks) const {
  for (Index g = 0; g < count(); ++g) {
    const double n = double(size(g));
    Mat3 sum = Mat3::Zero();
    for (const Index* row = begin(g); row != end(g); ++row) sum += blockAt(blocks, *row);
    const Mat3 shared = sharedProjector(g, projectors);
    const Mat3 block = shared * sum * shared / (n * n) + heldSize(diagonalSize(sum) / n) * (Mat3::Identity() - shared / n);
    for (const Index* row = begin(g); row != end(g); ++row) blockAt(blocks, *row) = block;
  }
}

}  // namespace stroma
