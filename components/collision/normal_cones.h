// SPDX-License-Identifier: LGPL-2.1-or-later
// The directions in which the parts of a surface may have contacts: the filter of SOFA's LocalMinDistance. Over coplanar faces
// that is their normal alone, so that a body sliding on them does not catch on the edges between them.
//
// w leads from the point of the part to that of the other surface, n is the unit vector along the sum of the unit normals of
// the triangles around the part, c and a are coneFactor and angleCone. A part rejects w where
//
//   triangle:  n.w < 0
//   line between two triangles:  n.w < 0, or for one of them  t.w < -(c max(0, n.t) + a) |w|,
//     t the unit vector in its plane, across the line and out of it
//   another line:  |e.w| > (a + 1e-4) |w|,  e along it
//   point:  n.w < -a |w|, or for one of its edges  l.w < -(c max(0, n.l) + a) |w|,
//     l the unit vector from the edge's other end; without triangles n is along the sum of the l
//
// With bothSide the tests of n are omitted. Spheres reject nothing, nor do points without a LineCollisionModel of the same
// state in their node or above. Products that are zero but for rounding, below 1e-9 |w|, count as zero; a quad is two
// triangles. Faces and lines have no contacts in a strip along their rims, a millionth of their size; a part that lands there
// touches the edge or the end, so that nothing falls through.
//
// Source: the formulas are SOFA's (LocalMinDistance), where triangles of quads do not count.
#pragma once
#include <vector>

#include "components/collision/collision_model.h"

namespace stroma::collision {

class NormalCones {
 public:
  void compile(const CollisionModel& model, double angle_cone, double cone_factor);
  /// Whether this part of the model may have a contact in direction `way`, at the current position of the model. Before
  /// compile(): yes.
  bool hold(const Part& part, const Vec3& way) const;

 private:
  void compileLines();
  void compilePoints();
  Vec3 normalOf(const Triangle& face) const;
  bool isWithin(const Vec3& out, const Vec3& normal, const Vec3& way, double size) const;
  bool lineHolds(const Part& part, const Vec3& way) const;
  bool pointHolds(Index node, const Vec3& way) const;

  const CollisionModel* model_ = nullptr;
  double angle_cone_ = 0, cone_factor_ = 0.5;
  std::vector<std::vector<Triangle>> faces_;  ///< around each line, the first two corners are the line's; or each node
  std::vector<std::vector<Index>> ends_;      ///< of edges at each node
};

}  // namespace stroma::collision
