// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>

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

/// Of factors that precondition, in nanoseconds, by the same laws.
struct FactorCosts {
  double order = 0;        ///< once for a pattern, with the analysis; 0: not estimated
  double factor = 0;       ///< with the assembly
  double application = 0;  ///< with turned nodes
  double entries = 0;      ///< numbers in the factors
};
FactorCosts factorCosts(Index rows, const Extents& extents);
/// Whether so many numbers fit into half of the machine's memory.
bool factorsFit(double entries);

/// Nanoseconds for a row: what an iteration of conjugate gradients takes besides its product, and a product where its cost is not
/// known. Of cubes of 9,261 nodes of tetrahedra (a V-cycle 270, the vectors 17) and 5,481 of hexahedra (360, 22).
struct IterationCosts {
  static constexpr double vectors = 20, hierarchy = 8000, usual_product = 20;
  /// Less where its levels fit into a cache.
  static double cycle(Index rows) { return 180 + 120 * std::min(1.0, rows / 8000.0); }
};
/// Nanoseconds of a product with an assembled matrix, out of cache.
inline double assembledProductCost(const BlockMatrix& matrix) { return 2.9 * matrix.blocks(); }

}  // namespace stroma
