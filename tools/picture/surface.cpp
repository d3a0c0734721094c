// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace stroma::picture {
namespace {

Vec3 pointOf(const Points& x, Index i) {
  const float* p = x.data() + 3 * std::size_t(i);
  return {p[0], p[1], p[2]};
}

/// Twice the area, in the direction of the normal.
Vec3 areaVector(const Triangle& t, const Points& x) {
  const Vec3 a = pointOf(x, t[0]);
  return (pointOf(x, t[1]) - a).cross(pointOf(x, t[2]) - a);
}

std::vector<Vec3> unitNormals(const std::vector<Triangle>& triangles, const Points& x) {
  std::vector<Vec3> normals;
  for (const Triangle& t : triangles) {
    const Vec3 n = areaVector(t, x);
    const double length = n.norm();
    normals.push_back(length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero()));
  }
  return normals;
}

/// A side of a triangle: its nodes in ascending order, and whose it is.
struct Side {
  Index a, b, triangle;
  bool is_turned;  ///< the triangle goes from b to a
  bool sameEdge(const Side& other) const { return a == other.a && b == other.b; }
};

/// Those of the same edge lie together.
std::vector<Side> sortedSides(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), Index(t), a > b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
  });
  return sides;
}

/// `visit(first, last)` for the sides of each edge.
template <class Visit>
void forEachEdge(const std::vector<Side>& sides, Visit&& visit) {
  for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
    while (j < sides.size() && sides[i].sameEdge(sides[j])) ++j;
    visit(sides.data() + i, sides.data() + j);
  }
}

/// Corners 3 t + k that are joined, by one of them.
class Joined {
 public:
  explicit Joined(std::size_t count) : first_(count) { std::iota(first_.begin(), first_.end(), std::size_t(0)); }
  std::size_t of(std::size_t i) {
    while (first_[i] != i) i = first_[i] = first_[first_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { first_[of(std::max(i, j))] = of(std::min(i, j)); }

 private:
  std::vector<std::size_t> first_;
};

std::size_t cornerOf(const std::vector<Triangle>& triangles, Index triangle, Index node) {
  const Triangle& t = triangles[std::size_t(triangle)];
  return 3 * std::size_t(triangle) + std::size_t(std::find(t.begin(), t.end(), node) - t.begin());
}

}  // namespace

SmoothSurface::SmoothSurface(std::vector<Triangle> triangles, const Points& rest, double crease)
    : triangles_(std::move(triangles)) {
  const std::vector<Vec3> normals = unitNormals(triangles_, rest);
  const double least = std::cos(crease);
  Joined joined(3 * triangles_.size());
  forEachEdge(sortedSides(triangles_), [&](const Side* first, const Side* last) {
    if (last - first != 2 || first[0].is_turned == first[1].is_turned) return;
    const Index s = first[0].triangle, t = first[1].triangle;
    if (normals[std::size_t(s)].dot(normals[std::size_t(t)]) < least) return;
    for (const Index node : {first->a, first->b})
      joined.join(cornerOf(triangles_, s, node), cornerOf(triangles_, t, node));
  });
  std::vector<Index> number(3 * triangles_.size(), -1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      Index& corner = number[joined.of(3 * t + k)];
      if (corner < 0) {
        corner = Index(node_.size());
        node_.push_back(triangles_[t][k]);
      }
      triangles_[t][k] = corner;
    }
}

Points SmoothSurface::normals(const Points& x) const {
  std::vector<Vec3> sums(node_.size(), Vec3::Zero());
  for (const Triangle& corners : triangles_) {
    const Triangle nodes{node_[std::size_t(corners[0])], node_[std::size_t(corners[1])],
                         node_[std::size_t(corners[2])]};
    const Vec3 n = areaVector(nodes, x);
    for (const Index corner : corners) sums[std::size_t(corner)] += n;
  }
  Points out(3 * sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = sums[i].norm();
    for (int k = 0; k < 3; ++k) out[3 * i + std::size_t(k)] = length > 0 ? float(sums[i][k] / length) : 0.f;
  }
  return out;
}

std::vector<Edge> outline(const std::vector<Triangle>& triangles, const Points& x, const Vec3& back, double crease) {
  const std::vector<Vec3> normals = unitNormals(triangles, x);
  const double least = std::cos(crease);
  std::vector<Edge> edges;
  forEachEdge(sortedSides(triangles), [&](const Side* first, const Side* last) {
    const Vec3& n = normals[std::size_t(first[0].triangle)];
    if (last - first == 2) {
      const Vec3& m = normals[std::size_t(first[1].triangle)];
      if (n.dot(m) >= least && (n.dot(back) >= 0) == (m.dot(back) >= 0)) return;
    }
    edges.push_back({first->a, first->b});
  });
  return edges;
}

double meanSide(const std::vector<Triangle>& triangles, const Points& x) {
  double sum = 0;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) sum += (pointOf(x, t[k]) - pointOf(x, t[(k + 1) % 3])).norm();
  return triangles.empty() ? 0 : sum / double(3 * triangles.size());
}

}  // namespace stroma::picture
