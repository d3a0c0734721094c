// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/drawn_segments.h"
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
  Vec3 pathAt(double t) const { return times_.empty() ? Vec3(Vec3::Zero()) : path_.at(t); }  ///< [m]
  /// What a hand has set, and where it leads [m].
  const Vec3& offset() const { return offset_; }
  Vec3 displacement(double t) const { return pathAt(t) + offset_; }
  /// The offset that the scene was written with, where a run starts, also after a reset.
  const Vec3& startOffset() const { return start_offset_; }
  Vec3 startAt(double t) const { return pathAt(t) + start_offset_; }
  /// From where a hand has led them, by `most` [m] towards the offset.
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

/// The obstacles of a law where they are written, for who draws them.
void addShapes(const BarrierLaw& law, std::vector<DrawnObstacles::Shape>& shapes);

/// A place, as the values name_x, name_y and name_z.
void serializePlace(Archive& archive, const std::string& name, Vec3& place);

/// The fastest that obstacles may be led in explicit steps [m/s]: a barrier stops what is a few times faster. Between it and the speed of
/// sound stands the density of the bodies, which is that of sheets as thick as contactDistance where they enclose less.
double fastestLead(const BarrierLaw& law, const std::vector<State*>& bodies);

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
