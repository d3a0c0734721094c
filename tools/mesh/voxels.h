// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/mesh/label_image.h"

namespace stroma {

/// The inside of a surface as an image of cubic voxels.
struct Voxels {
  LabelImage image;   ///< label 1 inside, with a layer of voxels outside on every side
  long covered = 0;   ///< voxels inside that the surface encloses more than once
  long reversed = 0;  ///< voxels outside that it encloses the wrong way round
};

/// Fills the voxels whose centre the surface winds around; it may cut and overlap itself, as unions of bodies and
/// surfaces smoothed too far do. A centre counts by the signs of the triangles that a line along x crosses before it:
/// as in Jacobson, Kavan and Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized winding
/// numbers", for a closed surface. Time: triangles times the lines that each covers. `size` [unit of the positions] >
/// 0. Throws ComponentError for a surface that is open or whose triangles are turned different ways, and for one
/// without an inside.
Voxels voxelsInside(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles, double size);

}  // namespace stroma
