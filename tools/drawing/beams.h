// SPDX-License-Identifier: LGPL-2.1-or-later
// What bodies of rigid frames have besides their nodes.
#pragma once
#include "tools/drawing/body.h"

namespace stroma::drawing {

/// A beam between two rows that are centres, in the place of the edges of the mesh that it lies on. Before the rows get page
/// numbers.
void addBeam(Body& body, Index a, Index b, double radius);
void dropEdgesOfBeams(Body& body);
/// The size of each body, and the length of the axes of frames: a part of the scene, and less than half of the way from frame to
/// frame, so that they stay apart.
void chooseSizes(std::vector<Body>& bodies);

}  // namespace stroma::drawing
