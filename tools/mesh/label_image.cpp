// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/label_image.h"

#include <Eigen/LU>
#include <cmath>

namespace stroma {

double LabelImage::voxelVolume() const { return std::abs(steps.determinant()); }

std::vector<long> LabelImage::voxels() const {
  std::vector<long> count(values.size() + 1, 0);
  for (const std::uint8_t r : region) ++count[r];
  count.erase(count.begin());
  return count;
}

double LabelImage::smallestSpacing() const { return steps.colwise().norm().minCoeff(); }

Vec3 LabelImage::bodySize() const {
  std::array<Index, 3> low = size, high{-1, -1, -1};
  auto voxel = region.begin();
  for (Index z = 0; z < size[2]; ++z)
    for (Index y = 0; y < size[1]; ++y)
      for (Index x = 0; x < size[0]; ++x, ++voxel) {
        if (*voxel == 0) continue;
        const std::array<Index, 3> at{x, y, z};
        for (std::size_t k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], at[k]);
          high[k] = std::max(high[k], at[k]);
        }
      }
  const Vec3 voxels(high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1);
  return steps.colwise().norm().transpose().cwiseProduct(voxels);
}

ConnectedParts connectedParts(const std::array<Index, 3>& size, const std::vector<std::uint8_t>& region) {
  const std::array<std::size_t, 3> stride{1, std::size_t(size[0]), std::size_t(size[0]) * std::size_t(size[1])};
  ConnectedParts parts;
  parts.part.assign(region.size(), -1);
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t voxel, std::uint8_t own) {
    if (region[voxel] != own || parts.part[voxel] >= 0) return;
    parts.part[voxel] = Index(parts.first.size()) - 1;
    open.push_back(voxel);
  };
  for (std::size_t start = 0; start < region.size(); ++start) {
    if (region[start] == 0 || parts.part[start] >= 0) continue;
    parts.first.push_back(start);
    parts.voxels.push_back(0);
    for (reach(start, region[start]); !open.empty();) {
      const std::size_t at = open.back();
      open.pop_back();
      ++parts.voxels.back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t along = at / stride[k] % std::size_t(size[k]);
        if (along > 0) reach(at - stride[k], region[start]);
        if (along + 1 < std::size_t(size[k])) reach(at + stride[k], region[start]);
      }
    }
  }
  return parts;
}

}  // namespace stroma
