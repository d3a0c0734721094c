// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>

#include "components/collision/contact_pairs.h"

namespace stroma::collision {

/// The way from p to q is fixed + sum c_i x_i over nodes that something moves.
struct Push {
  std::array<Index, 6> rows{-1, -1, -1, -1, -1, -1};
  std::array<double, 6> c{};
  Vec3 fixed = Vec3::Zero(), n;
  double d = 0, k = 0;
  std::array<Index, 2> turns{-1, -1};  ///< rows of orientations of balls: of p, of q
  std::array<double, 2> radii{};       ///< theirs [m]
  bool acts = false;    ///< at the last force
  bool joined = false;  ///< a part of the matrix
  bool rubs = false;    ///< by a force of constraint, which addForce() knows nothing of
  double mu = 0;        ///< of friction
};

/// The weights of a point of a model, times `sign`: -1 of p, 1 of q.
void addSide(const CollisionModel& model, const PartPoint& point, double sign, Push& push);
Vec3 wayOf(const Push& push, ConstRows x);
/// d - (q - p).n
double depth(const Push& push, ConstRows x);
/// How far q has slid on p since the step began, with the turns of balls [m].
Vec3 slid(const Push& push, ConstRows x, ConstRows x_start);
/// The part of the step after the surfaces have met, if both move evenly: the share of slid() for which SOFA's friction acts.
double shareInTouch(const Push& push, ConstRows x, ConstRows x_start);

}  // namespace stroma::collision
