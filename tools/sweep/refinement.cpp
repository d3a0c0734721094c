// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/refinement.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "framework/mesh/cell_lists.h"

namespace stroma::sweep {
namespace {

constexpr double least_refinement = 1.05;  ///< below it a direction counts as not refined
constexpr double even = 1.1;               ///< of the most over the least: what whole numbers of cells make of "alike"

}  // namespace

Mat3 spacingTensor(const EndState& end) {
  Mat3 sum = Mat3::Zero();
  double volume = 0;
  const auto add = [&](const CellKind& kind, const auto& cells, const std::vector<Vec3>& rest) {
    for (const auto& cell : cells) {
      const auto corners = cornersOf(cell, rest);
      const double size = std::abs(kind.size(corners.data()));
      for (const auto& [a, b] : kind.edges) {
        const Vec3 edge = corners[std::size_t(a)] - corners[std::size_t(b)];
        sum += size * edge * edge.transpose();
      }
      volume += size;
    }
  };
  for (const Body& body : end.bodies) {
    add(cell_kinds::tetrahedron, body.tetrahedra, body.rest);
    add(cell_kinds::hexahedron, body.hexahedra, body.rest);
  }
  if (volume > 0) sum /= volume;
  return sum;
}

int Refinement::fixed() const {
  return int(std::count_if(ratio.begin(), ratio.end(), [](double r) { return r > 0 && r < least_refinement; }));
}

bool Refinement::isEven(int skipped) const { return skipped > 2 || ratio.back() <= even * ratio[std::size_t(skipped)]; }

Refinement refinementBetween(const Mat3& fine, const Mat3& coarse) {
  Refinement result;
  if (!(fine.determinant() > 0 && coarse.determinant() > 0)) return result;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat3> solver(coarse, fine);
  for (Index i = 0; i < 3; ++i) {
    result.ratio[std::size_t(i)] = std::sqrt(std::max(0.0, solver.eigenvalues()[i]));
    result.direction[std::size_t(i)] = solver.eigenvectors().col(i).normalized();
  }
  return result;
}

double spacingAlong(const Mat3& tensor, const Vec3& direction) {
  return std::sqrt(direction.dot(tensor * direction)) / 2;
}

Vec3 mostRefined(const std::vector<Mat3>& tensors) {
  Vec3 direction = Vec3::Zero();
  double most = 1;
  for (const Mat3& fine : tensors)
    for (const Mat3& coarse : tensors) {
      const Refinement step = refinementBetween(fine, coarse);
      if (step.ratio[2] <= most || step.isEven(0)) continue;
      most = step.ratio[2], direction = step.direction[2];
    }
  return direction;
}

std::string directionText(const Vec3& direction) {
  constexpr double parallel = 0.99;
  for (Index c = 0; c < 3; ++c)
    if (std::abs(direction[c]) > parallel) return std::string(1, "xyz"[c]);
  return fmt::format("({:.1f} {:.1f} {:.1f})", direction[0], direction[1], direction[2]);
}

}  // namespace stroma::sweep
