// SPDX-License-Identifier: LGPL-2.1-or-later
// BarycentricMapping: points embedded in the tetrahedra, hexahedra or quadratic tetrahedra of a body, as a fine surface in
// a coarse mesh; or on the triangles and quads of a body that has no volume, or on its edges.
//
//   x_c = sum_a N_a(xi) x_a,   v_c = sum_a N_a v_a,   f_a += N_a f_c
//
// a runs over the nodes of the cell that holds the point at the start: N_a are its volume coordinates in a
// tetrahedron, and in a hexahedron or a quadratic tetrahedron the trilinear or quadratic functions of the coordinates xi,
// found by Newton's method. A point
// outside of all cells belongs to the nearest one, whose map is continued: linearly, for these two from the nearest
// point of the cell. Every map of the body that is affine moves the points exactly. Points far outside swing far: the
// component says how many there are and how far they lie.
//
// Points of triangles, quads and edges are moved onto the nearest of these where the scene starts, and stay there: N_a are those of
// the foot of the point.
//
// Points on which nothing acts are placed after steps that something reads, and cost nothing else.
//
// Source: the attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01">
//   <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="0.1 0.1 0.2"/>
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="25" tolerance="1e-8"/>
//   <Node name="body">
//     <TetrahedronSetTopologyContainer name="mesh"/>
//     <Hexa2TetraTopologicalMapping input="@../grid" output="@mesh"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.4"/>
//     <FixedProjectiveConstraint indices="0 1 2"/>
//     <Node name="surface">
//       <MechanicalObject position="0.03 0.05 0.2  0.07 0.05 0.2  0.05 0.1 0.1"/>
//       <BarycentricMapping/>
//     </Node>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/LU>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>

#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;

Point toPoint(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// A point in a cell: the weights of its corners, and how far it lies outside [m].
struct Place {
  std::array<double, most_cell_nodes> weights{};
  double distance = 0;
};

Place placeInTetrahedron(const Vec3* corner, const Vec3& p) {
  Mat3 edges;
  edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
  const Vec3 u = edges.inverse() * (p - corner[0]);
  Place place{{1 - u.sum(), u[0], u[1], u[2]}, 0};
  std::array<double, 4> inside{};
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += inside[a] = std::max(0.0, place.weights[a]);
  Vec3 nearest = Vec3::Zero();
  for (std::size_t a = 0; a < 4; ++a) nearest += inside[a] / sum * corner[a];
  place.distance = (p - nearest).norm();
  if (*std::min_element(place.weights.begin(), place.weights.begin() + 4) >= 0) place.distance = 0;
  return place;
}

/// Newton's method held in the cell: inside it ends at the point, outside at the side that the point lies beyond.
Place placeInCurved(const CellKind& kind, const Vec3* corner, const Vec3& p) {
  std::array<double, most_cell_nodes> value{};
  std::array<LocalPoint, most_cell_nodes> slope{};
  const auto slopeOf = [&](std::size_t a) { return Vec3(slope[a][0], slope[a][1], slope[a][2]); };
  Mat3 jacobian;
  const auto evaluate = [&](const LocalPoint& xi) {
    kind.shapes(xi, value.data());
    kind.gradients(xi, slope.data());
    Vec3 x = Vec3::Zero();
    jacobian.setZero();
    for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a)
      x += value[a] * corner[a], jacobian += corner[a] * slopeOf(a).transpose();
    return x;
  };
  LocalPoint xi{};
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vec3 before(xi.data()), miss = p - evaluate(xi), next = before + jacobian.inverse() * miss;
    xi = {next[0], next[1], next[2]};
    kind.hold(xi);
    if ((Vec3(xi.data()) - before).norm() < 1e-14) break;
  }
  const Vec3 miss = p - evaluate(xi), beyond = jacobian.inverse() * miss;
  Place place;
  for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) place.weights[a] = value[a] + slopeOf(a).dot(beyond);
  place.distance = beyond.norm() < 1e-9 ? 0 : miss.norm();
  return place;
}

/// The foot of the point on an edge, a triangle or a quad, by the method of Gauss and Newton; it may lie beyond their borders.
Place placeOn(std::size_t nodes, const Vec3* corner, const Vec3& p) {
  double u = 0, v = 0;
  const auto weights = [nodes](double a, double b) {
    Place place;
    if (nodes == 2) place.weights = {1 - a, a};
    if (nodes == 3) place.weights = {1 - a - b, a, b};
    if (nodes == 4) place.weights = {(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b};
    return place;
  };
  const auto at = [&](const Place& place) {
    Vec3 x = Vec3::Zero();
    for (std::size_t a = 0; a < nodes; ++a) x += place.weights[a] * corner[a];
    return x;
  };
  for (int iteration = 0; iteration < (nodes == 4 ? 30 : 1); ++iteration) {
    const Vec3 miss = p - at(weights(u, v));
    Vec3 along = corner[1] - corner[0];
    if (nodes == 4) along = (1 - v) * along + v * (corner[2] - corner[3]);
    if (nodes == 2) {
      u += along.dot(miss) / along.squaredNorm();
      continue;
    }
    Vec3 across = corner[nodes - 1] - corner[0];
    if (nodes == 4) across = (1 - u) * across + u * (corner[2] - corner[1]);
    const double uu = along.squaredNorm(), uv = along.dot(across), vv = across.squaredNorm(), size = uu * vv - uv * uv;
    const double du = (vv * along.dot(miss) - uv * across.dot(miss)) / size, dv = (uu * across.dot(miss) - uv * along.dot(miss)) / size;
    u += du, v += dv;
    if (std::abs(du) + std::abs(dv) < 1e-14) break;
  }
  double a = std::clamp(u, 0., 1.), b = std::clamp(v, 0., 1.);
  if (nodes == 3 && a + b > 1) a /= a + b, b = 1 - a;
  Place place = weights(u, v);
  place.distance = (p - at(weights(a, b))).norm();
  return place;
}

Place placeIn(const CellKind& kind, const Vec3* corner, const Vec3& p) {
  if (kind.dimension < 3) return placeOn(std::size_t(kind.nodes), corner, p);
  return kind.affine ? placeInTetrahedron(corner, p) : placeInCurved(kind, corner, p);
}

class BarycentricMapping final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.addLink("input_topology", input_topology_)
        .help("mesh whose cells hold the points; the one of the state that is followed when not given");
    table.addLink("output_topology", output_topology_).help("SOFA's; without effect: the points are those of output");
    table.add("useRestPosition", from_rest_).help("find the cells at rest instead of at the start");
  }

  void init() override {
    WeightedMapping::init();
    for (const State* state : {&input(), &output()})
      if (!state->hasPointsOnly())
        throw ComponentError(state->path() + " has other nodes than points",
                             "points; a RigidMapping or a SkinningMapping with frames");
    const Topology* topology = findTopology(input(), input(), input_topology_, MeshNodes::all, "input_topology");
    if (!topology)
      throw ComponentError(fmt::format("{} has no mesh", input().path()), "a topology, or input_topology=\"@path\"");
    const int dimension = highestDimension(topology->mesh());
    if (dimension < 1)
      throw ComponentError(fmt::format("{} has no cells", topology->path()), "a mesh of a volume, of a surface or of lines");
    found_.assign(output().position.size(), {});
    bg::assign_inverse(around_);
    bool embedded = false;  // in cells of one kind, on surfaces in those of both
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          if (kind.dimension != dimension || cells.empty() || (embedded && dimension == 3) || (dimension < 3 && kind.nodes > 4)) return;
          embed(kind, cells);
          embedded = true;
        },
        topology->mesh());
    if (!embedded) throw ComponentError(fmt::format("{} has only cells of curved edges", topology->path()), "triangles, quads or edges");
    finish();
  }

 private:
  using Tree = bg::index::rtree<std::pair<Box, std::size_t>, bg::index::quadratic<16>>;

  /// Where a point lies best.
  struct Found {
    double distance = std::numeric_limits<double>::infinity();
    std::vector<Weight> weights;
  };

  /// Gives every point its cell, where it has none that is nearer.
  template <class Cell>
  void embed(const CellKind& kind, const std::vector<Cell>& cells) {
    const std::vector<Vec3>& body = from_rest_ ? input().rest_position : input().position;
    const std::vector<Vec3>& points = from_rest_ ? output().rest_position : output().position;
    const Tree tree = treeOf(cells, body);
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::size_t cell = 0;
      const Place best = nearestPlace(kind, cells, body, tree, points[i], cell);
      if (!(best.distance < found_[i].distance)) continue;
      found_[i] = {best.distance, {}};
      for (std::size_t a = 0; a < cells[cell].size(); ++a) found_[i].weights.push_back({cells[cell][a], best.weights[a]});
    }
  }

  void finish() {
    std::size_t outside = 0, farthest = 0;
    double farthest_distance = 0;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (!std::isfinite(found_[i].distance))
        throw ComponentError(fmt::format("no cell can hold point {}: all have no volume where it is looked for", i),
                             "a body whose cells have volumes where it starts", "useRestPosition=\"true\"");
      addNode(found_[i].weights);
      outside += found_[i].distance > 0;
      if (found_[i].distance > farthest_distance) farthest_distance = found_[i].distance, farthest = i;
    }
    if (outside > 0)
      tellOutside(
          fmt::format("{} of {} points lie outside of the cells, point {} by {:.3g} m: they follow a cell near by",
                      outside, found_.size(), farthest, farthest_distance),
          farthest_distance / bg::distance(around_.min_corner(), around_.max_corner()));
    found_.clear();
  }

  /// `share`: of the size of the body.
  void tellOutside(const std::string& sentence, double share) const {
    if (share > 0.1)
      warn(sentence, "points inside of the body or near it");
    else if (share > 1e-6)
      inform(sentence);
  }

  /// The boxes of the cells; `around_` holds all of them.
  template <class Cell>
  Tree treeOf(const std::vector<Cell>& cells, const std::vector<Vec3>& body) {
    std::vector<std::pair<Box, std::size_t>> boxes;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      Vec3 from = Vec3::Constant(std::numeric_limits<double>::infinity()), to = -from;
      const auto corners = cornersOf(cells[c], body);
      for (const Vec3& p : corners) from = from.cwiseMin(p), to = to.cwiseMax(p);
      if constexpr (std::tuple_size_v<Cell> ==
                    10)  // the Bezier points of curved edges bound the cell, its nodes do not
        for (std::size_t e = 0; e < cell_tables::tetrahedron_middles.size(); ++e) {
          const auto [a, b] = cell_tables::tetrahedron_middles[e];
          const Vec3 p = 2 * corners[4 + e] - (corners[std::size_t(a)] + corners[std::size_t(b)]) / 2;
          from = from.cwiseMin(p), to = to.cwiseMax(p);
        }
      boxes.emplace_back(Box(toPoint(from), toPoint(to)), c);
      bg::expand(around_, boxes.back().first);
    }
    return Tree(boxes);
  }

  /// In the nearest cell, whose number goes to `cell`: by ascending distance of their boxes, as no cell whose box is
  /// farther than the best one can be better.
  template <class Cell>
  static Place nearestPlace(const CellKind& kind, const std::vector<Cell>& cells, const std::vector<Vec3>& body,
                            const Tree& tree, const Vec3& point, std::size_t& cell) {
    const Point p = toPoint(point);
    Place best;
    best.distance = std::numeric_limits<double>::infinity();
    for (auto found = tree.qbegin(bg::index::nearest(p, unsigned(cells.size()))); found != tree.qend(); ++found) {
      if (bg::distance(found->first, p) >= best.distance) break;
      const Place place = placeIn(kind, cornersOf(cells[found->second], body).data(), point);
      if (place.distance < best.distance) best = place, cell = found->second;
      if (best.distance == 0) break;
    }
    return best;
  }

  Link<Topology> input_topology_{"topology"}, output_topology_{"topology"};
  bool from_rest_ = false;
  std::vector<Found> found_;  ///< of each point, while they are looked for
  Box around_;                ///< all cells
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(barycentric_mapping) {
  factory.add<stroma::BarycentricMapping>("BarycentricMapping", "points embedded in the cells of a body");
}
