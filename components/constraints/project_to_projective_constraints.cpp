// SPDX-License-Identifier: LGPL-2.1-or-later
// Nodes that are moved to a point, a line or a plane and kept on it.
//
//   ProjectToPointProjectiveConstraint:  P = 0,          x -> point
//   ProjectToLineProjectiveConstraint:   P = d d^T,      x -> o + d d^T (x - o),          d = direction / |direction|
//   ProjectToPlaneProjectiveConstraint:  P = I - n n^T,  x -> o + (I - n n^T) (x - o),    n = normal / |normal|
//
// A node that does not start there arrives at the end of the first step, by the shortest path; with startsThere it is there
// before the first step, as in SOFA. After each step its position is projected again, so that round-off does not accumulate,
// and its velocity has no component away from the point, line or plane.
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0  3 0 0"/>
//   <UniformMass totalMass="0.4"/>
//   <SpringForceField springsIndices1="0 1 2" springsIndices2="1 2 3" lengths="1 1 1" stiffness="200"/>
//   <ProjectToPointProjectiveConstraint indices="0" point="0 0.1 0"/>
//   <ProjectToLineProjectiveConstraint indices="1" origin="1 0 0" direction="1 1 0"/>
//   <ProjectToPlaneProjectiveConstraint indices="2 3" origin="0 0 0" normal="0 1 1"/>
// </Node>
#include "components/constraints/held_nodes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ProjectTo : public HeldNodes {
 public:
  void declare(DataTable& table) override {
    HeldNodes::declare(table);
    table.add("startsThere", starts_there_).help("nodes are brought there before the first step, not by it");
    declareMatrix(table);
  }
  bool prescribesMotion() const override { return true; }
  void placeStart(double t, Rows x, Rows v) const override {
    if (starts_there_ && activeIn(t, t)) prescribe(t, x, v);
  }
  void prescribe(double, Rows x, Rows v) const override {
    for (std::size_t i = 0; i < nodes().size(); ++i) {
      x[row(i)] = origin_ + projector() * (x[row(i)] - origin_);
      v[row(i)] = (projector() * v[row(i)]).eval();
    }
  }

 protected:
  static Vec3 direction(const Vec3& given, const char* attribute) {
    if (!(given.norm() > 0)) throw ComponentError(std::string(attribute) + " is zero", "a vector that is not zero");
    return given.normalized();
  }
  Vec3 origin_ = Vec3::Zero();

 private:
  bool starts_there_ = false;
};

class ProjectToPoint final : public ProjectTo {
 public:
  void declare(DataTable& table) override {
    ProjectTo::declare(table);
    table.add("point", origin_).help("where the nodes are kept").unit("m").required();
  }
};

class ProjectToLine final : public ProjectTo {
 public:
  void declare(DataTable& table) override {
    ProjectTo::declare(table);
    table.add("origin", origin_).help("a point of the line").unit("m");
    table.add("direction", direction_).help("direction of the line").unit("-").required();
  }
  void init() override {
    HeldNodes::init();
    const Vec3 d = direction(direction_, "direction");
    setProjectors({d * d.transpose()});
  }

 private:
  Vec3 direction_ = Vec3::Zero();
};

class ProjectToPlane final : public ProjectTo {
 public:
  void declare(DataTable& table) override {
    ProjectTo::declare(table);
    table.add("origin", origin_).help("a point of the plane").unit("m");
    table.add("normal", normal_).help("normal of the plane").unit("-").required();
  }
  void init() override {
    HeldNodes::init();
    const Vec3 n = direction(normal_, "normal");
    setProjectors({Mat3::Identity() - n * n.transpose()});
  }

 private:
  Vec3 normal_ = Vec3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(project_to_projective_constraints) {
  factory.add<stroma::ProjectToPoint>("ProjectToPointProjectiveConstraint", "Keeps nodes at a point");
  factory.add<stroma::ProjectToLine>("ProjectToLineProjectiveConstraint", "Keeps nodes on a line");
  factory.add<stroma::ProjectToPlane>("ProjectToPlaneProjectiveConstraint", "Keeps nodes in a plane");
}
