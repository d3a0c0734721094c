// SPDX-License-Identifier: LGPL-2.1-or-later
// Which of q and -q an orientation is stored as. The sign is that of the scene's numbers at the start and follows the motion, so that
// a recording has no jumps. Products of quaternions keep it by themselves; these functions are for what would lose it.
#pragma once
#include "framework/mechanics/frames.h"

namespace stroma {

/// The rotation vector of up to a whole turn with exp(r) = q. Of the shortest one, exp may be -q.
Vec3 signedRotationVector(const Quaternion& q);
/// Writes q or -q, whichever is nearer to what the row holds: for an orientation that is computed without its past.
void putNearest(const Quaternion& q, Rows x, Index row);

}  // namespace stroma
