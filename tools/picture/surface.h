// SPDX-License-Identifier: LGPL-2.1-or-later
// Surfaces of triangles for shading: smooth where the rest shape is, with creases where it has edges; and outlines.
#pragma once
#include <vector>

#include "framework/scene/types.h"

namespace stroma::picture {

/// Three numbers for each point.
using Points = std::vector<float>;

/// A surface with its nodes doubled along creases. Which edges are creases is decided once, at the rest shape, so that the
/// shading of a film does not flicker.
class SmoothSurface {
 public:
  /// `rest`: of the nodes that the triangles name. An edge whose faces enclose more than `crease` [rad] is a crease.
  SmoothSurface(std::vector<Triangle> triangles, const Points& rest, double crease);

  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< by corner
  const std::vector<Index>& nodes() const { return node_; }              ///< node of each corner
  /// Unit normals of the corners, each the sum of those of its triangles by area; zero where they cancel.
  Points normals(const Points& x) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<Index> node_;
};

/// Edges by which a shape is known from `back`, the direction towards the eye: those between a face that looks there and one
/// that does not, creases, and borders.
std::vector<Edge> outline(const std::vector<Triangle>& triangles, const Points& x, const Vec3& back, double crease);

/// The mean length of the triangles' sides; 0 without any.
double meanSide(const std::vector<Triangle>& triangles, const Points& x);

}  // namespace stroma::picture
