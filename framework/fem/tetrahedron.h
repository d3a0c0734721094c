// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/fem/gradients.h"

namespace stroma::tetrahedron {

using namespace elastic;

/// Differences from vertex a.
template <class T>
struct Edges {
  V3<T> e[3];
  explicit Edges(const V3<T> (&x)[4]) : e{x[1] - x[0], x[2] - x[0], x[3] - x[0]} {}
};

}  // namespace stroma::tetrahedron
