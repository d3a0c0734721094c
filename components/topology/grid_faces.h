// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>

#include "framework/mesh/mesh.h"

namespace stroma {

/// Adds the quads of a solid grid of n[0] x n[1] x n[2] nodes (x fastest), inner ones too, in SOFA's order: those normal to z,
/// to y and to x; and beside them the two triangles (0 1 2)(0 2 3) of each.
inline void addGridFaces(const std::array<int, 3>& n, Mesh& mesh) {
  constexpr int first[3] = {0, 0, 1}, second[3] = {1, 2, 2};  // the directions of faces normal to z, y and x
  const Index strides[3] = {1, n[0], n[0] * n[1]};
  for (std::size_t f = 0; f < 3; ++f) {
    std::array<int, 3> count = n;
    --count[std::size_t(first[f])], --count[std::size_t(second[f])];
    const Index u = strides[first[f]], v = strides[second[f]];
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) {
          const Index a = i + strides[1] * j + strides[2] * k;
          mesh.quads.push_back({a, a + u, a + u + v, a + v});
          mesh.triangles.push_back({a, a + u, a + u + v});
          mesh.triangles.push_back({a, a + u + v, a + v});
        }
  }
}

}  // namespace stroma
