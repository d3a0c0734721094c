// SPDX-License-Identifier: LGPL-2.1-or-later
// Dead loads per length of edges and per area of quads, that keep their direction.
//
//   EdgePressureForceField:  f_a = L_0/2 pressure for both ends of an edge, L_0 its length at rest
//                            or with p_intensity q (one for all or one for each edge):  f_a = L_0/2 q n, n normal to the edge
//   QuadPressureForceField:  f_a = A_0/4 pressure for each corner of a quad, A_0 the area of its halves at rest
//
// n is binormal x tangent where a binormal is given, else the direction normal to the edge and to z on the side of the
// only triangle at the edge. It follows the edge, without a tangent; with late it is that of the evaluation before, as SOFA's.
// Edges are listed by their ends (edges), by number (edgeIndices: in the mesh's list, else in the order in which its triangles
// have them), or are all with both ends between dmin and dmax along `normal`; so are quads (quadList).
//
// E = -sum f_a . x_a and K = 0 where forces do not follow.
//
// Source: names, attributes and shares are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3" edges="0 1  1 2  2 3  3 0  0 2"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <MeshSpringForceField linesStiffness="500"/>
//   <EdgePressureForceField edgeIndices="2" pressure="0 1 0"/>
//   <QuadPressureForceField quadList="0" pressure="0 0 -2"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "components/loads/dead_load.h"
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class DeadPressure : public DeadLoad, public LocalLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh that is loaded");
    table.add("normal", normal_).help("with dmin and dmax: elements between two planes are loaded").unit("-");
    table.add("dmin", dmin_).help("distance of the one plane from the origin").unit("m");
    table.add("dmax", dmax_).help("distance of the other").unit("m");
    table.add("allowEmpty", allow_empty_).help("an empty selection is not an error: there is no load");
    for (const char* name : {"showForces", "arrowSizeCoef"}) table.addVisualOnly(name);
  }
  void init() override {
    ForceField::init();
    loads_.clear();
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (const auto& [node, force] : loads_) sum -= force.dot(x[state().firstRow() + node]);
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    for (const auto& [node, force] : loads_) f[state().firstRow() + node] += force;
  }
  void addLoadedRows(std::vector<Index>& rows) const override {
    for (const auto& [node, force] : loads_) rows.push_back(state().firstRow() + node);
  }

 protected:
  const Mesh& mesh() const {
    const Topology* found = topology_.find(*this, state(), MeshNodes::first);
    if (!found) throw ComponentError("there is no mesh to load", "a topology in this node or above");
    return found->mesh();
  }
  const Vec3& rest(Index node) const { return state().rest_position[std::size_t(node)]; }
  bool choosesByPlanes() const { return dmin_ != dmax_; }
  /// Whether all nodes of a cell lie between the planes.
  bool isBetween(const auto& cell) const {
    return std::all_of(cell.begin(), cell.end(), [this](Index node) {
      const double d = rest(node).dot(normal_);
      return d > dmin_ && d < dmax_;
    });
  }
  /// `name`: of the attribute; `thing`: what it lists. `has_any`: the mesh has such.
  void checkCells(const auto& cells, const char* name, const char* thing, bool has_any) const {
    if (cells.empty() && !allow_empty_)
      throw ComponentError(fmt::format("no {} is loaded{}", thing, has_any ? "" : ": the mesh has none"), "at least one",
                           has_any ? "check the selection that is linked"
                                   : "of the faces of volume cells a loader makes some with createSubelements=\"true\", a solid "
                                     "RegularGridTopology with computeQuadList=\"true\" or computeEdgeList=\"true\"");
    if (cells.empty()) warn(fmt::format("{} selects nothing: there is no load", name));
    for (const auto& cell : cells)
      for (const Index node : cell)
        if (node < 0 || node >= state().nodes())
          throw ComponentError(fmt::format("{} names node {} of {}", name, node, state().nodes()),
                               fmt::format("nodes 0 to {}", state().nodes() - 1));
  }
  static const auto& chosen(const auto& cells, int index, const char* name) {
    if (index < 0 || std::size_t(index) >= cells.size())
      throw ComponentError(fmt::format("{} names {}, and the mesh has {}", name, index, cells.size()),
                           cells.empty() ? std::string("a mesh with such cells") : fmt::format("0 to {}", cells.size() - 1));
    return cells[std::size_t(index)];
  }
  Vec3 pressure_ = Vec3::Zero();
  std::vector<std::pair<Index, Vec3>> loads_;  ///< node and force [N]

 private:
  TopologyLink topology_;
  Vec3 normal_ = Vec3::Zero();
  double dmin_ = 0, dmax_ = 0;
  bool allow_empty_ = false;
};

class QuadPressure final : public DeadPressure {
 public:
  void declare(DataTable& table) override {
    DeadPressure::declare(table);
    table.add("pressure", pressure_).help("force per area at rest, of a fixed direction").unit("Pa").required();
    table.add("quadList", list_).help("loaded quads of the mesh");
  }
  void init() override {
    DeadPressure::init();
    const Mesh& found = mesh();
    std::vector<Quad> quads;
    for (const int index : list_) quads.push_back(chosen(found.quads, index, "quadList"));
    if (list_.empty() && choosesByPlanes())
      std::copy_if(found.quads.begin(), found.quads.end(), std::back_inserter(quads), [this](const Quad& q) { return isBetween(q); });
    checkCells(quads, "quadList", "quad", !found.quads.empty());
    for (const Quad& q : quads) {
      const Vec3 diagonal = rest(q[2]) - rest(q[0]);
      const double area = ((rest(q[1]) - rest(q[0])).cross(diagonal).norm() + diagonal.cross(rest(q[3]) - rest(q[0])).norm()) / 2;
      for (const Index node : q) loads_.emplace_back(node, area / 4 * pressure_);
    }
  }

 private:
  std::vector<int> list_;
};

class EdgePressure final : public DeadPressure {
 public:
  void declare(DataTable& table) override {
    DeadPressure::declare(table);
    table.add("pressure", pressure_).help("force per length at rest, of a fixed direction").unit("N/m");
    table.add("edges", edges_).help("loaded edges by their ends");
    table.add("edgeIndices", list_).help("loaded edges by number");
    table.add("p_intensity", intensity_).help("force per length along the normal of each edge, or one for all").unit("N/m");
    table.add("binormal", binormal_).help("normal of the plane of the edges").unit("-");
    table.add("late", late_).help("with p_intensity: normals are those of the time before, as SOFA's");
    table.addChoice("lengths", lengths_, {"own", "first"})
        .help("L_0 with p_intensity: of each loaded edge, or of as many from the mesh's first edge on, as in SOFA");
  }
  void init() override {
    DeadPressure::init();
    const Mesh& found = mesh();
    chosen_ = edges_;
    const std::vector<Edge> all = edgesInOrder(found);
    for (const int index : list_) chosen_.push_back(chosen(all, index, "edgeIndices"));
    if (chosen_.empty() && choosesByPlanes())
      std::copy_if(all.begin(), all.end(), std::back_inserter(chosen_), [this](const Edge& e) { return isBetween(e); });
    checkCells(chosen_, "edges", "edge", !all.empty());
    lengths_at_rest_.clear();
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Edge& e = lengths_ == Lengths::first && i < all.size() ? all[i] : chosen_[i];
      lengths_at_rest_.push_back((rest(e[1]) - rest(e[0])).norm());
    }
    sides_.assign(chosen_.size(), -1);
    for (const Edge& e : chosen_)
      for (const Index node : e) loads_.emplace_back(node, (rest(e[1]) - rest(e[0])).norm() / 2 * pressure_);
    follows_ = pressure_.isZero(0) && !intensity_.empty();
    if (!follows_ && !intensity_.empty()) warn("p_intensity has no effect beside pressure", "one of the two");
    const std::size_t count = chosen_.size(), values = intensity_.size();
    if (follows_ && values != 1 && values != count)
      warn(fmt::format("p_intensity has {} values for {} edges: {}", values, count,
                       values < count ? "the others take the first" : "those beyond are left out"),
           fmt::format("1 value or {}", count));
    if (!follows_ && pressure_.isZero(0)) warn("neither pressure nor p_intensity is given: there is no load");
    if (follows_ && !data().find("binormal")->isSet()) findSides(found);
  }
  ForceTraits traits() const override {
    ForceTraits traits = DeadPressure::traits();
    if (follows_) traits.linear = traits.constant_stiffness = traits.conservative = traits.exact_tangent = false;
    traits.time_dependent = traits.time_dependent || (follows_ && late_);
    return traits;
  }
  double energy(ConstRows x) const override { return follows_ ? 0 : DeadPressure::energy(x); }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    if (!follows_) return DeadPressure::addForce(x, v, f);
    findNormals(x);
    const Index first = state().firstRow();
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Vec3 force = lengths_at_rest_[i] / 2 * intensity_[intensity_.size() > i ? i : 0] * normals_[i];
      for (const Index node : chosen_[i]) f[first + node] += force;
    }
  }
  void setTime(double t) override { time_ = t; }
  void reset() override { normals_.clear(), next_.clear(); }
  void serialize(Archive& archive) override {
    if (!late_) return;
    archive.list("normals", normals_);
    archive.list("next_normals", next_);
    archive.value("normals_at", known_at_);
  }

 private:
  void findNormals(ConstRows x) {
    const Index first = state().firstRow();
    if (late_ && !next_.empty() && time_ == known_at_) return;  // those of the time before stay
    normals_.swap(next_);
    next_.clear();
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Vec3 a = x[first + chosen_[i][0]], b = x[first + chosen_[i][1]], tangent = (b - a).normalized();
      Vec3 n = sides_[i] < 0 ? binormal_.normalized().cross(tangent).normalized() : Vec3::UnitZ().cross(tangent);
      if (sides_[i] >= 0 && n.dot(Vec3(x[first + sides_[i]]) - a) < 0) n = -n;
      next_.push_back(n);
    }
    if (!late_ || normals_.size() != next_.size()) normals_ = next_;
    known_at_ = time_;
  }
  /// Those that the mesh lists, else in the order in which its triangles have them.
  static std::vector<Edge> edgesInOrder(const Mesh& mesh) {
    if (!mesh.edges.empty()) return mesh.edges;
    std::vector<Edge> edges;
    std::map<Edge, int> known;
    for (const Triangle& t : mesh.triangles)
      for (std::size_t j = 0; j < 3; ++j) {
        const Index a = t[(j + 1) % 3], b = t[(j + 2) % 3];
        if (known.emplace(Edge{std::min(a, b), std::max(a, b)}, 0).second) edges.push_back({std::min(a, b), std::max(a, b)});
      }
    return edges;
  }
  /// The third node of the only triangle at each edge.
  void findSides(const Mesh& mesh) {
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      int triangles = 0;
      for (const Triangle& t : mesh.triangles) {
        const bool has = std::count(t.begin(), t.end(), chosen_[i][0]) && std::count(t.begin(), t.end(), chosen_[i][1]);
        if (!has) continue;
        ++triangles;
        for (const Index node : t)
          if (node != chosen_[i][0] && node != chosen_[i][1]) sides_[i] = node;
      }
      if (triangles != 1)
        throw ComponentError(fmt::format("edge {} (nodes {} {}) has {} triangles, so it has no normal", i, chosen_[i][0],
                                         chosen_[i][1], triangles),
                             "an edge on the border of triangles, or a binormal");
    }
  }
  std::vector<Edge> edges_, chosen_;
  std::vector<int> list_;
  std::vector<double> intensity_;
  std::vector<double> lengths_at_rest_;  ///< L_0 [m], shape (loaded edges)
  enum class Lengths { own, first } lengths_ = Lengths::own;
  Vec3 binormal_ = Vec3::Zero();
  std::vector<Index> sides_;
  bool follows_ = false, late_ = false;
  double time_ = 0, known_at_ = 0;       ///< [s]; of next_
  std::vector<Vec3> normals_, next_;     ///< that forces have, and of the place of known_at_; shape (loaded edges)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(edge_and_quad_pressures) {
  factory.add<stroma::EdgePressure>("EdgePressureForceField", "a load per length of edges");
  factory.add<stroma::QuadPressure>("QuadPressureForceField", "a dead load per area of quads");
}
