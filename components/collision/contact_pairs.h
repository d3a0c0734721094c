// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/collision/collision_method.h"
#include "components/collision/normal_cones.h"

namespace stroma::collision {

/// A point of a part of a surface: sum weight_i x_i over its corners.
struct PartPoint {
  const Part* part = nullptr;
  std::array<double, 3> weight{};
};

/// Two points of two surfaces that were nearer than the alarm distance when contacts were looked for.
struct Contact {
  const CollisionModel *model_a, *model_b;
  PartPoint a, b;
  Vec3 normal;    ///< unit, from a to b
  double contact; ///< distance of the two points at which surfaces touch, radii and skins included [m]
};

/// Contacts of pairs of models at the models' present positions. As SOFA's: points and lines and triangles have contacts
/// where the closest points lie within both, more than 1e-6 of their size from the ends; a triangle and a line or a
/// triangle by the corners, of which each belongs to one part, and by edges where the method says so. A LocalMinDistance
/// asks both parts for their cones.
class ContactSearch {
 public:
  void compile(const std::vector<ModelPair>& pairs, const Method& method);
  void find(std::vector<Contact>& out);

 private:
  struct Surface {
    const CollisionModel* model;
    std::vector<Box> boxes;
    BoxTree tree;
    NormalCones cones;
  };
  struct Pair {
    std::size_t a, b;
  };
  std::size_t surfaceOf(const CollisionModel& model);
  void fit(Surface& surface) const;
  void meet(const Surface& a, const Part& p, const Surface& b, const Part& q, double alarm, double contact,
            std::vector<Contact>& out) const;

  const Method* method_ = nullptr;
  std::vector<Surface> surfaces_;
  std::vector<Pair> pairs_;
};

}  // namespace stroma::collision
