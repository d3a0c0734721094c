// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/block_matrix.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "framework/algebra/parallel.h"

namespace stroma {

// A node of a mesh has some fifteen neighbours, each in several elements: to look is quicker than to sort them all later.
void BlockPattern::addBlock(Index row, Index column) {
  std::vector<Index>& columns = columns_[row];
  if (columns.empty()) columns.reserve(16);
  if (columns.size() > 64 || std::find(columns.begin(), columns.end(), column) == columns.end()) columns.push_back(column);
}

void BlockPattern::addClique(const Index* rows, int count) {
  for (int i = 0; i < count * count; ++i) addBlock(rows[i / count], rows[i % count]);
}

BlockMatrix::BlockMatrix(BlockPattern&& pattern) : row_start_(std::size_t(pattern.rows()) + 1, 0), diagonal_(pattern.rows()) {
  constexpr Index piece = 4096;
  parallelFor(int(pattern.rows() / piece) + 1, [&](int k) {
    for (Index i = Index(k) * piece; i < std::min(pattern.rows(), (Index(k) + 1) * piece); ++i) {
      std::vector<Index>& row = pattern.columns_[i];
      pattern.addBlock(i, i);
      std::sort(row.begin(), row.end());
      row.erase(std::unique(row.begin(), row.end()), row.end());
    }
  });
  std::size_t total = 0;
  for (const std::vector<Index>& row : pattern.columns_) total += row.size();
  if (total > std::size_t(std::numeric_limits<Index>::max()))
    throw std::length_error("the assembled matrix would have " + std::to_string(total) +
                            " blocks of 3x3, more than a 32-bit index counts; use a matrix-free solver");
  columns_.reserve(total);
  for (Index i = 0; i < pattern.rows(); ++i) {
    const std::vector<Index> row = std::move(pattern.columns_[i]);
    diagonal_[i] = row_start_[i] + Index(std::lower_bound(row.begin(), row.end(), i) - row.begin());
    columns_.insert(columns_.end(), row.begin(), row.end());
    row_start_[i + 1] = Index(columns_.size());
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
