// SPDX-License-Identifier: LGPL-2.1-or-later
// FEMMass: the mass matrix of finite elements by few quadrature points, with a density given at the nodes.
//
//   M_ij = sum over cells and points q of w_q |J(q)| rho(q) N_i(q) N_j(q),   rho(q) = sum_a N_a(q) rho_a,   at rest
//   gravity: the sums of rows
//
// Points: edges, triangles and tetrahedra 1, prisms 2, quads 3, hexahedra and pyramids 2 x 2 x 2. With fewer points than the
// products of N need, M is not of full rank for the first four: MeshMatrixMass has the exact integrals.
//
// NodalMassDensity: `property` lists the density of each node; nodes beyond its end have the last one. FEMMass takes the one
// that nodalMassDensity names, else the nearest in this node or above, else 1 kg/m^3 (per area or length on surfaces and
// lines).
//
// Source: names, attributes and points are SOFA's; the three points of a quad are (sqrt(2/3), 0), (-1/sqrt 6, +-1/sqrt 2).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-9"/>
//   <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
//   <MechanicalObject name="dofs"/>
//   <NodalMassDensity name="density" property="1000"/>
//   <FEMMass template="Vec3,Hexahedron" nodalMassDensity="@density"/>
//   <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
//   <FixedProjectiveConstraint indices="0 4 8"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/mechanics/mesh_mass.h"
#include "components/mechanics/node_pair_matrix.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class NodalMassDensity final : public Component {
 public:
  std::string roleText() const override { return "density of nodes"; }
  void declare(DataTable& table) override {
    table.add("property", density_).help("density of each node; the last one for those beyond the list").unit("kg/m^3").min(0).physical();
    table.add("template", template_).help("Vec3; without effect");
  }
  void init() override {
    if (density_.empty()) throw ComponentError("property is empty", "one density at least");
  }
  double of(Index node) const { return density_[std::min(std::size_t(node), density_.size() - 1)]; }

 private:
  std::vector<double> density_{1};
  std::string template_ = "Vec3";
};

struct Point {
  LocalPoint xi;
  double weight;
};

/// As SOFA's elements have them.
std::vector<Point> pointsOf(const CellKind& kind) {
  if (&kind == &cell_kinds::edge) return {{{0, 0, 0}, 2}};
  if (&kind == &cell_kinds::triangle) return {{{1. / 3, 1. / 3, 0}, 0.5}};
  if (&kind == &cell_kinds::tetrahedron) return {{{0.25, 0.25, 0.25}, 1. / 6}};
  if (&kind == &cell_kinds::quad) {
    const double a = std::sqrt(2. / 3), b = 1 / std::sqrt(6.), c = 1 / std::sqrt(2.);
    return {{{a, 0, 0}, 4. / 3}, {{-b, -c, 0}, 4. / 3}, {{-b, c, 0}, 4. / 3}};
  }
  const double g = 1 / std::sqrt(3.);
  if (&kind == &cell_kinds::prism) return {{{1. / 3, 1. / 3, -g}, 0.5}, {{1. / 3, 1. / 3, g}, 0.5}};
  const bool is_pyramid = &kind == &cell_kinds::pyramid;  // the points of a hexahedron whose upper face is one point
  if (&kind != &cell_kinds::hexahedron && !is_pyramid)
    throw ComponentError(fmt::format("there are no quadrature points of {}", kind.plural),
                         "edges, triangles, quads, tetrahedra, hexahedra, prisms or pyramids", "MeshMatrixMass knows all cells");
  std::vector<Point> points;
  for (const double z : {-g, g})
    for (const double y : {-g, g})
      for (const double x : {-g, g}) {
        const double s = (1 - z) / 2;
        if (is_pyramid)
          points.push_back({{s * x, s * y, 1 - s}, s * s / 2});
        else
          points.push_back({{x, y, z}, 1});
      }
  return points;
}

/// |J|: volume, area or length over that of the reference cell.
double measureOf(const CellKind& kind, const LocalPoint& xi, const Vec3* x) {
  std::array<LocalPoint, most_cell_nodes> slopes;
  kind.gradients(xi, slopes.data());
  Mat3 jacobian = Mat3::Zero();
  for (int a = 0; a < kind.nodes; ++a) jacobian += x[a] * Vec3(slopes[a][0], slopes[a][1], slopes[a][2]).transpose();
  if (kind.dimension == 3) return std::abs(jacobian.determinant());
  return kind.dimension == 2 ? jacobian.col(0).cross(jacobian.col(1)).norm() : jacobian.col(0).norm();
}

class FEMMass final : public Mass {
 public:
  void declare(DataTable& table) override {
    Mass::declare(table);
    topology_.declare(table, "mesh of the cells");
    table.add("template", template_).help("Vec3, or with the kind of cell that carries the mass: Vec3,Hexahedron");
    table.addLink("nodalMassDensity", density_).help("the NodalMassDensity; the nearest one by default");
    table.addVisualOnly("elementSpace");
  }

  void init() override {
    Mass::init();
    const NodalMassDensity* density = density_.get();
    for (const Node* above = &node(); above && !density; above = above->parent())
      for (const auto& component : above->components())
        if (auto* found = dynamic_cast<NodalMassDensity*>(component.get()); found && !density)
          found->ensureReady(), density = found;
    const Topology* topology = topology_.find(*this, state());
    if (!topology) throw ComponentError("there is no mesh whose cells could carry the mass", "a topology");
    const Mesh& mesh = topology->mesh();
    std::vector<MassCell> cells;
    const std::string word = template_.find(',') == std::string::npos ? "" : template_.substr(template_.find(',') + 1);
    const int highest = highestDimension(mesh);
    forEachCellList(
        [&](const CellKind& kind, const auto& list) {
          if (word.empty() ? kind.dimension == highest : kind.word == word)
            for (const auto& cell : list) cells.push_back({&kind, cell.data()});
        },
        mesh);
    if (cells.empty()) throw ComponentError(fmt::format("{} has no such cells", topology->path()), "cells of the template");
    build(cells, density, mesh.overlap);
  }

  const std::vector<double>& lumped() const override { return row_sums_; }
  bool isDiagonal() const override { return false; }
  void addProduct(ConstRows p, double factor, Rows out) const override {
    matrix_.addProduct(state().segment(p), factor, state().segment(out));
  }
  void addPattern(BlockPattern& pattern) const override { matrix_.addPattern(state().firstRow(), pattern); }
  void prepareAssembly(const BlockMatrix& matrix) override { matrix_.prepare(state().firstRow(), matrix); }
  void addTo(double factor, BlockMatrix& matrix) const override { matrix_.addTo(factor, matrix); }
  void addDiagonal(double factor, std::vector<double>& blocks) const override {
    matrix_.addDiagonal(state().firstRow(), factor, blocks);
  }

 private:
  void build(const std::vector<MassCell>& cells, const NodalMassDensity* density, double overlap) {
    std::vector<std::vector<Index>> neighbours(std::size_t(state().size()));
    for (Index i = 0; i < state().size(); ++i) neighbours[std::size_t(i)] = {i};
    for (const MassCell& cell : cells)
      for (int i = 0; i < cell.kind->nodes; ++i)
        neighbours[std::size_t(cell.nodes[i])].insert(neighbours[std::size_t(cell.nodes[i])].end(), cell.nodes,
                                                      cell.nodes + cell.kind->nodes);
    matrix_.build(neighbours);
    row_sums_.assign(std::size_t(state().size()), 0.0);
    std::array<double, most_cell_nodes> shape{};
    std::array<Vec3, most_cell_nodes> x;
    const CellKind* before = nullptr;
    std::vector<Point> points;
    for (const auto& [kind, nodes] : cells) {
      if (kind != before) points = pointsOf(*kind), before = kind;
      for (int a = 0; a < kind->nodes; ++a) x[std::size_t(a)] = state().rest_position[std::size_t(nodes[a])];
      for (const Point& point : points) {
        kind->shapes(point.xi, shape.data());
        double rho = density ? 0 : 1;
        for (int a = 0; density && a < kind->nodes; ++a) rho += shape[std::size_t(a)] * density->of(nodes[a]);
        const double mass = point.weight * measureOf(*kind, point.xi, x.data()) * rho / overlap;
        for (int i = 0; i < kind->nodes; ++i)
          for (int j = 0; j < kind->nodes; ++j) {
            const double entry = mass * shape[std::size_t(i)] * shape[std::size_t(j)];
            matrix_.at(nodes[i], nodes[j]) += entry;
            row_sums_[std::size_t(nodes[i])] += entry;
          }
      }
    }
  }

  TopologyLink topology_;
  Link<NodalMassDensity> density_{"density of nodes"};
  std::string template_;
  NodePairMatrix matrix_;
  std::vector<double> row_sums_;  ///< [kg], shape (nodes)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fem_mass) {
  factory.add<stroma::FEMMass>("FEMMass", "mass matrix of finite elements with a density at the nodes");
  factory.add<stroma::NodalMassDensity>("NodalMassDensity", "the density of each node, for FEMMass");
}
