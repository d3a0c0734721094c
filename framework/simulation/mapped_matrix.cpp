// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/mapped_matrix.h"

#include <algorithm>

namespace stroma {

void MappedMatrix::prepare(BlockPattern&& pattern, const std::vector<Mapping*>& mappings, Index independent_rows) {
  independent_rows_ = independent_rows;
  full_ = BlockMatrix(std::move(pattern));
  places_.clear();
  jacobian_.assign(full_.rows(), {});
  for (Index row = 0; row < independent_rows; ++row) jacobian_[row] = {Term{row, Mat3::Identity()}};
  updateJacobian(mappings);
  sums_ = {};
  for (Index row = 0; row < full_.rows(); ++row)
    for (Index slot = full_.rowStart()[row]; slot < full_.rowStart()[row + 1]; ++slot) {
      const Index column = full_.columns()[slot];
      const bool is_own = row < independent_rows && column < independent_rows;
      (is_own ? sums_.own : sums_.mapped) += jacobian_[row].size() * jacobian_[column].size();
    }
}

// The row of a mapped node: its blocks times the rows of their parents, terms of one independent row summed.
void MappedMatrix::updateJacobian(const std::vector<Mapping*>& mappings) {
  for (const Mapping* mapping : mappings) {
    blocks_.clear();
    mapping->addJacobian(blocks_);
    for (const JacobianBlock& block : blocks_) jacobian_[block.child].clear();
    for (const JacobianBlock& block : blocks_) {
      std::vector<Term>& child = jacobian_[block.child];
      for (const Term& term : jacobian_[block.parent]) {
        const Mat3 product = block.block * term.block;
        const auto same = std::find_if(child.begin(), child.end(), [&](const Term& t) { return t.row == term.row; });
        if (same == child.end())
          child.push_back({term.row, product});
        else
          same->block += product;
      }
    }
  }
}

BlockMatrix MappedMatrix::reducedPattern() const {
  BlockPattern pattern(independent_rows_);
  for (Index row = 0; row < full_.rows(); ++row)
    for (Index slot = full_.rowStart()[row]; slot < full_.rowStart()[row + 1]; ++slot)
      for (const Term& left : jacobian_[row])
        for (const Term& right : jacobian_[full_.columns()[slot]]) pattern.addBlock(left.row, right.row);
  return BlockMatrix(std::move(pattern));
}

/// Jacobians that are not linear may name other rows than before: the place is checked.
void MappedMatrix::add(BlockMatrix& out, Index row, Index column, const Mat3& block, Index& place) {
  const bool is_known = place >= out.rowStart()[row] && place < out.rowStart()[row + 1] && out.columns()[place] == column;
  if (!is_known) place = out.slot(row, column);
  out.add(place, block);
}

void MappedMatrix::reduce(BlockMatrix& out) {
  out.clear();
  std::size_t added = 0;
  const auto addAt = [&](Index row, Index column, const Mat3& block) {
    if (added == places_.size()) places_.push_back(-1);
    add(out, row, column, block, places_[added++]);
  };
  for (Index row = 0; row < full_.rows(); ++row)
    for (Index slot = full_.rowStart()[row]; slot < full_.rowStart()[row + 1]; ++slot) {
      const Index column = full_.columns()[slot];
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(full_.values().data() + std::size_t(slot) * 9);
      if (row < independent_rows_ && column < independent_rows_) {
        addAt(row, column, block);
        continue;
      }
      for (const Term& left : jacobian_[row]) {
        const Mat3 half = left.block.transpose() * block;
        for (const Term& right : jacobian_[column]) addAt(left.row, right.row, half * right.block);
      }
    }
}

}  // namespace stroma
