// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/porous_cells.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "components/hyperelasticity/cell_volume.h"
#include "framework/fem/eigen_matrix.h"

namespace stroma::porous {
namespace {

using Corners = PorousCells::OfNodes<Vec3>;
using Areas = PorousCells::OfNodes<Vec3>;

/// The edges from vertex 0, as columns.
Mat3 edgesOf(const Vec3* corner) {
  Mat3 edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = corner[i + 1] - corner[0];
  return edges;
}

Areas areasOfTetrahedron(const Vec3* x, const Corners& corner, double overlap, const Sponge& sponge) {
  const Mat3 now = edgesOf(x);
  const double six_volumes = edgesOf(corner.data()).determinant();
  const double weight = sponge.coefficient * std::sqrt(sponge.logarithmSlope(now.determinant() / six_volumes));
  const double factor = std::copysign(weight / (6 * overlap), six_volumes);
  Eigen::Matrix<double, 3, 4> area;
  for (int i = 0; i < 3; ++i) area.col(i + 1) = factor * now.col((i + 1) % 3).cross(now.col((i + 2) % 3));
  area.col(0) = -area.rightCols<3>().rowwise().sum();
  Areas result;
  for (int i = 0; i < 4; ++i) result[std::size_t(i)] = area.col(i);
  return result;
}

hyperelastic::HexahedronVolume<double> volumeOfHexahedron(const Vec3* x) {
  V3<double> node[8];
  for (int a = 0; a < 8; ++a) node[a] = vectorOf(x[a]);
  return hyperelastic::HexahedronVolume<double>(node);
}
Areas areasOfHexahedron(const Vec3* x, const Corners& corner, double overlap, const Sponge& sponge) {
  const auto now = volumeOfHexahedron(x);
  const double rest = volumeOfHexahedron(corner.data()).value();
  const double weight = sponge.coefficient * std::sqrt(sponge.logarithmSlope(now.value() / rest));
  V3<double> area[8];
  now.gradient(std::copysign(weight / (512 * overlap), rest), area);
  Areas result;
  for (std::size_t a = 0; a < 8; ++a) result[a] = toEigen(area[a]);
  return result;
}

/// One of a hexahedron's 2x2x2 points.
struct Point {
  double n[8];                    ///< N_a
  Eigen::Matrix<double, 3, 8> g;  ///< grad N_a [1/m]
  double volume;                  ///< with the sign of det J [m^3]
};
std::array<Point, 8> pointsOf(const Corners& corner) {
  const CellKind& kind = cell_kinds::hexahedron;
  std::array<Point, 8> result;
  for (std::size_t p = 0; p < 8; ++p) {
    const QuadraturePoint& at = kind.rule(2).points[p];
    std::array<LocalPoint, 8> slopes;
    kind.shapes(at.xi, result[p].n);
    kind.gradients(at.xi, slopes.data());
    Eigen::Matrix<double, 3, 8> local;
    Mat3 j = Mat3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
      local.col(Eigen::Index(a)) = Vec3(slopes[a].data());
      j += corner[a] * local.col(Eigen::Index(a)).transpose();
    }
    result[p].g = j.inverse().transpose() * local;
    result[p].volume = at.weight * j.determinant();
  }
  return result;
}

}  // namespace

std::span<const Index> PorousCells::nodes(std::size_t cell) const {
  if (isTetrahedra()) return mesh_.tetrahedra[cell];
  return mesh_.hexahedra[cell];
}

Corners PorousCells::corners(std::size_t cell) const {
  Corners result;
  const auto of = nodes(cell);
  std::transform(of.begin(), of.end(), result.begin(), [&](Index node) { return rest_[node]; });
  return result;
}

std::string PorousCells::fault(std::size_t cell) const {
  const Corners corner = corners(cell);
  double longest = 0;
  for (int a = 1; a < kind_.nodes; ++a) longest = std::max(longest, (corner[std::size_t(a)] - corner[0]).norm());
  if (!(std::abs(kind_.size(corner.data())) > 1e-15 * longest * longest * longest)) return "is flat at rest";
  if (isTetrahedra()) return {};
  const auto points = pointsOf(corner);
  const auto [least, most] = std::minmax_element(points.begin(), points.end(),
                                                 [](const Point& a, const Point& b) { return a.volume < b.volume; });
  return least->volume * most->volume > 0 ? "" : "is folded at rest: its points have volumes of both signs";
}

PorousCells::OfNodes<double> PorousCells::shares(std::size_t cell) const {
  OfNodes<double> result{};
  const Corners corner = corners(cell);
  if (isTetrahedra()) {
    const double volume = std::abs(edgesOf(corner.data()).determinant()) / (6 * mesh_.overlap);
    std::fill_n(result.begin(), 4, volume / 4);
    return result;
  }
  for (const Point& p : pointsOf(corner))
    for (std::size_t a = 0; a < 8; ++a) result[a] += std::abs(p.volume) / mesh_.overlap * p.n[a];
  return result;
}

PorousCells::OfNodes<double> PorousCells::fractions(std::size_t cell) const {
  OfNodes<double> result = shares(cell);
  const double volume = std::accumulate(result.begin(), result.end(), 0.);
  for (double& share : result) share /= volume;
  return result;
}

std::array<PorousCells::OfNodes<double>, most_cell_nodes> PorousCells::gradients(std::size_t cell) const {
  std::array<OfNodes<double>, most_cell_nodes> result{};
  const Corners corner = corners(cell);
  if (isTetrahedra()) {
    const Mat3 edges = edgesOf(corner.data());
    const double volume = std::abs(edges.determinant()) / (6 * mesh_.overlap);
    Eigen::Matrix<double, 3, 4> g;
    g.rightCols<3>() = edges.inverse().transpose();
    g.col(0) = -g.rightCols<3>().rowwise().sum();
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) result[a][b] = volume * g.col(Eigen::Index(a)).dot(g.col(Eigen::Index(b)));
    return result;
  }
  for (const Point& p : pointsOf(corner)) {
    const Eigen::Matrix<double, 8, 8> products = std::abs(p.volume) / mesh_.overlap * p.g.transpose() * p.g;
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = 0; b < 8; ++b) result[a][b] += products(Eigen::Index(a), Eigen::Index(b));
  }
  return result;
}

Areas PorousCells::areas(std::size_t cell, const Vec3* x, const Sponge& sponge) const {
  return isTetrahedra() ? areasOfTetrahedron(x, corners(cell), mesh_.overlap, sponge)
                        : areasOfHexahedron(x, corners(cell), mesh_.overlap, sponge);
}

}  // namespace stroma::porous
