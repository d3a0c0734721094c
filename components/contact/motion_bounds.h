// SPDX-License-Identifier: LGPL-2.1-or-later
// How far a step may move bodies and vertices, which determines the pairs to search (KeptGaps::begin()): twice the motion of the previous
// step or the motion at their speed, whichever is larger, plus an eighth of the mean edge.
#pragma once
#include <algorithm>

#include "components/contact/kept_gaps.h"

namespace stroma {
class Archive;
class State;
}  // namespace stroma

namespace stroma::contact {

class MotionBounds {
 public:
  static constexpr double of_edge = 0.125;  ///< pairs are searched at least this far, as a fraction of lengthOf()
  /// The mean edge; for single points, which are spheres, the thickness or contactDistance.
  static double lengthOf(const BarrierLaw& law) {
    const double edge = law.surfaces.meanEdge();
    return edge > 0 ? edge : std::max(law.thickness, law.range);
  }
  /// Stores the motion of the previous step, which moved vertices from `start` to x.
  void measure(const Surfaces& surfaces, const std::vector<Vec3>& start, const std::vector<Vec3>& x);
  /// For a step of dt [s] with the velocities of `states`, in which obstacles move by `of_obstacles`.
  void find(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles);
  /// The expected motion of each vertex, after find(); `start`: of the previous step, empty: none.
  void expect(const BarrierLaw& law, const std::vector<State*>& states, double dt, const Vec3& of_obstacles,
              const std::vector<Vec3>& start, const std::vector<Vec3>& x);
  /// In the previous step something moved farther than any pair was searched.
  bool wasExceeded() const { return travel_ > 2 * way_; }
  double longest() const { return way_; }                              ///< the largest of all bodies, without obstacles [m]
  const std::vector<double>& ofBodies() const { return of_bodies_; }  ///< [m]
  const ExpectedMotion& expected() const { return expected_; }
  void reset() { travel_ = way_ = 0, travels_.clear(); }
  void serialize(Archive& archive);

 private:
  double travel_ = 0;                ///< the largest motion of a vertex in the last step [m]
  double way_ = 0;
  std::vector<double> travels_;      ///< per body: the largest motion in the last step [m]
  std::vector<double> of_bodies_;
  ExpectedMotion expected_;
};

}  // namespace stroma::contact
