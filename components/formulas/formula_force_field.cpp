// SPDX-License-Identifier: LGPL-2.1-or-later
// FormulaForceField: a load that is given by formulas in the place and the time.
//
//   per = node:    f_a = b(X_a, t)                              b in N
//   per = area:    f_a = integral of N_a b(X, t) dA at rest     b in Pa
//   per = volume:  f_a = integral of N_a b(X, t) dV at rest     b in N/m^3
//   E = -sum f_a . x_a,   K = 0
//
// force holds three formulas, of the components of b along x, y and z, with a semicolon between them. They know x, y, z,
// the place X at rest [m], and t, the time [s] at the end of the step; pi; + - * / ^, comparisons, `&&`, `||` and
// `condition ? a : b`; sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, ln, log2, log10, sqrt, abs, sign,
// min, max. A load does not follow the deformation: it is dead.
//
// The integrals have Gauss points: those of areas and volumes are exact for a b of the first degree on triangles and
// tetrahedra, and of the second along each axis on quads and hexahedra that are boxes. per = node loads `indices`, or
// every node; per = area the faces that SurfacePressureForceField would load; per = volume all cells of the mesh.
//
// The formulas are read by muParser (muparser.beltoforion.de).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0  2 0 0  2 1 0" edges="0 1  1 2  2 3  3 0  0 2  1 4  4 5  5 2
//     2 4" quads="0 1 2 3  1 4 5 2"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 3"/>
//   <MeshSpringForceField linesStiffness="200"/>
//   <FormulaForceField per="area" force="0; 0; x > 1 ? 5 * sin(2*pi*t)^2 : 0"/>
// </Node>
#include <fmt/format.h>
#include <muParser.h>

#include <array>
#include <cmath>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/surface_selection.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// b(X, t): three formulas of x, y, z and t.
class VectorFormula {
 public:
  /// Throws ComponentError with the place of what cannot be read.
  void read(const std::string& text);
  bool dependsOnTime() const { return depends_on_time_; }
  Vec3 at(const Vec3& place, double t) {
    place_ = place, t_ = t;
    return {parsers_[0].Eval(), parsers_[1].Eval(), parsers_[2].Eval()};
  }

 private:
  void readOne(const std::string& text, std::size_t axis);

  std::array<mu::Parser, 3> parsers_;
  Vec3 place_ = Vec3::Zero();
  double t_ = 0;
  bool depends_on_time_ = false;
};

void VectorFormula::read(const std::string& text) {
  std::vector<std::string> parts{""};
  for (const char c : text)
    if (c == ';')
      parts.emplace_back();
    else
      parts.back() += c;
  if (parts.size() != 3)
    throw ComponentError(fmt::format("force has {} formulas", parts.size()),
                         "3, of x, y and z, with a semicolon between them", "force=\"0; 0; -5 * sin(t)\"");
  depends_on_time_ = false;
  for (std::size_t axis = 0; axis < 3; ++axis) readOne(parts[axis], axis);
}

void VectorFormula::readOne(const std::string& text, std::size_t axis) {
  mu::Parser& parser = parsers_[axis];
  try {
    parser.DefineVar("x", &place_[0]);
    parser.DefineVar("y", &place_[1]);
    parser.DefineVar("z", &place_[2]);
    parser.DefineVar("t", &t_);
    parser.DefineConst("pi", M_PI);
    parser.SetExpr(text);
    parser.Eval();
    depends_on_time_ = depends_on_time_ || parser.GetUsedVar().count("t") > 0;
  } catch (const mu::Parser::exception_type& problem) {
    throw ComponentError(fmt::format("the formula '{}' of the {} component cannot be read: {}", text,
                                     std::string("xyz").substr(axis, 1), problem.GetMsg()),
                         "a formula of x, y, z and t", "stroma doc FormulaForceField lists the functions");
  }
}

class FormulaForceField final : public ForceField, public LocalLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh that holds the faces or cells");
    table.add("force", text_)
        .recompiled()
        .help("three formulas of x, y, z and t with a semicolon between them: in N, Pa or N/m^3 with `per`")
        .required();
    table.addChoice("per", per_, {"node", "area", "volume"}).help("what a value of the formula acts on");
    table.add("indices", indices_).help("with per=\"node\" the loaded nodes; every node by default");
    selection_.declare(table);
  }

  void init() override {
    ForceField::init();
    formula_.read(text_);
    points_.clear();
    if (per_ != Per::node && data().find("indices")->isSet())
      throw ComponentError("indices are nodes, and the load is per area or volume", "per=\"node\", or no indices");
    if (per_ == Per::node) loadNodes();
    if (per_ == Per::area) loadFaces();
    if (per_ == Per::volume) loadCells();
    evaluate(node().root().root_time);
    for (const Load& load : loads_)
      if (!load.force.allFinite())
        throw ComponentError(fmt::format("the formula gives {} {} {} at node {}", load.force[0], load.force[1],
                                         load.force[2], load.node),
                             "finite numbers at the start");
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.has_stiffness = false;
    traits.time_dependent = formula_.dependsOnTime();
    return traits;
  }
  void setTime(double t) override { evaluate(t); }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Load& load : loads_) sum -= load.force.dot(x[state().firstRow() + load.node]);
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    for (const Load& load : loads_) f[state().firstRow() + load.node] += load.force;
  }
  void addLoadedRows(std::vector<Index>& rows) const override {
    for (const Load& load : loads_) rows.push_back(state().firstRow() + load.node);
  }
  // K = 0
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}

 private:
  enum class Per : int { node, area, volume };
  struct Load {
    Index node;
    Vec3 force;  ///< [N]
  };
  /// A place where the formula is evaluated, and its part of what each of some nodes gets.
  struct Point {
    Vec3 place;  ///< X [m]
    int count;
    std::array<std::size_t, most_cell_nodes> load;  ///< in loads_
    std::array<double, most_cell_nodes> weight;     ///< 1, or the integral of N_a around it [m^2] or [m^3]
  };

  void prepareLoads() {
    loads_.clear();
    load_of_node_.assign(std::size_t(state().size()), -1);
  }
  std::size_t loadOf(Index node) {
    int& load = load_of_node_[std::size_t(node)];
    if (load < 0) load = int(loads_.size()), loads_.push_back({node, Vec3::Zero()});
    return std::size_t(load);
  }
  void loadNodes() {
    prepareLoads();
    const auto nodes = data().find("indices")->isSet() ? checkedNodes(indices_, state(), "indices") : allNodes(state());
    for (const Index node : nodes) points_.push_back({state().rest_position[node], 1, {loadOf(node)}, {1}});
  }
  const Mesh& mesh() const {
    const Topology* topology = topology_.find(*this, state());
    if (!topology) throw ComponentError("no mesh in this node or above", "a topology with faces or cells");
    return topology->mesh();
  }
  void loadFaces() {
    prepareLoads();
    for (const Face& face : selection_.faces(*this, mesh(), state())) addCell(face.kind(), face.nodes, 1);
  }
  void loadCells() {
    prepareLoads();
    const Mesh& cells = mesh();
    if (highestDimension(cells) < 3)
      throw ComponentError("the mesh has no volume", "tetrahedra or hexahedra, or per=\"area\"");
    forEachCellList(
        [&](const CellKind& kind, const auto& list) {
          for (const auto& cell : list)
            if (kind.dimension == 3) addCell(kind, cell, 1 / cells.overlap);
        },
        cells);
  }
  /// The Gauss points of a face or a cell.
  void addCell(const CellKind& kind, const auto& nodes, double share) {
    const std::size_t count = std::size_t(kind.nodes);
    for (const QuadraturePoint& gauss : kind.rule(kind.affine ? 2 : 3).points) {
      double n[most_cell_nodes];
      LocalPoint slopes[most_cell_nodes];
      kind.shapes(gauss.xi, n);
      kind.gradients(gauss.xi, slopes);
      Point point{Vec3::Zero(), int(count), {}, {}};
      Mat3 tangents = Mat3::Zero();
      for (std::size_t a = 0; a < count; ++a) {
        const Vec3& at = state().rest_position[nodes[a]];
        point.place += n[a] * at;
        for (int i = 0; i < 3; ++i) tangents.col(i) += slopes[a][std::size_t(i)] * at;
      }
      const Vec3 area = tangents.col(0).cross(tangents.col(1));
      const double size = kind.dimension == 2 ? area.norm() : std::abs(area.dot(tangents.col(2)));
      for (std::size_t a = 0; a < count; ++a)
        point.load[a] = loadOf(nodes[a]), point.weight[a] = share * gauss.weight * size * n[a];
      points_.push_back(point);
    }
  }
  void evaluate(double t) {
    for (Load& load : loads_) load.force.setZero();
    for (const Point& point : points_) {
      const Vec3 value = formula_.at(point.place, t);
      for (std::size_t a = 0; a < std::size_t(point.count); ++a) loads_[point.load[a]].force += point.weight[a] * value;
    }
  }

  TopologyLink topology_;
  SurfaceSelection selection_;
  std::string text_;
  Per per_ = Per::node;
  std::vector<int> indices_;
  VectorFormula formula_;
  std::vector<Point> points_;
  std::vector<Load> loads_;
  std::vector<int> load_of_node_;  ///< in loads_, or -1; shape (nodes of the state)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(formula_force_field) {
  factory.add<stroma::FormulaForceField>("FormulaForceField", "a load given by formulas in the place and the time");
}
