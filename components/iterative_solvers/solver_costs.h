// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <string>

#include "components/iterative_solvers/factor_counts.h"
#include "framework/algebra/linear_solver.h"

namespace stroma {

class Archive;
/// What ways of solving A x = b cost, from the size and the shape of a body alone: no clock decides, so that each run
/// does the same. Seconds are those of one core of 115 Gflop/s in single precision that reads 25 GB/s; what counts is their ratios.
struct SolverCosts {
  double direct = 0;          ///< to order, and to factor and solve as often as is expected
  double first = 0;           ///< to order and factor once
  double with_factors = 0;    ///< a solve of a later matrix by factors, with its share of factorisations
  bool keeps_factors = false;  ///< these are of former matrices: fresh ones cost more
  double factor_entries = 0;  ///< numbers in the factors
  double setup = 0;           ///< of a multigrid hierarchy
  double iteration = 0;       ///< of conjugate gradients with it
  double multigrid = 0;       ///< with the usual number of iterations
  /// Iterations of one solve after which factors would have been the better choice. Largest int: never, they would not
  /// fit.
  int patience() const;
  void serialize(Archive& archive);
};

/// Extents of a body in nodes, the longest first: those of a box with the same second moments and as many nodes.
struct Extents {
  double length = 1, width = 1, height = 1;
};
/// Without positions a cube.
Extents extentsOf(Index nodes, ConstRows positions);

/// By the laws of nested dissection, up to 3.5 times too many numbers for small and slender bodies of tetrahedra.
FactorCounts factorCountsOf(const Extents& extents);
/// Whether nodes are tied to more than the next ones, of which there are 27 in hexahedra: separators are then twice as thick, and the
/// laws do not hold.
inline bool isWide(const BlockMatrix& pattern) { return pattern.blocks() > 40.0 * pattern.rows(); }
/// What was counted, or less by the laws where they hold.
FactorCounts fewest(const BlockMatrix& pattern, const FactorCounts& counted, const Extents& extents);

/// `matrix` tells what products and an assembly cost. `solves`: how many to expect, with other values in the pattern.
SolverCosts solverCosts(SystemMatrix& matrix, const FactorCounts& counts, int solves = 1);
/// The seconds of as many solves by MixedSolve, of a body with these extents, `pressures` and so many `entries` in all rows of B. Infinite
/// where the factors of the pressures would not fit.
double secondsWithPressures(SystemMatrix& matrix, const Extents& extents, double pressures, double entries, int solves);

/// Of factors that precondition, in nanoseconds.
struct FactorCosts {
  double order = 0;        ///< once for a pattern, with the analysis; 0: not estimated
  double factor = 0;       ///< without the assembly
  double application = 0;  ///< with turned vectors
  static constexpr double turning = 40;  ///< of these, for a row
  double entries = 0;      ///< numbers in the factors
  bool is_single = false;  ///< so that a solve has to be refined
  bool operator==(const FactorCosts&) const = default;
  /// `name`: what the names of the values begin with.
  void serialize(const std::string& name, Archive& archive);
};
/// `in_single`: in single precision in any case, which costs least.
FactorCosts factorCosts(double rows, double blocks, const FactorCounts& counts, bool in_single = false);
/// Whether so many numbers fit into half of the machine's memory.
bool factorsFit(double entries);

/// Nanoseconds of what multigrid and conjugate gradients take, for a matrix of so many blocks. A V-cycle reads the finest blocks
/// four times in 40 bytes; what goes with the rows is vectors, what leads to the next level and the levels below. Processor time of
/// each part in 18 bodies of 729 to 9,633 nodes (tetrahedra, hexahedra, quadratic ones, a membrane) beside other work, new memory
/// included.
struct IterationCosts {
  static constexpr double usual_product = 20;                ///< for a row
  static constexpr double usual_blocks = 13;                 ///< in a row, where no pattern is known: of tetrahedra
  /// Of conjugate gradients with blocks of the diagonal: each row has 230 bytes, which are moved twice: in the caches, or from memory
  /// where there are 40 MB of them. In 50 bodies of 336 to 205,379 nodes.
  static double vectors(double rows) { return rows * (5 + 8 * std::clamp((230e-6 * rows - 4) / 36, 0.0, 1.0)); }
  /// Of former factors, or of a hierarchy: each node with what surrounds it, for each matrix.
  static double turns(double rows, double blocks) { return 140 * rows + 4 * blocks; }
  /// Times as much where the hierarchy needs patches: two to three times the iterations, each 1.4 to 3 times as dear.
  static constexpr double with_patches = 4.5;
  /// Less where the levels fit into the caches.
  static double cycle(double rows, double blocks) {
    const double megabytes = 50e-6 * blocks;
    return (4.9 * blocks + 93 * rows) * (0.75 + 0.25 * std::clamp((megabytes - 3) / 6, 0.0, 1.0));
  }
  /// Where the finest level goes by products of so many nanoseconds.
  static double cycleByProducts(double rows, double product, bool is_turned) { return 7 * product + (is_turned ? 85 : 60) * rows; }
  static double hierarchy(double rows, double blocks) { return 110 * blocks + 1200 * rows; }
  /// Where nothing is known: of hexahedra. Tetrahedra take a third, and six times as much where their dilatation is that of nodes.
  static double assembly(double rows) { return 600 * rows; }
  /// As the force fields say. Where products alone have all their terms, what is assembled is the usual part.
  static double assembly(const SystemMatrix& matrix) {
    constexpr double of_products = 1e29;
    const double told = matrix.assemblyCost();
    return told >= 0 && told < of_products ? told + 30.0 * matrix.rows() : assembly(double(matrix.rows()));
  }
  /// Of a direct solver, with the analysis.
  static double order(double blocks, const FactorCounts& counts) {
    return 5e5 + (isDissected(blocks, counts) ? 430 : 80) * blocks;
  }
  static double pattern(double rows, double blocks) { return 2500 * rows + 150 * blocks; }
  /// Of the first factors: a module with its libraries, and memory that the system has to give.
  static double room(double entries) { return 5e6 + 5.5 * entries; }
};
/// Iterations for a decade that conjugate gradients with multigrid are expected to take after the first ones, of Poisson's ratios to
/// 0.45. Hexahedra give a node twice the neighbours that tetrahedra do, and a group of nodes goes through all of them: 10 to 11
/// iterations for eight decades instead of 12 to 22. Quadratic tetrahedra have more neighbours yet, but most of them at the corners.
/// Stretched cells take more: with q = |(a, b, c)| / (sqrt(3) min(a, b, c)) of the sides of hexahedra 1.1 (q - 1) iterations, to q = 2.5
/// in ten blocks, and of tetrahedra half as many. `positions` may be none.
double expectedMultigridRate(const BlockMatrix& pattern, ConstRows positions = {});
constexpr double least_multigrid_rate = 1.2;

}  // namespace stroma
