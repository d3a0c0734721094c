// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/key_times.h"
#include "framework/mesh/topology.h"

namespace stroma::contact {

/// What stands or moves on a path beside the bodies, as attributes of a component.
class Obstacles {
 public:
  void declare(DataTable& table);
  /// Throws ComponentError. `bodies_meet`: so that something does without obstacles.
  void init(bool bodies_meet, const std::string& expected);
  void addTo(BarrierLaw& law) const;
  Vec3 displacement(double t) const { return times_.empty() ? Vec3(Vec3::Zero()) : path_.at(t); }  ///< [m]

 private:
  LinkList<Topology> meshes_{"topology"};
  std::vector<double> planes_, spheres_, capsules_, cylinders_, boxes_, times_;
  std::vector<Vec3> movements_;
  KeyTimes<Vec3> path_;
};

/// Moves obstacles towards `goal` as far as bodies at x let them, with their vertices in x. `way`: of all vertices, work space.
void moveObstacles(BarrierLaw& law, const Vec3& goal, std::vector<Vec3>& x, std::vector<Vec3>& way);

/// Throws ComponentError when surfaces of the component at `path` lie in one another, or nearer than their thickness, at x,
/// with the worst places. `name` says what a vertex is. Pairs are known then for motion up to `margin`; 0: contactDistance.
void refuseOverlap(const std::string& path, const BarrierLaw& law, const std::vector<Vec3>& x,
                   const std::function<std::string(int)>& name, double margin = 0);

/// What pushes and has no gap, or no finite force, at x: "node 3 of /dofs and node 4 of /dofs: a gap of -0.1 m", the worst of it; or
/// empty. Leaves no trace in a `law` that is a copy.
std::string describeWorst(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& name);

/// "the edge from A to B goes 0.1 m through the triangle at C"
std::string describe(const Candidates::Crossing& crossing, const Surfaces& surfaces,
                     const std::function<std::string(int)>& name);

}  // namespace stroma::contact
