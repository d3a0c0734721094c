// SPDX-License-Identifier: LGPL-2.1-or-later
// Surfaces of bodies, for a CollisionPipeline that watches whether they come near each other. They exert no force.
//
// PointCollisionModel: the nodes of the state. LineCollisionModel: the edges of the mesh. TriangleCollisionModel: its
// triangles, its quads as two triangles each, else the boundary of its volume cells. SphereCollisionModel: a sphere around
// each node, radius for all or listRadius for each.
//
// Two models may meet when both are active, at least one of them is simulated, they are of different nodes (or of one
// with selfCollision on both), and have no number of `group` in common. contactDistance adds to that of the pipeline's
// method.
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <CollisionPipeline/>
//   <MinProximityIntersection contactDistance="0.05"/>
//   <EulerExplicitSolver/>
//   <Node name="ball">
//     <MechanicalObject position="0 1 0  0.5 1 0"/>
//     <UniformMass totalMass="1"/>
//     <MeshSpringForceField topology="@edges" stiffness="100"/>
//     <EdgeSetTopologyContainer name="edges" position="0 1 0  0.5 1 0" edges="0 1"/>
//     <SphereCollisionModel radius="0.1"/>
//     <LineCollisionModel/>
//     <PointCollisionModel/>
//   </Node>
//   <Node name="floor">
//     <MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <FixedProjectiveConstraint fixAll="true"/>
//     <TriangleCollisionModel simulated="false" moving="false"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/collision/collision_model.h"
#include "framework/mesh/cell_faces.h"
#include "framework/scene/factory.h"

namespace stroma::collision {

void CollisionModel::declare(DataTable& table) {
  table.addLink("mstate", mstate_).help("state whose nodes move the surface; that of this node or above when not given");
  topology_.declare(table, "mesh of the surface");
  table.add("active", active_).help("false: it meets nothing");
  table.add("moving", moving_).help("SOFA's; whether it moves by itself");
  table.add("simulated", simulated_).help("false: an obstacle, which meets no other one");
  table.add("selfCollision", self_collision_).help("it may meet the other models of its node");
  table.add("contactDistance", contact_distance_).alias("proximity").help("added to that of the method").unit("m").min(0);
  table.add("group", groups_).help("models with a number in common do not meet");
  table.add("bothSide", both_sides_).help("SOFA's; surfaces here have two sides");
  table.add("contactStiffness", stiffness_).help("of contact forces, which there are none of").unit("N/m").min(0);
  table.add("contactFriction", friction_).help("of contact forces, which there are none of").unit("-").min(0);
  table.add("contactRestitution", restitution_).help("of contact forces, which there are none of").unit("-").min(0);
  for (const char* name : {"color", "filename", "computeNormals", "displayContactNormals", "LineActiverPath",
                           "PointActiverPath", "minProximity", "fileSphere"})
    table.addVisualOnly(name);
}

void CollisionModel::init() {
  state_ = mstate_.get() ? mstate_.get() : find<State>(true);
  if (!state_) throw ComponentError("no state moves this surface", "a state in this node or above");
  parts_.clear();
  makeParts(parts_);
  for (const Part& part : parts_)
    for (int i = 0; i < part.corners; ++i)
      if (part.node[std::size_t(i)] < 0 || part.node[std::size_t(i)] >= state_->nodes())
        throw ComponentError(fmt::format("the mesh names node {}, and {} has {}", part.node[std::size_t(i)],
                                         state_->path(), state_->nodes()),
                             "a mesh of the nodes of the state");
}

const Mesh* CollisionModel::mesh() const {
  const Topology* topology = topology_.find(*this, *state_, MeshNodes::first);
  return topology ? &topology->mesh() : nullptr;
}

std::span<const Vec3> CollisionModel::corners(const Part& part, std::array<Vec3, 3>& out) const {
  for (int i = 0; i < part.corners; ++i) {
    const Index node = part.node[std::size_t(i)] * state_->rows_per_node;  // of a frame its centre
    out[std::size_t(i)] = state_->isBound() ? Vec3(state_->x()[node]) : state_->position[std::size_t(node)];
  }
  return {out.data(), std::size_t(part.corners)};
}

bool CollisionModel::mayMeet(const CollisionModel& a, const CollisionModel& b) {
  if (!a.active_ || !b.active_ || (!a.simulated_ && !b.simulated_)) return false;
  if (&a.node() == &b.node() && !(a.self_collision_ && b.self_collision_)) return false;
  return std::none_of(a.groups_.begin(), a.groups_.end(), [&b](int group) {
    return std::find(b.groups_.begin(), b.groups_.end(), group) != b.groups_.end();
  });
}

namespace {

class Points final : public CollisionModel {
 public:
  Kind kind() const override { return Kind::point; }
  void makeParts(std::vector<Part>& parts) override {
    for (Index node = 0; node < state().nodes(); ++node) parts.push_back({{node, -1, -1}, 1, 0});
  }
};

class Lines final : public CollisionModel {
 public:
  Kind kind() const override { return Kind::line; }
  void makeParts(std::vector<Part>& parts) override {
    if (const Mesh* found = mesh())
      for (const Edge& edge : found->edges.empty() ? found->allEdges() : found->edges)
        parts.push_back({{edge[0], edge[1], -1}, 2, 0});
  }
};

class Triangles final : public CollisionModel {
 public:
  Kind kind() const override { return Kind::triangle; }
  void makeParts(std::vector<Part>& parts) override {
    const Mesh* found = mesh();
    if (!found) return;
    const bool has_faces = !found->triangles.empty() || !found->quads.empty();
    for (const Triangle& t : has_faces ? found->triangles : found->boundaryTriangles()) parts.push_back({t, 3, 0});
    for (const Quad& q : has_faces ? found->quads : found->boundaryQuads()) {
      parts.push_back({{q[0], q[1], q[2]}, 3, 0});
      parts.push_back({{q[0], q[2], q[3]}, 3, 0});
    }
  }
};

class Spheres final : public CollisionModel {
 public:
  void declare(DataTable& table) override {
    CollisionModel::declare(table);
    table.add("radius", radius_).alias("defaultRadius").help("of each sphere").unit("m").min(0);
    table.add("listRadius", radii_).help("of each sphere, one for each node; radius when not given").unit("m").min(0);
  }
  Kind kind() const override { return Kind::sphere; }
  void makeParts(std::vector<Part>& parts) override {
    for (Index node = 0; node < state().nodes(); ++node)
      parts.push_back({{node, -1, -1}, 1, std::size_t(node) < radii_.size() ? radii_[std::size_t(node)] : radius_});
  }

 private:
  double radius_ = 1;
  std::vector<double> radii_;
};

}  // namespace
}  // namespace stroma::collision

STROMA_COMPONENT(collision_models) {
  using namespace stroma::collision;
  factory.add<Points>("PointCollisionModel", "the nodes of a body, where contact is watched for");
  factory.add<Lines>("LineCollisionModel", "the edges of a body, where contact is watched for");
  factory.add<Triangles>("TriangleCollisionModel", "the surface of a body, where contact is watched for");
  factory.add<Spheres>("SphereCollisionModel", "spheres around nodes, where contact is watched for");
}
