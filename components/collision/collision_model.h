// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "framework/collision/box_tree.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/state.h"
#include "framework/mechanics/state_topology.h"

namespace stroma::collision {

/// A part of a surface: one, two or three nodes of the model's state, and a radius [m].
struct Part {
  std::array<Index, 3> node{-1, -1, -1};
  int corners = 0;
  double radius = 0;
  unsigned owned = 0;        ///< bits: each node belongs to a corner of one part
  unsigned owned_edges = 0;  ///< the same of edges, from a corner to the next
  bool of_quad = false;      ///< half of one
};

/// The surface of a body as collision detection sees it: its parts, and what they may collide with.
class CollisionModel : public Component, public DrawnSolids {
 public:
  std::string roleText() const override { return "collision model"; }
  void declare(DataTable& table) override;
  void init() override;
  void addSolids(std::vector<const State*>& bodies, std::vector<Sphere>& spheres) const override;

  enum class Kind { point, line, triangle, sphere };
  virtual Kind kind() const = 0;
  const std::vector<Part>& parts() const { return parts_; }
  /// Writes the current positions of the corners of a part to `out`; returns their number.
  std::span<const Vec3> corners(const Part& part, std::array<Vec3, 3>& out) const;
  Box boxOf(const Part& part, double grown = 0) const;  ///< of now, with its radius; grown by a distance [m]
  /// The boxes of all parts, in their order.
  void boxParts(std::vector<Box>& boxes, double grown = 0) const;
  Vec3 place(Index node) const;          ///< [m], of a node now; of a frame its centre
  Vec3 wayOf(Index node) const;          ///< in a step at its velocity [m]
  std::vector<Triangle> faces() const;   ///< of its mesh: triangles, and quads as two; else the boundary of volume cells
  std::vector<Edge> edges() const;       ///< of its mesh
  bool hasTwoSides() const { return both_sides_; }
  double restDistance(const Part& p, const Part& q) const;  ///< [m], radii taken off
  double contactDistance() const { return contact_distance_; }
  double contactStiffness() const { return stiffness_; }
  bool isInGroup(int number) const;
  const std::string& response() const { return response_; }  ///< empty: that of the scene
  State& state() const { return *state_; }
  const Topology* topology() const { return topology_.find(*this, *state_, MeshNodes::first); }  ///< null: there is none
  bool isActive() const { return active_; }
  /// Its state moves.
  bool isMoved() const;
  bool isMoving() const { return moving_; }  ///< it may be placed elsewhere, also by a program
  bool isSimulated() const { return simulated_; }
  /// Whether the two may collide at all, wherever they are.
  static bool mayMeet(const CollisionModel& a, const CollisionModel& b);

 protected:
  virtual void makeParts(std::vector<Part>& parts) = 0;
  /// The mesh of the model; null if it has none and is inactive. Throws ComponentError if it has none and is active.
  const Mesh* mesh() const;

 private:
  void shareOut();

  Link<State> mstate_{"mechanical state"};
  TopologyLink topology_;
  State* state_ = nullptr;
  std::vector<Part> parts_;
  bool active_ = true, moving_ = true, simulated_ = true, self_collision_ = false, both_sides_ = false;
  double contact_distance_ = 0, stiffness_ = 10, friction_ = 0, restitution_ = 0;
  std::vector<int> groups_;
  std::string response_;
};

}  // namespace stroma::collision
