// SPDX-License-Identifier: LGPL-2.1-or-later
// Contacts of two parts by SOFA's formulas: MinProximityIntersection, LocalMinDistance, NewProximityIntersection. P and Q are the closest
// points on the lines and planes through the parts, n leads from the first part to the second, and a contact needs |Q - P| below the
// alarm distance, plus skins and radii.
//
//   triangle and point or sphere  inside: both weights, and that of the first corner, more than 1e-6. NewProximity takes a point beyond
//                                 an edge to it where the triangle is the first of the mesh with this edge or corner. For spheres it
//                                 asks edge 12 in the place of 31, and 31 in the place of 23
//   line and point                MinProximity and NewProximity take a point beyond an end to it; LocalMinDistance drops it
//   line and sphere               the same, but MinProximity drops what is beyond an end, and measures along the line from its second
//                                 end and sets the point from its first
//   line and line                 inside by 1e-6 (LocalMinDistance: 1e-15); parallel ones have the middles of both
//   triangle and line, two triangles  NewProximity alone: corners as points, and edges as lines with useLineLine
//
// Each contact has a number, which penalties use to keep one contact of those with the same number: of the point or sphere, or of the part
// of the model with more parts.
#pragma once
#include "components/collision/contact_pairs.h"

namespace stroma::collision {

struct Listed {
  Contact contact;
  double value;  ///< distance, less the one at which they touch [m]
  long number;
};

/// The order of kinds in SOFA's pairs: the first model of a pair is the one with the lower number.
int placeInPair(CollisionModel::Kind kind);

class PartLister {
 public:
  PartLister(const Method& method, const CollisionModel& first, const CollisionModel& second, const NormalCones& of_first,
             const NormalCones& of_second);
  void meet(Index i, Index j, std::vector<Listed>& out) const;

 private:
  /// Points of a contact by their weights in the corners of the parts.
  using Weights = std::array<double, 3>;
  struct Parts {
    const Part &p, &q;
    std::array<Vec3, 3> x, y;  ///< their corners
  };
  void add(const Parts& parts, const Weights& of_p, const Weights& of_q, long number, std::vector<Listed>& out) const;
  void meetTriangles(const Parts& parts, Index i, Index j, std::vector<Listed>& out) const;
  void meetTriangleAndLine(const Parts& parts, Index j, std::vector<Listed>& out) const;

  const Method& method_;
  const CollisionModel &first_, &second_;
  const NormalCones &cones_of_first_, &cones_of_second_;
  double alarm_, contact_;  ///< with the skins of both models [m]
};

}  // namespace stroma::collision
