// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/solver_costs.h"

#include <unistd.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {
namespace {

// Nested dissection of a box of l x w x h nodes, l >= w >= h, cuts it into l / w parts whose separators have w h nodes:
// flops grow with (w h)^3 l / w and entries with (w h)^2 l / w. The factors are those of cubes of 1,000 to 70,000 nodes. In a
// flat part, w > h, the cuts after the first ones count too: separators shorten along one axis alone. The laws of that are
// fitted to plates of 17 to 101 nodes by 3 to 5.
constexpr double flops_each = 135, entries_each = 81;
constexpr double flops_a_second = 40e9, seconds_an_entry = 8e-9, seconds_to_order_a_node = 12e-6;
// Per 3x3 block of the matrix; from the same cubes.
constexpr double setup_seconds = 0.6e-6, iteration_seconds = 30e-9;
constexpr int usual_iterations = 15;
double entriesOf(const Extents& e) {
  const double separator = e.width * e.height, flatness = e.width / e.height;
  return entries_each * (1 + 0.7 * std::log(flatness)) * e.length / e.width * separator * separator;
}
double flopsOf(const Extents& e) {
  const double separator = e.width * e.height, flatness = e.width / e.height;
  return flops_each * (1 + 2.4 * (1 - 1 / flatness)) * e.length / e.width * separator * separator * separator;
}

/// Numbers that fit into half of the machine's memory.
double mostEntries() {
  const double bytes = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
  return std::min(0.5 * bytes / sizeof(double), 2e9);
}

}  // namespace

double SolverCosts::multigrid() const { return setup + usual_iterations * iteration; }

int SolverCosts::patience() const {
  constexpr int least = 60;
  if (factor_entries > mostEntries()) return std::numeric_limits<int>::max();
  return int(std::clamp(direct / iteration, double(least), 1e6));
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
  }
  return extents;
}

bool factorsFit(double entries) { return entries <= mostEntries(); }

SolverCosts solverCosts(const BlockMatrix& pattern, const Extents& e) {
  SolverCosts costs;
  costs.factor_entries = entriesOf(e);
  costs.direct = flopsOf(e) / flops_a_second +
                 seconds_an_entry * costs.factor_entries + seconds_to_order_a_node * pattern.rows();
  costs.setup = setup_seconds * pattern.blocks();
  costs.iteration = iteration_seconds * pattern.blocks();
  return costs;
}

// Small and slender ones are factored in double precision. Ordering, analysis, assembly and the turning of vectors are in
// nanoseconds for a row.
FactorCosts factorCosts(Index rows, const Extents& e) {
  constexpr double order = 8000, assembly = 1500, turning = 40;
  const double entries = entriesOf(e), flops = flopsOf(e);
  const bool is_single = flops >= std::max(5e7, 180 * entries);
  FactorCosts costs;
  costs.order = order * rows;
  costs.factor = (is_single ? flops / 115 + 1.5 * entries : flops / 40 + 2.5 * entries) + assembly * rows;
  costs.application = (is_single ? 0.65 : 1) * entries + turning * rows;
  costs.entries = entries;
  return costs;
}

}  // namespace stroma
