// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>

#include "framework/scene/types.h"

namespace stroma {

template <class Block>
double diagonalSize(const Block& block) {
  return block.diagonal().cwiseAbs().sum() / 3;
}

/// What held directions have on the diagonal beside numbers of this size: a power of two like them, so that where held and
/// free directions lie oblique in a block neither loses digits to the other; 1 beside none.
inline double heldSize(double size) { return size > 0 && std::isfinite(size) ? std::ldexp(1., std::ilogb(size)) : 1; }

}  // namespace stroma
