// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/meshing/label_field.h"

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
  parts_ = connectedParts(padded_, region_);
  keepVolumes();
}

std::vector<std::size_t> LabelField::mixedVoxels() const {
  std::vector<std::size_t> mixed;
  for (Index z = 1; z + 1 < padded_[2]; ++z)
    for (Index y = 1; y + 1 < padded_[1]; ++y)
      for (Index x = 1; x + 1 < padded_[0]; ++x) {
        const std::uint8_t own = region_[place(x, y, z)];
        bool differs = false;
        for (Index row = 0; row < 9 && !differs; ++row) {
          const std::uint8_t* at = &region_[place(x - 1, y + row % 3 - 1, z + row / 3 - 1)];
          differs = at[0] != own || at[1] != own || at[2] != own;
        }
        if (differs) mixed.push_back(place(x, y, z));
      }
  return mixed;
}

/// The part of the nearest voxel of `region` among the 27 about p.
int LabelField::nearestPart(const Vec3& p, int region) const {
  const Vec3 u = inverse_ * (p - origin_);
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (Index k = 0; k < 27; ++k) {
    const Vec3 voxel = u.array().round().matrix() + Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    const std::size_t at = place(Index(voxel.x()) + border, Index(voxel.y()) + border, Index(voxel.z()) + border);
    if (region_[at] != region || (voxel - u).squaredNorm() >= least) continue;
    least = (voxel - u).squaredNorm(), nearest = int(parts_.part[at]);
  }
  return nearest;
}

std::vector<double> LabelField::volumes(const std::vector<std::size_t>& mixed) const {
  constexpr int samples = 4;  // along each axis of a voxel
  std::vector<double> volume(parts_.voxels.begin(), parts_.voxels.end());
  for (const std::size_t voxel : mixed) {
    const int own = region_[voxel];
    const Index x = Index(voxel) % padded_[0], y = Index(voxel) / padded_[0] % padded_[1];
    const Index z = Index(voxel) / padded_[0] / padded_[1];
    for (int k = 0; k < samples * samples * samples; ++k) {
      const Vec3 shift(k % samples, k / samples % samples, k / samples / samples);
      const Vec3 p = centre(x, y, z) + steps_ * ((shift.array() + 0.5) / samples - 0.5).matrix();
      const int found = at(p);
      if (found == own) continue;
      constexpr double share = 1. / (samples * samples * samples);
      if (own) volume[parts_.part[voxel]] -= share;
      if (const int part = found ? nearestPart(p, found) : -1; part >= 0) volume[part] += share;
    }
  }
  return volume;
}

/// Bisection of the logarithm of the strength of all parts that need another one, at the same time.
void LabelField::keepVolumes() {
  constexpr long small = 1000;  // voxels: of larger parts smoothing takes little, and matchVolumes() gives it back
  constexpr double largest = 16;
  constexpr int rounds = 9;
  const std::vector<std::size_t> mixed = mixedVoxels();
  std::vector<double> volume = volumes(mixed);
  struct Range {
    std::size_t part;
    double low, high;
  };
  std::vector<Range> ranges;
  for (std::size_t p = 0; p < volume.size(); ++p) {
    const double error = volume[p] / double(parts_.voxels[p]) - 1;
    if (parts_.voxels[p] < small && std::abs(error) > tolerated)
      ranges.push_back({p, error < 0 ? 0 : -std::log(largest), error < 0 ? std::log(largest) : 0});
  }
  if (ranges.empty()) return;
  std::vector<float> of_part(volume.size(), 1);
  for (int round = 0; round < rounds; ++round) {
    for (const Range& range : ranges) of_part[range.part] = float(std::exp((range.low + range.high) / 2));
    strength_.assign(region_.size(), 1);
    for (std::size_t i = 0; i < region_.size(); ++i)
      if (parts_.part[i] >= 0) strength_[i] = of_part[parts_.part[i]];
    volume = volumes(mixed);
    for (Range& range : ranges)
      (volume[range.part] < double(parts_.voxels[range.part]) ? range.low : range.high) = (range.low + range.high) / 2;
  }
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
      for (Index x = 0; x < 3; ++x, ++i) mixed |= (found[i] = row[x]) != found[0];
    }
  if (!mixed) return found[0];
  std::array<double, 256> sum;  // set where a region occurs
  for (const std::uint8_t r : found) sum[r] = 0;
  for (std::size_t i = 0; i < 27; ++i) {
    double share = weight[0][i % 3] * weight[1][i / 3 % 3] * weight[2][i / 9];
    if (!strength_.empty())
      share *= double(strength_[place(c[0] + Index(i % 3) - 1, c[1] + Index(i / 3 % 3) - 1, c[2] + Index(i / 9) - 1)]);
    sum[found[i]] += share;
  }
  int best = found[0];
  for (const std::uint8_t r : found)
    if (sum[r] > sum[best] || (sum[r] == sum[best] && r < best)) best = r;
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
  const std::vector<Index>& part = parts_.part;
  const std::vector<long>& voxels = parts_.voxels;
  const double voxel = std::cbrt(std::abs(steps_.determinant()));
  Spread spread;
  std::vector<BoundaryPoint> points;
  const auto visit = [&](std::size_t a, std::size_t b, const Vec3& at_a, const Vec3& at_b) {
    if (region_[a] == region_[b]) return;
    const auto distanceOf = [&](std::size_t i) {
      return std::min(spacing[region_[i]], 0.5 * voxel * std::cbrt(double(voxels[part[i]])));
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
