// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Core>
#include <vector>

#include "tools/mesh/label_image.h"

namespace stroma::meshing {

/// The label of every point of space. Each voxel's indicator of a label is spread by a quadratic B-spline (width three
/// voxels, a partition of unity); the label of a point is the one with the largest sum. Boundaries lie half way between
/// voxels and are smooth instead of stairs. Smoothing rounds edges and corners, which takes a quarter of a cube of two
/// voxels wide and all of a single voxel: the indicator of a small connected part that would lose or gain more than
/// `tolerated` of its volume is made stronger or weaker until the part has the volume of its voxels.
class LabelField {
 public:
  explicit LabelField(const LabelImage& image);
  /// 0 outside, i + 1 for the i-th label of the image.
  int at(const Vec3& p) const;

  /// A point where the region changes from `low` to `high` > `low`.
  struct BoundaryPoint {
    Vec3 position;
    int low, high;
  };
  /// Points on the boundary of every connected part of every region, at least `spacing[region]` apart within a part
  /// and nearer to each other on parts that are small; always in the same order.
  std::vector<BoundaryPoint> boundaryPoints(const std::vector<double>& spacing) const;
  /// Corners of a box, aligned with the axes of space, around all voxels and a voxel more.
  std::array<Vec3, 2> box() const;

 private:
  std::size_t place(Index x, Index y, Index z) const {
    return std::size_t(x) + std::size_t(padded_[0]) * (std::size_t(y) + std::size_t(padded_[1]) * std::size_t(z));
  }
  Vec3 centre(Index x, Index y, Index z) const { return origin_ + steps_ * Vec3(x - border, y - border, z - border); }
  void keepVolumes();
  /// The voxels (in padded_) about which several regions meet.
  std::vector<std::size_t> mixedVoxels() const;
  /// Volumes of the parts in voxels, by samples about the voxels of mixedVoxels().
  std::vector<double> volumes(const std::vector<std::size_t>& mixed) const;
  int nearestPart(const Vec3& p, int region) const;
  BoundaryPoint between(Vec3 a, Vec3 b) const;

  static constexpr Index border = 2;         ///< voxels of region 0 around the image
  static constexpr double tolerated = 0.03;  ///< of a part's volume; matchVolumes() mends what is less
  std::array<Index, 3> padded_;
  std::vector<std::uint8_t> region_;
  ConnectedParts parts_;
  std::vector<float> strength_;  ///< of each voxel's indicator; empty: 1 everywhere
  Vec3 origin_;
  Mat3 steps_, inverse_;
};

}  // namespace stroma::meshing
