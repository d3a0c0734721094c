// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <compare>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

/// Two places that are kept apart: of a body and a sphere or capsule, or of a vertex and a plane.
struct KeptGap {
  const Candidate* pair = nullptr;  ///< null: a plane
  std::size_t plane = 0;
  std::array<int, 4> v{-1, -1, -1, -1};
  /// unit: the direction from the other side where the step starts, and one along the surface
  Vec3 side = Vec3::Zero(), across = Vec3::Zero();
  std::array<double, 4> side_c{};  ///< c there
  double distance = 0;   ///< of the closest points there [m]
  // where conditions were last looked at
  std::array<double, 4> c{};
  Vec3 n = Vec3::Zero(), tangent = Vec3::Zero();
  double gap = 0;  ///< less contactDistance [m]
  bool counts = true;

  /// Where the two places are at x.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Edges whose distance has no one direction: their ends meet the triangles beside them instead.
  bool isOfParallelEdges(const BarrierLaw& law, const std::vector<Vec3>& x) const;
};

/// The vertices of the closest points of a gap.
struct GapKey {
  std::array<int, 4> vertices;
  std::size_t gap;
  auto operator<=>(const GapKey&) const = default;
};

/// Of those with the same closest points all but one no longer count. `keys`: work space.
void ignoreDoubles(std::vector<KeptGap>& gaps, std::vector<GapKey>& keys);

}  // namespace stroma::contact
