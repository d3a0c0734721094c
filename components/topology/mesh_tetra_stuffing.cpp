// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshTetraStuffing: fills a closed surface with tetrahedra of a body-centred lattice.
//
// The nodes are the corners and the centres of cubes with side `size`. A size of -n means n cubes along the longest side of the box. The
// lattice is centred in the box: vbbox, or the bounding box of the surface enlarged by 1 % on each side. Around each edge of a cube are
// four tetrahedra, each between the two ends of the edge and two neighbouring centres. Whether a node is inside is decided by lines
// through it along the three axes and the four diagonals. Each line votes by the direction in which it crosses the nearest triangle, and a
// tie counts as outside.
//
// Tetrahedra with a node inside are kept. With snapPoints an inner node moves to the nearest point where the surface cuts one of its
// edges, if that is within the fraction alphaLong of an edge of a cube, or alphaShort of an edge to a centre. It then counts as on the
// surface. With splitTetrahedra the outer part of each tetrahedron is cut off where the surface cuts its edges.
//
// Source: F. Labelle, J. R. Shewchuk: Isosurface stuffing (2007); attributes, lattice and order are SOFA's. Here the diagonals of cut sides
// start at the inner node with the smaller number.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <MeshTetraStuffing name="stuffing" size="-3" inputPoints="0 0 0  1 0 0  0 1 0  0 0 1"
//     inputTriangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
//   <Node name="body">
//     <EulerImplicitSolver/>
//     <CGLinearSolver iterations="100" tolerance="1e-9"/>
//     <TetrahedronSetTopologyContainer position="@../stuffing.outputPoints" tetrahedra="@../stuffing.outputTetrahedra"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <TetrahedronFEMForceField youngModulus="1e4" poissonRatio="0.3"/>
//     <FixedProjectiveConstraint indices="0 1 2"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "framework/collision/box_tree.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// In halves of a cube from the first corner: corners are even, middles are odd.
using Spot = std::array<int, 3>;
Spot operator+(const Spot& a, const Spot& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
/// Edges of a node, each beside its opposite; the first six are long.
constexpr std::array<Spot, 14> edges = {
    {{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 2}, {0, 0, -2},
     {1, 1, 1}, {-1, -1, -1}, {-1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}}};

class MeshTetraStuffing final : public Component {
 public:
  std::string roleText() const override { return "mesh engine"; }
  void declare(DataTable& table) override {
    table.add("inputPoints", surface_).help("nodes of the surface").unit("m");
    table.add("inputTriangles", triangles_).help("its triangles");
    table.add("inputQuads", quads_).help("its quads, each taken as two triangles");
    table.add("vbbox", box_).help("lower and upper corner of the part of space to fill; by default that of the surface").unit("m");
    table.add("size", size_).help("edge of a cube; below zero how many there are along the longest side of the box").unit("m");
    table.add("snapPoints", snaps_).help("move nodes that are near the surface onto it");
    table.add("splitTetrahedra", splits_).alias("splitTetras").help("cut off what is outside");
    table.add("alphaLong", alpha_long_).help("what is near, as a part of an edge of a cube").unit("-").min(0).max(0.5);
    table.add("alphaShort", alpha_short_).help("the same of an edge to a middle").unit("-").min(0).max(0.5);
    table.add("outputPoints", points_).help("nodes").unit("m").output();
    table.add("outputTetrahedra", cells_).alias("outputTetras").help("the cells").output();
    table.addVisualOnly("draw");
  }

  void init() override {
    checkInput();
    layOut();
    vote();
    if (snaps_) snap();
    fill();
    if (cells_.empty())
      throw ComponentError("no node of the lattice lies in the surface", "a smaller size, and normals that point outward");
    dropUnused();
  }

 private:
  void checkInput() {
    faces_ = triangles_;
    for (const Quad& q : quads_) {
      faces_.push_back({q[0], q[1], q[2]});
      faces_.push_back({q[0], q[2], q[3]});
    }
    if (surface_.empty() || faces_.empty()) throw ComponentError("there is no surface to fill", "inputPoints and inputTriangles");
    for (const Triangle& t : faces_)
      for (const Index node : t)
        if (node < 0 || std::size_t(node) >= surface_.size())
          throw ComponentError(fmt::format("a triangle names node {} of {}", node, surface_.size()));
    if (size_ == 0) throw ComponentError("size is zero", "the edge of a cube, or -8 for eight of them");
    if (!box_.empty() && box_.size() != 2) throw ComponentError(fmt::format("vbbox has {} corners", box_.size()), "two");
  }

  /// The lattice, and which triangles are near its lines.
  void layOut() {
    Vec3 low = surface_[0], high = surface_[0];
    for (const Vec3& p : surface_) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Vec3 more = (high - low) * 0.01;
    low -= more, high += more;
    if (box_.size() == 2 && box_[0].x() < box_[1].x()) {
      low = box_[0];
      high = box_[1];
    }
    cube_ = size_ > 0 ? size_ : (high - low).maxCoeff() / -size_;
    const Vec3 middle = (low + high) / 2;
    double nodes = 2;
    for (std::size_t a = 0; a < 3; ++a) {
      const int before = int((middle[Index(a)] - low[Index(a)]) / cube_) + 2;
      const int after = int((high[Index(a)] - middle[Index(a)]) / cube_) + 2;
      corners_[a] = before + after + 1;
      first_[Index(a)] = middle[Index(a)] - before * cube_;
      nodes *= corners_[a] + 1;
    }
    constexpr double most = 2e7;
    if (nodes > most)
      throw ComponentError(fmt::format("the lattice has {:.3g} nodes", nodes), fmt::format("a larger size, for {:g} at most", most));
    middles_ = std::size_t(corners_[0]) * std::size_t(corners_[1]) * std::size_t(corners_[2]);
    const std::size_t count =
        middles_ + std::size_t(corners_[0] + 1) * std::size_t(corners_[1] + 1) * std::size_t(corners_[2] + 1);
    points_.clear();
    for (std::size_t p = 0; p < count; ++p) {
      const Spot at = spotOf(p);
      points_.push_back(first_ + cube_ / 2 * Vec3(at[0], at[1], at[2]));
    }
    inside_.assign(count, 0), cuts_.assign(count, {});
    boxes_.clear();
    for (const Triangle& t : faces_) {
      Box box;
      for (const Index node : t) box.add(surface_[std::size_t(node)]);
      boxes_.push_back(box.grownBy(1e-9 * cube_));
    }
    tree_.build(boxes_);
  }
  Spot spotOf(std::size_t p) const {
    const bool is_middle = p >= middles_;
    const std::size_t nx = std::size_t(corners_[0] + is_middle), ny = std::size_t(corners_[1] + is_middle);
    const std::size_t i = p - (is_middle ? middles_ : 0);
    Spot at{int(i % nx) * 2, int(i / nx % ny) * 2, int(i / nx / ny) * 2};
    for (int& c : at) c -= is_middle;
    return at;
  }
  /// -1: beyond the lattice.
  Index nodeAt(const Spot& at) const {
    const int odd = at[0] & 1;
    Index number = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const int n = corners_[a] + odd, c = (at[a] + odd) / 2;
      if (at[a] + odd < 0 || c >= n) return -1;
      number = number * n + c;
    }
    return number + (odd ? Index(middles_) : 0);
  }
  Index neighbour(std::size_t p, std::size_t edge) const { return nodeAt(spotOf(p) + edges[edge]); }

  /// Where lines through nodes cross the surface.
  void vote() {
    for (std::size_t e = 0; e < edges.size(); e += 2)
      for (std::size_t p = 0; p < points_.size(); ++p)
        if (neighbour(p, e) >= 0 && neighbour(p, e + 1) < 0) follow(p, e);
    for (int& votes : inside_) votes = votes > 0 ? 1 : -1;
  }
  void follow(std::size_t start, std::size_t e) {
    std::vector<std::size_t> line;
    for (Index p = Index(start); p >= 0; p = neighbour(std::size_t(p), e)) line.push_back(std::size_t(p));
    std::set<Index> near;
    for (std::size_t i = 1; i < line.size(); ++i) {
      Box box;
      box.add(points_[line[i - 1]]), box.add(points_[line[i]]);
      tree_.forEachMeeting(box, [&near](Index face) { near.insert(face); });
    }
    const Vec3 origin = points_[start], along = points_[line[1]] - origin;
    std::vector<std::pair<double, int>> crossings;  // place in edges; 1: outward
    for (const Index face : near)
      if (const auto crossing = crossed(std::size_t(face), origin, along)) crossings.push_back(*crossing);
    if (crossings.empty()) return;
    std::sort(crossings.begin(), crossings.end());
    std::size_t next = 0;
    for (std::size_t d = 0; d < line.size(); ++d) {
      const double at = double(d);
      while (next < crossings.size() && crossings[next].first < at) ++next;
      int& votes = inside_[line[d]];
      const bool is_last = next == crossings.size();
      if (!is_last && (next == 0 || at - crossings[next - 1].first < crossings[next].first - at))
        votes += crossings[next].second;
      else
        votes -= crossings[next - 1].second;
      if (!is_last) cuts_[line[d]][e] = crossings[next].first - at;
      if (next > 0) cuts_[line[d]][e + 1] = at - crossings[next - 1].first;
    }
  }
  std::optional<std::pair<double, int>> crossed(std::size_t face, const Vec3& origin, const Vec3& along) const {
    const Triangle& t = faces_[face];
    const Vec3 &a = surface_[std::size_t(t[0])], ab = surface_[std::size_t(t[1])] - a, ac = surface_[std::size_t(t[2])] - a;
    const Vec3 across = along.cross(ac);
    const double det = ab.dot(across);
    if (det == 0) return {};
    const Vec3 from = origin - a;
    const double u = from.dot(across) / det;
    const Vec3 q = from.cross(ab);
    const double v = along.dot(q) / det, at = ac.dot(q) / det;
    if (u < 0 || v < 0 || u + v > 1 || at < 0) return {};
    return std::pair(at, ab.cross(ac).dot(along) < 0 ? -1 : 1);
  }

  /// Nodes inside go to the nearest cut that is too near.
  void snap() {
    std::vector<std::size_t> nearby;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (inside_[p] > 0 && nearestCut(p)) nearby.push_back(p);
    for (const std::size_t p : nearby) {
      const std::optional<std::size_t> e = nearestCut(p);
      if (!e) continue;
      points_[p] += cuts_[p][*e] * (points_[std::size_t(neighbour(p, *e))] - points_[p]);
      inside_[p] = 0;
      for (std::size_t other = 0; other < edges.size(); ++other) {
        cuts_[p][other] = 0;
        if (const Index q = neighbour(p, other); q >= 0) cuts_[std::size_t(q)][other ^ 1] = 0;
      }
    }
  }
  std::optional<std::size_t> nearestCut(std::size_t p) const {
    std::optional<std::size_t> nearest;
    double least = 0;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const Index q = neighbour(p, e);
      if (q < 0 || inside_[std::size_t(q)] >= 0) continue;
      const double cut = cuts_[p][e], length = e < 6 ? 1 : 0.75;
      if (cut == 0 || cut >= (e < 6 ? alpha_long_ : alpha_short_)) continue;
      if (const double square = cut * cut * length; !nearest || square < least) {
        nearest = e;
        least = square;
      }
    }
    return nearest;
  }

  void fill() {
    cells_.clear(), split_.clear();
    if (splits_)
      for (std::size_t p = 0; p < inside_.size(); ++p)
        for (std::size_t e = 0; inside_[p] < 0 && e < edges.size(); ++e)
          if (const Index q = neighbour(p, e); q >= 0 && inside_[std::size_t(q)] > 0) {
            split_[{Index(p), q}] = Index(points_.size());
            points_.push_back(points_[p] + std::min(cuts_[p][e], 1.) * (points_[std::size_t(q)] - points_[p]));
          }
    // the middles around an edge along each axis, seen from its upper end
    constexpr int around[3][4][3] = {{{-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1}, {-1, -1, 1}},
                                     {{-1, -1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, -1, -1}},
                                     {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}}};
    for (std::size_t p = 0; p < middles_; ++p)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Index before = neighbour(p, 2 * axis + 1);
        if (before < 0) continue;
        std::array<Index, 4> shell{};
        for (std::size_t i = 0; i < 4; ++i)
          shell[i] = nodeAt(spotOf(p) + Spot{around[axis][i][0], around[axis][i][1], around[axis][i][2]});
        for (std::size_t i = 0; i < 4; ++i) addCell({Index(p), before, shell[(i + 1) % 4], shell[i]});
      }
  }

  void addCell(const Tetrahedron& cell) {
    std::vector<Index> in, on, out;
    for (const Index node : cell) (inside_[std::size_t(node)] > 0 ? in : inside_[std::size_t(node)] < 0 ? out : on).push_back(node);
    if (in.empty() && !out.empty()) return;
    if (out.empty() || !splits_) return keep(cell);
    std::sort(in.begin(), in.end());
    const auto cut = [this](Index outside, Index inside) { return split_.at({outside, inside}); };
    if (in.size() == 1) {
      Tetrahedron moved = cell;
      for (Index& node : moved)
        if (inside_[std::size_t(node)] < 0) node = cut(node, in[0]);
      keep(moved);
    } else if (in.size() == 2 && out.size() == 1) {
      const Index a = cut(out[0], in[0]), b = cut(out[0], in[1]);
      keep({on[0], in[0], in[1], b}), keep({on[0], in[0], b, a});
    } else if (in.size() == 2) {
      const Index a0 = cut(out[0], in[0]), b0 = cut(out[0], in[1]), a1 = cut(out[1], in[0]), b1 = cut(out[1], in[1]);
      keep({in[0], in[1], b0, b1});
      keep({in[0], a0, b0, b1});
      keep({in[0], a0, b1, a1});
    } else {  // a prism: the diagonals of its sides begin at the smaller node
      const Index a = cut(out[0], in[0]), b = cut(out[0], in[1]), c = cut(out[0], in[2]);
      keep({in[0], in[1], in[2], c});
      keep({in[0], in[1], c, b});
      keep({in[0], a, b, c});
    }
  }
  void keep(Tetrahedron cell) {
    const Vec3 a = points_[std::size_t(cell[0])];
    const auto from = [&](std::size_t i) -> Vec3 { return points_[std::size_t(cell[i])] - a; };
    if (from(1).dot(from(2).cross(from(3))) < 0) std::swap(cell[2], cell[3]);
    cells_.push_back(cell);
  }

  void dropUnused() {
    std::vector<Index> number(points_.size(), -1);
    for (const Tetrahedron& cell : cells_)
      for (const Index node : cell) number[std::size_t(node)] = 0;
    std::vector<Vec3> used;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (number[p] == 0) number[p] = Index(used.size()), used.push_back(points_[p]);
    for (Tetrahedron& cell : cells_)
      for (Index& node : cell) node = number[std::size_t(node)];
    points_ = std::move(used);
    inside_.clear();
    cuts_.clear();
    split_.clear();
    boxes_.clear();
  }

  std::vector<Vec3> surface_, box_, points_;
  std::vector<Triangle> triangles_, faces_;
  std::vector<Quad> quads_;
  std::vector<Tetrahedron> cells_;
  double size_ = -8, alpha_long_ = 0.24999, alpha_short_ = 0.42978;
  bool snaps_ = false, splits_ = false;

  double cube_ = 1;               ///< [m]
  Vec3 first_ = Vec3::Zero();     ///< the first corner
  std::array<int, 3> corners_{};  ///< along the axes
  std::size_t middles_ = 0;       ///< node of the first middle
  std::vector<int> inside_;       ///< 1, 0 on the surface, -1
  std::vector<std::array<double, 14>> cuts_;            ///< along each edge to the next crossing, as a part of it; 0: none
  std::map<std::pair<Index, Index>, Index> split_;      ///< cut points, by the node outside and the one inside
  std::vector<Box> boxes_;
  BoxTree tree_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_tetra_stuffing) {
  factory.add<stroma::MeshTetraStuffing>("MeshTetraStuffing", "a lattice of tetrahedra in a surface");
}
