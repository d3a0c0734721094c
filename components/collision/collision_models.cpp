// SPDX-License-Identifier: LGPL-2.1-or-later
// Surfaces of bodies, for a CollisionPipeline that looks whether they come near each other. A CollisionResponse makes
// forces of that.
//
// PointCollisionModel: the nodes of the state. LineCollisionModel: the edges of the mesh. TriangleCollisionModel: its
// triangles, its quads as two triangles each, else the boundary of its volume cells. SphereCollisionModel: a sphere around
// each node, radius for all or listRadius for each.
//
// Two models may meet when both are active, at least one of them is simulated, they are of different nodes (or of one
// with selfCollision on both), and have no number of `group` in common. With selfCollision a model meets itself. Parts of
// one state meet where they have no node in common and are farther apart at rest than their contact distance.
// contactDistance adds to that of the pipeline's method.
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
#include "components/collision/collision_model.h"
#include "framework/mesh/cell_faces.h"
#include "framework/scene/factory.h"

namespace stroma::collision {
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
    for (const Edge& edge : edges()) parts.push_back({{edge[0], edge[1], -1}, 2, 0});
  }
};

class Triangles final : public CollisionModel {
 public:
  Kind kind() const override { return Kind::triangle; }
  void makeParts(std::vector<Part>& parts) override {
    for (const Triangle& face : faces()) parts.push_back({face, 3, 0});
    const Mesh* found = mesh();
    if (!found || found->quads.empty()) return;
    for (std::size_t i = found->triangles.size(); i < parts.size(); ++i) parts[i].of_quad = true;
  }
};

class Spheres final : public CollisionModel {
 public:
  void declare(DataTable& table) override {
    CollisionModel::declare(table);
    table.add("radius", radius_).alias("defaultRadius").help("of each sphere").unit("m").min(0);
    table.add("listRadius", radii_).help("of each sphere, one for each node; radius by default").unit("m").min(0);
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
  factory.add<Points>("PointCollisionModel", "the nodes of a body, where contacts are looked for");
  factory.add<Lines>("LineCollisionModel", "the edges of a body, where contacts are looked for");
  factory.add<Triangles>("TriangleCollisionModel", "the surface of a body, where contacts are looked for");
  factory.add<Spheres>("SphereCollisionModel", "spheres around nodes, where contacts are looked for");
}
