// SPDX-License-Identifier: LGPL-2.1-or-later
// SurfacePressureConstraint: a closed surface, such as the cavity of an actuator, under a pressure or with a given volume.
//
//   V(x) = 1/6 sum over triangles (a, b, c) of a . (b x c)
//   valueType volumeGrowth: V = V_0 + value, and p is what that takes
//   valueType pressure:     p = value
//
// The force is p dV/dx, on each triangle p times its area along its normal. Normals point out of the cavity that is
// inflated; flipNormal turns them. `pressure` and `volumeGrowth` have both after a step. They do not depend on the time step.
//
// Source: the names and attributes are those of SOFA's plugin SoftRobots.
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

#include "components/lagrangian/pair_constraint.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class SurfacePressure final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    PairConstraint::declare(table);
    topology_.declare(table, "mesh with the triangles and quads of the surface");
    table.add("triangles", triangles_).help("of the surface; those of the mesh when not given");
    table.add("value", values_).atOnce().help("pressure [Pa] or growth of the volume [m^3]; of several the one of valueIndex");
    table.add("valueIndex", index_).help("which of value").min(0);
    table.add("valueType", type_).help("pressure, or volumeGrowth: the growth of the volume since the start");
    table.add("flipNormal", flip_).help("normals point the other way");
    table.add("pressure", pressure_).help("of the last step").unit("Pa").output();
    table.add("initialCavityVolume", start_volume_).help("volume at the start").unit("m^3").output();
    table.add("cavityVolume", volume_).help("volume after the last step").unit("m^3").output();
    table.add("volumeGrowth", growth_).help("growth of the volume since the start").unit("m^3").output();
    for (const char* name : {"drawPressure", "drawScale"}) table.addVisualOnly(name);
  }
  void init() override {
    PairConstraint::init();
    if (type_ != "pressure" && type_ != "volumeGrowth")
      throw ComponentError(fmt::format("valueType is {}", type_), "pressure or volumeGrowth");
    faces_ = triangles_;
    if (faces_.empty())
      if (const Topology* topology = topology_.find(*this, first())) {
        faces_ = topology->mesh().triangles;
        for (const Quad& q : topology->mesh().quads)
          faces_.push_back({q[0], q[1], q[2]}), faces_.push_back({q[0], q[2], q[3]});
      }
    if (faces_.empty()) throw ComponentError("the surface has no triangle", "triangles, or a mesh that has some");
    for (const Triangle& t : faces_)
      for (const Index node : t) checkNode(first(), node, "triangles");
    is_measured_ = false;
  }
  void constrainedStepBegins(ConstRows x, double) override {
    if (is_measured_) return;
    start_volume_ = volume_ = volumeAt(x);
    is_measured_ = true;
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const double value = index_ < int(values_.size()) ? values_[std::size_t(index_)] : 0;
    volume_ = volumeAt(x);
    if (type_ == "pressure")
      rows.begin(Kind::given, 0, value);
    else
      rows.begin(Kind::equal, volume_ - start_volume_ - value);
    for (const Triangle& t : faces_) {
      const Vec3 a = placeOf(x, t[0]), b = placeOf(x, t[1]), c = placeOf(x, t[2]);
      rows.add(rowOf(first(), t[0]), sign() / 6 * b.cross(c));
      rows.add(rowOf(first(), t[1]), sign() / 6 * c.cross(a));
      rows.add(rowOf(first(), t[2]), sign() / 6 * a.cross(b));
    }
  }
  void takeForces(std::span<const double> forces) override {
    PairConstraint::takeForces(forces);
    pressure_ = forces.empty() ? 0 : forces[0];
    growth_ = volume_ - start_volume_;
  }
  void reset() override {
    PairConstraint::reset();
    is_measured_ = false;
  }
  void serialize(Archive& archive) override {
    archive.value("start_volume", start_volume_);
    archive.value("is_measured", is_measured_);
  }

 private:
  double sign() const { return flip_ ? -1 : 1; }
  Vec3 placeOf(ConstRows x, Index node) const { return x[rowOf(first(), node)]; }
  double volumeAt(ConstRows x) const {
    double sum = 0;
    for (const Triangle& t : faces_) sum += placeOf(x, t[0]).dot(placeOf(x, t[1]).cross(placeOf(x, t[2])));
    return sign() * sum / 6;
  }

  TopologyLink topology_;
  std::vector<Triangle> triangles_, faces_;
  std::vector<double> values_{0};
  int index_ = 0;
  std::string type_ = "pressure";
  bool flip_ = false, is_measured_ = false;
  double pressure_ = 0, start_volume_ = 0, growth_ = 0;
  mutable double volume_ = 0;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(surface_pressure_constraint) {
  factory.add<stroma::lagrangian::SurfacePressure>("SurfacePressureConstraint", "a cavity under pressure, or of a given volume");
}
