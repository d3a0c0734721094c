// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of kept gaps from one step to the next, and by what gaps between rigid bodies yield to them. Where such bodies meet in
// more points than they have ways to move, their forces are those of an even layer between them: a force over its area is what
// the layer there is pressed by. A vertex stands for its share of the faces that look at the other body, the part of each
// triangle that is nearest to it (Meyer, Desbrun, Schroeder and Barr 2003), so that it does not matter how a quad is cut into two.
// Rims that cross stand for the mean of their ends.
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
  /// After `surfaces` have been finished. `rigid`: of each body of them.
  void compile(const Surfaces& surfaces, std::vector<char> rigid);
  void clear() { names_.clear(), forces_.clear(); }
  /// Of gaps between rigid bodies: `each` rows of a gap, its push and what rubs there.
  void take(const KeptGaps& gaps, const Surfaces& surfaces, std::span<const double> forces, std::size_t each);
  /// Of gaps between rigid bodies: forces that are likely now, and what their rows yield by. Others are left as they are.
  void expect(const KeptGaps& gaps, const Surfaces& surfaces, const std::vector<Vec3>& x, std::size_t each, std::span<double> forces,
              std::span<double> yields) const;
  /// Whether one of them is off by more than `tolerated` [m] where gaps were last looked at, x: a push or what sticks.
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
