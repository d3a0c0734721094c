// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>

#include "framework/scene/types.h"

namespace stroma {

template <class Block>
double diagonalSize(const Block& block) {
  return block.diagonal().cwiseAbs().sum() / 3;
}

/// The diagonal entry of fixed directions beside entries of this size: a power of two of the same magnitude, so that
/// neither loses digits if fixed and free directions are oblique in a block; 1 if there are none.
inline double heldSize(double size) { return size > 0 && std::isfinite(size) ? std::ldexp(1., std::ilogb(size)) : 1; }

}  // namespace stroma
