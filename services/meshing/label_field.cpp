// SPDX-License-Identifier: LGPL-2.1-or-later
#include "services/meshing/label_field.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace stroma::meshing {

namespace {

/// The three weights of the quadratic B-spline at distance d in [-1/2, 1/2] from the middle sample.
std::array<double, 3> splineWeights(double d) {
  return {0.5 * (0.5 - d) * (0.5 - d), 0.75 - d * d, 0.5 * (0.5 + d) * (0.5 + d)};
}

/// Accepted points of the parts, in cells as wide as the distance to keep.
class Spread {
 public:
  bool isFree(Index part, const Vec3& p, double spacing) const {
    const auto [x, y, z] = cellOf(p, spacing);
    for (Index k = 0; k < 27; ++k) {
      const auto near = points_.find({part, x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1});
      if (near == points_.end()) continue;
      for (const Vec3& q : near->second)
        if ((p - q).squaredNorm() < spacing * spacing) return false;
    }
    return true;
  }
  void add(Index part, const Vec3& p, double spacing) {
    const auto [x, y, z] = cellOf(p, spacing);
    points_[{part, x, y, z}].push_back(p);
  }

 private:
  static std::array<Index, 3> cellOf(const Vec3& p, double spacing) {
    return {Index(std::floor(p.x() / spacing)), Index(std::floor(p.y() / spacing)), Index(std::floor(p.z() / spacing))};
  }
  std::map<std::tuple<Index, Index, Index, Index>, std::vector<Vec3>> points_;
};

}  // namespace

LabelField::LabelField(const LabelImage& image)
    : padded_{image.size[0] + 2 * border, image.size[1] + 2 * border, image.size[2] + 2 * border},
      origin_(image.origin),
      steps_(image.steps),
      inverse_(image.steps.inverse()) {
  region_.assign(std::size_t(padded_[0]) * std::size_t(padded_[1]) * std::size_t(padded_[2]), 0);
  auto from = image.region.begin();
  for (Index z = 0; z < image.size[2]; ++z)
    for (Index y = 0; y < image.size[1]; ++y, from += image.size[0])
      std::copy(from, from + image.size[0], region_.begin() + std::ptrdiff_t(place(border, y + border, z + border)));
}

int LabelField::at(const Vec3& p) const {
  const Vec3 u = inverse_ * (p - origin_);
  std::array<Index, 3> c;
  std::array<std::array<double, 3>, 3> weight;
  for (std::size_t k = 0; k < 3; ++k) {
    const double nearest = std::round(u[int(k)]);
    if (!(nearest >= -1 && nearest <= padded_[k] - 2 * border)) return 0;
    c[k] = Index(nearest) + border;
    weight[k] = splineWeights(u[int(k)] - nearest);
  }
  std::array<std::uint8_t, 27> found;
  bool mixed = false;
  for (Index z = 0, i = 0; z < 3; ++z)
    for (Index y = 0; y < 3; ++y) {
      const std::uint8_t* row = &region_[place(c[0] - 1, c[1] + y - 1, c[2] + z - 1)];
      for (Index x = 0; x < 3; ++x, ++i) mixed |= (found[std::size_t(i)] = row[x]) != found[0];
    }
  if (!mixed) return found[0];
  std::array<double, 256> sum;  // set where a region occurs
  for (const std::uint8_t r : found) sum[r] = 0;
  for (std::size_t i = 0; i < 27; ++i) sum[found[i]] += weight[0][i % 3] * weight[1][i / 3 % 3] * weight[2][i / 9];
  int best = found[0];
  for (const std::uint8_t r : found)
    if (sum[r] > sum[std::size_t(best)] || (sum[r] == sum[std::size_t(best)] && r < best)) best = r;
  return best;
}

std::array<Vec3, 2> LabelField::box() const {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p =
        centre(corner & 1 ? padded_[0] - 1 : 0, corner & 2 ? padded_[1] - 1 : 0, corner & 4 ? padded_[2] - 1 : 0);
    low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  return {low, high};
}

/// The connected part (through voxel faces) of each voxel, -1 outside, and how many voxels each part has.
std::vector<Index> LabelField::parts(std::vector<long>& voxels) const {
  const std::ptrdiff_t row = padded_[0], slice = row * padded_[1];
  std::vector<Index> part(region_.size(), -1);
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < region_.size(); ++first) {
    if (region_[first] == 0 || part[first] >= 0) continue;
    const Index number = Index(voxels.size());
    voxels.push_back(0);
    part[first] = number;
    open.push_back(first);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      ++voxels.back();
      for (const std::ptrdiff_t step : {-slice, -row, std::ptrdiff_t(-1), std::ptrdiff_t(1), row, slice}) {
        const std::size_t other = std::size_t(std::ptrdiff_t(at) + step);  // the border keeps it inside the array
        if (region_[other] != region_[first] || part[other] >= 0) continue;
        part[other] = number;
        open.push_back(other);
      }
    }
  }
  return part;
}

/// Bisection; low == high when both ends are in one region.
LabelField::BoundaryPoint LabelField::between(Vec3 a, Vec3 b) const {
  int at_a = at(a), at_b = at(b);
  for (int k = 0; k < 40 && at_a != at_b; ++k) {
    const Vec3 middle = (a + b) / 2;
    const int here = at(middle);
    if (here == at_a)
      a = middle;
    else
      b = middle, at_b = here;
  }
  return {(a + b) / 2, std::min(at_a, at_b), std::max(at_a, at_b)};
}

std::vector<LabelField::BoundaryPoint> LabelField::boundaryPoints(const std::vector<double>& spacing) const {
  std::vector<long> voxels;
  const std::vector<Index> part = parts(voxels);
  const double voxel = std::cbrt(std::abs(steps_.determinant()));
  Spread spread;
  std::vector<BoundaryPoint> points;
  const auto visit = [&](std::size_t a, std::size_t b, const Vec3& at_a, const Vec3& at_b) {
    if (region_[a] == region_[b]) return;
    const auto distanceOf = [&](std::size_t i) {
      return std::min(spacing[region_[i]], 0.5 * voxel * std::cbrt(double(voxels[std::size_t(part[i])])));
    };
    const Vec3 middle = (at_a + at_b) / 2;
    const bool wanted = (part[a] >= 0 && spread.isFree(part[a], middle, distanceOf(a))) ||
                        (part[b] >= 0 && spread.isFree(part[b], middle, distanceOf(b)));
    if (!wanted) return;
    const BoundaryPoint point = between(at_a, at_b);
    if (point.low == point.high) return;
    for (const std::size_t i : {a, b})
      if (part[i] >= 0) spread.add(part[i], middle, distanceOf(i));
    points.push_back(point);
  };
  for (Index z = 1; z + 1 < padded_[2]; ++z)
    for (Index y = 1; y + 1 < padded_[1]; ++y)
      for (Index x = 1; x + 1 < padded_[0]; ++x) {
        const std::size_t a = place(x, y, z);
        visit(a, place(x + 1, y, z), centre(x, y, z), centre(x + 1, y, z));
        visit(a, place(x, y + 1, z), centre(x, y, z), centre(x, y + 1, z));
        visit(a, place(x, y, z + 1), centre(x, y, z), centre(x, y, z + 1));
      }
  return points;
}

}  // namespace stroma::meshing
