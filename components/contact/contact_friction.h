// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction with normal forces l and directions that are held fixed in a solve (Li et al. 2020). With u the way along the
// tangents since the start of the step and y = |u| / e, its force has the potential mu l f0(|u|),
//   f0' = 2 y - y^2 for y < 1, else 1
#pragma once
#include "components/contact/contact_terms.h"

namespace stroma::contact {

class Friction {
 public:
  double mu = 0;
  double slip = 1e-6;  ///< e [m]
  struct Slide {
    std::array<int, 4> v;
    std::array<double, 4> c;
    Vec3 n;
    double force;   ///< mu l [N]; negative: takes away what was counted twice
    bool on_plane;  ///< its other point moves with the obstacles
  };
  /// What slides from now on.
  std::vector<Slide> slides;
  /// Forces at x of what began the step at `start` while obstacles have moved by `moved`.
  void compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved);
  const Terms& terms() const { return terms_; }
  /// On all vertices, of the last compute(); `out` has that many.
  void forces(std::vector<Vec3>& out) const;
  void clear() { slides.clear(), terms_.clear(); }

 private:
  Terms terms_;
};

}  // namespace stroma::contact
