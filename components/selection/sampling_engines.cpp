// SPDX-License-Identifier: LGPL-2.1-or-later
// Points chosen on a mesh or in it, and what places on a mesh say, before the first step.
//
// MeshSampler: `number` nodes of `position` that lie far from each other. They are chosen one by one, each the farthest from those
//   before: the first is node 0, unless fixedPosition count as chosen. Then they are moved to the middle of the nodes that are
//   nearest to them, at most maxIter times (Lloyd 1982). Distances are along `edges`, or straight without them. outputPosition and
//   outputIndices are theirs.
// RandomPointDistributionInSurface: inPoints, numberOfInPoints points in a closed surface of triangles that are at least
//   minDistanceBetweenPoints from each other. outPoints are those that were tried and lie outside. A point lies inside when the
//   surface winds around it once: when the solid angles of its triangles add up to 4 pi (van Oosterom and Strackee 1983).
// ValuesFromPositions: values that go by the coordinate along `direction`: the first of inputValues where it is least, the last where it
//   is largest, the others evenly between, and linear from one to the next. edgeValues, triangleValues and tetrahedronValues are
//   those at the centres of cells. The nodes are `position`, else those of the state or topology of the node or above.
//   With extent="x" the coordinate is p . direction as it is long, from the least x of the nodes to the largest, as in SOFA.
// Vertex2Frame: frames, one for each node: z is its normal; x = a x z and y = z x x with a the y axis, or the z axis where the
//   normal is along y. With useNormals="false" x points to the next node, y = a x x and z = x x y with a the x axis, or the z axis
//   where that way is along x; the last node has the axes of the one before. Each frame then turns about its axis `rotation`.
//
// The random numbers are the same for one randomSeed, on every machine.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MeshTopology name="box" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3" tetrahedra="0 1 2 3"/>
//   <MeshSampler name="some" position="@box.position" number="2"/>
//   <RandomPointDistributionInSurface name="grains" vertices="@box.position" triangles="@box.triangles" numberOfInPoints="5"
//     minDistanceBetweenPoints="0.05"/>
//   <ValuesFromPositions name="graded" position="@box.position" tetrahedra="@box.tetrahedra" inputValues="1 3" direction="0 0 1"/>
//   <NormalsFromPoints name="out" position="@box.position" triangles="@box.triangles"/>
//   <Vertex2Frame name="upright" position="@box.position" normals="@out.normals"/>
//   <MechanicalObject template="Rigid3" position="@upright.frames"/>
//   <UniformMass totalMass="1"/>
//   <Node name="points">
//     <MechanicalObject position="@../grains.inPoints"/>
//     <UniformMass totalMass="1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "components/selection/engine.h"
#include "components/selection/random_numbers.h"
#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

template <class Cells>
void checkCells(const Cells& cells, std::size_t nodes) {
  for (const auto& cell : cells)
    for (const Index node : cell)
      if (node < 0 || std::size_t(node) >= nodes)
        throw ComponentError(fmt::format("a cell names node {}, and there are {}", node, nodes));
}

class MeshSampler final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("position", position_).help("nodes to choose from").unit("m");
    addCellList(table, cell_kinds::edge, edges_).help("ways between them; straight ones when empty");
    table.add("number", number_).help("how many are chosen").min(1);
    table.add("fixedPosition", fixed_).help("points that are chosen already; the nodes nearest to them count").unit("m");
    table.add("maxIter", most_moves_).help("how often the chosen ones are moved at most").min(0);
    table.add("outputIndices", indices_).help("the chosen nodes").output();
    table.add("outputPosition", chosen_).help("where they are").unit("m").output();
  }
  void init() override {
    const std::size_t nodes = position_.size();
    checkCells(edges_, nodes);
    if (std::size_t(number_) > nodes)
      throw ComponentError(fmt::format("there are {} nodes, and {} are to be chosen", nodes, number_), "a smaller number");
    around_.assign(nodes, {});
    for (const Edge& e : edges_) {
      around_[std::size_t(e[0])].push_back(e[1]);
      around_[std::size_t(e[1])].push_back(e[0]);
    }
    std::vector<std::size_t> fixed;
    for (const Vec3& p : fixed_) fixed.push_back(nearestTo(p));
    std::vector<std::size_t> chosen = farthest(fixed);
    for (int move = 0; move < most_moves_; ++move) {
      const std::vector<std::size_t> moved = toMiddles(fixed, chosen);
      if (moved == chosen) break;
      chosen = moved;
    }
    if (chosen.empty()) throw ComponentError("all nodes lie where a fixed point is", "nodes in other places");
    if (chosen.size() < std::size_t(number_))
      warn(fmt::format("{} of {} nodes were found: all others lie where one is chosen or fixed", chosen.size(), number_),
           "a smaller number");
    indices_.assign(chosen.begin(), chosen.end());
    chosen_.clear();
    for (const std::size_t node : chosen) chosen_.push_back(position_[node]);
  }

 private:
  static constexpr double far = std::numeric_limits<double>::infinity();
  std::size_t nearestTo(const Vec3& p) const {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < position_.size(); ++i)
      if ((position_[i] - p).squaredNorm() < (position_[nearest] - p).squaredNorm()) nearest = i;
    return nearest;
  }
  /// Of each node the way to `from`, where it is shorter than the one in `way`; `owner` then says `number`.
  void spread(std::size_t from, std::size_t number, std::vector<double>& way, std::vector<std::size_t>& owner) const {
    using Place = std::pair<double, std::size_t>;
    std::priority_queue<Place, std::vector<Place>, std::greater<>> waiting;
    const auto reach = [&](std::size_t node, double distance) {
      if (!(distance < way[node])) return;
      way[node] = distance, owner[node] = number;
      if (!edges_.empty()) waiting.emplace(distance, node);
    };
    if (edges_.empty()) {
      for (std::size_t i = 0; i < way.size(); ++i) reach(i, (position_[i] - position_[from]).norm());
      return;
    }
    reach(from, 0);
    while (!waiting.empty()) {
      const auto [distance, node] = waiting.top();
      waiting.pop();
      if (distance > way[node]) continue;
      for (const Index next : around_[node])
        reach(std::size_t(next), distance + (position_[std::size_t(next)] - position_[node]).norm());
    }
  }
  /// At most `number`: none lies where another one or a fixed one is.
  std::vector<std::size_t> farthest(const std::vector<std::size_t>& fixed) const {
    std::vector<double> way(position_.size(), far);
    std::vector<std::size_t> owner(position_.size(), 0), chosen;
    for (const std::size_t node : fixed) spread(node, 0, way, owner);
    while (chosen.size() < std::size_t(number_)) {
      const bool is_first = fixed.empty() && chosen.empty();
      const std::size_t next = is_first ? 0 : std::size_t(std::max_element(way.begin(), way.end()) - way.begin());
      if (way[next] == 0) break;
      chosen.push_back(next);
      spread(next, 0, way, owner);
    }
    return chosen;
  }
  /// Each chosen node becomes the one that is nearest to the mean of those that are nearest to it.
  std::vector<std::size_t> toMiddles(const std::vector<std::size_t>& fixed, const std::vector<std::size_t>& chosen) const {
    std::vector<double> way(position_.size(), far);
    const std::size_t nobody = chosen.size();
    std::vector<std::size_t> owner(position_.size(), nobody), moved = chosen;
    for (std::size_t c = 0; c < chosen.size(); ++c) spread(chosen[c], c, way, owner);
    for (const std::size_t node : fixed) spread(node, nobody, way, owner);
    std::vector<Vec3> middle(chosen.size(), Vec3::Zero());
    std::vector<int> count(chosen.size(), 0);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] != nobody) middle[owner[i]] += position_[i], ++count[owner[i]];
    std::vector<double> least(chosen.size(), far);
    for (std::size_t i = 0; i < owner.size(); ++i) {
      const std::size_t c = owner[i];
      if (c == nobody) continue;
      const double distance = (position_[i] - middle[c] / count[c]).norm();
      if (distance < least[c]) {
        least[c] = distance;
        moved[c] = i;
      }
    }
    return moved;
  }

  std::vector<Vec3> position_, fixed_, chosen_;
  std::vector<Edge> edges_;
  int number_ = 1, most_moves_ = 100;
  std::vector<int> indices_;
  std::vector<std::vector<Index>> around_;
};

class RandomPointDistributionInSurface final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("vertices", vertices_).help("nodes of a closed surface").unit("m");
    addCellList(table, cell_kinds::triangle, triangles_).help("its triangles");
    table.add("numberOfInPoints", number_).help("how many points").min(1).max(1e6);
    table.add("minDistanceBetweenPoints", distance_).help("how far they are from each other at least; negative: anyhow").unit("m");
    table.add("randomSeed", seed_).help("other numbers, other points");
    table.add("inPoints", inside_).help("the points").unit("m").output();
    table.add("outPoints", outside_).help("points that lie outside").unit("m").output();
    for (const char* name : {"isVisible", "drawOutputPoints", "numberOfTests"}) table.addVisualOnly(name);
  }
  void init() override {
    if (vertices_.empty() || triangles_.empty())
      throw ComponentError("there is no surface", "vertices and triangles", "triangles=\"@mesh.triangles\"");
    checkCells(triangles_, vertices_.size());
    Vec3 low = vertices_.front(), high = low;
    for (const Vec3& p : vertices_) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    inside_.clear(), outside_.clear();
    RandomNumbers random(seed_);
    constexpr int patience = 10'000;  // tries without a new point
    for (int tries = 0; tries < patience && inside_.size() < std::size_t(number_); ++tries) {
      Vec3 p;
      for (int a = 0; a < 3; ++a) p[a] = random.between(low[a], high[a]);
      const bool is_near = std::any_of(inside_.begin(), inside_.end(), [&](const Vec3& q) { return (p - q).norm() < distance_; });
      if (is_near) continue;
      if (!isInside(p)) {
        outside_.push_back(p);
        continue;
      }
      inside_.push_back(p), tries = 0;
    }
    if (inside_.empty()) throw ComponentError("no point was found inside of the surface", "a closed one");
    if (inside_.size() < std::size_t(number_))
      warn(fmt::format("{} of {} points were found: there is no room for more", inside_.size(), number_),
           "a smaller minDistanceBetweenPoints");
  }

 private:
  bool isInside(const Vec3& p) const {
    double angle = 0;
    for (const Triangle& t : triangles_) {
      const Vec3 a = vertices_[std::size_t(t[0])] - p, b = vertices_[std::size_t(t[1])] - p, c = vertices_[std::size_t(t[2])] - p;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return std::abs(angle) > 2 * std::numbers::pi;
  }
  std::vector<Vec3> vertices_, inside_, outside_;
  std::vector<Triangle> triangles_;
  int number_ = 10, seed_ = 0;
  double distance_ = 0.1;
};

class ValuesFromPositions final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("inputValues", given_).help("the values, from the least coordinate to the largest");
    table.add("direction", direction_).help("along which the values change").unit("-");
    table.addChoice("extent", extent_, {"direction", "x"}).help("from where to where the values go: along direction, or x as in SOFA");
    table.add("position", position_).alias("rest_position").help("nodes").unit("m");
    addCellList(table, cell_kinds::edge, edges_).help("edges");
    addCellList(table, cell_kinds::triangle, triangles_).help("triangles");
    addCellList(table, cell_kinds::tetrahedron, tetrahedra_).help("tetrahedra");
    table.add("fieldType", kind_).help("0: numbers, the only ones there are").min(0).max(0);
    table.add("values", values_).help("of the nodes").output();
    table.add("edgeValues", edge_values_).help("of the edges").unit("-").output();
    table.add("triangleValues", triangle_values_).help("of the triangles").unit("-").output();
    table.add("tetrahedronValues", tetrahedron_values_).help("of the tetrahedra").unit("-").output();
    for (const char* name : {"drawVectors", "drawVectorLength"}) table.addVisualOnly(name);
  }
  void init() override {
    if (given_.empty()) throw ComponentError("inputValues has no value", "a value, or several from the least coordinate to the largest");
    if (!(direction_.norm() > 0)) throw ComponentError("direction is zero", "a vector that is not");
    findNodes();
    way_ = extent_ == Extent::x ? direction_ : direction_.normalized();
    least_ = std::numeric_limits<double>::infinity(), most_ = -least_;
    for (const Vec3& p : position_) {
      const double here = extent_ == Extent::x ? p.x() : p.dot(way_);
      least_ = std::min(least_, here), most_ = std::max(most_, here);
    }
    if (given_.size() > 1 && !position_.empty() && !(most_ > least_))
      throw ComponentError(fmt::format("all nodes lie in one plane across {}", extent_ == Extent::x ? "x" : "direction"), "another one");
    values_.clear();
    for (const Vec3& p : position_) values_.push_back(at(p));
    atCentres(edges_, edge_values_);
    atCentres(triangles_, triangle_values_);
    atCentres(tetrahedra_, tetrahedron_values_);
  }

 private:
  enum class Extent : int { direction, x } extent_ = Extent::direction;
  void findNodes() {
    if (data().find("position")->isSet()) return;
    for (const bool upwards : {false, true}) {
      const auto* state = find<State>(upwards);
      const auto* topology = firstTopology(*this, upwards);
      if (!state && !topology) continue;
      position_ = state ? nodePlaces(*state, state->rest_position) : topology->mesh().position;
      break;
    }
    const Topology* topology = findTopology(*this, Index(position_.size()), "position", MeshNodes::first);
    const auto take = [this](const char* name, auto& mine, const auto& cells) {
      if (!data().find(name)->isSet()) mine = cells;
    };
    if (!topology) return;
    const Mesh& mesh = topology->mesh();
    take("edges", edges_, mesh.edges);
    take("triangles", triangles_, mesh.triangles);
    take("tetrahedra", tetrahedra_, mesh.tetrahedra);
  }
  double at(const Vec3& p) const {
    const std::size_t last = given_.size() - 1;
    if (last == 0) return given_[0];
    const double place = std::clamp((p.dot(way_) - least_) / (most_ - least_), 0., 1.) * double(last);
    const auto first = std::min(std::size_t(place), last - 1);
    const double share = place - double(first);
    return (1 - share) * given_[first] + share * given_[first + 1];
  }
  template <class Cells>
  void atCentres(const Cells& cells, std::vector<double>& values) const {
    checkCells(cells, position_.size());
    values.clear();
    for (const auto& cell : cells) {
      Vec3 sum = Vec3::Zero();
      for (const Index node : cell) sum += position_[std::size_t(node)];
      values.push_back(at(sum / double(cell.size())));
    }
  }
  std::vector<double> given_, values_, edge_values_, triangle_values_, tetrahedron_values_;
  Vec3 direction_{0, 1, 0}, way_{0, 1, 0};
  std::vector<Vec3> position_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  std::vector<Tetrahedron> tetrahedra_;
  int kind_ = 0;
  double least_ = 0, most_ = 0;  ///< of the coordinate [m]
};

class Vertex2Frame final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("position", position_).help("nodes").unit("m");
    table.add("normals", normals_).help("of the nodes").unit("-");
    table.add("useNormals", by_normals_).help("z along normals; false: x along the way to the next node");
    table.add("invertNormals", opposite_).help("the opposite normals");
    table.add("rotation", axis_).help("about which of its axes each frame turns: 0 x, 1 y, 2 z").min(0).max(2);
    table.add("rotationAngle", angle_).help("by how much").unit("deg");
    table.add("frames", frames_).help("x y z and x y z w of each frame").unit("-").output().inValuesOf(7);
    table.addVisualOnly("texCoords");
  }
  void init() override {
    frames_.clear();
    if (by_normals_ && normals_.size() != position_.size())
      throw ComponentError(fmt::format("there are {} nodes and {} normals", position_.size(), normals_.size()), "one for each node",
                           "normals of NormalsFromPoints");
    if (!by_normals_ && position_.size() == 1) throw ComponentError("there is one node, and no way to a next one", "useNormals=\"true\"");
    const double turn = angle_ * std::numbers::pi / 180;
    for (std::size_t i = 0; i < position_.size(); ++i) {
      const Mat3 axes = by_normals_ ? onNormal(i) : towardsNext(std::min(i, position_.size() - 2));
      const Eigen::Quaterniond q = Eigen::AngleAxisd(turn, axes.col(axis_)) * Eigen::Quaterniond(axes);
      const Vec3& p = position_[i];
      frames_.insert(frames_.end(), {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
    }
  }

 private:
  /// Along which axis something points to within round-off.
  static bool isAlong(double cosine) { return 1 - std::abs(cosine) <= std::numeric_limits<double>::epsilon(); }
  Mat3 onNormal(std::size_t node) const {
    if (!(normals_[node].norm() > 0)) throw ComponentError(fmt::format("the normal of node {} is zero", node));
    Mat3 axes;
    axes.col(2) = (opposite_ ? -1 : 1) * normals_[node].normalized();
    axes.col(0) = (isAlong(axes(1, 2)) ? Vec3::UnitZ() : Vec3::UnitY()).cross(axes.col(2)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0)).normalized();
    return axes;
  }
  Mat3 towardsNext(std::size_t node) const {
    const Vec3 way = position_[node + 1] - position_[node];
    if (!(way.norm() > 0)) throw ComponentError(fmt::format("nodes {} and {} are in one place", node, node + 1));
    Mat3 axes;
    axes.col(0) = way.normalized();
    axes.col(1) = (isAlong(axes(0, 0)) ? Vec3::UnitZ() : Vec3::UnitX()).cross(axes.col(0)).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1)).normalized();
    return axes;
  }
  std::vector<Vec3> position_, normals_;
  bool by_normals_ = true, opposite_ = false;
  int axis_ = 0;
  double angle_ = 0;
  std::vector<double> frames_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sampling_engines) {
  factory.add<stroma::MeshSampler>("MeshSampler", "nodes of a mesh that lie far from each other");
  factory.add<stroma::RandomPointDistributionInSurface>("RandomPointDistributionInSurface", "random points in a closed surface");
  factory.add<stroma::ValuesFromPositions>("ValuesFromPositions", "values that change along a direction");
  factory.add<stroma::Vertex2Frame>("Vertex2Frame", "frames that stand on the nodes of a surface");
}
