// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/block_matrix.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace stroma {

void BlockPattern::addClique(const Index* rows, int count) {
  for (int i = 0; i < count; ++i) {
    std::vector<Index>& row = columns_[rows[i]];
    row.insert(row.end(), rows, rows + count);
  }
}

BlockMatrix::BlockMatrix(BlockPattern&& pattern) {
  const Index count = pattern.rows();
  std::size_t total = 0;
  for (Index i = 0; i < count; ++i) {
    std::vector<Index>& row = pattern.columns_[i];
    row.push_back(i);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    total += row.size();
  }
  if (total > std::size_t(std::numeric_limits<Index>::max()))
    throw std::length_error("the assembled matrix would have " + std::to_string(total) +
                            " blocks of 3x3, more than a 32-bit index counts; use a matrix-free solver");
  row_start_.assign(std::size_t(count) + 1, 0);
  columns_.reserve(total);
  diagonal_.resize(count);
  for (Index i = 0; i < count; ++i) {
    std::vector<Index>& row = pattern.columns_[i];
    const auto at = std::lower_bound(row.begin(), row.end(), i) - row.begin();
    diagonal_[i] = row_start_[i] + Index(at);
    columns_.insert(columns_.end(), row.begin(), row.end());
    row_start_[i + 1] = Index(columns_.size());
    std::vector<Index>().swap(row);
  }
  values_.assign(total * 9, 0.0);
}

Index BlockMatrix::slot(Index row, Index column) const {
  const auto first = columns_.begin() + row_start_[row];
  const auto last = columns_.begin() + row_start_[row + 1];
  const auto at = std::lower_bound(first, last, column);
  return at != last && *at == column ? Index(at - columns_.begin()) : -1;
}

void BlockMatrix::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

}  // namespace stroma
