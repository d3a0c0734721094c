// SPDX-License-Identifier: LGPL-2.1-or-later
// CarvingRegion: removes tissue. Cells whose centre, the current mean of their nodes, is in a box or a ball are removed
// between two steps. The region may move, like a tool drawn through a body.
//
//   c + velocity (t - begin) + offset   is its centre, begin <= t <= end, checked every `every` seconds
//
// `offset` can be changed during a run: in the live view the pointer drags the region.
//
// A cell is removed with its mass, its forces, its history (plastic or viscous strains), faces and edges of no other cell, and
// points that lose their last cell. With keepsPoints such points stay, fixed in place, so that points keep their numbers.
// Everything else continues from its current state: positions, velocities, histories of other cells.
//
// Source: the scene with the cells taken away, started from the state that the run has then.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <RegularGridTopology n="5 3 3" min="0 0 0" max="0.08 0.04 0.04"/>
//   <MechanicalObject/>
//   <MeshMatrixMass massDensity="1000"/>
//   <BoxROI name="end" box="-1 -1 -1  0.001 1 1"/>
//   <FixedProjectiveConstraint indices="@end.indices"/>
//   <HexahedronFEMForceField youngModulus="3000" poissonRatio="0.4"/>
//   <CarvingRegion sphere="0.08 0.04 0.04  0.02" velocity="-0.1 0 0" begin="0.02" end="0.2"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/output/mesh_change_plan.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

class CarvingRegion final : public MeshChangePlan, public DrawnObstacles {
 public:
  void declare(DataTable& table) override {
    MeshChangePlan::declare(table);
    table.add("box", box_).unit("m").help("two corners of a box: xmin ymin zmin xmax ymax zmax");
    table.add("sphere", sphere_).unit("m").help("centre and radius of a ball: x y z r");
    table.add("velocity", velocity_).unit("m/s").help("of the region");
    table.add("offset", offset_).atOnce().unit("m").help("of the region from where it is else: a hand that leads a tool");
    table.add("begin", begin_).unit("s").help("when the region is where it is given, and carves first");
    table.add("end", end_).unit("s").help("when it carves last; below begin: it does not end");
    table.add("moved", moved_).output().unit("m").help("displacement of the region from its given position");
    table.add("every", every_).unit("s").min(0).help("time between looks; 0: every step");
  }

  void init() override {
    MeshChangePlan::init();
    if (box_.size() != (sphere_.empty() ? 6 : 0) || sphere_.size() != (box_.empty() ? 4 : 0))
      throw ComponentError(
          fmt::format("a region has {} numbers of a box and {} of a ball", box_.size(), sphere_.size()),
          "box with 6 numbers or sphere with 4");
    if (mainKind().dimension == 0) throw ComponentError(topology().path() + " has no cells", "a mesh with cells");
    state_ = node().find<State>(this, true);
    if (!state_ || !state_->hasPointsOnly() || state_->nodes() != topology().mesh().nodes())
      throw ComponentError("no state of points here has the nodes of " + topology().path(), "the node of the body");
    reset();
  }

  void reset() override { moved_ = moved_offset_ = offset_, next_ = begin_, looked_ = std::numeric_limits<double>::lowest(); }
  void serialize(Archive& archive) override {
    archive.value("next", next_);
    archive.value("looked", looked_);
  }
  std::string describe() const override {
    return fmt::format("carves {} from t = {:g} s on", topology().path(), begin_);
  }

  void begin(const Simulation& simulation) override { showShapesAt(simulation.time()); }
  void afterStep(const Simulation& simulation, const StepContext&) override { showShapesAt(simulation.time()); }
  void showShapesAt(double t) override {
    moved_ = std::max(0., (end_ >= begin_ ? std::min(t, end_) : t) - begin_) * velocity_ + offset_;
    moved_offset_ = offset_;
  }
  Vec3 shapesMovedBy() const override { return moved_ + offset_ - moved_offset_; }
  void addShapes(std::vector<Shape>& shapes) const override {
    if (!sphere_.empty()) {
      shapes.push_back({{Vec3(sphere_[0], sphere_[1], sphere_[2])}, {}, sphere_[3]});
      return;
    }
    const Vec3 low(box_[0], box_[1], box_[2]), high(box_[3], box_[4], box_[5]);
    Shape shape;
    for (int corner = 0; corner < 8; ++corner)
      shape.points.emplace_back((corner & 1 ? high : low)[0], (corner & 2 ? high : low)[1], (corner & 4 ? high : low)[2]);
    for (const auto& [a, b, c, d] : {Quad{0, 2, 3, 1}, Quad{4, 5, 7, 6}, Quad{0, 1, 5, 4}, Quad{2, 6, 7, 3},
                                     Quad{0, 4, 6, 2}, Quad{1, 3, 7, 5}}) {
      shape.triangles.push_back({a, b, c});
      shape.triangles.push_back({a, c, d});
    }
    shapes.push_back(std::move(shape));
  }

  std::vector<MeshChange> changesAt(double t, double dt) override {
    constexpr double slack = 1e-6;  // of a step
    if (!state_->isBound() || t < next_ - slack * dt || t == looked_ || (end_ >= begin_ && t > end_ + slack * dt))
      return {};
    std::vector<MeshChange> changes;
    MeshChange change{&topology(), &mainKind(), {}, {}, {}, keeps_points_, true};
    const Vec3 way = (t - begin_) * velocity_ + offset_;
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          for (std::size_t c = 0; kind.type == change.kind->type && c < cells.size(); ++c)
            if (contains(centreOf(cells[c]) - way)) change.removed.push_back(Index(c));
        },
        topology().mesh());
    if (change.removed.empty()) {
      changesMade(t, dt);
    } else {
      changes.push_back(std::move(change));
    }
    return changes;
  }
  void changesMade(double t, double dt) override {
    looked_ = t;
    const double late = t + 1e-6 * dt - next_;
    if (every_ > 0 && late >= 0) next_ += late - std::fmod(late, every_) + every_;
  }

 private:
  template <class Cell>
  Vec3 centreOf(const Cell& cell) const {
    Vec3 sum = Vec3::Zero();
    for (const auto node : cell) sum += Vec3(state_->x()[Index(node)]);
    return sum / double(cell.size());
  }
  bool contains(const Vec3& point) const {
    if (!sphere_.empty()) return (point - Vec3(sphere_[0], sphere_[1], sphere_[2])).norm() <= sphere_[3];
    const Vec3 low(box_[0], box_[1], box_[2]), high(box_[3], box_[4], box_[5]);
    return (point.array() >= low.array().min(high.array())).all() &&
           (point.array() <= low.array().max(high.array())).all();
  }

  std::vector<double> box_, sphere_;
  Vec3 velocity_ = Vec3::Zero(), offset_ = Vec3::Zero();
  double begin_ = 0, end_ = -1, every_ = 0;
  const State* state_ = nullptr;
  double next_ = 0, looked_ = 0;  ///< when it looks next, and looked last [s]
  Vec3 moved_ = Vec3::Zero(), moved_offset_ = Vec3::Zero();  ///< where it is drawn, and the offset in that [m]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(carving_region) {
  factory.add<stroma::CarvingRegion>("CarvingRegion", "removes cells that enter a box or a ball");
}
