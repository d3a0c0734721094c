// SPDX-License-Identifier: LGPL-2.1-or-later
// The states of meshes that topological mappings made.
//
// Mesh2PointMechanicalMapping: points on the nodes and cells of a mesh, as Mesh2PointTopologicalMapping makes them.
//   x_c = sum w x_p + offset,   v_c = sum w v_p,   f_p += w f_c
//   The topological mapping is the one of the node, or topologicalMapping.
//
// TubularMapping: circles around rigid frames, as Edge2QuadTopologicalMapping makes them.
//   x = c_i + q_i p_j,   p_j = r_i (0, cos(2 pi j/N), sin(2 pi j/N)),   N = nbPointsOnEachCircle,   j < N
//   r_i is `radius`. With peak = n it grows from 0 over the first n frames, r_i = radius i/n; with peak = -n it falls to 0 over
//   the last n.
//
// A state without positions gets as many nodes as follow.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="200" tolerance="1e-12"/>
//   <Node name="cloth">
//     <MeshTopology name="net" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <TriangularFEMForceField youngModulus="1000" poissonRatio="0.3" thickness="0.01"/>
//     <FixedProjectiveConstraint indices="0 1"/>
//     <Node name="middles">
//       <Mesh2PointTopologicalMapping input="@../net" triangleBaryCoords="0.3 0.3 0"/>
//       <MechanicalObject/>
//       <Mesh2PointMechanicalMapping/>
//       <ConstantForceField totalForce="0 0 0.1"/>
//     </Node>
//   </Node>
//   <Node name="rod">
//     <MechanicalObject template="Rigid3" position="0 0 2 0 0 0 1  1 0 2 0 0 0 1"/>
//     <UniformMass totalMass="2" inertia="0.1 0.1 0.1"/>
//     <FixedProjectiveConstraint indices="0"/>
//     <Node name="tube">
//       <MechanicalObject size="12"/>
//       <TubularMapping nbPointsOnEachCircle="6" radius="0.1" peak="1"/>
//       <RestShapeSpringsForceField points="6" stiffness="100"/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <numbers>

#include "components/mappings/frame_mapping.h"
#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A state of points of which a scene says neither places nor how many there are gets `count` nodes.
void giveNodes(State& child, std::size_t count) {
  for (const char* name : {"position", "rest_position", "size"})
    if (const Data* data = child.data().find(name); data && data->isSet()) return;
  if (!child.hasPointsOnly() || std::size_t(child.nodes()) == count || firstTopology(child, false)) return;
  child.position.assign(count, Vec3::Zero()), child.rest_position.assign(count, Vec3::Zero());
  child.velocity.assign(count, Vec3::Zero());
}

void requireNodes(const State& child, std::size_t count) {
  if (!child.hasPointsOnly())
    throw ComponentError(fmt::format("the nodes of {} are no points", child.path()), "a state of template Vec3");
  if (std::size_t(child.nodes()) != count)
    throw ComponentError(fmt::format("{} has {} nodes, and {} are carried", child.path(), child.nodes(), count), "as many of each");
}

class Mesh2PointMechanical final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.addLink("topologicalMapping", points_).help("what made the points; the one of this node by default");
  }

  void init() override {
    WeightedMapping::init();
    Component& maker = findMaker();
    const auto& nodes = listOf<std::vector<int>>(maker, "pointNodes");
    const auto& ends = listOf<std::vector<int>>(maker, "pointEnds");
    const auto& weights = listOf<std::vector<double>>(maker, "pointWeights");
    offsets_ = listOf<std::vector<Vec3>>(maker, "pointOffsets");
    giveNodes(output(), ends.size());
    requireNodes(output(), ends.size());
    std::size_t k = 0;
    for (const int end : ends) {
      std::vector<Weight> sum;
      for (; k < std::size_t(end); ++k) {
        if (nodes[k] >= input().nodes())
          throw ComponentError(
              fmt::format("{} takes node {}, and {} has {}", maker.path(), nodes[k], input().path(), input().nodes()),
              "the state of the mesh that it takes points of");
        sum.push_back({Index(nodes[k]) * input().rows_per_node, weights[k], 0});
      }
      addNode(sum);
    }
  }

  void apply(Rows x) const override {
    WeightedMapping::apply(x);
    for (std::size_t i = 0; i < offsets_.size(); ++i) x[output().firstRow() + Index(i)] += offsets_[i];
  }
  void applyJ(Rows v) const override { WeightedMapping::apply(v); }

 private:
  Component& findMaker() const {
    if (points_.get()) return *points_.get();
    for (const auto& each : node().components())
      if (each->data().find("pointEnds")) return each->ensureReady(), *each;
    throw ComponentError("there is no Mesh2PointTopologicalMapping in this node", "topologicalMapping=\"@path\"");
  }
  template <class List>
  static const List& listOf(const Component& maker, const char* name) {
    const Data* data = maker.data().find(name);
    List* const* list = data ? std::get_if<List*>(&data->pointer()) : nullptr;
    if (!list) throw ComponentError(maker.path() + " makes no points", "a Mesh2PointTopologicalMapping");
    return **list;
  }

  Link<Topology> points_{"topological mapping"};
  std::vector<Vec3> offsets_;  ///< [m], shape (points)
};

class TubularMapping final : public FrameMapping {
 public:
  void declare(DataTable& table) override {
    FrameMapping::declare(table);
    table.add("nbPointsOnEachCircle", around_).help("points around each frame").min(1).required();
    table.add("radius", radius_).help("of the circles").unit("m").min(0, false).required();
    table.add("peak", peak_).help("over how many frames the radius grows from 0, or, negative, falls to 0 at the end");
  }

  void init() override {
    FrameMapping::init();
    start();
    const Index count = input().nodes();
    giveNodes(output(), std::size_t(count * around_));
    requireNodes(output(), std::size_t(count * around_));
    for (Index i = 0; i < count; ++i) {
      const int from_end = peak_ > 0 ? int(i) : int(count - 1 - i), length = std::abs(peak_);
      const double radius = from_end < length ? radius_ * from_end / length : radius_;
      for (int j = 0; j < around_; ++j) {
        const double angle = 2 * std::numbers::pi * j / around_;
        addPoint({{i, 1, radius * Vec3(0, std::cos(angle), std::sin(angle))}});
      }
    }
    placeChild(true);
  }

 private:
  int around_ = 8, peak_ = 0;
  double radius_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(point_and_tube_mappings) {
  factory.add<stroma::Mesh2PointMechanical>("Mesh2PointMechanicalMapping", "points on the nodes and cells of a mesh");
  factory.add<stroma::TubularMapping>("TubularMapping", "circles around rigid frames");
}
