// SPDX-License-Identifier: LGPL-2.1-or-later
// SurfacePressureConstraint: a closed surface, such as the cavity of an actuator, under a pressure or with a given volume.
//
//   V(x) = 1/6 sum over triangles (a, b, c) of (a - o) . ((b - o) x (c - o)),   o any point;
//     of a quad the mean of its two cuts in triangles, the volume below its bilinear surface
//   valueType volumeGrowth: V = V_0 + value, and p is what that takes, between minPressure and maxPressure where they are given
//   valueType pressure:     p = value, while minVolumeGrowth <= V - V_0 <= maxVolumeGrowth where they are given
//
// The force is p dV/dx: each triangle has p times its area along its normal, a third on each corner, and each quad the force
// from its bilinear functions, independent of its first corner. Normals point out of the inflated cavity; flipNormal reverses
// them. `pressure` and `volumeGrowth` have both after a step. They do not depend on the time step. An open surface has no
// volume: it can only have a pressure.
//
// Source: the names and attributes are those of SOFA's plugin SoftRobots, where pressures are p times the time step.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="4"/>
//   <RestShapeSpringsForceField stiffness="100"/>
//   <SurfacePressureConstraint triangles="0 2 1  0 1 3  0 3 2  1 2 3" valueType="pressure" value="10"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>

#include "components/lagrangian/actuator.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class SurfacePressure final : public Actuator {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.find("forces")->help("the pressure in the last step").unit("Pa");
    topology_.declare(table, "mesh with the triangles and quads of the surface");
    table.add("triangles", triangles_).help("of the surface; with quads those of the mesh when neither is given");
    table.add("quads", quads_).help("of the surface, each bilinear");
    declareValue(table, "volumeGrowth", "pressure", false, "pressure [Pa] or growth of the volume since the start [m^3]");
    table.add("flipNormal", flip_).help("normals point the other way");
    table.add("minPressure", least_pressure_).recompiled().help("least pressure; without it, none").unit("Pa");
    table.add("maxPressure", most_pressure_).recompiled().help("largest pressure; without it, none").unit("Pa");
    table.add("minVolumeGrowth", least_growth_).recompiled().help("least growth; without it, none").unit("m^3");
    table.add("maxVolumeGrowth", most_growth_).recompiled().help("largest growth; without it, none").unit("m^3");
    table.add("maxPressureVariation", pressure_change_)
        .recompiled()
        .help("largest change of the imposed pressure in a step; without it, none")
        .unit("Pa")
        .min(0);
    table.add("maxVolumeGrowthVariation", growth_change_)
        .recompiled()
        .help("largest change of the imposed growth in a step; without it, none")
        .unit("m^3")
        .min(0);
    table.add("pressure", told_force_).help("of the last step").unit("Pa").output();
    table.add("initialCavityVolume", start_).help("volume at the start").unit("m^3").output();
    table.add("cavityVolume", volume_).help("volume after the last step").unit("m^3").output();
    table.add("volumeGrowth", way_).help("growth of the volume since the start").unit("m^3").output();
    for (const char* name : {"drawPressure", "drawScale", "visualization", "showVisuScale"}) table.addVisualOnly(name);
  }
  void init() override {
    Actuator::init();
    setFaces(triangles_, quads_);
    if (faces_.empty())
      if (const Topology* topology = topology_.find(*this, first())) setFaces(topology->mesh().triangles, topology->mesh().quads);
    if (faces_.empty()) throw ComponentError("the surface has no triangle", "triangles or quads, or a mesh that has some");
    for (const Triangle& t : faces_)
      for (const Index node : t) checkNode(first(), node, "the surface");
    bound({written("minVolumeGrowth", least_growth_, -infinity), written("maxVolumeGrowth", most_growth_, infinity),
           written("maxVolumeGrowthVariation", growth_change_, infinity)},
          {written("minPressure", least_pressure_, -infinity), written("maxPressure", most_pressure_, infinity),
           written("maxPressureVariation", pressure_change_, infinity)});
    const bool needs_volume =
        !imposesForce() || data().find("minVolumeGrowth")->isSet() || data().find("maxVolumeGrowth")->isSet();
    if (needs_volume) checkClosed();
  }
  void takeForces(std::span<const double> forces) override {
    Actuator::takeForces(forces);
    volume_ = start_ + way_;
  }
  void serialize(Archive& archive) override {
    Actuator::serialize(archive);
    archive.value("volume", volume_);
  }

 protected:
  double measure(ConstRows x) const override {
    const Vec3 o = placeOf(x, faces_.front()[0]);
    double sum = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const Triangle& t = faces_[f];
      sum += weightOf(f) * (placeOf(x, t[0]) - o).dot((placeOf(x, t[1]) - o).cross(placeOf(x, t[2]) - o));
    }
    return (flip_ ? -1 : 1) * sum / 6;
  }
  void addGradient(ConstRows x, double sign, LagrangianRows& rows) const override {
    const double share = sign * (flip_ ? -1 : 1) / 6;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const Triangle& t = faces_[f];
      const Vec3 a = placeOf(x, t[0]);
      const Vec3 third = share * weightOf(f) * (placeOf(x, t[1]) - a).cross(placeOf(x, t[2]) - a);
      for (const Index node : t) rows.add(rowOf(first(), node), third);
    }
  }

 private:
  Vec3 placeOf(ConstRows x, Index node) const { return x[rowOf(first(), node)]; }
  double weightOf(std::size_t face) const { return face < whole_ ? 1 : 0.5; }
  void setFaces(const std::vector<Triangle>& triangles, const std::vector<Quad>& quads) {
    faces_ = triangles, whole_ = triangles.size();
    for (const Quad& q : quads)
      for (std::size_t i = 0; i < 4; ++i) faces_.push_back({q[i], q[(i + 1) % 4], q[(i + 2) % 4]});
  }

  /// Throws ComponentError unless each edge is passed as often in the one direction as in the other. Where it is not, nodes at
  /// one place count as one: the surface may have been read triangle by triangle.
  void checkClosed() const {
    if (!openEdge([](Index node) { return node; })) return;
    std::map<std::array<double, 3>, Index> nodes;
    const auto edge = openEdge([&](Index node) {
      const Vec3& p = first().position[std::size_t(node)];
      return nodes.emplace(std::array{p.x(), p.y(), p.z()}, node).first->second;
    });
    if (edge)
      throw ComponentError(fmt::format("the surface has no volume: at the edge of nodes {} and {} a triangle has no "
                                       "neighbour, or one that is turned the other way",
                                       (*edge)[0], (*edge)[1]),
                           "a closed surface, whose triangles all turn the same way");
  }
  template <class NodeAt>
  std::optional<std::array<Index, 2>> openEdge(NodeAt&& node_at) const {
    std::map<std::array<Index, 2>, int> passes;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i) {
        const Index a = node_at(faces_[f][i]), b = node_at(faces_[f][(i + 1) % 3]);
        if (a != b) passes[{std::min(a, b), std::max(a, b)}] += (f < whole_ ? 2 : 1) * (a < b ? 1 : -1);
      }
    for (const auto& [edge, sum] : passes)
      if (sum != 0) return edge;
    return {};
  }

  TopologyLink topology_;
  std::vector<Triangle> triangles_, faces_;  ///< of faces_ those of quads, both cuts of each, come last and count half
  std::vector<Quad> quads_;
  std::size_t whole_ = 0;  ///< faces that count as one
  bool flip_ = false;
  double least_pressure_ = 0, most_pressure_ = 0, least_growth_ = 0, most_growth_ = 0, pressure_change_ = 0, growth_change_ = 0;
  double volume_ = 0;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(surface_pressure_constraint) {
  factory.add<stroma::lagrangian::SurfacePressure>("SurfacePressureConstraint",
                                                   "a cavity under pressure, or of a given volume");
}
