// SPDX-License-Identifier: LGPL-2.1-or-later
// Overlapping patches of nodes, each solved for exactly: M^-1 = sum_p R_p^T (R_p A R_p^T)^-1 R_p, R_p the nodes of a patch.
// What the diagonal blocks cannot smooth lives in such a patch. In a nearly incompressible body a motion of one node
// changes volumes, and only several nodes together move without that.
#pragma once
#include "components/iterative_solvers/multigrid_blocks.h"

namespace stroma::amg {

/// Inverses are symmetric, A_p^-1 = L + L^T with half of the diagonal in L: the columns of L, from the row of their node on,
/// rounded down to eight and padded with zeros. A number that is read serves two products.
template <int D>
struct Patches {
  std::vector<Index> start{0}, members;      ///< nodes, ascending; shape (patches + 1), (members of all)
  std::vector<Index> entry_start, entries;   ///< where a node is in `results`; shape (nodes + 1), (members of all)
  std::vector<std::size_t> first{0}, place;  ///< of a patch in `inverses` (patches + 1) and in `results` (patches)
  Floats inverses;                           ///< the columns of L of all patches
  Array<float> results;                      ///< work space: of each patch, padded, what was found and what was given

  bool exist() const { return start.size() > 1; }
  Index count() const { return Index(start.size()) - 1; }
  Index nodesOf(Index k) const { return start[std::size_t(k) + 1] - start[std::size_t(k)]; }
  /// Numbers of D x nodes, padded.
  static int padded(Index nodes) { return (int(nodes) * D + 7) / 8 * 8; }
  /// Where the columns of node m of a patch begin.
  static int firstRow(Index m) { return int(m) * D / 8 * 8; }
  void allocateWork() {
    if (!exist()) return;
    results.assign(place.back() + 2 * std::size_t(padded(nodesOf(count() - 1))) + 8, 0.0f);  // loads run past a node's
  }
  /// Fills `results` for a vector of all nodes.
  void solve(const float* in) {
    constexpr Index piece = 16;
    parallelFor(int((count() + piece - 1) / piece), [&](int at) {
      const Index last = std::min(count(), (Index(at) + 1) * piece);
      for (Index k = Index(at) * piece; k < last; ++k) solveOne(k, in);
    });
  }
  /// sum = what the patches of a node found for it.
  void gather(Index node, Column<D>& sum) const {
    sum = {};
    Column<D> part;
    for (Index e = entry_start[std::size_t(node)]; e < entry_start[std::size_t(node) + 1]; ++e) {
      part.load(results.data() + entries[std::size_t(e)]);
      sum.lane += part.lane;
    }
  }

 private:
  void solveOne(Index k, const float* in) {
    const Index nodes = nodesOf(k), *node = members.data() + start[std::size_t(k)];
    const int height = padded(nodes);
    float* __restrict found = results.data() + place[std::size_t(k)];
    float* __restrict given = found + height;
    std::fill_n(found, 2 * height, 0.0f);
    for (Index m = 0; m < nodes; ++m)
      for (int c = 0; c < D; ++c) given[m * D + c] = in[std::size_t(node[m]) * lanes<D> + std::size_t(c)];
    const float* __restrict columns = inverses.data() + first[std::size_t(k)];
    for (Index m = 0; m < nodes; ++m)
      for (int c = 0; c < D; c += 3) {
        const int from = firstRow(m), rows = height - from, own = int(m) * D + c;
        addThreeColumns(columns, rows, given + from, given + own, found + from, found + own);
        columns += 3 * rows;
      }
  }
  /// y += L x_own, y_own += L^T x for three columns of L.
  static void addThreeColumns(const float* columns, int rows, const float* x, const float* x_own, float* y, float* y_own) {
    const float *a = columns, *b = a + rows, *c = b + rows, xa = x_own[0], xb = x_own[1], xc = x_own[2];
    float ya = 0, yb = 0, yc = 0;
#pragma omp simd reduction(+ : ya, yb, yc)
    for (int i = 0; i < rows; ++i) {
      y[i] += a[i] * xa + b[i] * xb + c[i] * xc;
      ya += a[i] * x[i], yb += b[i] * x[i], yc += c[i] * x[i];
    }
    y_own[0] += ya, y_own[1] += yb, y_own[2] += yc;
  }
};

}  // namespace stroma::amg
