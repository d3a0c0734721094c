// SPDX-License-Identifier: LGPL-2.1-or-later
// Edge2QuadTopologicalMapping: a tube of quads around edges between rigid frames, for TubularMapping to carry.
//
//   node i N + j = c_i + R_i (radius Y cos(2 pi j/N) + Z sin(2 pi j/N) radius'),   N = nbPointsOnEachCircle
//   quad j of edge (a, b): a N + j, b N + j, b N + j + 1, a N + j + 1 (counted round)
//
// c_i and R_i are centre and orientation of frame i where the scene starts: the frames of the state beside the input. Y and Z
// are its axes y and z, and radius' is radius. With radiusFocal the circles are ellipses: Z is focalAxis, Y = Z x (1 0 0), and
// radius' is radiusFocal. edgeList takes some of the edges. flipNormals turns the quads the other way.
//
// Source: names, attributes, node and quad order are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="200" tolerance="1e-12"/>
//   <MeshTopology name="line" edges="0 1  1 2"/>
//   <MechanicalObject name="frames" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1"/>
//   <UniformMass totalMass="3" inertia="0.1 0.1 0.1"/>
//   <BeamFEMForceField youngModulus="1e6" poissonRatio="0.3" radius="0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="tube">
//     <QuadSetTopologyContainer name="quads"/>
//     <Edge2QuadTopologicalMapping nbPointsOnEachCircle="6" radius="0.1" input="@../line" output="@quads"/>
//     <MechanicalObject/>
//     <TubularMapping nbPointsOnEachCircle="6" radius="0.1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "framework/mechanics/frames.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class Edge2Quad final : public TopologicalMapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("topology of the edges").required();
    table.addLink("output", output_).help("container to fill; without it the mapping is a topology itself");
    table.add("nbPointsOnEachCircle", around_).help("nodes of each circle").min(3).required();
    table.add("radius", radius_).help("of the circles").unit("m").min(0, false);
    table.add("radiusFocal", focal_).help("of ellipses along focalAxis; 0: circles").unit("m").min(0);
    table.add("focalAxis", axis_).help("axis of ellipses, in the axes of the frames").unit("-");
    table.add("edgeList", chosen_).help("which edges; all by default");
    table.add("flipNormals", flip_).help("turn the quads the other way");
    table.add("position", mesh_.position).alias("points").help("nodes").unit("m").output();
    addCellList(table, cell_kinds::quad, mesh_.quads).help("the quads").output();
  }

  void init() override {
    const Topology* source = input_.get();
    if (!source) throw ComponentError("there is no topology of edges", "input=\"@...\"");
    if (!data().find("radius")->isSet() && !(focal_ > 0)) throw ComponentError("there is no radius", "radius=\"...\"");
    const State* frames = source->node().find<State>(nullptr, false);
    if (!frames || !frames->hasFrames())
      throw ComponentError(fmt::format("beside {} there are no rigid frames", source->path()), "a state of template Rigid3 there");
    placeNodes(*frames);
    const Mesh& mesh = source->mesh();
    addQuads(mesh.edges.empty() ? mesh.allEdges() : mesh.edges, frames->nodes());
  }

 private:
  void placeNodes(const State& frames) {
    Vec3 y = Vec3::UnitY() * radius_, z = Vec3::UnitZ() * radius_;
    if (focal_ > 0) {
      if (!(axis_.norm() > 0)) throw ComponentError("focalAxis is zero", "a vector that is not zero");
      z = axis_.normalized();
      y = radius_ * z.cross(Vec3::UnitX());
      z *= focal_;
    }
    mesh_ = Mesh();
    for (Index i = 0; i < frames.nodes(); ++i) {
      const Quaternion turn = turnedBy(frames.position[std::size_t(2 * i + 1)]);
      for (int j = 0; j < around_; ++j) {
        const double angle = 2 * std::numbers::pi * j / around_;
        mesh_.position.push_back(frames.position[std::size_t(2 * i)] + turn * Vec3(std::cos(angle) * y + std::sin(angle) * z));
      }
    }
  }
  void addQuads(const std::vector<Edge>& edges, Index frames) {
    std::vector<int> which = chosen_;
    if (!data().find("edgeList")->isSet()) which.resize(edges.size()), std::iota(which.begin(), which.end(), 0);
    if (which.empty()) throw ComponentError("there is no edge to make a tube of", "edges, or an edgeList that is not empty");
    for (const int e : which) {
      if (e < 0 || std::size_t(e) >= edges.size())
        throw ComponentError(fmt::format("edgeList names {}, and there are {} edges", e, edges.size()));
      const auto [a, b] = edges[std::size_t(e)];
      if (a >= frames || b >= frames) throw ComponentError(fmt::format("edge {} joins frame {} of {}", e, std::max(a, b), frames));
      for (Index j = 0; j < around_; ++j) {
        const Index next = (j + 1) % around_;
        Quad quad{a * around_ + j, b * around_ + j, b * around_ + next, a * around_ + next};
        if (flip_) std::reverse(quad.begin(), quad.end());
        mesh_.quads.push_back(quad);
      }
    }
  }

  int around_ = 8;
  double radius_ = 1, focal_ = 0;
  Vec3 axis_ = Vec3::UnitZ();
  std::vector<int> chosen_;
  bool flip_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(edge2quad_topological_mapping) {
  factory.add<stroma::Edge2Quad>("Edge2QuadTopologicalMapping", "a tube of quads around the edges between rigid frames");
}
