// SPDX-License-Identifier: LGPL-2.1-or-later
// Stiffness matrices of a cell that is cut into 1, 8, 64, ... parts, each with a factor of its own.
#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "framework/fem/isotropic.h"
#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma::parts {

using CellStiffness = Eigen::Matrix<double, 24, 24>;
using Corners = std::array<Vec3, 8>;
inline constexpr int corner_places[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// The gradients of the shape functions by xi, in [0, 1] along each axis.
inline std::array<Vec3, 8> slopesAt(const Vec3& xi) {
  std::array<Vec3, 8> slopes;
  for (std::size_t a = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) {
      double slope = corner_places[a][axis] ? 1 : -1;
      for (int other = 0; other < 3; ++other)
        if (other != axis) slope *= corner_places[a][other] ? xi[other] : 1 - xi[other];
      slopes[a][axis] = slope;
    }
  return slopes;
}

/// Of a part with its lowest corner at `low`, of the size 1 / n; throws where the cell is inverted.
inline CellStiffness partStiffness(const Corners& rest, const Vec3& low, int n, const Lame& material) {
  CellStiffness k = CellStiffness::Zero();
  for (int point = 0; point < 8; ++point) {
    Vec3 xi = low;
    for (int axis = 0; axis < 3; ++axis) xi[axis] += (0.5 + (point >> axis & 1 ? 0.5 : -0.5) / std::sqrt(3.)) / n;
    std::array<Vec3, 8> g = slopesAt(xi);
    Mat3 jacobian = Mat3::Zero();
    for (std::size_t a = 0; a < 8; ++a) jacobian += rest[a] * g[a].transpose();
    const double weight = jacobian.determinant() / (8. * n * n * n);
    if (!(weight > 0)) throw ComponentError("a cell is flat or inverted at rest", "hexahedra that are not");
    const Mat3 inverse = jacobian.inverse().transpose();
    for (Vec3& gradient : g) gradient = inverse * gradient;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const Vec3 &ga = g[std::size_t(a)], &gb = g[std::size_t(b)];
        k.block<3, 3>(3 * a, 3 * b) += weight * (material.lambda * ga * gb.transpose() + material.mu * gb * ga.transpose() +
                                                 material.mu * ga.dot(gb) * Mat3::Identity());
      }
  }
  return k;
}

/// Condenses the eight cells in a cell, again and again until one is left (M. Nesme, P. Kry, L. Jerabkova, F. Faure 2009).
class Composite {
 public:
  /// `factors`: of the n^3 parts, x fastest; n is a power of two.
  Composite(const Corners& corners, const double* factors, int n, const Lame& material)
      : corners_(corners), factors_(factors), n_(n), material_(material) {}

  /// Zero where nothing is filled.
  CellStiffness stiffness() const { return of({0, 0, 0}, n_).value_or(CellStiffness::Zero()); }

 private:
  using Place = std::array<int, 3>;
  static constexpr int nodes = 27, free_nodes = 19;
  static constexpr double rigid = 1e7;  ///< times the material's stiffness, of what is empty

  Vec3 at(const Place& place) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
      double shape = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double xi = double(place[axis]) / n_;
        shape *= corner_places[a][axis] ? xi : 1 - xi;
      }
      sum += shape * corners_[a];
    }
    return sum;
  }
  CellStiffness ofBox(const Place& low, int size, const Lame& material) const {
    Corners corners;
    for (std::size_t a = 0; a < 8; ++a)
      corners[a] = at(childAt(low, size, a));
    return partStiffness(corners, Vec3::Zero(), 1, material);
  }

  std::optional<CellStiffness> of(const Place& low, int size) const {
    if (size == 1) {
      const double factor = factors_[low[0] + n_ * (low[1] + n_ * low[2])];
      if (factor == 0) return {};
      return factor * ofBox(low, 1, material_);
    }
    const int half = size / 2;
    std::array<std::optional<CellStiffness>, 8> children;
    bool any = false;
    for (std::size_t c = 0; c < 8; ++c) {
      children[c] = of(childAt(low, half, c), half);
      any = any || children[c];
    }
    if (!any) return {};
    using Matrix = Eigen::Matrix<double, 3 * nodes, 3 * nodes>;
    Matrix filled = Matrix::Zero(), all = Matrix::Zero();
    const Lame stiff{0, rigid * (material_.lambda + 2 * material_.mu) / 2};
    for (std::size_t c = 0; c < 8; ++c) {
      const CellStiffness k = children[c] ? *children[c] : ofBox(childAt(low, half, c), half, stiff);
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = 0; b < 8; ++b) {
          const auto block = k.block<3, 3>(3 * Index(a), 3 * Index(b));
          all.block<3, 3>(3 * numberOf(c, a), 3 * numberOf(c, b)) += block;
          if (children[c]) filled.block<3, 3>(3 * numberOf(c, a), 3 * numberOf(c, b)) += block;
        }
    }
    const Eigen::Matrix<double, 3 * nodes, 24> w = weights(all);
    return CellStiffness(w.transpose() * filled * w);
  }
  static Place childAt(const Place& low, int half, std::size_t c) {
    return {low[0] + half * corner_places[c][0], low[1] + half * corner_places[c][1], low[2] + half * corner_places[c][2]};
  }
  /// Of corner a of child c among the 27 nodes, x fastest.
  static Index numberOf(std::size_t c, std::size_t a) {
    const auto along = [&](std::size_t axis) { return corner_places[c][axis] + corner_places[a][axis]; };
    return along(0) + 3 * along(1) + 9 * along(2);
  }

  /// How the 27 nodes follow the eight corners.
  static Eigen::Matrix<double, 3 * nodes, 24> weights(const Eigen::Matrix<double, 3 * nodes, 3 * nodes>& k) {
    std::array<Index, free_nodes> inner{};
    std::array<Index, 8> corner{};
    for (std::size_t a = 0; a < 8; ++a) corner[a] = 2 * (corner_places[a][0] + 3 * corner_places[a][1] + 9 * corner_places[a][2]);
    std::size_t count = 0;
    for (Index i = 0; i < nodes; ++i)
      if (std::find(corner.begin(), corner.end(), i) == corner.end()) inner[count++] = i;
    Eigen::Matrix<double, 3 * free_nodes, 3 * free_nodes> kff;
    Eigen::Matrix<double, 3 * free_nodes, 24> kfc;
    for (Index i = 0; i < free_nodes; ++i) {
      for (Index j = 0; j < free_nodes; ++j)
        kff.block<3, 3>(3 * i, 3 * j) = k.block<3, 3>(3 * inner[std::size_t(i)], 3 * inner[std::size_t(j)]);
      for (Index a = 0; a < 8; ++a)
        kfc.block<3, 3>(3 * i, 3 * a) = k.block<3, 3>(3 * inner[std::size_t(i)], 3 * corner[std::size_t(a)]);
    }
    const Eigen::Matrix<double, 3 * free_nodes, 24> answer = -kff.partialPivLu().solve(kfc);
    Eigen::Matrix<double, 3 * nodes, 24> w = Eigen::Matrix<double, 3 * nodes, 24>::Zero();
    for (std::size_t a = 0; a < 8; ++a) w.block<3, 3>(3 * corner[a], 3 * Index(a)) = Mat3::Identity();
    for (std::size_t i = 0; i < free_nodes; ++i)
      for (Index axis = 0; axis < 3; ++axis) {
        const Index row = 3 * inner[i] + axis;
        for (Index a = 0; a < 8; ++a)
          if (follows(inner[i], std::size_t(a))) w(row, 3 * a + axis) = answer(3 * Index(i) + axis, 3 * a + axis);
        w.row(row) /= w.row(row).sum();
      }
    return w;
  }
  /// A node of an edge follows its ends, one of a face its corners.
  static bool follows(Index node, std::size_t a) {
    const Index place[3] = {node % 3, node / 3 % 3, node / 9};
    for (int axis = 0; axis < 3; ++axis)
      if (place[axis] != 1 && place[axis] != 2 * corner_places[a][axis]) return false;
    return true;
  }

  const Corners& corners_;
  const double* factors_;
  int n_;
  Lame material_;
};

}  // namespace stroma::parts
