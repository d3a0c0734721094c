// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/scene_volumes.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

#include "components/iterative_solvers/solver_costs.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/scene/node.h"

namespace stroma {
namespace {

/// K / mu at Poisson's ratio 0.495.
constexpr double least_bulk = 99.67;

/// The directions in which a row is coupled to others.
Mat3 freeDirections(const BlockMatrix& a, Index row) {
  Mat3 sum = Mat3::Zero();
  for (Index s = a.rowStart()[row]; s < a.rowStart()[row + 1]; ++s) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(a.values().data() + 9 * std::size_t(s));
    if (a.columns()[s] != row) sum += block * block.transpose();
  }
  const double trace = sum.trace();
  if (!(trace > 0)) return Mat3::Zero();
  sum /= trace;
  if (sum.determinant() > 1e-12) return Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> values(sum);
  Mat3 kept = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (values.eigenvalues()[k] > 1e-14) kept += values.eigenvectors().col(k) * values.eigenvectors().col(k).transpose();
  return kept;
}

/// Whether the terms are in the matrix once: K of a dilatation is almost that of the terms alone.
bool areThoseOf(SystemMatrix& matrix, const VolumeTerms& terms, const std::vector<Mat3>& free) {
  constexpr double least = 0.9, most = 1.3;
  const ConstRows x = matrix.positions();
  Vector u(x.count), force(x.count);
  Vec3 middle = Vec3::Zero();
  for (Index i = 0; i < x.count; ++i) middle += x[i] / double(x.count);
  for (Index i = 0; i < x.count; ++i) u[i] = free[std::size_t(i)] * (x[i] - middle);
  matrix.multiply(u, force);
  double of_terms = 0;
  for (Index c = 0; c < terms.count(); ++c) {
    double change = 0;
    for (Index e = terms.start[std::size_t(c)]; e < terms.start[std::size_t(c) + 1]; ++e)
      change += terms.gradients[std::size_t(e)].dot(u[terms.rows[std::size_t(e)]]);
    of_terms += terms.bulk[std::size_t(c)] * change * change;
  }
  const double of_matrix = dot(u, force);
  return of_matrix > least * of_terms && of_matrix < most * of_terms;
}

VolumeTerms termsOf(SystemMatrix& matrix, const Node& root) {
  VolumeTerms terms;
  std::vector<ForceField*> fields;
  std::vector<Mapping*> mappings;
  std::vector<State*> states;
  root.collect(fields), root.collect(mappings), root.collect(states);
  Index rows = 0;
  for (const State* state : states) rows += state->size();
  if (!mappings.empty() || rows != matrix.rows()) return terms;
  for (const ForceField* field : fields)
    if (const auto* resists = dynamic_cast<const ResistsVolumes*>(field)) resists->addVolumeTerms(terms);
  return terms;
}

bool areStiff(const VolumeTerms& terms) {
  Index stiff = 0;
  for (std::size_t c = 0; c < terms.bulk.size(); ++c) stiff += terms.bulk[c] > least_bulk * terms.shear[c];
  return 2 * stiff > terms.count();
}

}  // namespace

VolumeTerms stiffVolumesOf(SystemMatrix& matrix, const Node& root) {
  if (!matrix.symmetric() || !matrix.isOfLooseNodes() || matrix.key().shift != 0) return {};
  const auto* const owner = dynamic_cast<const HasVolumeTerms*>(&matrix);
  VolumeTerms terms = owner ? owner->volumeTerms() : termsOf(matrix, root);
  if (owner || !areStiff(terms)) return areStiff(terms) ? terms : VolumeTerms{};
  const BlockMatrix& a = matrix.assemble();
  std::vector<Mat3> free;
  for (Index row = 0; row < a.rows(); ++row) free.push_back(freeDirections(a, row));
  for (std::size_t e = 0; e < terms.rows.size(); ++e)
    terms.gradients[e] = (free[std::size_t(terms.rows[e])] * terms.gradients[e]).eval();
  return areThoseOf(matrix, terms, free) ? terms : VolumeTerms{};
}

VolumeTerms likelyVolumesOf(SystemMatrix& matrix, const Node& root) {
  if (!matrix.symmetric() || !matrix.isOfLooseNodes()) return {};
  VolumeTerms terms = termsOf(matrix, root);
  return areStiff(terms) ? terms : VolumeTerms{};
}

double secondsWithPressures(SystemMatrix& matrix, const VolumeTerms& terms, int solves, bool loose) {
  constexpr double nanosecond = 1e-9, to_tolerance = 30, to_a_digit = 13;
  constexpr double each_row = 260;     // of an iteration: products with B, and with the vectors before
  constexpr double making_block = 60;  // of X, and of what is subtracted from K
  constexpr double few_nodes = 12;     // of a volume; with more, separators of X are twice as thick
  const BlockMatrix& pattern = matrix.pattern();
  const double rows = pattern.rows(), blocks = pattern.blocks(), pressure_rows = std::ceil(terms.count() / 3.);
  Extents extents = extentsOf(matrix.rows(), matrix.positions());
  const double finer = std::cbrt(pressure_rows / rows);
  extents = {extents.length * finer, extents.width * finer, extents.height * finer};
  FactorCounts counts = factorCountsOf(extents);
  if (double(terms.rows.size()) > few_nodes * terms.count()) counts.entries *= 4, counts.flops *= 8;
  const FactorCosts factors = factorCosts(pressure_rows, 27 * pressure_rows, counts, true);
  if (!factorsFit(factors.entries)) return std::numeric_limits<double>::infinity();
  const double made = IterationCosts::assembly(matrix) + IterationCosts::hierarchy(rows, blocks) + making_block * blocks + factors.factor;
  const double iteration = IterationCosts::cycle(rows, blocks) + 2 * BlockMatrix::productCost(blocks, false) + 2 * factors.application +
                           each_row * rows;
  const double first = factors.order + IterationCosts::room(factors.entries);
  return nanosecond * (first + solves * (made + (loose ? to_a_digit : to_tolerance) * iteration));
}

}  // namespace stroma
