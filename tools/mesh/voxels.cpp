// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/voxels.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "framework/scene/component.h"

namespace stroma {
namespace {

/// Where a line along x crosses a triangle; `sign` is 1 where it goes in, the triangle facing outward.
struct Crossing {
  double x;
  int sign;
};

/// Whether (y, z) lies on the left of the edge from a to b, seen along x. Both triangles of an edge get the same answer
/// because the ends are put in order first: no line slips through between them.
bool isLeft(const Vec3& a, const Vec3& b, double y, double z) {
  const bool in_order = std::pair(a.y(), a.z()) < std::pair(b.y(), b.z());
  const Vec3 &from = in_order ? a : b, &to = in_order ? b : a;
  const bool left = (to.y() - from.y()) * (z - from.z()) - (to.z() - from.z()) * (y - from.y()) > 0;
  return left == in_order;
}

/// How often the triangle, seen along x, winds around (y, z): -1, 0 or 1.
int windingOf(const std::array<Vec3, 3>& p, double y, double z) {
  int winding = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = p[k], &b = p[(k + 1) % 3];
    if ((a.z() <= z) == (b.z() <= z)) continue;
    const bool upward = a.z() <= z;
    if (isLeft(a, b, y, z) == upward) winding += upward ? 1 : -1;
  }
  return winding;
}

class Filler {
 public:
  Filler(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles, double size)
      : position_(position), triangles_(triangles), size_(size) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Triangle& t : triangles)
      for (const Index n : t) {
        low = low.cwiseMin(position[n]);
        high = high.cwiseMax(position[n]);
      }
    double voxels = 1;
    for (int k = 0; k < 3; ++k) {
      const double count = std::ceil((high[k] - low[k]) / size) + 2;
      voxels *= count;
      if (!(voxels < 2e9))
        throw ComponentError(fmt::format("voxels of {:.4g} make more than 2e9 in a box of {:.4g} x {:.4g} x {:.4g}",
                                         size, high.x() - low.x(), high.y() - low.y(), high.z() - low.z()),
                             "larger voxels");
      image_.size[k] = Index(count);
      // the box in the middle: centres do not lie in planes that the surface of a box shares with a grid
      image_.origin[k] = (low[k] + high[k]) / 2 - (count - 1) / 2 * size;
    }
    image_.steps = size * Mat3::Identity();
    image_.values = {1};
    image_.region.assign(voxels, 0);
    lines_.resize(std::size_t(image_.size[1]) * std::size_t(image_.size[2]));
  }

  Voxels operator()() {
    double volume = 0;
    for (const Triangle& t : triangles_) volume += cross(t);
    const int outward = volume > 0 ? 1 : -1;
    for (std::size_t line = 0; line < lines_.size(); ++line) fill(line, outward);
    if (std::find(image_.region.begin(), image_.region.end(), 1) == image_.region.end())
      throw ComponentError(fmt::format("no centre of a voxel of {:.4g} lies inside the surface", size_),
                           "a surface around a body, or smaller voxels");
    return {std::move(image_), covered_, reversed_};
  }

 private:
  /// Enters a triangle into the lines that cross it; returns its share of six times the enclosed volume.
  double cross(const Triangle& t) {
    std::array<Vec3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = position_[t[k]] - image_.origin;
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
    // a triangle seen edge on is crossed somewhere between its corners
    const double low = std::min({p[0].x(), p[1].x(), p[2].x()}), high = std::max({p[0].x(), p[1].x(), p[2].x()});
    const auto [first_y, last_y] = range(p, 1);
    const auto [first_z, last_z] = range(p, 2);
    for (Index k = first_z; k <= last_z; ++k)
      for (Index j = first_y; j <= last_y; ++j) {
        const double y = j * size_, z = k * size_;
        const int winding = windingOf(p, y, z);
        if (winding == 0) continue;
        double x = p[0].x() - (normal.y() * (y - p[0].y()) + normal.z() * (z - p[0].z())) / normal.x();
        if (!std::isfinite(x)) x = low;
        lines_[std::size_t(j) + std::size_t(image_.size[1]) * std::size_t(k)].push_back(
            {std::clamp(x, low, high), -winding});
      }
    return p[0].dot(normal);
  }

  /// Lines that may cross, with one more on each side: windingOf() decides, and decides alike for all triangles.
  std::pair<Index, Index> range(const std::array<Vec3, 3>& p, Eigen::Index axis) const {
    const auto [low, high] = std::minmax({p[0][axis], p[1][axis], p[2][axis]});
    const double last = double(image_.size[axis] - 1);
    return {Index(std::clamp(std::floor(low / size_), 0.0, last)),
            Index(std::clamp(std::ceil(high / size_), 0.0, last))};
  }

  void fill(std::size_t line, int outward) {
    std::vector<Crossing>& crossings = lines_[line];
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
    int winding = 0;
    std::size_t next = 0;
    for (Index i = 0; i < image_.size[0]; ++i) {
      for (; next < crossings.size() && crossings[next].x <= i * size_; ++next)
        winding += outward * crossings[next].sign;
      if (winding > 0) image_.region[std::size_t(i) + std::size_t(image_.size[0]) * line] = 1;
      covered_ += winding > 1, reversed_ += winding < 0;
    }
    for (; next < crossings.size(); ++next) winding += outward * crossings[next].sign;
    if (winding != 0)
      throw ComponentError(
          "the surface is open, or some of its triangles are turned inward and others outward: a line through it goes "
          "in more often than out",
          "a closed surface whose triangles are all turned the same way");
    crossings = {};
  }

  const std::vector<Vec3>& position_;
  const std::vector<Triangle>& triangles_;
  double size_;
  LabelImage image_;
  std::vector<std::vector<Crossing>> lines_;
  long covered_ = 0, reversed_ = 0;
};

}  // namespace

Voxels voxelsInside(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles, double size) {
  return Filler(position, triangles, size)();
}

}  // namespace stroma
