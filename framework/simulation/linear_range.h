// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/condensed_body.h"

namespace stroma {

/// Watches how far the surface of a linear body turns and stretches. With the surface gradient of the displacement of
/// a triangle, G = grad u in its plane (t1, t2, n): strain (G + G^T)/2 in the plane, turn ((G_21 - G_12)/2, n.G_1,
/// n.G_2). A few triangles a step, all of them in turn.
class LinearRange {
 public:
  /// Triangles of the bodies' surfaces, quads in two, that have a node which moves.
  void compile(const System& system, const CondensedBody& body, const std::vector<Index>& active_of_row);
  /// `u`: displacement of active nodes, 3 numbers each. `all`: every triangle, else the next few.
  void look(const double* u, double t, bool all);
  void reset() { largest_turn_ = largest_strain_ = 0, next_ = 0; }
  bool isEmpty() const { return triangles_.empty(); }
  /// Empty, or what was beyond the bounds, when first.
  std::string sentence(double rotation_bound, double strain_bound) const;

 private:
  struct Patch {
    std::array<Index, 3> node;  ///< active, or -1 where held
    std::array<Vec3, 2> slope;  ///< of shape functions 1 and 2 in the plane [1/m]
    Vec3 normal, along;
    std::array<Index, 3> rows;
  };
  void measure(const Patch& patch, const double* u, double t);

  const System* system_ = nullptr;
  std::vector<Patch> triangles_;
  std::size_t next_ = 0;
  double largest_turn_ = 0, largest_strain_ = 0;  ///< [rad], [-]
  double time_of_turn_ = 0, time_of_strain_ = 0;
  std::array<Index, 3> turned_{}, strained_{};
};

}  // namespace stroma
