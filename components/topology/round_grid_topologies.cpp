// SPDX-License-Identifier: LGPL-2.1-or-later
// Grids of hexahedra in a cylinder and in a sphere: those of a box whose nodes are moved towards the axis or the centre.
//
//   CylinderGridTopology: p = (x, y) of a square from -radius to radius, times max(|x|, |y|) / |p|; z from 0 to length
//   SphereGridTopology: p = (x, y, z) of a cube from -radius to radius, times max(|x|, |y|, |z|) / |p|
//
// `axis` is the z axis of the grid, and `center` its origin: the centre of the first layer of a cylinder, or of the sphere. The x axis of
// the grid is that of the scene made normal to `axis`, or y of the scene if `axis` is x. Nodes and cells are in the order of
// RegularGridTopology. The corners of the square also lie on the circle, so that the cells there are flat at one edge. With nz = 1 the
// grid is a disc of quads. computeTriangleList and computeEdgeList add faces and edges: quads in the order of RegularGridTopology, two
// triangles in each, and the edges of these.
//
// Source: names, attributes and places are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9"/>
//   <CylinderGridTopology name="grid" n="3 3 5" axis="1 0 0" length="2" radius="0.3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <HexahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
//   <Node name="ball">
//     <SphereGridTopology name="grid" n="3 3 3" center="0 3 0" radius="1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "components/topology/grid_faces.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class RoundGrid : public Topology {
 public:
  void declare(DataTable& table) override {
    table.add("n", n_).unit("-").help("number of nodes in x, y, z").min(1);
    for (std::size_t a = 0; a < 3; ++a)
      table.add(std::string("n") + "xyz"[a], counts_[a]).help("number of nodes along one axis").min(1).shorthand();
    table.add("center", center_).help("where the grid begins, or its middle").unit("m");
    table.add("axis", axis_).help("direction of z").unit("-");
    table.add("radius", radius_).help("of the outermost nodes").unit("m").min(0, false);
    table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
    addCellList(table, cell_kinds::hexahedron, mesh_.hexahedra).help("the cells").output();
    addCellList(table, cell_kinds::quad, mesh_.quads).help("those of a disc, or of a solid grid where they are asked for").output();
    addCellList(table, cell_kinds::triangle, mesh_.triangles).help("two of each quad").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("those of the triangles").output();
    table.add("computeTriangleList", triangles_).help("quads also of a solid grid, and two triangles beside each");
    table.add("computeEdgeList", edges_).help("the edges of these triangles");
    for (const char* name : {"computeHexaList", "computeQuadList", "computePointList", "createTexCoords", "drawEdges",
                             "drawTriangles", "drawQuads", "drawHexahedra"})
      table.addVisualOnly(name);
  }
  void init() override {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::string name = std::string("n") + "xyz"[a];
      if (!data().find(name)->isSet()) continue;
      if (data().find("n")->isSet()) throw ComponentError(fmt::format("both n and {} are given", name), "one of them");
      n_[a] = counts_[a];
    }
    constexpr double most = 1e8;
    if (double(n_[0]) * n_[1] * n_[2] > most) throw ComponentError("the grid has too many nodes", fmt::format("at most {:g}", most));
    if (n_[0] < 2 || n_[1] < 2 || n_[2] < fewestLayers())
      throw ComponentError(fmt::format("a grid of {} x {} x {} nodes has no cells", n_[0], n_[1], n_[2]), "at least 2 in x and y");
    if (!(axis_.norm() > 0)) throw ComponentError("axis is zero", "a vector that is not");
    mesh_ = Mesh();
    makeNodes();
    makeCells();
    makeFaces();
  }

 protected:
  virtual Vec3 placed(const Vec3& share) const = 0;  ///< in the axes of the grid; of each n - 1, from 0 to 1
  virtual int fewestLayers() const { return 1; }
  double radius_ = 1;

 private:
  void makeNodes() {
    constexpr double close = 1e-6;
    const Vec3 z = axis_.normalized(), start = (z - Vec3::UnitX()).norm() < close ? Vec3::UnitY() : Vec3::UnitX();
    const Vec3 y = z.cross(start).normalized(), x = y.cross(z).normalized();
    const auto share = [this](int i, std::size_t a) { return n_[a] > 1 ? double(i) / (n_[a] - 1) : 0; };
    for (int k = 0; k < n_[2]; ++k)
      for (int j = 0; j < n_[1]; ++j)
        for (int i = 0; i < n_[0]; ++i) {
          const Vec3 p = placed({share(i, 0), share(j, 1), share(k, 2)});
          mesh_.position.push_back(center_ + p[0] * x + p[1] * y + p[2] * z);
        }
  }
  void makeCells() {
    const Index row = n_[0], layer = row * n_[1];
    for (int k = 0; k < std::max(1, n_[2] - 1); ++k)
      for (int j = 0; j + 1 < n_[1]; ++j)
        for (int i = 0; i + 1 < n_[0]; ++i) {
          const Index a = i + row * j + layer * k, b = a + layer;
          if (n_[2] == 1)
            mesh_.quads.push_back({a, a + 1, a + row + 1, a + row});
          else
            mesh_.hexahedra.push_back({a, a + 1, a + row + 1, a + row, b, b + 1, b + row + 1, b + row});
        }
  }
  void makeFaces() {
    if (!triangles_ && !edges_) return;
    Mesh faces;
    faces.position = mesh_.position;
    if (n_[2] > 1) addGridFaces(n_, faces);
    for (const Quad& q : mesh_.quads) {
      faces.triangles.push_back({q[0], q[1], q[2]});
      faces.triangles.push_back({q[0], q[2], q[3]});
    }
    if (edges_) mesh_.edges = faces.allEdges();
    if (!triangles_) return;
    if (n_[2] > 1) mesh_.quads = faces.quads;
    mesh_.triangles = faces.triangles;
  }
  std::array<int, 3> n_{2, 2, 2}, counts_{2, 2, 2};
  bool triangles_ = false, edges_ = false;
  Vec3 center_ = Vec3::Zero(), axis_ = Vec3::UnitZ();
};

class CylinderGrid final : public RoundGrid {
 public:
  void declare(DataTable& table) override {
    RoundGrid::declare(table);
    table.add("length", length_).help("along the axis").unit("m").min(0, false);
  }

 private:
  Vec3 placed(const Vec3& share) const override {
    Vec3 p = radius_ * (2 * share - Vec3::Ones());
    p[2] = 0;
    const double middle = 1e-7 * radius_;
    if (p.norm() > middle) p *= p.cwiseAbs().maxCoeff() / p.norm();
    p[2] = share[2] * length_;
    return p;
  }
  double length_ = 1;
};

class SphereGrid final : public RoundGrid {
  Vec3 placed(const Vec3& share) const override {
    Vec3 p = radius_ * (2 * share - Vec3::Ones());
    const double middle = 1e-7 * radius_;
    if (p.norm() > middle) p *= p.cwiseAbs().maxCoeff() / p.norm();
    return p;
  }
  int fewestLayers() const override { return 2; }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(round_grid_topologies) {
  factory.add<stroma::CylinderGrid>("CylinderGridTopology", "a cylinder cut into hexahedra");
  factory.add<stroma::SphereGrid>("SphereGridTopology", "a ball cut into hexahedra");
}
