// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/solver_costs.h"

#include <unistd.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "framework/algebra/direct_solver.h"
#include "framework/scene/archive.h"

namespace stroma {
namespace {

// Nested dissection of a box of l x w x h nodes, l >= w >= h, cuts it into l / w parts whose separators have w h nodes:
// flops grow with (w h)^3 l / w and entries with (w h)^2 l / w. The factors are those of cubes of 1,000 to 70,000 nodes. In a
// flat part, w > h, the cuts after the first ones count too: separators shorten along one axis alone. The laws of that are
// fitted to plates of 17 to 101 nodes by 3 to 5.
constexpr double flops_each = 135, entries_each = 81;
constexpr double nanosecond = 1e-9;
/// The q of expectedMultigridRate(): a node's farthest neighbour is across a cell, and its nearest along the shortest side. Of every
/// eighth node.
double stretchOf(const BlockMatrix& pattern, ConstRows x) {
  constexpr Index each = 8;
  constexpr double most = 3;
  if (x.count != pattern.rows()) return 1;
  double sum = 0, nodes = 0;
  for (Index row = 0; row < x.count; row += each) {
    double nearest = std::numeric_limits<double>::max(), farthest = 0;
    for (Index s = pattern.rowStart()[row]; s < pattern.rowStart()[row + 1]; ++s) {
      const double square = (x[pattern.columns()[s]] - x[row]).squaredNorm();
      if (square > 0) nearest = std::min(nearest, square), farthest = std::max(farthest, square);
    }
    if (farthest > 0) sum += std::clamp(std::sqrt(farthest / (3 * nearest)), 1.0, most), ++nodes;
  }
  return nodes > 0 && std::isfinite(sum) ? sum / nodes : 1;
}

/// Numbers that fit into half of the machine's memory.
double mostEntries() {
  const double bytes = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
  return std::min(0.5 * bytes / sizeof(double), 2e9);
}

}  // namespace

int SolverCosts::patience() const {
  constexpr int least = 60;
  if (factor_entries > mostEntries()) return std::numeric_limits<int>::max();
  return int(std::clamp(direct / iteration, double(least), 1e6));
}

void SolverCosts::serialize(Archive& archive) {
  archive.value("cost_first", first);
  archive.value("cost_with_factors", with_factors);
  archive.value("cost_entries", factor_entries);
  archive.value("cost_setup", setup);
  archive.value("cost_iteration", iteration);
}

void FactorCosts::serialize(const std::string& name, Archive& archive) {
  archive.value(name + "single", is_single);
  archive.value(name + "order", order);
  archive.value(name + "factor", factor);
  archive.value(name + "application", application);
  archive.value(name + "entries", entries);
}

Extents extentsOf(Index nodes, ConstRows positions) {
  const double side = std::cbrt(double(nodes));
  if (positions.count != nodes || nodes < 2) return {side, side, side};
  Vec3 middle = Vec3::Zero();
  for (Index i = 0; i < nodes; ++i) middle += positions[i] / double(nodes);
  Mat3 moments = Mat3::Zero();
  for (Index i = 0; i < nodes; ++i) moments += (positions[i] - middle) * (positions[i] - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> values(moments, Eigen::EigenvaluesOnly);
  if (!values.eigenvalues().allFinite() || !(values.eigenvalues()[2] > 0)) return {side, side, side};
  // a thickness of less than two nodes there is not
  const Vec3 size = values.eigenvalues().cwiseMax(1e-12 * values.eigenvalues()[2]).cwiseSqrt();
  const double cell = std::cbrt(size.prod() / double(nodes));
  Extents extents{size[2] / cell, size[1] / cell, size[0] / cell};
  if (extents.height < 2) {
    const double flat = std::sqrt(size[1] * size[2] * 2 / double(nodes));
    extents = {size[2] / flat, std::max(2.0, size[1] / flat), 2};
    if (size[1] < 2 * flat) extents = {std::max(2.0, nodes / 4.0), 2, 2};  // nor a width
  }
  return extents;
}

FactorCounts factorCountsOf(const Extents& e) {
  const double separator = e.width * e.height, flatness = e.width / e.height, parts = e.length / e.width;
  return {entries_each * (1 + 0.7 * std::log(flatness)) * parts * separator * separator,
          flops_each * (1 + 2.4 * (1 - 1 / flatness)) * parts * separator * separator * separator};
}

FactorCounts fewest(const BlockMatrix& pattern, const FactorCounts& counted, const Extents& extents) {
  return isWide(pattern) ? counted : fewer(counted, factorCountsOf(extents));
}

double expectedMultigridRate(const BlockMatrix& pattern, ConstRows positions) {
  constexpr double of_tetrahedra = 2, tetrahedral_blocks = 13, hexahedral_blocks = 21, of_quadratic = 3.1;
  constexpr Index linear_row = 48;  // a corner of quadratic tetrahedra has 65 neighbours, one of hexahedra 27
  constexpr Index least_part = 20;  // an eighth of their nodes are corners; a hub of springs is one node
  Index wide = 0;
  for (std::size_t row = 0; row + 1 < pattern.rowStart().size(); ++row)
    wide += pattern.rowStart()[row + 1] - pattern.rowStart()[row] > linear_row;
  if (least_part * wide > pattern.rows()) return of_quadratic;
  const double like_hexahedra = (double(pattern.blocks()) / pattern.rows() - tetrahedral_blocks) / (hexahedral_blocks - tetrahedral_blocks);
  const double hexahedral = std::clamp(like_hexahedra, 0.0, 1.0), stretched = stretchOf(pattern, positions) - 1;
  return of_tetrahedra + 0.55 * stretched + (least_multigrid_rate - of_tetrahedra + 0.55 * stretched) * hexahedral;
}

bool factorsFit(double entries) { return entries <= mostEntries(); }

// Both ways assemble, multigrid only where it makes a hierarchy. Where forces are not linear, the solves of Newton's method are loose.
SolverCosts solverCosts(SystemMatrix& matrix, const FactorCounts& counts, int solves) {
  constexpr double to_tolerance = 15, loose = 7, applications = 3;
  const BlockMatrix& pattern = matrix.pattern();
  const double rows = pattern.rows(), blocks = pattern.blocks(), assembly = IterationCosts::assembly(matrix);
  FactorCosts factors = factorCosts(rows, blocks, counts);
  factors.factor += assembly;
  const double usual = solves > 1 ? loose : to_tolerance, each = factors.is_single ? applications : 1;
  const double matrix_product = BlockMatrix::productCost(blocks, false);
  const double by_fields = matrix.productCost(), product = by_fields > 0 ? std::min(by_fields, matrix_product) : matrix_product;
  SolverCosts costs;
  // iterations by former factors to two decades, and matrices that factors serve
  constexpr double by_former = 5, served = 3;
  costs.factor_entries = factors.entries;
  const double own = factors.factor + each * (factors.application + matrix_product);
  const double former = by_former * (factors.application + product + IterationCosts::vectors(rows)) +
                        IterationCosts::turns(rows, blocks) + factors.factor / served;
  costs.keeps_factors = solves > 1 && former < own;
  costs.with_factors = nanosecond * (costs.keeps_factors ? former : own);
  const double before = factors.order + IterationCosts::room(factors.entries);
  costs.first = nanosecond * (before + factors.factor);
  costs.direct = nanosecond * (before + own) + (solves - 1) * costs.with_factors;
  costs.setup = nanosecond * (IterationCosts::hierarchy(rows, blocks) + assembly);
  costs.iteration = nanosecond * (IterationCosts::cycle(rows, blocks) + IterationCosts::vectors(rows) + product);
  costs.multigrid = costs.setup + solves * usual * costs.iteration;
  return costs;
}

double secondsWithPressures(SystemMatrix& matrix, const Extents& extents, double pressures, double entries, int solves) {
  constexpr double to_tolerance = 30, loose = 13;
  constexpr double each_row = 260;     // of an iteration: products with B, and with the vectors before
  constexpr double making_block = 60;  // of X, and of what is subtracted from K
  constexpr double few_nodes = 12;     // of a volume; with more, separators of X are twice as thick
  const BlockMatrix& pattern = matrix.pattern();
  const double rows = pattern.rows(), blocks = pattern.blocks(), pressure_rows = std::ceil(pressures / 3);
  const double finer = std::cbrt(pressure_rows / rows);
  FactorCounts counts = factorCountsOf({extents.length * finer, extents.width * finer, extents.height * finer});
  if (entries > few_nodes * pressures) counts.entries *= 4, counts.flops *= 8;
  const FactorCosts factors = factorCosts(pressure_rows, 27 * pressure_rows, counts, true);
  if (!factorsFit(factors.entries)) return std::numeric_limits<double>::infinity();
  const double made = IterationCosts::hierarchy(rows, blocks) + making_block * blocks + factors.factor;
  const double iteration = IterationCosts::cycle(rows, blocks) + 2 * BlockMatrix::productCost(blocks, false) + 2 * factors.application +
                           each_row * rows;
  const double first = factors.order + IterationCosts::room(factors.entries) + made;
  return nanosecond * (first + solves * (IterationCosts::assembly(matrix) + (solves > 1 ? loose : to_tolerance) * iteration));
}

// Small and slender ones are factored in double precision. Of matrices of 729 to 12,005 nodes whose patterns had been factored before.
FactorCosts factorCosts(double rows, double blocks, const FactorCounts& counts, bool in_single) {
  const auto [entries, flops] = counts;
  const bool is_single = in_single || flops >= std::max(5e7, 180 * entries);
  FactorCosts costs;
  costs.order = IterationCosts::order(blocks, counts);
  const Factorisation::Cost own = Factorisation::Cost::of(entries, flops, is_single);
  costs.factor = own.factor / nanosecond;
  costs.application = own.apply / nanosecond + FactorCosts::turning * rows;
  costs.entries = entries, costs.is_single = is_single;
  return costs;
}

}  // namespace stroma
