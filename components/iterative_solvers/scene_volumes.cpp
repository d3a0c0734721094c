// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/scene_volumes.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

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

std::vector<Mat3> freeDirections(const BlockMatrix& a) {
  std::vector<Mat3> free;
  for (Index row = 0; row < a.rows(); ++row) free.push_back(freeDirections(a, row));
  return free;
}

bool areStiff(const VolumeTerms& terms) {
  Index stiff = 0;
  for (Index c = 0; c < terms.count(); ++c) stiff += terms.bulk[c] > least_bulk * terms.shear[c];
  return 2 * stiff > terms.count();
}

bool isOwner(const SystemMatrix& matrix) { return dynamic_cast<const HasVolumeTerms*>(&matrix) != nullptr; }

VolumeTerms termsOf(const SystemMatrix& matrix, const Node& root) {
  if (const auto* const owner = dynamic_cast<const HasVolumeTerms*>(&matrix)) return owner->volumeTerms();
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

}  // namespace

VolumeTerms volumesOfFields(SystemMatrix& matrix, const Node& root) {
  if (!matrix.symmetric() || !matrix.isOfLooseNodes()) return {};
  VolumeTerms terms = termsOf(matrix, root);
  return areStiff(terms) ? terms : VolumeTerms{};
}

VolumeTerms stiffVolumesOf(SystemMatrix& matrix, const Node& root) {
  VolumeTerms terms = volumesOfFields(matrix, root);
  if (isOwner(matrix) || terms.count() == 0) return terms;
  const std::vector<Mat3> free = freeDirections(matrix.assemble());
  for (std::size_t e = 0; e < terms.rows.size(); ++e) terms.gradients[e] = (free[terms.rows[e]] * terms.gradients[e]).eval();
  return terms;
}

/// K of a dilatation is almost that of the terms alone.
bool hasStiffVolumes(SystemMatrix& matrix, const Node& root) {
  constexpr double least = 0.9, most = 1.3;
  const VolumeTerms terms = volumesOfFields(matrix, root);
  if (isOwner(matrix) || terms.count() == 0) return terms.count() > 0;
  const std::vector<Mat3> free = freeDirections(matrix.assemble());
  const ConstRows x = matrix.positions();
  Vector u(x.count), force(x.count);
  Vec3 middle = Vec3::Zero();
  for (Index i = 0; i < x.count; ++i) middle += x[i] / double(x.count);
  for (Index i = 0; i < x.count; ++i) u[i] = free[i] * (x[i] - middle);
  matrix.multiply(u, force);
  double of_terms = 0;
  for (Index c = 0; c < terms.count(); ++c) {
    double change = 0;
    for (Index e = terms.start[c]; e < terms.start[c + 1]; ++e) change += terms.gradients[e].dot(u[terms.rows[e]]);
    of_terms += terms.bulk[c] * change * change;
  }
  const double of_matrix = dot(u, force);
  return of_matrix > least * of_terms && of_matrix < most * of_terms;
}

}  // namespace stroma
