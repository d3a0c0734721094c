// SPDX-License-Identifier: LGPL-2.1-or-later
// BarycentricMapping: points embedded in the tetrahedra, hexahedra or quadratic tetrahedra of a body, as a fine surface in
// a coarse mesh; or on the triangles and quads of a body that has no volume, or on its edges.
//
//   x_c = sum_a N_a(xi) x_a,   v_c = sum_a N_a v_a,   f_a += N_a f_c
//
// a runs over the nodes of the cell that contains the point at the start: N_a are its volume coordinates in a tetrahedron, and
// in a hexahedron or a quadratic tetrahedron the trilinear or quadratic functions of the coordinates xi, found by Newton's
// method. A point outside of all cells belongs to the nearest one, whose map is extrapolated linearly, for these two from the
// nearest point of the cell. An affine deformation of the body moves the points exactly. Points far outside amplify rotations:
// the component reports how many there are and how far out they are.
//
// Points of triangles, quads and edges are moved onto the nearest of these at the start, and stay there: N_a are those of the
// projected point.
//
// foundBy = centres takes for a point outside, or off a surface, the cell with the nearest centre and extrapolates its shape
// functions, as SOFA does (cell_centres.h). On edges and for frames there is no difference.
//
// A child of frames (template Rigid3) is embedded too, in tetrahedra or hexahedra: its centres as points, and its orientations
// turn with the cells, by the rotation closest to the deformation gradient there (cell_turns.h). The mapping is then
// nonlinear, and BarrierContact does not accept surfaces on such frames, because their distance from the straight path of a
// step has no bound.
//
// With cellsOf = grid the cells of a RegularGridTopology or SparseGridTopology are where the grid is written, and not where the body
// starts; with moved_grid the grid is moved first, without scale and turn, so that its first node is the body's at rest. In SOFA the
// points of grids are found so.
//
// Points without forces are only updated after steps in which they are read, and cost nothing otherwise.
//
// Source: the attributes are SOFA's, and so are embedded frames; forces and torques pass here by the exact Jacobian.
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

#include <algorithm>
#include <cmath>

#include "components/mappings/cell_centres.h"
#include "components/mappings/cell_embedding.h"
#include "components/mappings/cell_turns.h"
#include "components/mappings/weighted_mapping.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class BarycentricMapping final : public WeightedMapping {
 public:
  void declare(DataTable& table) override {
    WeightedMapping::declare(table);
    table.addLink("input_topology", input_topology_)
        .help("mesh whose cells contain the points; by default that of the parent state");
    table.addLink("output_topology", output_topology_).help("SOFA's; without effect: the points are those of output");
    table.addChoice("foundBy", found_by_, {"nearest", "centres"})
        .help("which cell a point outside of all belongs to: the nearest, or the one with the nearest centre, as in SOFA");
    table.addChoice("cellsOf", cells_of_, {"start", "grid", "moved_grid"})
        .help(
            "where the cells of a grid are searched: where the body starts, where the grid is written, or there moved so that its first "
            "node is the body's at rest");
    table.add("useRestPosition", from_rest_).help("find the cells at rest instead of at the start");
  }

  void init() override {
    WeightedMapping::init();
    turns_.clear();
    if (!input().hasPointsOnly() || (!output().hasPointsOnly() && !output().hasFrames()))
      throw ComponentError((input().hasPointsOnly() ? output() : input()).path() + " has other nodes than points",
                           "points; a RigidMapping or a SkinningMapping with frames");
    const Topology* topology = findTopology(input(), input(), input_topology_, MeshNodes::all, "input_topology");
    if (!topology)
      throw ComponentError(fmt::format("{} has no mesh", input().path()), "a topology, or input_topology=\"@path\"");
    double size = 0;
    std::vector<Vec3> grid = topology->mesh().position;
    const bool by_grid = cells_of_ != CellsOf::start && grid.size() == input().position.size() &&
                         (topology->type() == "RegularGridTopology" || topology->type() == "SparseGridTopology");
    const Vec3 way = by_grid && cells_of_ == CellsOf::moved_grid ? Vec3(input().rest_position[0] - grid[0]) : Vec3(Vec3::Zero());
    for (Vec3& place : grid) place += way;
    const std::vector<Vec3>& body = by_grid ? grid : from_rest_ ? input().rest_position : input().position;
    const std::vector<Vec3> points = nodePlaces(output(), from_rest_ ? output().rest_position : output().position);
    const bool by_centres = found_by_ == FoundBy::centres && !output().hasFrames() && findsByCentres(*topology);
    const std::vector<EmbeddedPoint> found =
        by_centres ? embedByCentres(*topology, body, points, size) : embedPoints(*topology, body, points, size);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!std::isfinite(found[i].distance))
        throw ComponentError(fmt::format("no cell can contain point {}: all have no volume where it is searched", i),
                             "a body whose cells have volumes where it starts", "useRestPosition=\"true\"");
      std::vector<Weight> weights;
      for (std::size_t a = 0; a < found[i].nodes.size(); ++a) weights.push_back({found[i].nodes[a], found[i].weights[a]});
      addNode(weights);
      if (output().hasFrames()) addTurn(Index(i), found[i]);
    }
    tellOutside(found, size);
  }

  void compile() override {
    WeightedMapping::compile();
    if (!turns_.empty()) refuseStepLimits();
  }

  bool isLinear() const override { return turns_.empty(); }
  void apply(Rows x) const override {
    turns_.noteSigns(x, output().firstRow());
    WeightedMapping::apply(x);
    turns_.apply(x, input().firstRow(), output().firstRow());
  }
  void applyJ(Rows v) const override {
    WeightedMapping::apply(v);
    turns_.applyJ(v, input().firstRow(), output().firstRow());
  }
  void applyJT(Rows f) const override {
    WeightedMapping::applyJT(f);
    turns_.applyJT(f, input().firstRow(), output().firstRow());
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    WeightedMapping::addJacobian(out);
    turns_.addJacobian(out, input().firstRow(), output().firstRow());
  }
  void addCurvature(ConstRows v, Rows a) const override {
    turns_.addCurvature(v, a, input().firstRow(), output().firstRow());
  }
  void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const override {
    forBlocks(f, [&](Index row, Index column, const Mat3& block) { df[row] += factor * (block * dx[column]); });
  }
  void addGeometricPattern(BlockPattern& pattern) const override {
    forBlocks({}, [&](Index row, Index column, const Mat3&) { pattern.addBlock(row, column); });
  }
  void addGeometricStiffness(ConstRows f, double factor, BlockMatrix& matrix) const override {
    forBlocks(f, [&](Index row, Index column, const Mat3& block) { matrix.add(row, column, factor * block); });
  }

 private:
  /// How far what these frames carry leaves the line of a step has no bound: what limits steps would miss some contacts.
  void refuseStepLimits() const {
    std::vector<Mapping*> mappings;
    std::vector<ForceField*> fields;
    node().root().collect(mappings);
    node().root().collect(fields);
    std::vector<const State*> carried{&output()};
    const auto is_carried = [&carried](const State* state) {
      return std::find(carried.begin(), carried.end(), state) != carried.end();
    };
    for (bool grows = true; grows;) {
      grows = false;
      for (const Mapping* mapping : mappings) {
        const std::vector<State*> from = mapping->inputs();
        if (is_carried(&mapping->output()) || std::none_of(from.begin(), from.end(), is_carried)) continue;
        carried.push_back(&mapping->output()), grows = true;
      }
    }
    for (const ForceField* field : fields) {
      if (!dynamic_cast<const StepLimiter*>(field)) continue;
      for (const State* state : field->states())
        if (is_carried(state))
          throw ComponentError(fmt::format("{} limits steps by {}, which embedded frames carry on ways that have no bound",
                                           field->path(), state->path()),
                               "contact on points that are embedded themselves, or CollisionResponse");
    }
  }

  /// The second row of a frame.
  void addTurn(Index frame, const EmbeddedPoint& place) {
    if (place.slopes.empty())
      throw ComponentError(fmt::format("frame {} has no cell with a volume to turn with", frame),
                           "a mesh of volume cells; frames of other frames take a RigidMapping");
    const std::vector<Vec3>& rows = from_rest_ ? output().rest_position : output().position;
    turns_.add(2 * frame + 1, place.nodes, place.slopes, turnedBy(rows[std::size_t(2 * frame + 1)]));
    addNode({});
  }
  template <class Visit>
  void forBlocks(ConstRows f, Visit&& visit) const {
    turns_.forGeometricBlocks(f, input().firstRow(), output().firstRow(), visit);
  }

  /// `size`: of the body.
  void tellOutside(const std::vector<EmbeddedPoint>& found, double size) const {
    std::size_t outside = 0, farthest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      outside += found[i].distance > 0;
      if (found[i].distance > found[farthest].distance) farthest = i;
    }
    if (outside == 0) return;
    const double most = found[farthest].distance;
    const std::string sentence =
        fmt::format("{} of {} points lie outside of the cells, point {} by {:.3g} m: they follow a cell near by", outside,
                    found.size(), farthest, most);
    if (most > 0.1 * size)
      warn(sentence, "points inside of the body or near it");
    else if (most > 1e-6 * size)
      inform(sentence);
  }

  Link<Topology> input_topology_{"topology"}, output_topology_{"topology"};
  bool from_rest_ = false;
  enum class FoundBy : int { nearest, centres } found_by_ = FoundBy::nearest;
  enum class CellsOf : int { start, grid, moved_grid } cells_of_ = CellsOf::start;
  CellTurns turns_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(barycentric_mapping) {
  factory.add<stroma::BarycentricMapping>("BarycentricMapping", "points embedded in the cells of a body");
}
