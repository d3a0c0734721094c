// SPDX-License-Identifier: LGPL-2.1-or-later
// BarycentricMapping: points embedded in the tetrahedra or hexahedra of a body, as a fine surface in a coarse mesh.
//
//   x_c = sum_a N_a(xi) x_a,   v_c = sum_a N_a v_a,   f_a += N_a f_c
//
// a runs over the corners of the cell that holds the point at the start: N_a are its volume coordinates in a
// tetrahedron, and the trilinear functions of the coordinates xi in a hexahedron, found by Newton's method. A point
// outside of all cells belongs to the nearest one, whose map is continued: linearly, for hexahedra from the nearest
// point of the cell. Every map of the body that is affine moves the points exactly. Points far outside swing far: the
// component says how many there are and how far they lie.
//
// Points on which nothing acts are placed after each step and cost nothing else.
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
#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;

Point toPoint(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// A point in a cell: the weights of its corners, and how far it lies outside [m].
template <std::size_t N>
struct Place {
  std::array<double, N> weights{};
  double distance = 0;
};

Place<4> placeIn(const std::array<Vec3, 4>& corner, const Vec3& p) {
  Mat3 edges;
  edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
  const Vec3 u = edges.inverse() * (p - corner[0]);
  Place<4> place{{1 - u.sum(), u[0], u[1], u[2]}, 0};
  std::array<double, 4> inside{};
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += inside[a] = std::max(0.0, place.weights[a]);
  Vec3 nearest = Vec3::Zero();
  for (std::size_t a = 0; a < 4; ++a) nearest += inside[a] / sum * corner[a];
  place.distance = (p - nearest).norm();
  if (*std::min_element(place.weights.begin(), place.weights.end()) >= 0) place.distance = 0;
  return place;
}

/// Signs of the corners in VTK's order.
constexpr double side[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                               {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

Place<8> placeIn(const std::array<Vec3, 8>& corner, const Vec3& p) {
  std::array<double, 8> value{};
  std::array<Vec3, 8> slope{};
  Mat3 jacobian;
  const auto evaluate = [&](const Vec3& xi) {
    Vec3 x = Vec3::Zero();
    jacobian.setZero();
    for (std::size_t a = 0; a < 8; ++a) {
      const double f[3] = {1 + side[a][0] * xi[0], 1 + side[a][1] * xi[1], 1 + side[a][2] * xi[2]};
      value[a] = f[0] * f[1] * f[2] / 8;
      slope[a] = Vec3(side[a][0] * f[1] * f[2], side[a][1] * f[0] * f[2], side[a][2] * f[0] * f[1]) / 8;
      x += value[a] * corner[a];
      jacobian += corner[a] * slope[a].transpose();
    }
    return x;
  };
  // Newton's method held in the cell: inside it ends at the point, outside at the side that the point lies beyond
  Vec3 xi = Vec3::Zero();
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vec3 before = xi, miss = p - evaluate(xi);
    xi = (xi + jacobian.inverse() * miss).cwiseMax(-1).cwiseMin(1);
    if ((xi - before).norm() < 1e-14) break;
  }
  const Vec3 miss = p - evaluate(xi), beyond = jacobian.inverse() * miss;
  Place<8> place;
  for (std::size_t a = 0; a < 8; ++a) place.weights[a] = value[a] + slope[a].dot(beyond);
  place.distance = beyond.norm() < 1e-9 ? 0 : miss.norm();
  return place;
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
    const Topology* topology = input_topology_.get() ? input_topology_.get() : input().find<Topology>(true);
    if (!topology)
      throw ComponentError(fmt::format("{} has no mesh", input().path()), "a topology, or input_topology=\"@path\"");
    const Mesh& mesh = topology->mesh();
    if (mesh.nodes() != input().size())
      throw ComponentError(
          fmt::format("{} has {} nodes and {} has {}", topology->path(), mesh.nodes(), input().path(), input().size()),
          "the mesh of the state that is followed");
    if (!mesh.tetrahedra.empty())
      embed(mesh.tetrahedra);
    else if (!mesh.hexahedra.empty())
      embed(mesh.hexahedra);
    else
      throw ComponentError(fmt::format("{} has neither tetrahedra nor hexahedra", topology->path()),
                           "a mesh of a volume");
  }

 private:
  template <class Cell>
  void embed(const std::vector<Cell>& cells) {
    constexpr std::size_t corners = std::tuple_size_v<Cell>;
    const std::vector<Vec3>& body = from_rest_ ? input().rest_position : input().position;
    const std::vector<Vec3>& points = from_rest_ ? output().rest_position : output().position;
    const auto cornersOf = [&](std::size_t cell) {
      std::array<Vec3, corners> at;
      for (std::size_t a = 0; a < corners; ++a) at[a] = body[cells[cell][a]];
      return at;
    };
    std::vector<std::pair<Box, std::size_t>> boxes;
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      Vec3 from = Vec3::Constant(std::numeric_limits<double>::infinity()), to = -from;
      for (const Vec3& p : cornersOf(c)) from = from.cwiseMin(p), to = to.cwiseMax(p);
      boxes.emplace_back(Box(toPoint(from), toPoint(to)), c);
      low = low.cwiseMin(from), high = high.cwiseMax(to);
    }
    const bg::index::rtree<std::pair<Box, std::size_t>, bg::index::quadratic<16>> tree(boxes);

    std::size_t outside = 0, farthest = 0;
    double farthest_distance = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point p = toPoint(points[i]);
      Place<corners> best;
      best.distance = std::numeric_limits<double>::infinity();
      std::size_t cell = 0;
      // by ascending distance of their boxes: no cell whose box is farther than the best one can be better
      for (auto found = tree.qbegin(bg::index::nearest(p, unsigned(cells.size()))); found != tree.qend(); ++found) {
        if (bg::distance(found->first, p) >= best.distance) break;
        const Place<corners> place = placeIn(cornersOf(found->second), points[i]);
        if (place.distance < best.distance) best = place, cell = found->second;
        if (best.distance == 0) break;
      }
      if (!std::isfinite(best.distance))
        throw ComponentError(fmt::format("no cell can hold point {}: all have no volume where it is looked for", i),
                             "a body whose cells have volumes where it starts", "useRestPosition=\"true\"");
      std::vector<Weight> weights;
      for (std::size_t a = 0; a < corners; ++a) weights.push_back({cells[cell][a], best.weights[a]});
      addNode(weights);
      outside += best.distance > 0;
      if (best.distance > farthest_distance) farthest_distance = best.distance, farthest = i;
    }
    const double size = (high - low).norm();
    const std::string sentence =
        fmt::format("{} of {} points lie outside of the cells, point {} by {:.3g} m: they follow a cell near by",
                    outside, points.size(), farthest, farthest_distance);
    if (farthest_distance > 0.1 * size)
      warn(sentence, "points inside of the body or near it");
    else if (farthest_distance > 1e-6 * size)
      inform(sentence);
  }

  Link<Topology> input_topology_{"topology"}, output_topology_{"topology"};
  bool from_rest_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(barycentric_mapping) {
  factory.add<stroma::BarycentricMapping>("BarycentricMapping", "points embedded in the cells of a body");
}
