// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/collision/pair_distances.h"

#include <Eigen/Geometry>
#include <limits>

namespace stroma {
namespace {

__extension__ using Wide = __float128;  // 113 bits

template <class T>
struct Point {
  T x, y, z;
  Point operator-(const Point& o) const { return {x - o.x, y - o.y, z - o.z}; }
  Point operator+(const Point& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Point operator*(T s) const { return {x * s, y * s, z * s}; }
  friend T dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend Point cross(const Point& a, const Point& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
};

/// The nearest of what has been considered: every feature of a pair is.
template <class T>
struct Nearest {
  T square = T(std::numeric_limits<double>::max());
  Point<T> difference{};
  std::array<T, 4> weights{};
  void consider(const Point<T>& d, const std::array<T, 4>& w) {
    const T length = dot(d, d);
    if (length < square) square = length, difference = d, weights = w;
  }
  /// Point i against the edge from j to k; `sign`: of the point's weight.
  void considerEdge(const std::array<Point<T>, 4>& x, std::size_t i, std::size_t j, std::size_t k, int sign) {
    const Point<T> along = x[k] - x[j], from = x[i] - x[j];
    const T length = dot(along, along), reach = dot(from, along);
    const T t = !(reach > 0) ? T(0) : reach >= length ? T(1) : reach / length;
    // from the nearer end, for the sake of round-off
    const Point<T> d = t > T(0.5) ? (x[i] - x[k]) + along * (T(1) - t) : from - along * t;
    std::array<T, 4> w{};
    w[i] = T(sign), w[j] = T(-sign) * (T(1) - t), w[k] = T(-sign) * t;
    consider(d * T(sign), w);
  }
};

template <class T>
std::array<Point<T>, 4> relative(const FourPoints& x) {
  std::array<Point<T>, 4> out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = {T(x[i].x()) - T(x[0].x()), T(x[i].y()) - T(x[0].y()), T(x[i].z()) - T(x[0].z())};
  return out;
}

/// The interior of the pair, a point over a triangle or two lines that cross. False: nearly singular.
template <class T>
bool considerInterior(PairKind kind, const std::array<Point<T>, 4>& x, Nearest<T>& nearest) {
  const bool triangle = kind == PairKind::point_triangle;
  const Point<T> first = triangle ? x[2] - x[1] : x[1] - x[0], second = triangle ? x[3] - x[1] : x[3] - x[2];
  const Point<T> from = triangle ? x[0] - x[1] : x[0] - x[2], normal = cross(first, second);
  const T square = dot(normal, normal), sizes = dot(first, first) * dot(second, second);
  if (square > T(0)) {
    const T along_second = dot(cross(from, second), normal) / square, along_first = dot(cross(from, first), normal) / square;
    const Point<T> d = normal * (dot(from, normal) / square);
    if (triangle) {
      const T v = along_second, w = -along_first, u = T(1) - v - w;
      if (u > T(0) && v > T(0) && w > T(0)) nearest.consider(d, {T(1), -u, -v, -w});
    } else {
      const T s = -along_second, t = -along_first;
      if (s > T(0) && s < T(1) && t > T(0) && t < T(1)) nearest.consider(d, {T(1) - s, s, t - T(1), -t});
    }
  }
  return square > T(1e-6) * sizes || sizes == T(0);  // points that coincide leave nothing to lose
}

template <class T>
bool closestOf(PairKind kind, const FourPoints& points, ClosestPoints& found) {
  const std::array<Point<T>, 4> x = relative<T>(points);
  Nearest<T> nearest;
  const bool regular = considerInterior(kind, x, nearest);
  if (kind == PairKind::point_triangle) {
    nearest.considerEdge(x, 0, 1, 2, 1), nearest.considerEdge(x, 0, 2, 3, 1), nearest.considerEdge(x, 0, 3, 1, 1);
  } else {
    nearest.considerEdge(x, 0, 2, 3, 1), nearest.considerEdge(x, 1, 2, 3, 1);
    nearest.considerEdge(x, 2, 0, 1, -1), nearest.considerEdge(x, 3, 0, 1, -1);
  }
  for (std::size_t i = 0; i < 4; ++i) found.weights[i] = double(nearest.weights[i]);
  found.difference = {double(nearest.difference.x), double(nearest.difference.y), double(nearest.difference.z)};
  return regular;
}

}  // namespace

ClosestPoints closestPoints(PairKind kind, const FourPoints& x) {
  ClosestPoints found;
  if (!closestOf<double>(kind, x, found)) closestOf<Wide>(kind, x, found);
  if (const double square = found.difference.squaredNorm(); square > 1e-130 && square < 1e130) return found;
  double size = 0;  // products of four lengths must not leave the range of doubles
  for (const Vec3& point : x) size = std::max(size, (point - x[0]).cwiseAbs().maxCoeff());
  if (size == 0 || !std::isfinite(size) || (size > 1e-65 && size < 1e65)) return found;
  const double unit = std::ldexp(1, std::min(-std::ilogb(size), 1000));
  found = closestPoints(kind, {Vec3::Zero(), unit * (x[1] - x[0]), unit * (x[2] - x[0]), unit * (x[3] - x[0])});
  return found.difference /= unit, found;
}

double parallelFactor(const Vec3& ea, const Vec3& eb, double rest_squares) {
  const double share = ea.cross(eb).squaredNorm() / (1e-3 * rest_squares);
  return share < 1 ? (2 - share) * share : 1;
}

}  // namespace stroma
