// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/label_image.h"

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
        for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], at[k]), high[k] = std::max(high[k], at[k]);
      }
  const Vec3 voxels(high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1);
  return steps.colwise().norm().transpose().cwiseProduct(voxels);
}

}  // namespace stroma
