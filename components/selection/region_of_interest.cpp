// SPDX-License-Identifier: LGPL-2.1-or-later
// Selects the nodes and cells of a mesh that lie in a region: boxes (BoxROI), spheres (SphereROI), rectangles (PlaneROI),
// one box without another (PairBoxROI). (Of a closed surface: MeshROI.)
//
// The outputs are link sources: indices="@roi.indices". A node on the border is inside: borders are widened for round-off, by
// 1e-9 of the region or of the mesh, whichever is smaller, unless exactBorder="true" (SOFA's way). A cell is inside when all its
// nodes are (strict="true") or when their mean is (strict="false"). The nodes tested are `position`, else the rest positions of
// the state of the node, else those of its topology, else the nearest state or topology above. The cells tested are those given,
// else the lists of the topology of the node or above; their indices count in these lists.
//
// BoxROI: `box` lists axis-aligned boxes (x y z of one corner, x y z of the opposite one). `orientedBox` lists boxes of
// ten numbers, three corners p0 p1 p2 of a parallelogram and a depth d: points p1 + a (p0 - p1) + b (p2 - p1) + c n
// with 0 <= a, b <= 1, |c| <= d/2 and n the unit normal. SphereROI: `centers` and `radii`, one radius for each or one for all; of
// the edges and triangles inside only those that point the way of `direction` or `normal`, where edgeAngle or triAngle is given.
//
// PlaneROI: `plane` lists rectangles of ten numbers, three corners p0 p1 p2 and a depth d: points p0 + a (p1 - p0) +
// b (p2 - p0) + c n with 0 <= a, b <= 1 and |c| <= d/2. PairBoxROI: nodes in inclusiveBox that are not in includedBox.
//
// Unlike SOFA a region that is not given is an error (there: the unit cube), and so is an empty selection, unless
// allowEmpty="true": a clamp that holds nothing is otherwise seen only in the result.
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="4 2 2"/>
//   <BoxROI name="clamped" box="-0.1 -0.1 -0.1 0.1 2.1 2.1"/>
//   <SphereROI name="pulled" centers="4 1 1" radii="0.5"/>
//   <PlaneROI name="face" plane="4 0 0  4 2 0  4 0 2  0.1"/>
//   <PairBoxROI name="shell" inclusiveBox="-1 -1 -1 5 3 3" includedBox="0.5 0.5 0.5 3.5 1.5 1.5"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "components/selection/region_of_interest.h"
#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {

void RegionOfInterest::declare(DataTable& table) {
  table.add("position", position_).alias("rest_position").unit("m").help("nodes tested; default: those of the state or topology");
  table.add("strict", strict_).help("a cell is inside when all its nodes are; false: when its centre is");
  table.add("allowEmpty", allow_empty_).help("an empty selection is no error, nor are no nodes to select from");
  table.add("exactBorder", exact_).help("borders are not widened for round-off, as in SOFA");
  forEachCellList(
      [&table](const CellKind& kind, auto& selection) {
        std::string word(kind.plural);
        word[0] = char(std::toupper(static_cast<unsigned char>(word[0])));
        Data& wanted = table.add("compute" + word, selection.wanted).help(fmt::format("select {}", kind.plural));
        if (kind.type == CellType::quad) wanted.alias("computeQuad");
      },
      cells_);
  table.add("doUpdate", update_).help("accepted for SOFA's scenes: the selection is made once, at rest");
  forEachCellList(
      [&table](const CellKind& kind, auto& selection) {
        const std::string one(kind.singular), many(kind.plural);
        const bool is_quad = kind.type == CellType::quad;  // SOFA's lists of these have other names
        Data& tested = addCellList(table, kind, selection.cells).help(many + " tested; default: those of the topology");
        if (is_quad) tested.alias("quad");
        table.add(one + "Indices", selection.indices).help(many + " inside, by index").output();
        table.add(one + "OutIndices", selection.outside).help(many + " outside, by index").output();
        Data& inside = table.add(many + "InROI", selection.inside_cells).help(many + " inside, by nodes").output();
        if (is_quad) inside.alias("quadInROI");
        table.add(many + "OutROI", selection.outside_cells).help(many + " outside, by nodes").output();
      },
      cells_);
  table.add("indices", indices_).alias("pointIndices").help("nodes inside, ascending").output();
  table.add("indicesOut", outside_).alias("indicesOutside").help("nodes outside, ascending").output();
  table.add("pointsInROI", points_inside_).unit("m").help("positions of the nodes inside").output();
  table.add("pointsOutROI", points_outside_).unit("m").help("positions of the nodes outside").output();
  table.add("nbIndices", count_).help("number of nodes inside").output();
  for (const char* name : {"drawROI", "drawBoxes", "drawSphere", "drawPoints", "drawEdges", "drawTriangles", "drawQuads",
                           "drawTetrahedra", "drawHexahedra", "drawSize"}) table.addVisualOnly(name);
}

void RegionOfInterest::init() {
  if (update_) warn("the selection is made once, at rest: doUpdate is not used", "doUpdate=\"false\"");
  forget();
  prepare();
  findPositions();
  if (!position_.empty()) takeCells();
  for (const Vec3& p : position_) around_.extend(p);
  inside_.resize(position_.size());
  for (std::size_t n = 0; n < position_.size(); ++n) {
    inside_[n] = contains(position_[n]);
    (inside_[n] ? indices_ : outside_).push_back(int(n));
    (inside_[n] ? points_inside_ : points_outside_).push_back(position_[n]);
  }
  count_ = int(indices_.size());
  bool any_cell = false;
  forEachCellList(
      [&](const CellKind&, auto& selection) {
        if (selection.wanted && !position_.empty()) select(selection);
        any_cell = any_cell || !selection.indices.empty();
      },
      cells_);
  if (indices_.empty() && !any_cell && !allow_empty_) failEmpty();
}

/// A selection that is made again starts from nothing.
void RegionOfInterest::forget() {
  indices_.clear();
  outside_.clear();
  points_inside_.clear();
  points_outside_.clear();
  around_.setEmpty();
  forEachCellList(
      [](const CellKind&, auto& selection) {
        selection.indices.clear();
        selection.outside.clear();
        selection.inside_cells.clear();
        selection.outside_cells.clear();
      },
      cells_);
}

void RegionOfInterest::findPositions() {
  const bool is_given = data().find("position")->isSet();
  if (is_given && position_.empty() && !allow_empty_) throw ComponentError("position is empty", "a list of nodes");
  if (is_given) return;
  for (const bool upwards : {false, true}) {
    if (const auto* state = find<State>(upwards)) return void(position_ = nodePlaces(*state, state->rest_position));
    if (const auto* topology = firstTopology(*this, upwards)) return void(position_ = topology->mesh().position);
  }
  if (!allow_empty_) throw ComponentError("there are no nodes to select from", "a state or topology in the node or above, or position");
}

void RegionOfInterest::takeCells() {
  const Topology* topology = findTopology(*this, Index(position_.size()), "position", MeshNodes::first);
  if (!topology) return;
  forEachCellList(
      [this](const CellKind& kind, auto& selection, const auto& from) {
        if (!data().find(kind.plural)->isSet()) selection.cells = from;
      },
      cells_, topology->mesh());
}

template <class Cell>
void RegionOfInterest::select(Selection<Cell>& selection) const {
  for (std::size_t c = 0; c < selection.cells.size(); ++c) {
    const Cell& cell = selection.cells[c];
    bool all = true;
    Vec3 centre = Vec3::Zero();
    for (const Index node : cell) {
      if (node < 0 || std::size_t(node) >= position_.size())
        throw ComponentError(fmt::format("a cell names node {}, but there are {} positions", node, position_.size()),
                             "cells and positions of one mesh");
      all = all && inside_[node];
      centre += position_[node] / double(cell.size());
    }
    bool is_inside = strict_ ? all : contains(centre) || (whole_counts_ && all);
    if constexpr (std::is_same_v<Cell, Edge> || std::is_same_v<Cell, Triangle>) is_inside = is_inside && pointsRight(cell);
    (is_inside ? selection.indices : selection.outside).push_back(int(c));
    (is_inside ? selection.inside_cells : selection.outside_cells).push_back(cell);
  }
}

void RegionOfInterest::failEmpty() const {
  const Vec3 low = around_.min(), high = around_.max();
  throw ComponentError(
      fmt::format("the selection is empty: none of {} nodes is in {}; they lie in ({:.4g} {:.4g} {:.4g}) to ({:.4g} "
                  "{:.4g} {:.4g})",
                  position_.size(), describeRegion(), low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
      "a region with nodes, or allowEmpty=\"true\"");
}

namespace {

class BoxROI : public RegionOfInterest {
 public:
  void declare(DataTable& table) override {
    table.add("box", box_).recompiled().unit("m").help("boxes of six numbers: one corner and the opposite one");
    table.add("orientedBox", oriented_box_)
        .recompiled()
        .unit("m")
        .help("boxes of ten numbers: three corners of a face, and the depth");
    RegionOfInterest::declare(table);
  }

 protected:
  void prepare() override;
  bool contains(const Vec3& p) const override;
  std::string describeRegion() const override {
    return low_.size() + oriented_.size() == 1 ? "the box"
                                               : fmt::format("the {} boxes", low_.size() + oriented_.size());
  }
  std::vector<double> box_, oriented_box_;

 private:
  /// Corner, and the map of p - corner to (a, b, c): a box is 0 <= a, b <= 1, |c| <= 1/2.
  struct Oriented {
    Vec3 corner;
    Mat3 to_unit;
  };
  std::vector<Vec3> low_, high_;
  std::vector<Oriented> oriented_;
};

void BoxROI::prepare() {
  if (box_.empty() && oriented_box_.empty()) throw ComponentError("no box is given", "box or orientedBox");
  if (box_.size() % 6 != 0)
    throw ComponentError(fmt::format("box has {} numbers", box_.size()), "six for each box: x y z of two corners");
  if (oriented_box_.size() % 10 != 0)
    throw ComponentError(fmt::format("orientedBox has {} numbers", oriented_box_.size()),
                         "ten for each box: three points and a depth");
  low_.clear(), high_.clear(), oriented_.clear();
  for (std::size_t i = 0; i < box_.size(); i += 6) {
    const Vec3 a(box_[i], box_[i + 1], box_[i + 2]), b(box_[i + 3], box_[i + 4], box_[i + 5]);
    low_.push_back(a.cwiseMin(b)), high_.push_back(a.cwiseMax(b));
  }
  for (std::size_t i = 0; i < oriented_box_.size(); i += 10) {
    const double* v = oriented_box_.data() + i;
    const Vec3 p0(v[0], v[1], v[2]), p1(v[3], v[4], v[5]), p2(v[6], v[7], v[8]);
    const Vec3 normal = (p1 - p0).cross(p2 - p0);
    if (!(normal.norm() > 0) || v[9] == 0)
      throw ComponentError("an oriented box has no volume", "three points that are not in a line, and a depth");
    Mat3 axes;
    axes << p0 - p1, p2 - p1, normal.normalized() * std::abs(v[9]);
    oriented_.push_back({p1, axes.inverse()});
  }
}

bool BoxROI::contains(const Vec3& p) const {
  for (std::size_t b = 0; b < low_.size(); ++b)
    if (isIn(low_[b], high_[b], p)) return true;
  for (const Oriented& box : oriented_) {
    const Vec3 abc = box.to_unit * (p - box.corner);
    const bool in_face = abc.head<2>().minCoeff() >= -widening && abc.head<2>().maxCoeff() <= 1 + widening;
    if (in_face && std::abs(abc[2]) <= 0.5 + widening) return true;
  }
  return false;
}

class SphereROI : public RegionOfInterest {
 public:
  void declare(DataTable& table) override {
    table.add("centers", centers_).unit("m").help("centres of the spheres");
    table.add("radii", radii_).unit("m").help("a radius for each centre, or one for all").min(0);
    table.add("direction", direction_).unit("-").help("of edges that count, where edgeAngle is given");
    table.add("edgeAngle", edge_angle_).unit("degree").help("between such an edge and direction at most; 0: any").min(0);
    table.add("normal", normal_).unit("-").help("of triangles that count, (c - a) x (b - a), where triAngle is given");
    table.add("triAngle", triangle_angle_).alias("angle").unit("degree").help("between such a normal and normal at most; 0: any").min(0);
    RegionOfInterest::declare(table);
  }

 protected:
  void prepare() override {
    if (centers_.empty()) throw ComponentError("no sphere is given", "centers and radii");
    if (radii_.size() != 1 && radii_.size() != centers_.size())
      throw ComponentError(fmt::format("there are {} radii for {} centers", radii_.size(), centers_.size()),
                           "one radius for each centre, or one for all");
    if ((edge_angle_ > 0 && !(direction_.norm() > 0)) || (triangle_angle_ > 0 && !(normal_.norm() > 0)))
      warn("an angle is given without direction or normal: no edge or no triangle counts", "a vector that is not zero");
  }
  bool pointsRight(const Edge& edge) const override {
    const Vec3 way = position_[edge[1]] - position_[edge[0]];
    return edge_angle_ == 0 || std::abs(way.normalized().dot(direction_.normalized())) >= std::abs(cosine(edge_angle_));
  }
  /// As in SOFA, against the usual normal.
  bool pointsRight(const Triangle& t) const override {
    const Vec3 n = (position_[t[2]] - position_[t[0]]).cross(position_[t[1]] - position_[t[0]]);
    return triangle_angle_ == 0 || n.normalized().dot(normal_.normalized()) >= cosine(triangle_angle_);
  }
  bool contains(const Vec3& p) const override {
    for (std::size_t s = 0; s < centers_.size(); ++s)
      if (const double r = radii_[radii_.size() == 1 ? 0 : s]; (p - centers_[s]).norm() <= r + widened(r)) return true;
    return false;
  }
  std::string describeRegion() const override {
    return centers_.size() == 1 ? "the sphere" : fmt::format("the {} spheres", centers_.size());
  }

 private:
  static double cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }
  std::vector<Vec3> centers_;
  std::vector<double> radii_;
  Vec3 direction_ = Vec3::Zero(), normal_ = Vec3::Zero();
  double edge_angle_ = 0, triangle_angle_ = 0;
};

/// An oriented box by another corner first.
class PlaneROI final : public BoxROI {
 public:
  void declare(DataTable& table) override {
    table.add("plane", plane_).unit("m").help("rectangles of ten numbers: three corners, and the depth");
    RegionOfInterest::declare(table);
  }

 protected:
  void prepare() override {
    oriented_box_ = plane_;
    for (std::size_t i = 0; i + 10 <= plane_.size(); i += 10)
      std::swap_ranges(oriented_box_.begin() + long(i), oriented_box_.begin() + long(i) + 3,
                       oriented_box_.begin() + long(i) + 3);
    BoxROI::prepare();
  }

 private:
  std::vector<double> plane_;
};

class PairBoxROI : public RegionOfInterest {
 public:
  void declare(DataTable& table) override {
    table.add("inclusiveBox", outer_).unit("m").help("x y z of two corners: nodes must be in it");
    table.add("includedBox", inner_).unit("m").help("x y z of two corners: and not in this one");
    RegionOfInterest::declare(table);
    table.find("pointsInROI")->alias("pointsInBox");
  }

 protected:
  void prepare() override {
    if (outer_.size() != 6 || inner_.size() != 6)
      throw ComponentError("inclusiveBox or includedBox has not six numbers", "x y z of two corners");
  }
  bool contains(const Vec3& p) const override { return isInBox(outer_, p) && !isInBox(inner_, p); }
  std::string describeRegion() const override { return "the space between the boxes"; }

 private:
  bool isInBox(const std::vector<double>& box, const Vec3& p) const {
    const Vec3 a(box.data()), b(box.data() + 3);
    return isIn(a.cwiseMin(b), a.cwiseMax(b), p);
  }
  std::vector<double> outer_, inner_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(region_of_interest) {
  factory.add<stroma::PlaneROI>("PlaneROI", "selects the nodes and cells near rectangles");
  factory.add<stroma::PairBoxROI>("PairBoxROI", "selects the nodes and cells in one box and not in another");
  factory.add<stroma::BoxROI>("BoxROI", "selects the nodes and cells in boxes");
  factory.add<stroma::SphereROI>("SphereROI", "selects the nodes and cells in spheres");
}
