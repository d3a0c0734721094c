// SPDX-License-Identifier: LGPL-2.1-or-later
// How far a step may move bodies and vertices, which says what pairs are looked for (KeptGaps::begin()): twice as far as in the step
// before, or as their speed would take them, and an eighth of the mean edge.
#pragma once
#include <algorithm>

#include "components/contact/kept_gaps.h"

namespace stroma {
class Archive;
class State;
}  // namespace stroma

namespace stroma::contact {

class KeptWays {
 public:
  static constexpr double of_edge = 0.125;  ///< pairs are searched at least this far, as a fraction of lengthOf()
  /// The mean edge; for single points the thickness, as they are spheres, or contactDistance.
  static double lengthOf(const BarrierLaw& law) {
    const double edge = law.surfaces.meanEdge();
    return edge > 0 ? edge : std::max(law.thickness, law.range);
  }
  /// The step before has moved vertices from `start` to x.
  void measure(const Surfaces& surfaces, const std::vector<Vec3>& start, const std::vector<Vec3>& x);
  /// Of a step of dt [s] with these velocities, in which obstacles go `of_obstacles`.
  void find(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles);
  /// Of each vertex, after find(); `start`: of the step before, empty: none.
  void expect(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles,
              const std::vector<Vec3>& start, const std::vector<Vec3>& x);
  /// Something has moved in the step before by more than any pair was looked for.
  bool wasExceeded() const { return travel_ > 2 * way_; }
  double longest() const { return way_; }                              ///< that of all bodies, without obstacles [m]
  const std::vector<double>& ofBodies() const { return of_bodies_; }  ///< [m]
  const ExpectedWays& expected() const { return expected_; }
  void reset() { travel_ = way_ = 0, travels_.clear(); }
  void serialize(Archive& archive);

 private:
  double travel_ = 0;                ///< the longest way of a vertex in the last step [m]
  double way_ = 0;
  std::vector<double> travels_;      ///< of each body, its longest way in the last step [m]
  std::vector<double> of_bodies_;
  ExpectedWays expected_;
};

}  // namespace stroma::contact
