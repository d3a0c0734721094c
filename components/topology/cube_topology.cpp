// SPDX-License-Identifier: LGPL-2.1-or-later
// CubeTopology: the surface of a box of nx x ny x nz nodes, of quads oriented outward.
//
// The order of the nodes is: the lowest layer with x fastest, the highest layer, then each layer between. A layer between has the row of
// least y, the row of largest y, and the columns of least and largest x without their ends. With `internalPoints`, or if nx, ny or nz is 1,
// the nodes are all those of the box in the order of RegularGridTopology. Quads are ordered by their normal, z, y, then x, and at each by
// the lower end first. With `splitNormals` each side has its own nodes. The sides are ordered least x, y, z, then largest x, y, z, and in
// each the first of the other two axes is fastest. Edges then join the nodes of the first sides (least x, largest x, least y ...).
//
// SphereQuadTopology: the same quads on a sphere. Each node p of the cube from -1 to 1 becomes  center + radius (max |p_i| / |p|) p.
//
// Source: names, attributes and the order are SOFA's.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <CubeTopology nx="3" ny="3" nz="3" min="0 0 0" max="1 1 1"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="1"/>
//   <MeshSpringForceField stiffness="100"/>
//   <QuadPressureForceField quadList="0 1 2 3" pressure="0 0 1"/>
//   <Node name="ball">
//     <SphereQuadTopology nx="4" ny="4" nz="4" center="0 0 3" radius="0.5"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <MeshSpringForceField stiffness="100"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class CubeTopology : public Topology {
 public:
  void declare(DataTable& table) override {
    for (std::size_t a = 0; a < 3; ++a)
      table.add(std::string("n") + "xyz"[a], n_[a]).help("number of nodes along one axis").min(1).required();
    declareShape(table);
    table.add("internalPoints", is_full_).help("the nodes inside are there too");
    table.add("splitNormals", is_split_).help("each side has nodes of its own");
    table.add("position", mesh_.position).alias("points").unit("m").help("nodes").output();
    addCellList(table, cell_kinds::quad, mesh_.quads).help("the cells").output();
    addCellList(table, cell_kinds::edge, mesh_.edges).help("their sides").output();
  }
  void init() override {
    constexpr double most = 1e8;
    if (double(n_[0]) * n_[1] * n_[2] > most) throw ComponentError("the box has too many nodes", fmt::format("at most {:g}", most));
    if ((n_[0] > 1) + (n_[1] > 1) + (n_[2] > 1) < 2)
      throw ComponentError(fmt::format("a box of {} x {} x {} nodes has no quads", n_[0], n_[1], n_[2]), "two of them above 1");
    if (is_split_ && (n_[0] < 2 || n_[1] < 2 || n_[2] < 2))
      throw ComponentError(fmt::format("splitNormals, and a box of {} x {} x {} nodes", n_[0], n_[1], n_[2]), "two nodes along each axis");
    mesh_ = Mesh();
    number_.assign(std::size_t(n_[0]) * n_[1] * n_[2], -1);
    makeNodes();
    makeEdges();
    for (const std::size_t axis : {2, 1, 0})
      for (const bool upper : {false, true})
        if (!upper || n_[axis] > 1) makeQuads(axis, upper);
  }

 protected:
  using Place = std::array<int, 3>;
  virtual void declareShape(DataTable& table) {
    table.add("min", min_).unit("m").help("lower corner of the box");
    table.add("max", max_).unit("m").help("upper corner of the box");
  }
  virtual Vec3 placeOf(const Place& at) const { return between(min_, max_, at); }
  Vec3 between(const Vec3& low, const Vec3& high, const Place& at) const {
    Vec3 p = low;
    for (std::size_t a = 0; a < 3; ++a)
      if (n_[a] > 1) p[Eigen::Index(a)] += (high - low)[Eigen::Index(a)] / (n_[a] - 1) * at[a];
    return p;
  }

 private:
  Index& number(const Place& at) { return number_[std::size_t(at[0]) + std::size_t(n_[0]) * (at[1] + std::size_t(n_[1]) * at[2])]; }
  void addNode(const Place& at) {
    number(at) = Index(mesh_.position.size());
    mesh_.position.push_back(placeOf(at));
  }
  void addLayer(int k) {
    for (int j = 0; j < n_[1]; ++j)
      for (int i = 0; i < n_[0]; ++i) addNode({i, j, k});
  }
  /// Of a node of one side, where sides have nodes of their own.
  Index numberOn(const Place& at, std::size_t axis, bool upper) {
    if (!is_split_) return number(at);
    const std::array<int, 3> sizes{n_[1] * n_[2], n_[0] * n_[2], n_[0] * n_[1]};
    const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    int first = upper ? sizes[0] + sizes[1] + sizes[2] : 0;
    for (std::size_t a = 0; a < axis; ++a) first += sizes[a];
    return Index(first + at[u] + n_[u] * at[v]);
  }
  Index numberOnFirstSide(const Place& at) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const bool upper : {false, true})
        if (at[axis] == (upper ? n_[axis] - 1 : 0)) return numberOn(at, axis, upper);
    return number(at);
  }
  void makeSplitNodes() {
    for (const bool upper : {false, true})
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        Place at{};
        at[axis] = upper ? n_[axis] - 1 : 0;
        for (at[v] = 0; at[v] < n_[v]; ++at[v])
          for (at[u] = 0; at[u] < n_[u]; ++at[u]) mesh_.position.push_back(placeOf(at));
      }
  }
  void makeNodes() {
    if (is_split_) return makeSplitNodes();
    const bool is_hollow = !is_full_ && n_[0] > 1 && n_[1] > 1 && n_[2] > 1;
    if (is_hollow) {
      addLayer(0);
      addLayer(n_[2] - 1);
    }
    for (int k = is_hollow ? 1 : 0; k < (is_hollow ? n_[2] - 1 : n_[2]); ++k) {
      if (!is_hollow) {
        addLayer(k);
        continue;
      }
      for (const int j : {0, n_[1] - 1})
        for (int i = 0; i < n_[0]; ++i) addNode({i, j, k});
      for (const int i : {0, n_[0] - 1})
        for (int j = 1; j + 1 < n_[1]; ++j) addNode({i, j, k});
    }
  }
  bool isAtEnd(int i, std::size_t axis) const { return i == 0 || i == n_[axis] - 1; }
  void makeEdges() {
    for (int k = 0; k < n_[2]; ++k)
      for (int j = 0; j < n_[1]; ++j)
        for (int i = 0; i < n_[0]; ++i)
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const Place at{i, j, k};
            const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
            if (at[axis] == n_[axis] - 1 || (!isAtEnd(at[u], u) && !isAtEnd(at[v], v))) continue;
            Place next = at;
            ++next[axis];
            mesh_.edges.push_back({numberOnFirstSide(at), numberOnFirstSide(next)});
          }
  }
  void makeQuads(std::size_t axis, bool upper) {
    const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const bool is_u_first = (axis == 1) == !upper;
    for (int j = 0; j + 1 < n_[v]; ++j)
      for (int i = 0; i + 1 < n_[u]; ++i) {
        const auto corner = [&](int di, int dj) {
          Place at{};
          at[axis] = upper ? n_[axis] - 1 : 0;
          at[u] = i + di;
          at[v] = j + dj;
          return numberOn(at, axis, upper);
        };
        if (is_u_first)
          mesh_.quads.push_back({corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
        else
          mesh_.quads.push_back({corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)});
      }
  }

  Place n_{2, 2, 2};
  Vec3 min_ = Vec3::Zero(), max_ = Vec3::Ones();
  bool is_full_ = false, is_split_ = false;
  std::vector<Index> number_;  ///< of the nodes of the box; -1: not there
};

class SphereQuadTopology final : public CubeTopology {
 protected:
  void declareShape(DataTable& table) override {
    table.add("center", center_).unit("m").help("middle of the sphere");
    table.add("radius", radius_).unit("m").help("its radius").min(0, false);
    for (const char* name : {"min", "max"}) table.addVisualOnly(name);
  }
  Vec3 placeOf(const Place& at) const override {
    const Vec3 p = between(-Vec3::Ones(), Vec3::Ones(), at);
    return p.isZero(0) ? center_ : Vec3(center_ + radius_ * p.cwiseAbs().maxCoeff() / p.norm() * p);
  }

 private:
  Vec3 center_ = Vec3::Zero();
  double radius_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(cube_topology) {
  factory.add<stroma::CubeTopology>("CubeTopology", "the surface of a box, cut into quads");
  factory.add<stroma::SphereQuadTopology>("SphereQuadTopology", "the surface of a sphere, cut into quads");
}
