// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/block_matrix.h"

namespace stroma {

/// What ways of solving A x = b cost, from the size and the shape of a body alone: no clock decides, so that each run
/// does the same. Seconds are those of one core of 40 Gflop/s and 10 GB/s; what counts is their ratios.
struct SolverCosts {
  double direct = 0;          ///< to order, factor and solve once
  double factor_entries = 0;  ///< numbers in the factors
  double setup = 0;           ///< of a multigrid hierarchy
  double iteration = 0;       ///< of conjugate gradients with it

  /// With the usual number of iterations.
  double multigrid() const;
  /// Iterations of one solve after which factors would have been the better choice. Largest int: never, they would not
  /// fit.
  int patience() const;
};

/// Extents of a body in nodes, the longest first: those of a box with the same second moments and as many nodes.
struct Extents {
  double length = 1, width = 1, height = 1;
};
/// Without positions a cube.
Extents extentsOf(Index nodes, ConstRows positions);

SolverCosts solverCosts(const BlockMatrix& pattern, const Extents& extents);

/// What multigrid costs in iterations of block Jacobi on the same matrix, and iterations of it for a decade of the residual.
struct MultigridCosts {
  double iteration = 10, hierarchy = 150;
  static constexpr double usual_rate = 2;
};
/// `product`: nanoseconds of one, 0 where they are not known.
MultigridCosts multigridCosts(Index rows, double product);
/// Nanoseconds of a product with an assembled matrix, out of cache.
inline double assembledProductCost(const BlockMatrix& matrix) { return 2.9 * matrix.blocks(); }

}  // namespace stroma
