// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <vector>

#include "framework/algebra/block_matrix.h"
#include "framework/algebra/parallel.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// A matrix m_ij I over the nodes of one state, in compressed rows.
struct NodePairMatrix {
  std::vector<Index> start, columns;  ///< shapes (nodes + 1), (pairs); columns ascending in a row
  std::vector<Index> slots;           ///< blocks of the system's matrix, shape (pairs)
  std::vector<double> values;         ///< shape (pairs)

  /// Entries for `neighbours` of each row, with repetitions and in any order; values are zero.
  void build(std::vector<std::vector<Index>>& neighbours) {
    start.assign(1, 0);
    columns.clear();
    for (auto& list : neighbours) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      columns.insert(columns.end(), list.begin(), list.end());
      start.push_back(Index(columns.size()));
    }
    values.assign(columns.size(), 0.0);
  }
  double& at(Index row, Index column) {
    const auto begin = columns.begin() + start[std::size_t(row)], end = columns.begin() + start[std::size_t(row) + 1];
    return values[std::size_t(std::lower_bound(begin, end, column) - columns.begin())];
  }
  /// 0 where there is no such pair, as of a node without cells.
  double valueAt(Index row, Index column) const {
    const auto begin = columns.begin() + start[std::size_t(row)], end = columns.begin() + start[std::size_t(row) + 1];
    const auto at = std::lower_bound(begin, end, column);
    return at != end && *at == column ? values[std::size_t(at - columns.begin())] : 0;
  }
  bool empty() const { return values.empty(); }
  /// Row by row: 12 bytes and 6 flops for each pair. Rows of the state, as many as the matrix has.
  void addProduct(ConstRows p, double factor, Rows out) const {
    constexpr Index piece_rows = 4096;
    const Index size = p.count;
    const double* __restrict source = p.data;
    double* __restrict target = out.data;
    parallelFor(int((size + piece_rows - 1) / piece_rows), [&, source, target](int piece) {
      const Index end = std::min(size, (piece + 1) * piece_rows);
      for (Index i = piece * piece_rows; i < end; ++i) {
        double sum[row_doubles] = {};
        for (Index s = start[std::size_t(i)]; s < start[std::size_t(i) + 1]; ++s) {
          const double* row = source + std::size_t(columns[std::size_t(s)]) * row_doubles;
          for (int c = 0; c < row_doubles; ++c) sum[c] += values[std::size_t(s)] * row[c];
        }
        for (int c = 0; c < row_doubles; ++c) target[std::size_t(i) * row_doubles + std::size_t(c)] += factor * sum[c];
      }
    });
  }
  void addPattern(Index first, BlockPattern& pattern) const {
    for (Index i = 0; i + 1 < Index(start.size()); ++i)
      for (Index s = start[std::size_t(i)]; s < start[std::size_t(i) + 1]; ++s)
        pattern.addBlock(first + i, first + columns[std::size_t(s)]);
  }
  void prepare(Index first, const BlockMatrix& matrix) {
    slots.resize(columns.size());
    for (Index i = 0; i + 1 < Index(start.size()); ++i)
      for (Index s = start[std::size_t(i)]; s < start[std::size_t(i) + 1]; ++s)
        slots[std::size_t(s)] = matrix.slot(first + i, first + columns[std::size_t(s)]);
  }
  void addTo(double factor, BlockMatrix& matrix) const {
    for (std::size_t s = 0; s < slots.size(); ++s) {
      double* block = matrix.values().data() + std::size_t(slots[s]) * 9;
      for (int c : {0, 4, 8}) block[c] += factor * values[s];
    }
  }
  void addDiagonal(Index first, double factor, std::vector<double>& blocks) const {
    for (Index i = 0; i + 1 < Index(start.size()); ++i)
      for (Index s = start[std::size_t(i)]; s < start[std::size_t(i) + 1]; ++s)
        if (columns[std::size_t(s)] == i)
          for (int c : {0, 4, 8}) blocks[std::size_t(first + i) * 9 + std::size_t(c)] += factor * values[std::size_t(s)];
  }
};

}  // namespace stroma
