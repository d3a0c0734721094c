// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of kept gaps from one step to the next, and the compliances of gaps between rigid bodies. If such bodies touch at more
// points than they have degrees of freedom, their forces are those of a uniform elastic layer between them: a force over its area
// is the pressure of the layer there. A vertex has its share of the faces towards the other body, the part of each
// triangle that is nearest to it (Meyer, Desbrun, Schroeder and Barr 2003), so that it does not matter how a quad is split.
// Crossing rims have the mean of the shares of their ends.
#pragma once
#include <span>
#include <vector>

#include "components/contact/kept_gaps.h"

namespace stroma {
class Archive;
}

namespace stroma::contact {

class KeptForces {
 public:
  /// Call it when `surfaces` are finished. `rigid`: per body.
  void compile(const Surfaces& surfaces, std::vector<char> rigid);
  void clear() { names_.clear(), forces_.clear(); }
  /// Stores the forces of gaps between rigid bodies: each gap has `each` rows, normal and friction.
  void take(const KeptGaps& gaps, const Surfaces& surfaces, std::span<const double> forces, std::size_t each);
  /// For gaps between rigid bodies: expected forces, and the compliances of their rows. Others are unchanged.
  void expect(const KeptGaps& gaps, const Surfaces& surfaces, const std::vector<Vec3>& x, std::size_t each, std::span<double> forces,
              std::span<double> yields) const;
  /// Whether a gap or a sticking contact is violated by more than `tolerated` [m] at x, where gaps were last evaluated.
  bool isViolated(const KeptGaps& gaps, const BarrierLaw& law, const std::vector<Vec3>& x, std::size_t each, std::span<const double> forces,
             double friction, double tolerated) const;
  void serialize(Archive& archive);

 private:
  /// Kind (2: a plane) and numbers of two sides.
  using Name = std::array<int, 3>;
  static Name nameOf(const KeptGap& gap);
  bool isRigid(const KeptGap& gap, const Surfaces& surfaces) const;
  double areaAt(int vertex, const Vec3& towards, const Surfaces& surfaces, const std::vector<Vec3>& x) const;
  double areaOf(const KeptGap& gap, const Surfaces& surfaces, const std::vector<Vec3>& x) const;

  std::vector<char> rigid_;
  std::vector<std::array<double, 3>> shares_;  ///< of the corners of each triangle [m^2]
  std::vector<Name> names_;                    ///< sorted
  std::vector<Vec3> forces_;                   ///< of each name: on its first side [N]
  std::vector<std::size_t> pushed_;            ///< work space
};

}  // namespace stroma::contact
