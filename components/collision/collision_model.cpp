// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/collision_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "components/collision/distances.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma::collision {

void CollisionModel::declare(DataTable& table) {
  table.addLink("mstate", mstate_).help("state whose nodes move the surface; that of this node or above by default");
  topology_.declare(table, "mesh of the surface");
  table.add("active", active_).help("false: it has no contacts");
  table.add("moving", moving_).help("SOFA's; without effect: whether it moves is known");
  table.add("simulated", simulated_).help("false: an obstacle, which meets no other one");
  table.add("selfCollision", self_collision_).help("it may meet the other models of its node");
  table.add("contactDistance", contact_distance_).alias("proximity").help("added to that of the method").unit("m").min(0);
  table.add("group", groups_).help("models with a number in common do not meet");
  table.add("contactResponse", response_)
      .help("response to its contacts, overriding the CollisionResponse; that one is used where the other model has a different one");
  table.add("bothSide", both_sides_).help("a LocalMinDistance keeps the contacts of its back; other methods know no sides");
  table.add("contactStiffness", stiffness_)
      .help("the stiffness of a contact is the product of both models' over its contact distance")
      .min(0);
  table.add("contactFriction", friction_).help("SOFA's; penalty forces have no friction").unit("-").min(0);
  table.add("contactRestitution", restitution_).help("SOFA's; without effect there too").unit("-").min(0);
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
  shareOut();
}

void CollisionModel::shareOut() {
  std::vector<bool> has(std::size_t(state_->nodes()), false);
  std::set<Edge> edges;
  for (Part& part : parts_)
    for (int i = 0; i < part.corners; ++i) {
      const Index node = part.node[std::size_t(i)], next = part.node[std::size_t((i + 1) % part.corners)];
      if (!has[std::size_t(node)]) part.owned |= 1u << i;
      has[std::size_t(node)] = true;
      if (part.corners == 3 && edges.insert({std::min(node, next), std::max(node, next)}).second) part.owned_edges |= 1u << i;
    }
}

void CollisionModel::addSolids(std::vector<const State*>& bodies, std::vector<Sphere>& spheres) const {
  if (!active_) return;
  bodies.push_back(state_);
  if (kind() != Kind::sphere) return;
  for (const Part& part : parts_) spheres.push_back({state_, part.node[0], part.radius});
}

bool CollisionModel::isMoved() const {
  for (const Node* at = &state_->node(); at; at = at->parent())
    for (const auto& component : at->components())
      if (dynamic_cast<const Integrator*>(component.get())) return true;
  return false;
}

double CollisionModel::restDistance(const Part& p, const Part& q) const {
  const auto placesOf = [this](const Part& part, std::array<Vec3, 3>& out) {
    for (int i = 0; i < part.corners; ++i)
      out[std::size_t(i)] = state_->rest_position[std::size_t(part.node[std::size_t(i)] * state_->rows_per_node)];
    return std::span<const Vec3>(out.data(), std::size_t(part.corners));
  };
  std::array<Vec3, 3> a, b;
  return distanceOf(placesOf(p, a), placesOf(q, b)) - p.radius - q.radius;
}

const Mesh* CollisionModel::mesh() const {
  const Topology* topology = topology_.find(*this, *state_, MeshNodes::first);
  if (!topology && active_) throw ComponentError("there is no mesh for this surface", "a topology in this node or above");
  return topology ? &topology->mesh() : nullptr;
}

std::vector<Triangle> CollisionModel::faces() const {
  const Mesh* found = mesh();
  if (!found) return {};
  const bool has_faces = !found->triangles.empty() || !found->quads.empty();
  std::vector<Triangle> faces = has_faces ? found->triangles : found->boundaryTriangles();
  for (const Quad& q : has_faces ? found->quads : found->boundaryQuads()) {
    faces.push_back({q[0], q[1], q[2]});
    faces.push_back({q[0], q[2], q[3]});
  }
  return faces;
}

std::vector<Edge> CollisionModel::edges() const {
  const Mesh* found = mesh();
  if (!found) return {};
  return found->edges.empty() ? found->allEdges() : found->edges;
}

Vec3 CollisionModel::place(Index node) const {
  const Index row = node * state_->rows_per_node;
  return state_->isBound() ? Vec3(state_->x()[row]) : state_->position[std::size_t(row)];
}

Vec3 CollisionModel::wayOf(Index at) const {
  const Index row = at * state_->rows_per_node;
  return node().root().dt() * (state_->isBound() ? Vec3(state_->v()[row]) : state_->velocity[std::size_t(row)]);
}

std::span<const Vec3> CollisionModel::corners(const Part& part, std::array<Vec3, 3>& out) const {
  for (int i = 0; i < part.corners; ++i) out[std::size_t(i)] = place(part.node[std::size_t(i)]);
  return {out.data(), std::size_t(part.corners)};
}

Box CollisionModel::boxOf(const Part& part, double grown) const {
  std::array<Vec3, 3> places;
  Box box;
  for (const Vec3& corner : corners(part, places)) box.add(corner);
  return box.grownBy(part.radius + grown);
}

void CollisionModel::boxParts(std::vector<Box>& boxes, double grown) const {
  boxes.resize(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) boxes[i] = boxOf(parts_[i], grown);
}

bool CollisionModel::isInGroup(int number) const { return std::find(groups_.begin(), groups_.end(), number) != groups_.end(); }

bool CollisionModel::mayMeet(const CollisionModel& a, const CollisionModel& b) {
  if (!a.active_ || !b.active_ || (!a.simulated_ && !b.simulated_)) return false;
  if (&a.node() == &b.node() && !(a.self_collision_ && b.self_collision_)) return false;
  return std::none_of(a.groups_.begin(), a.groups_.end(), [&b](int group) { return b.isInGroup(group); });
}

}  // namespace stroma::collision
