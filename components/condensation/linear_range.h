// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/condensation/condensed_body.h"
#include "framework/scene/archive.h"

namespace stroma {

/// Watches how far the surface of a linear body turns and stretches from its rest shape. With the surface gradient of
/// the displacement of a triangle, G = grad u in its plane (t1, t2, n): strain (G + G^T)/2 in the plane, turn
/// ((G_21 - G_12)/2, n.G_1, n.G_2). All triangles when the displacements are larger than ever before and when asked for
/// the sentence; else a few per step, in turn. What is beyond the bounds for some steps in the middle of a run, with
/// smaller displacements than an earlier step, is seen by chance.
class LinearRange {
 public:
  /// Triangles of the bodies' surfaces, quads in two, that have a node which moves.
  void compile(const System& system, const CondensedBody& body, const std::vector<Index>& active_of_row);
  /// At the system's positions. `square`: sum of the squares of the displacements of active nodes [m^2].
  void look(double square, double t);
  void reset();
  void serialize(Archive& archive);  ///< what was seen so far
  bool isEmpty() const { return triangles_.empty(); }
  /// Triangles whose nodes are known in every step; the others are looked at by sentence() alone.
  std::size_t watched() const { return known_; }
  /// Empty, or what was beyond the bounds, and when. The inside has to be complete.
  std::string sentence(double rotation_bound, double strain_bound) const;

 private:
  struct Patch {
    std::array<Vec3, 2> edge;   ///< from corner 0, at rest
    std::array<Vec3, 2> slope;  ///< of shape functions 1 and 2 in the plane [1/m]
    Vec3 normal, along;
    std::array<Index, 3> rows;
  };
  struct Peaks {
    double turn = 0, strain = 0;  ///< [rad], [-]
    double time_of_turn = 0, time_of_strain = 0;
    std::array<Index, 3> turned{}, strained{};
  };
  void measure(const Patch& patch, double t, Peaks& peaks) const;

  const System* system_ = nullptr;
  std::vector<Patch> triangles_;  ///< the known ones first
  std::size_t known_ = 0, next_ = 0;
  Peaks peaks_;
  double largest_square_ = -1, last_time_ = 0;
};

}  // namespace stroma
