// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/key_times.h"
#include "framework/mesh/topology.h"

namespace stroma::contact {

/// Obstacles that stand still or move on a path, as attributes of a component.
class Obstacles {
 public:
  void declare(DataTable& table);
  /// Throws ComponentError. `bodies_meet`: there is contact even without obstacles.
  void init(bool bodies_meet, const std::string& expected);
  void addTo(BarrierLaw& law) const;
  Vec3 pathAt(double t) const { return times_.empty() ? Vec3(Vec3::Zero()) : path_.at(t); }  ///< [m]
  /// The target set by hand, and the position it leads to [m].
  const Vec3& offset() const { return offset_; }
  Vec3 displacement(double t) const { return pathAt(t) + offset_; }
  /// The offset written in the scene, used at the start of a run and after a reset.
  const Vec3& startOffset() const { return start_offset_; }
  Vec3 startAt(double t) const { return pathAt(t) + start_offset_; }
  /// Moves from the position set by hand by up to `most` [m] towards the offset.
  Vec3 ledFrom(const Vec3& there, double most) const {
    const Vec3 left = offset_ - there;
    return left.norm() > most ? Vec3(there + most * left.normalized()) : offset_;
  }

 private:
  void check() const;
  LinkList<Topology> meshes_{"topology"};
  std::vector<double> planes_, spheres_, capsules_, cylinders_, boxes_, times_;
  std::vector<Vec3> movements_;
  Vec3 offset_ = Vec3::Zero(), start_offset_ = Vec3::Zero();
  KeyTimes<Vec3> path_;
};

/// The obstacles of a law at their written positions, for drawing.
void addShapes(const BarrierLaw& law, std::vector<DrawnObstacles::Shape>& shapes);

/// A position, as the values name_x, name_y and name_z.
void serializePlace(Archive& archive, const std::string& name, Vec3& place);

/// The largest speed of obstacles in explicit steps [m/s]: a barrier stops bodies a few times faster. It follows from the stiffness
/// and the density of the bodies; thin bodies are treated as sheets of the thickness contactDistance.
double fastestLead(const BarrierLaw& law, const std::vector<State*>& bodies);

/// Throws ComponentError if surfaces of the component at `path` intersect at x, or are closer than their thickness, listing the
/// worst places. `name` describes a vertex. Afterwards pairs are known for motion up to `margin`; 0: contactDistance.
void refuseOverlap(const std::string& path, const BarrierLaw& law, const std::vector<Vec3>& x,
                   const std::function<std::string(int)>& name, double margin = 0);

/// The worst pushing pair without a positive gap or finite force at x: "node 3 of /dofs and node 4 of /dofs: a gap of -0.1 m"; or
/// empty. Changes only its own copy of `law`.
std::string describeWorst(const BarrierLaw& law, const std::vector<Vec3>& x, const std::function<std::string(int)>& name);

/// "the edge from A to B goes 0.1 m through the triangle at C"
std::string describe(const Candidates::Crossing& crossing, const Surfaces& surfaces,
                     const std::function<std::string(int)>& name);

}  // namespace stroma::contact
