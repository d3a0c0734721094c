// SPDX-License-Identifier: LGPL-2.1-or-later
// The stiffness of an elastic block of trilinear hexahedra as a stored matrix, assembled here from the textbook alone
// (2x2x2 Gauss points), so that solvers are tested on systems that no component of the project made.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tests/support/stored_matrix.h"

namespace stroma::test {

struct ElasticBlock {
  std::array<Index, 3> cells{4, 4, 4};
  double size = 1;          ///< edge of a cell [m]
  double young = 1;         ///< [Pa]
  double poisson = 0.3;     ///< [-]
  bool mean = false;        ///< the volume change is one per cell, its mean: cells do not lock
  double density = 0;       ///< of a consistent mass added to the stiffness [kg/m^3]
  bool hold_floor = true;   ///< the nodes at z = 0 are held in all directions (their rows are those of the identity)
  bool slide_wall = false;  ///< the nodes at x = 0 slide in their plane
  bool hold_wall = false;   ///< the nodes at x = 0 are held in all directions
  std::function<double(Vec3)> stiffer = {};  ///< factor of E at a point (cells as unit), 1 when not given

  Index nodes(int axis) const { return cells[axis] + 1; }
  Index node(Index i, Index j, Index k) const { return i + nodes(0) * (j + nodes(1) * k); }
  Index count() const { return nodes(0) * nodes(1) * nodes(2); }
  StoredMatrix matrix() const;

 private:
  using ElementMatrix = Eigen::Matrix<double, 24, 24>;
  ElementMatrix element(bool mass) const;
  void addVolume(const std::array<Index, 8>& corners, const Vec3& centre, VolumeTerms& terms) const;
  void hold(BlockMatrix& matrix, Index row, const Mat3& projector) const;
};

/// Corner c of a cell: its bits are x, y and z. In numbers: compiled without optimisation.
inline ElasticBlock::ElementMatrix ElasticBlock::element(bool mass) const {
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
  const double at_points = mean ? -2 * mu / 3 : lambda, volume = size * size * size, weight = volume / 8;
  ElementMatrix result = ElementMatrix::Zero();
  double* const entries = result.data();
  double change[24] = {};  // of the volume, over that at rest
  for (int q = 0; q < 8; ++q) {
    const auto sign = [](int bits, int axis) { return bits >> axis & 1 ? 1. : -1.; };
    double gradient[8][3], shape[8];
    for (int c = 0; c < 8; ++c) {
      shape[c] = 1;
      for (int axis = 0; axis < 3; ++axis) {
        double slope = sign(c, axis) / size;
        for (int other = 0; other < 3; ++other) {
          const double value = (1 + sign(c, other) * sign(q, other) / std::sqrt(3.)) / 2;
          if (other != axis) slope *= value;
          if (axis == 0) shape[c] *= value;
        }
        gradient[c][axis] = slope;
        change[3 * c + axis] += slope / 8;
      }
    }
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const double *g = gradient[a], *h = gradient[b], along = g[0] * h[0] + (g[1] * h[1] + g[2] * h[2]);
        const double diagonal = mass ? density * shape[a] * shape[b] : mu * along;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            const double other = mass ? 0 : at_points * g[i] * h[j] + mu * h[i] * g[j];
            entries[24 * (3 * b + j) + 3 * a + i] += weight * (other + (i == j ? diagonal : 0));
          }
      }
  }
  if (mean && !mass)
    for (int i = 0; i < 24; ++i)
      for (int j = 0; j < 24; ++j) entries[24 * j + i] += (lambda + 2 * mu / 3) * volume * change[i] * change[j];
  return result;
}

/// Rows and columns of `row` become P A P + I - P.
inline void ElasticBlock::hold(BlockMatrix& matrix, Index row, const Mat3& projector) const {
  const double* const p = projector.data();  // symmetric
  const auto multiply = [](const double* a, const double* b, double* to) {
    double product[9];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) product[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    std::copy_n(product, 9, to);
  };
  for (Index s = matrix.rowStart()[row]; s < matrix.rowStart()[row + 1]; ++s) {
    double* const mine = matrix.values().data() + 9 * std::size_t(s);
    double* const mirrored = matrix.values().data() + 9 * std::size_t(matrix.slot(matrix.columns()[s], row));
    multiply(p, mine, mine);
    multiply(mirrored, p, mirrored);  // on the diagonal both are one
  }
  matrix.add(row, row, Mat3::Identity() - projector);
}

/// The gradient of a cell's volume: a quarter of a face's area at each corner, and nothing in directions that are held.
inline void ElasticBlock::addVolume(const std::array<Index, 8>& corners, const Vec3& centre, VolumeTerms& terms) const {
  const double mu = young / (2 * (1 + poisson)), bulk = young / (3 * (1 - 2 * poisson)), area = size * size / 4;
  const double factor = (stiffer ? stiffer(centre) : 1) / (size * size * size);
  for (int c = 0; c < 8; ++c) {
    Vec3 gradient(c & 1 ? area : -area, c & 2 ? area : -area, c & 4 ? area : -area);
    const bool on_floor = corners[std::size_t(c)] < nodes(0) * nodes(1), on_wall = corners[std::size_t(c)] % nodes(0) == 0;
    if (slide_wall && on_wall) gradient.x() = 0;
    if ((hold_floor && on_floor) || (hold_wall && on_wall)) gradient.setZero();
    terms.rows.push_back(corners[std::size_t(c)]), terms.gradients.push_back(gradient);
  }
  terms.finish(factor * bulk, factor * mu);
}

inline StoredMatrix ElasticBlock::matrix() const {
  BlockPattern pattern(count());
  const auto forEachCell = [this](auto&& visit) {
    for (Index k = 0; k < cells[2]; ++k)
      for (Index j = 0; j < cells[1]; ++j)
        for (Index i = 0; i < cells[0]; ++i) {
          std::array<Index, 8> corners;
          for (int c = 0; c < 8; ++c) corners[c] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
          visit(corners, Vec3(i + 0.5, j + 0.5, k + 0.5));
        }
  };
  forEachCell([&](const std::array<Index, 8>& corners, const Vec3&) { pattern.addClique(corners.data(), 8); });
  BlockMatrix matrix(std::move(pattern));
  const ElementMatrix stiffness = element(false);
  const ElementMatrix mass = density == 0 ? ElementMatrix::Zero().eval() : element(true);
  forEachCell([&](const std::array<Index, 8>& corners, const Vec3& centre) {
    const double factor = stiffer ? stiffer(centre) : 1;
    const double *of_stiffness = stiffness.data(), *of_mass = mass.data();  // in numbers: compiled without optimisation
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        double* block = matrix.values().data() + 9 * std::size_t(matrix.slot(corners[a], corners[b]));
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            const int entry = 24 * (3 * b + j) + 3 * a + i;
            block[3 * i + j] += factor * of_stiffness[entry] + of_mass[entry];
          }
      }
  });
  if (hold_floor)
    for (Index n = 0; n < nodes(0) * nodes(1); ++n) hold(matrix, n, Mat3::Zero());
  if (hold_wall)
    for (Index k = 0; k < nodes(2); ++k)
      for (Index j = 0; j < nodes(1); ++j) hold(matrix, node(0, j, k), Mat3::Zero());
  if (slide_wall)
    for (Index k = hold_floor ? 1 : 0; k < nodes(2); ++k)
      for (Index j = 0; j < nodes(1); ++j) hold(matrix, node(0, j, k), Vec3(0, 1, 1).asDiagonal());
  StoredMatrix stored(std::move(matrix));
  if (mean) forEachCell([&](const std::array<Index, 8>& corners, const Vec3& centre) { addVolume(corners, centre, stored.volumes); });
  return stored;
}

}  // namespace stroma::test
