// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/factor_counts.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

namespace stroma {
namespace {

/// The row at each place of a minimum degree order (Amestoy, Davis, Duff 1996), which finds the nodes of a cut hexahedron that
/// touch few others.
std::vector<Index> minimumDegree(const BlockMatrix& pattern) {
  Eigen::SparseMatrix<char> graph(pattern.rows(), pattern.rows());
  graph.resizeNonZeros(pattern.blocks());
  std::copy(pattern.rowStart().begin(), pattern.rowStart().end(), graph.outerIndexPtr());
  std::copy(pattern.columns().begin(), pattern.columns().end(), graph.innerIndexPtr());
  std::fill_n(graph.valuePtr(), pattern.blocks(), char(1));
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Upper>(), order);
  return {order.indices().begin(), order.indices().end()};
}

/// A row of the factor is the part of the elimination tree that is reached from its columns in the matrix (Liu 1986). A block is
/// of nine numbers, and of six on the diagonal; a column of c blocks makes 27 c^2 operations.
FactorCounts countsOf(const BlockMatrix& pattern, const std::vector<Index>& order) {
  const std::size_t rows = order.size();
  std::vector<Index> place(rows), parent(rows, -1), seen(rows, -1), count(rows, 1);
  for (std::size_t k = 0; k < rows; ++k) place[order[k]] = Index(k);
  for (std::size_t k = 0; k < rows; ++k) {
    const Index row = Index(k);
    seen[row] = row;
    for (Index s = pattern.rowStart()[order[k]]; s < pattern.rowStart()[order[k] + 1]; ++s)
      for (Index column = place[pattern.columns()[s]]; column < row && seen[column] != row; column = parent[column]) {
        if (parent[column] < 0) parent[column] = row;
        ++count[column], seen[column] = row;
      }
  }
  FactorCounts counts;
  for (const Index blocks : count) counts.entries += 9.0 * blocks - 3, counts.flops += 27.0 * blocks * blocks;
  return counts;
}

}  // namespace

FactorCounts countFactors(const BlockMatrix& pattern) { return countsOf(pattern, minimumDegree(pattern)); }

}  // namespace stroma
