// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether a mesh is finer than another one alike in all directions. The spacing of a mesh is the symmetric tensor
//   S = sum_cells V sum_edges e e^T / sum_cells V,
// n^T S n the mean square of the cells' edges along n. Between two meshes it falls along n by sqrt(n^T S_2 n / n^T S_1 n):
// least and most along the eigenvectors of S_2 x = r^2 S_1 x.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "tools/sweep/end_state.h"

namespace stroma::sweep {

/// S of the volume cells of a run [m^2]; zero without cells.
Mat3 spacingTensor(const EndState& end);

/// By how much the spacing falls from a coarse mesh to a fine one, from the direction of the least to that of the most.
struct Refinement {
  std::array<double, 3> ratio{};
  std::array<Vec3, 3> direction{};

  /// Directions that are not refined at all.
  int fixed() const;
  /// Whether the directions behind the first `skipped` are refined alike.
  bool isEven(int skipped) const;
};

/// All ratios are 0 where a mesh has no volume.
Refinement refinementBetween(const Mat3& fine, const Mat3& coarse);

/// The spacing along a direction, as the edges of bricks have it: n^T S n = 4 h^2 [m].
double spacingAlong(const Mat3& tensor, const Vec3& direction);

/// Where some of the meshes are refined more in one direction than in another, that direction; else zero. Without volume
/// they are not compared.
Vec3 mostRefined(const std::vector<Mat3>& tensors);

/// "x", or "(0.7 0.7 0)"
std::string directionText(const Vec3& direction);

}  // namespace stroma::sweep
