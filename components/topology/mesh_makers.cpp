// SPDX-License-Identifier: LGPL-2.1-or-later
// Meshes computed before the first step, for containers that take them by src="@maker" or by links to its outputs.
//
// GenerateGrid: a box of `resolution` cells along x, y, z from min to max, as hexahedra (x slowest, z fastest) and as six
//   tetrahedra each. With no cells along z it is a flat grid of quads and triangles. Nodes: x fastest.
// GenerateCylinder: tetrahedra around the z axis from origin. Each of resHeight layers has a node on the axis, then
//   resRadial rings of resCircumferential nodes, from the inside out. surfaceTriangles with output_TrianglesPosition are its surface,
//   with its own nodes, and with both ends unless openSurface is set. (SOFA calls these triangles: src="@maker" would combine them
//   with the nodes of the tetrahedra.)
// GridMeshCreator: the unit square in z = 0 with resolution nx ny nodes, x fastest. trianglePattern: 0 quads; 1 triangles with
//   alternating diagonals; 2 diagonals from a corner to the opposite one; 3 the other diagonal. It also lists the edges of the cells.
// StringMeshCreator: `resolution` points on the x axis from 0 to 1, and the edges between neighbours. As by the mesh loaders, both
//   can be scaled, rotated, translated and split, and their normals flipped.
// ExtrudeQuadsAndGenerateHexas: layers of hexahedra on surfaceQuads, along the mean normals of the nodes from -thicknessIn to
//   thicknessOut. Node k of the surface becomes numberOfSlices + 1 successive nodes.
// ExtrudeEdgesAndGenerateQuads: strips of quads on curveEdges along extrudeDirection. The nodes are ordered by layer.
//
// Source: names, attributes and the order of nodes and cells are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <GridMeshCreator name="sheet" resolution="3 3" trianglePattern="0"/>
//   <ExtrudeQuadsAndGenerateHexas name="slab" surfaceVertices="@sheet.position" surfaceQuads="@sheet.quads" thicknessOut="0.5"/>
//   <StringMeshCreator name="line" resolution="4"/>
//   <ExtrudeEdgesAndGenerateQuads name="strip" curveVertices="@line.position" curveEdges="@line.edges" extrudeDirection="0 0 1"/>
//   <GenerateGrid name="box" max="1 1 1" resolution="2 2 2"/>
//   <GenerateCylinder name="rod" radius="0.1" height="1"/>
//   <HexahedronSetTopologyContainer position="@slab.extrudedVertices" hexahedra="@slab.extrudedHexas"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/mesh.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshMaker : public Component {
 public:
  std::string roleText() const override { return "mesh engine"; }

 protected:
  /// Throws for a mesh of more nodes than anybody wants.
  static void checkSize(double nodes) {
    constexpr double most = 1e8;
    if (nodes > most) throw ComponentError(fmt::format("the mesh would have {:g} nodes", nodes), fmt::format("at most {:g}", most));
  }
  static void checkNodes(const auto& cells, const std::vector<Vec3>& nodes, const char* name) {
    for (const auto& cell : cells)
      for (const Index node : cell)
        if (node < 0 || std::size_t(node) >= nodes.size())
          throw ComponentError(fmt::format("{} names node {} of {}", name, node, nodes.size()));
  }
};

class GenerateGrid final : public MeshMaker {
 public:
  void declare(DataTable& table) override {
    table.add("min", min_).help("one corner").unit("m");
    table.add("max", max_).help("the opposite corner").unit("m");
    table.add("resolution", cells_).help("number of cells along x, y and z; 0 along z: a flat grid").unit("-").min(0);
    table.add("output_position", mesh_.position).alias("position").help("nodes").unit("m").output();
    addCellList(table, cell_kinds::hexahedron, mesh_.hexahedra).help("the cells").output();
    addCellList(table, cell_kinds::tetrahedron, mesh_.tetrahedra).help("six of each").output();
    addCellList(table, cell_kinds::quad, mesh_.quads).help("of a flat grid").output();
    addCellList(table, cell_kinds::triangle, mesh_.triangles).help("two of each").output();
  }
  void init() override {
    mesh_ = Mesh();
    const int nx = std::max(1, cells_[0]), ny = std::max(1, cells_[1]), nz = cells_[2];
    checkSize((nx + 1.) * (ny + 1.) * (nz + 1.));
    const Vec3 size = max_ - min_, step(size[0] / nx, size[1] / ny, nz > 0 ? size[2] / nz : 0);
    for (int k = 0; k <= nz; ++k)
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) mesh_.position.push_back(min_ + step.cwiseProduct(Vec3(i, j, k)));
    const auto node = [&](int i, int j, int k) { return Index(i + (nx + 1) * (j + (ny + 1) * k)); };
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j) {
        if (nz == 0) addQuad({node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0)});
        for (int k = 0; k < nz; ++k)
          addHexahedron({node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k), node(i, j, k + 1),
                         node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)});
      }
  }

 private:
  void addQuad(const Quad& q) {
    mesh_.quads.push_back(q);
    mesh_.triangles.push_back({q[0], q[1], q[3]});
    mesh_.triangles.push_back({q[3], q[1], q[2]});
  }
  void addHexahedron(const Hexahedron& h) {
    constexpr std::size_t cut[6][4] = {{0, 5, 1, 6}, {0, 1, 3, 6}, {1, 3, 6, 2}, {6, 3, 0, 7}, {6, 7, 0, 5}, {7, 5, 4, 0}};
    mesh_.hexahedra.push_back(h);
    for (const auto& t : cut) mesh_.tetrahedra.push_back({h[t[0]], h[t[1]], h[t[2]], h[t[3]]});
  }
  Vec3 min_ = Vec3::Zero(), max_ = Vec3::Zero();
  std::array<int, 3> cells_{3, 3, 3};
  Mesh mesh_;
};

class GenerateCylinder final : public MeshMaker {
 public:
  void declare(DataTable& table) override {
    table.add("radius", radius_).help("of the outermost ring").unit("m").min(0, false);
    table.add("height", height_).help("along z").unit("m").min(0, false);
    table.add("origin", origin_).help("the middle of the first layer").unit("m");
    table.add("resCircumferential", around_).help("nodes of a ring").min(3);
    table.add("resRadial", rings_).help("rings of a layer").min(1);
    table.add("resHeight", layers_).help("layers").min(2);
    table.add("output_TetrahedraPosition", mesh_.position).alias("position").alias("output_position").help("nodes").unit("m").output();
    addCellList(table, cell_kinds::tetrahedron, mesh_.tetrahedra).help("the cells").output();
    table.add("openSurface", open_).help("the surface has no ends");
    table.add("output_TrianglesPosition", surface_.position).help("nodes of the surface").unit("m").output();
    table.add("surfaceTriangles", surface_.triangles).help("the surface, outward, of those nodes").output();
    for (const auto& [name, degree] : {std::pair("BezierTriangleDegree", &degrees_[0]), std::pair("BezierTetrahedronDegree", &degrees_[1])})
      table.add(name, *degree).help("straight cells alone").min(0).max(1);
  }
  void init() override {
    mesh_ = Mesh();
    const Index layer = around_ * rings_ + 1;
    checkSize(double(layer) * layers_);
    for (int i = 0; i < layers_; ++i) {
      const double z = i * height_ / (layers_ - 1);
      mesh_.position.push_back(origin_ + Vec3(0, 0, z));
      for (int j = 1; j <= rings_; ++j)
        for (int k = 0; k < around_; ++k) mesh_.position.push_back(onRing(j * radius_ / rings_, k, z));
    }
    for (int i = 1; i < layers_; ++i) addLayer(i * layer, layer);
    makeSurface();
  }

 private:
  Vec3 onRing(double r, int k, double z) const {
    const double angle = k * 2 * std::numbers::pi / around_;
    return origin_ + Vec3(r * std::cos(angle), r * std::sin(angle), z);
  }
  /// Layer by layer; then of each end its middle and the rings from the inside out, but for the outermost.
  void makeSurface() {
    surface_ = Mesh();
    for (int i = 0; i < layers_; ++i)
      for (int k = 0; k < around_; ++k) surface_.position.push_back(onRing(radius_, k, i * height_ / (layers_ - 1)));
    const auto add = [this](Index a, Index b, Index c, bool turned) {
      surface_.triangles.push_back(turned ? Triangle{a, c, b} : Triangle{a, b, c});
    };
    for (Index here = around_; here < layers_ * around_; here += around_)
      for (Index k = 0, below = here - around_; k < around_; ++k) {
        const Index next = (k + 1) % around_;
        add(here + k, below + k, below + next, false), add(here + k, below + next, here + next, false);
      }
    for (int end = 0; end < (open_ ? 0 : 2); ++end) {
      const auto middle = Index(surface_.position.size());
      surface_.position.push_back(onRing(0, 0, end * height_));
      for (int j = 1; j < rings_; ++j)
        for (int k = 0; k < around_; ++k) surface_.position.push_back(onRing(j * radius_ / rings_, k, end * height_));
      const auto ring = [&](int j) { return j == rings_ ? end * (layers_ - 1) * around_ : middle + 1 + (j - 1) * around_; };
      for (int k = 0; k < around_; ++k) add(middle, ring(1) + k, ring(1) + (k + 1) % around_, end == 0);
      for (int j = 1; j < rings_; ++j)
        for (int k = 0; k < around_; ++k) {
          const Index a = ring(j) + k, b = ring(j + 1) + k, c = ring(j + 1) + (k + 1) % around_, d = ring(j) + (k + 1) % around_;
          add(a, b, c, end == 0), add(a, c, d, end == 0);
        }
    }
  }
  void add(Index a, Index b, Index c, Index d) { mesh_.tetrahedra.push_back({a, b, c, d}); }
  /// Between the layer whose node on the axis is `axis` and the one below it.
  void addLayer(Index axis, Index below) {
    Index before = around_;
    for (Index k = 1; k <= around_; ++k) {
      const Index p[6] = {axis, axis + before, axis + k, axis - below, axis + before - below, axis + k - below};
      add(p[1], p[0], p[2], p[3]), add(p[1], p[2], p[4], p[3]), add(p[3], p[4], p[5], p[2]);
      before = k;
    }
    for (int j = 1; j < rings_; ++j, axis += around_) {
      before = around_;
      for (Index k = 1; k <= around_; ++k) {
        const Index a = axis + k, b = axis + before, c = a + around_, d = b + around_;
        const Index e = a - below, f = b - below, g = c - below, h = d - below;
        add(a, f, e, h), add(a, b, f, d), add(f, a, d, h), add(a, d, h, c), add(h, a, c, e), add(g, h, c, e);
        before = k;
      }
    }
  }
  double radius_ = 0.2, height_ = 1;
  Vec3 origin_ = Vec3::Zero();
  int around_ = 6, rings_ = 3, layers_ = 5, degrees_[2] = {0, 0};
  bool open_ = true;
  Mesh mesh_, surface_;
};

/// What SOFA's loaders do with every mesh: scale, turn and move it, split its quads and turn its cells round.
class PlacedMaker : public MeshMaker {
 public:
  void declare(DataTable& table) override {
    table.add("scale3d", scale3d_).help("factors along the axes, first").unit("-");
    table.add("scale", scale_).help("one factor for all").unit("-").shorthand();
    table.add("rotation", rotation_).help("about x, then y, then z").unit("degree");
    table.add("translation", translation_).help("last").unit("m");
    table.add("triangulate", triangulate_).help("split quads into triangles");
    table.add("flipNormals", flip_).help("turn triangles and quads round");
    table.addVisualOnly("filename");
  }

 protected:
  void place() {
    if (data().find("scale")->isSet()) scale3d_.setConstant(scale_);
    const Mat3 turn = rotationFromDegrees(rotation_);
    for (Vec3& p : mesh_.position) p = turn * p.cwiseProduct(scale3d_) + translation_;
    if (triangulate_) {
      for (const Quad& q : mesh_.quads)
        mesh_.triangles.push_back({q[0], q[1], q[2]}), mesh_.triangles.push_back({q[0], q[2], q[3]});
      mesh_.quads.clear();
    }
    if (!flip_) return;
    for (Triangle& cell : mesh_.triangles) std::swap(cell[1], cell[2]);
    for (Quad& cell : mesh_.quads) std::swap(cell[1], cell[3]);
  }
  Mesh mesh_;

 private:
  Vec3 scale3d_ = Vec3::Ones(), rotation_ = Vec3::Zero(), translation_ = Vec3::Zero();
  double scale_ = 1;
  bool triangulate_ = false, flip_ = false;
};

class GridMeshCreator final : public PlacedMaker {
 public:
  void declare(DataTable& table) override {
    PlacedMaker::declare(table);
    table.add("resolution", nodes_).help("number of nodes along x and y").unit("-").min(2);
    table.add("trianglePattern", pattern_).help("0 quads; triangles with 1 alternating diagonals, 2 one, 3 the other").min(0).max(3);
    table.add("position", mesh_.position).help("nodes").unit("m").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("of the cells").output();
    addCellList(table, cell_kinds::quad, mesh_.quads).help("the cells").output();
    addCellList(table, cell_kinds::triangle, mesh_.triangles).help("two of each cell").output();
  }
  void init() override {
    if (nodes_.size() != 2) throw ComponentError(fmt::format("resolution has {} numbers", nodes_.size()), "nx ny");
    const int nx = nodes_[0], ny = nodes_[1];
    checkSize(double(nx) * ny);
    mesh_ = Mesh();
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) mesh_.position.emplace_back(double(x) / (nx - 1), double(y) / (ny - 1), 0);
    const auto node = [nx](int x, int y) { return Index(x + nx * y); };
    for (int y = 0; y + 1 < ny; ++y)
      for (int x = 0; x + 1 < nx; ++x) {
        const Index a = node(x, y), b = node(x + 1, y), c = node(x + 1, y + 1), d = node(x, y + 1);
        const bool rising = pattern_ == 2 || (pattern_ == 1 && (x + y) % 2 == 0);
        if (pattern_ == 0) {
          mesh_.quads.push_back({a, b, c, d});
        } else if (rising) {
          mesh_.triangles.push_back({a, b, c}), mesh_.triangles.push_back({a, c, d});
        } else {
          mesh_.triangles.push_back({a, b, d}), mesh_.triangles.push_back({b, c, d});
        }
      }
    mesh_.edges = Mesh(mesh_).allEdges();
    place();
  }

 private:
  std::vector<int> nodes_{2, 2};
  int pattern_ = 2;
};

class StringMeshCreator final : public PlacedMaker {
 public:
  void declare(DataTable& table) override {
    PlacedMaker::declare(table);
    table.add("resolution", nodes_).help("number of points").min(2);
    table.add("position", mesh_.position).help("points").unit("m").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("between neighbours").output();
  }
  void init() override {
    mesh_ = Mesh();
    checkSize(nodes_);
    for (int i = 0; i < nodes_; ++i) {
      mesh_.position.emplace_back(double(i) / (nodes_ - 1), 0, 0);
      if (i > 0) mesh_.edges.push_back({i - 1, i});
    }
    place();
  }

 private:
  int nodes_ = 2;
};

class ExtrudeQuads final : public MeshMaker {
 public:
  void declare(DataTable& table) override {
    table.add("surfaceVertices", nodes_).help("nodes of the surface").unit("m");
    table.add("surfaceQuads", quads_).help("its cells");
    table.add("thicknessIn", in_).help("against the normals").unit("m");
    table.add("thicknessOut", out_).help("along the normals").unit("m");
    table.add("numberOfSlices", slices_).help("layers of cells").min(1);
    table.add("scale", scale_).help("factors of the surface").unit("-");
    table.add("flipNormals", flip_).help("turn the cells round");
    table.add("extrudedVertices", mesh_.position).help("nodes").unit("m").output();
    table.add("extrudedHexas", mesh_.hexahedra).help("the cells").output();
    table.add("extrudedSurfaceQuads", mesh_.quads).help("the first faces").output();
    table.addVisualOnly("isVisible");
  }
  void init() override {
    if (quads_.empty()) throw ComponentError("there are no quads to extrude", "surfaceVertices and surfaceQuads");
    checkNodes(quads_, nodes_, "surfaceQuads");
    checkSize(double(nodes_.size()) * (slices_ + 1.));
    mesh_ = Mesh();
    std::vector<Vec3> normals(nodes_.size(), Vec3::Zero());
    for (const Quad& q : quads_) {
      const Vec3 normal = (nodes_[q[1]] - nodes_[q[0]]).cross(nodes_[q[2]] - nodes_[q[0]]).normalized();
      for (const Index node : q) normals[node] += normal;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (int n = 0; n <= slices_; ++n)
        mesh_.position.push_back(nodes_[i].cwiseProduct(scale_) + normals[i].normalized() * (n * (in_ + out_) / slices_ - in_));
    const Index more = slices_ + 1;
    for (const Quad& q : quads_) {
      mesh_.quads.push_back({q[0] * more, q[1] * more, q[2] * more, q[3] * more});
      for (int n = 0; n < slices_; ++n) {
        Quad base = flip_ ? q : Quad{q[3], q[2], q[1], q[0]};
        Hexahedron cell;
        for (std::size_t c = 0; c < 4; ++c) cell[c] = base[c] * more + n, cell[c + 4] = cell[c] + 1;
        mesh_.hexahedra.push_back(cell);
      }
    }
  }

 private:
  std::vector<Vec3> nodes_;
  std::vector<Quad> quads_;
  double in_ = 0, out_ = 1;
  int slices_ = 1;
  Vec3 scale_ = Vec3::Ones();
  bool flip_ = false;
  Mesh mesh_;
};

class ExtrudeEdges final : public MeshMaker {
 public:
  void declare(DataTable& table) override {
    table.add("curveVertices", nodes_).help("nodes of the curve").unit("m");
    table.add("curveEdges", edges_).help("its edges");
    table.add("extrudeDirection", direction_).help("where to").unit("-");
    table.add("thicknessIn", in_).help("against the direction").unit("m");
    table.add("thicknessOut", out_).help("along the direction").unit("m");
    table.add("numberOfSections", sections_).help("rows of quads").min(1);
    table.add("extrudedVertices", mesh_.position).help("nodes").unit("m").output();
    table.add("extrudedEdges", mesh_.edges).help("along the curve and across").output();
    table.add("extrudedQuads", mesh_.quads).help("the cells").output();
  }
  void init() override {
    if (edges_.empty()) throw ComponentError("there are no edges to extrude", "curveVertices and curveEdges");
    if (!(direction_.norm() > 0)) throw ComponentError("extrudeDirection is zero", "a vector that is not");
    checkNodes(edges_, nodes_, "curveEdges");
    checkSize(double(nodes_.size()) * (sections_ + 1.));
    mesh_ = Mesh();
    const auto layer = Index(nodes_.size());
    const Vec3 step = direction_.normalized() * ((in_ + out_) / sections_);
    for (int n = 0; n <= sections_; ++n)
      for (const Vec3& p : nodes_) mesh_.position.push_back(p - direction_ * in_ + step * n);
    for (const Edge& e : edges_) {
      for (int n = 0; n <= sections_; ++n) mesh_.edges.push_back({e[0] + n * layer, e[1] + n * layer});
      for (int n = 0; n < sections_; ++n) mesh_.edges.push_back({e[0] + n * layer, e[0] + (n + 1) * layer});
      for (int n = 0; n < sections_; ++n)
        mesh_.quads.push_back({e[0] + n * layer, e[1] + n * layer, e[1] + (n + 1) * layer, e[0] + (n + 1) * layer});
    }
    if (edges_.size() < nodes_.size())  // the curve is open: its last end
      for (int n = 0; n < sections_; ++n) mesh_.edges.push_back({edges_.back()[1] + n * layer, edges_.back()[1] + (n + 1) * layer});
  }

 private:
  std::vector<Vec3> nodes_;
  std::vector<Edge> edges_;
  Vec3 direction_ = Vec3::UnitX();
  double in_ = 0, out_ = 1;
  int sections_ = 1;
  Mesh mesh_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_makers) {
  factory.add<stroma::GenerateGrid>("GenerateGrid", "a box of hexahedra and of tetrahedra");
  factory.add<stroma::GenerateCylinder>("GenerateCylinder", "a cylinder of tetrahedra");
  factory.add<stroma::GridMeshCreator>("GridMeshCreator", "a square of quads or triangles");
  factory.add<stroma::StringMeshCreator>("StringMeshCreator", "a line of points and edges");
  factory.add<stroma::ExtrudeQuads>("ExtrudeQuadsAndGenerateHexas", "layers of hexahedra on a surface of quads");
  factory.add<stroma::ExtrudeEdges>("ExtrudeEdgesAndGenerateQuads", "strips of quads on a curve");
}
