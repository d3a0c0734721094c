// SPDX-License-Identifier: LGPL-2.1-or-later
// A box of nx x ny x nz nodes: hexahedra; quads when one direction has a single node, edges when two have.
//
// Node (i, j, k), with i fastest, has the number i + nx (j + ny k) and the position
//   min + ((max - min) / (n - 1)) * (i, j, k)
// Cell (i, j, k) has the number i + (nx - 1) (j + (ny - 1) k); its corners are in VTK's order. With `cellWidth` w the
// number of nodes is 1 + (max - min) / w, rounded; the box is kept.
//
// Source: the attributes are those of SOFA's RegularGridTopology. Quads and edges of the cells of a solid grid are made
// only when computeQuadList or computeEdgeList is written in the scene, because nothing uses them otherwise. With
// computeTriangleList the quads are made too, in SOFA's order (those normal to z, y, then x), two triangles of each beside them,
// (0 1 2)(0 2 3), and edges are those of the triangles: with one diagonal in each quad.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="4 2 2"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/topology/grid_faces.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

constexpr int largest_grid = 1 << 28;  ///< nodes

class RegularGridTopology : public Topology {
 public:
  void declare(DataTable& table) override;
  void init() override;

 private:
  void readBox();
  void readCounts();
  void checkSize() const;
  void makeNodes();
  void makeCells();
  template <class Add>
  void forEachCell(Add&& add) const;
  bool isSet(const char* name) const { return data().find(name)->isSet(); }

  std::array<int, 3> n_{2, 2, 2};
  int nx_ = 2, ny_ = 2, nz_ = 2;
  Vec3 min_ = Vec3::Zero(), max_ = Vec3::Ones(), p0_ = Vec3::Zero();
  double xmin_ = 0, xmax_ = 1, ymin_ = 0, ymax_ = 1, zmin_ = 0, zmax_ = 1;
  double cell_width_ = 0, scale_ = 1;
  bool mirrored_ = false;
  bool hexas_ = true, quads_ = true, triangles_ = false, edges_ = true;
};

void RegularGridTopology::declare(DataTable& table) {
  table.add("n", n_).unit("-").help("number of nodes in x, y, z").min(1);
  table.add("nx", nx_).help("number of nodes in x").min(1).shorthand();
  table.add("ny", ny_).help("number of nodes in y").min(1).shorthand();
  table.add("nz", nz_).help("number of nodes in z").min(1).shorthand();
  table.add("min", min_).unit("m").help("lower corner of the box");
  table.add("max", max_).unit("m").help("upper corner of the box");
  table.add("xmin", xmin_).unit("m").help("lower corner").shorthand();
  table.add("xmax", xmax_).unit("m").help("upper corner").shorthand();
  table.add("ymin", ymin_).unit("m").help("lower corner").shorthand();
  table.add("ymax", ymax_).unit("m").help("upper corner").shorthand();
  table.add("zmin", zmin_).unit("m").help("lower corner").shorthand();
  table.add("zmax", zmax_).unit("m").help("upper corner").shorthand();
  table.add("scale", scale_).unit("-").help("factor of the box").shorthand();
  table.add("p0", p0_).unit("m").help("moves the unit box there when neither min nor max is given");
  table.add("cellWidth", cell_width_).unit("m").help("when positive, gives n from the box").min(0);
  table.add("allowMirrored", mirrored_).help("max may be below min: the grid then runs the other way, as in SOFA; or equal to it");
  table.add("computeHexaList", hexas_).help("make the hexahedra of a solid grid");
  table.add("computeQuadList", quads_).help("make the quads of a flat grid; of a solid one only when written");
  table.add("computeTriangleList", triangles_).help("split the quads into triangles beside them");
  table.add("computeEdgeList", edges_).help("make the edges of a line; of other grids only when written");
  for (const char* name : {"computePointList", "createTexCoords", "drawEdges", "drawTriangles", "drawQuads",
                           "drawTetrahedra", "drawHexahedra", "drawPoints", "computeAllBuffers"})
    table.addVisualOnly(name);
  table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
  forEachCellList(
      [&table](const CellKind& kind, auto& cells) {
        if (&kind != &cell_kinds::tetrahedron) addCellList(table, kind, cells).help(std::string(kind.plural)).output();
      },
      mesh_);
}

void RegularGridTopology::init() {
  readBox();
  readCounts();
  checkSize();
  makeNodes();
  makeCells();
}

void RegularGridTopology::readBox() {
  const char* names[3][2] = {{"xmin", "xmax"}, {"ymin", "ymax"}, {"zmin", "zmax"}};
  const double values[3][2] = {{xmin_, xmax_}, {ymin_, ymax_}, {zmin_, zmax_}};
  bool any_given = isSet("min") || isSet("max");
  for (int axis = 0; axis < 3; ++axis)
    for (int end = 0; end < 2; ++end) {
      if (!isSet(names[axis][end])) continue;
      if (isSet(end == 0 ? "min" : "max"))
        throw ComponentError(fmt::format("both {} and {} are given", names[axis][end], end == 0 ? "min" : "max"),
                             "one of them");
      (end == 0 ? min_ : max_)[axis] = values[axis][end];
      any_given = true;
    }
  if (isSet("p0") && !any_given)
    min_ += p0_, max_ += p0_;
  else if (isSet("p0") && p0_ != min_)
    warn("p0 is not used: min and max give the position of the grid");
  if (!any_given) warn("the box of the grid is not given: a unit cube is used", "min and max");
  min_ *= scale_, max_ *= scale_;
}

void RegularGridTopology::readCounts() {
  const char* names[3] = {"nx", "ny", "nz"};
  const int values[3] = {nx_, ny_, nz_};
  bool any_given = isSet("n");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!isSet(names[axis])) continue;
    if (isSet("n")) throw ComponentError(fmt::format("both n and {} are given", names[axis]), "one of them");
    n_[axis] = values[axis];
    any_given = true;
  }
  if (cell_width_ > 0) {
    if (any_given) throw ComponentError("both cellWidth and the number of nodes are given", "one of them");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cells = (max_ - min_)[Index(axis)] / cell_width_;
      if (!(std::abs(cells) < largest_grid))
        throw ComponentError(fmt::format("cellWidth {} gives {} cells", cell_width_, cells));
      n_[axis] = 1 + int(std::lround(cells));
      if (std::abs(cells - (n_[axis] - 1)) > 0.01)
        warn(fmt::format("the box is {:.3f} cells long in {}: {} are used", cells, "xyz"[axis], n_[axis] - 1));
    }
  } else if (!any_given) {
    warn("the number of nodes of the grid is not given: 2 2 2 is used", "n");
  }
}

void RegularGridTopology::checkSize() const {
  double nodes = 1;
  int cells = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = (max_ - min_)[Index(axis)];
    nodes *= n_[axis];
    if (n_[axis] < 1 || (n_[axis] > 1 && !(mirrored_ ? std::isfinite(length) : length > 0)))
      throw ComponentError(fmt::format("the box is {} long in {} for {} nodes", length, "xyz"[axis], n_[axis]),
                           "max greater than min");
    if (n_[axis] > 1) ++cells;
  }
  if (cells == 0) throw ComponentError("a grid of a single node has no cell", "n of at least 2 in one direction");
  if (nodes > largest_grid)
    throw ComponentError(fmt::format("a grid of {:.3g} nodes is too large", nodes),
                         fmt::format("at most {}", largest_grid));
}

void RegularGridTopology::makeNodes() {
  Vec3 step = Vec3::Zero();
  for (Index axis = 0; axis < 3; ++axis)
    if (n_[axis] > 1) step[axis] = (max_ - min_)[axis] / (n_[axis] - 1);
  mesh_.position.reserve(std::size_t(n_[0]) * std::size_t(n_[1]) * std::size_t(n_[2]));
  for (int k = 0; k < n_[2]; ++k)
    for (int j = 0; j < n_[1]; ++j)
      for (int i = 0; i < n_[0]; ++i) {
        Vec3 p = min_ + step.cwiseProduct(Vec3(i, j, k));
        // The far sides lie on the box to the last bit, so that a selection at max finds them.
        for (Index axis = 0; axis < 3; ++axis) {
          const int at[3] = {i, j, k};
          if (at[axis] > 0 && at[axis] == n_[axis] - 1) p[axis] = max_[axis];
        }
        mesh_.position.push_back(p);
      }
}

/// add(node, step): the first node of the cell, and the distance in node numbers along each of its directions.
template <class Add>
void RegularGridTopology::forEachCell(Add&& add) const {
  const Index strides[3] = {1, n_[0], n_[0] * n_[1]};
  std::vector<Index> steps;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (n_[axis] > 1) steps.push_back(strides[axis]);
  for (int k = 0; k < std::max(1, n_[2] - 1); ++k)
    for (int j = 0; j < std::max(1, n_[1] - 1); ++j)
      for (int i = 0; i < std::max(1, n_[0] - 1); ++i) add(i + strides[1] * j + strides[2] * k, steps);
}

void RegularGridTopology::makeCells() {
  forEachCell([this](Index a, const std::vector<Index>& s) {
    if (s.size() == 1) {
      if (edges_) mesh_.edges.push_back({a, a + s[0]});
    } else if (s.size() == 2) {
      const Quad quad{a, a + s[0], a + s[0] + s[1], a + s[1]};
      if (quads_) mesh_.quads.push_back(quad);
      if (triangles_) mesh_.triangles.push_back({quad[0], quad[1], quad[2]});
      if (triangles_) mesh_.triangles.push_back({quad[0], quad[2], quad[3]});
    } else if (hexas_) {
      const Index b = a + s[2];
      mesh_.hexahedra.push_back({a, a + s[0], a + s[0] + s[1], a + s[1], b, b + s[0], b + s[0] + s[1], b + s[1]});
    }
  });
  const bool want_quads = quads_ && isSet("computeQuadList") && !mesh_.hexahedra.empty();
  const bool want_edges = edges_ && isSet("computeEdgeList") && mesh_.edges.empty();
  if (triangles_ && !mesh_.hexahedra.empty()) addGridFaces(n_, mesh_);
  if (triangles_ && want_edges && !mesh_.triangles.empty()) {
    Mesh surface;
    surface.position = mesh_.position, surface.triangles = mesh_.triangles;
    mesh_.edges = surface.allEdges();
    return;
  }
  if (!want_quads && !want_edges) return;
  Mesh complete{mesh_};
  addSubelements(complete);
  if (want_quads) mesh_.quads = complete.quads;
  if (want_edges) mesh_.edges = complete.edges;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(regular_grid_topology) {
  factory.add<stroma::RegularGridTopology>("RegularGridTopology", "a box cut into equal hexahedra (quads, edges)");
}
