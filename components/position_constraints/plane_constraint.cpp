// SPDX-License-Identifier: LGPL-2.1-or-later
// PlaneConstraint: nodes do not penetrate planes, whatever force that takes.
//
//   n.x_i >= d  for each plane (unit normal n pointing to the free side, distance d from the origin)
//
// After each step a node behind a plane is moved back to it, along the normal, or along what other constraints leave
// free of it; then the part of its velocity that points into the plane is removed. The other parts stay: a node slides
// without friction and leaves the plane when anything draws it away. The push back does not enter the velocity, so
// nothing bounces. Until the end of the step the other position constraints move a node in contact along the plane
// only, so that they agree in a few turns; rigid sets do not know this, and each turn lifts a touching node by its share
// of the set's inertia only: the more nodes a set has, the more turns a contact on an edge or a corner takes, and a set
// that does not hold within the 1000 turns of a step is reported. A node that is held behind a plane cannot be moved:
// the step's report says so.
//
// Source: the non-penetrating area of Nesme et al. 2005, section 4; the update of positions and velocities is that of
// an inelastic, frictionless contact (Moreau).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 1  1 0 1  0 1 2"/>
//   <UniformMass totalMass="3"/>
//   <PlaneConstraint normal="0 0 1" d="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/state_positions.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PlaneConstraint final : public PositionConstraint {
 public:
  void declare(DataTable& table) override {
    PositionConstraint::declare(table);
    table.add("normal", normals_).required().unit("-").help("normals of the planes, to the side that nodes may be on");
    table.add("d", distances_)
        .unit("m")
        .help("distance of each plane from the origin along its normal, or one for all");
    table.add("indices", indices_).help("nodes that do not penetrate; every node by default");
    table.add("tolerance", tolerance_)
        .unit("m")
        .min(0)
        .help("tolerated depth; 0: 1e-12 of the body's size. Never below the round-off of positions");
  }
  void init() override;
  void compile() override {
    contacts_.reserve(nodes_.size() * normals_.size());
    contact_of_.assign(nodes_.size() * normals_.size(), -1);
  }
  void begin(const PositionStep& step) override {
    allowed_ = std::max(tolerance_, roundOff(step.x_start, nodes_));
    contacts_.clear();
    std::fill(contact_of_.begin(), contact_of_.end(), -1);
  }
  double correctPositions(const PositionStep& step, Rows x, Rows reference) override;
  double correctVelocities(const PositionStep& step, ConstRows x, Rows v) override;
  std::string violation() const override {
    return fmt::format("node {} is {:.3g} m behind plane {} and fixed there", worst_node_, worst_depth_, worst_plane_);
  }
  bool takesFrames() const override { return true; }
  std::string describe() const override {
    return fmt::format("{} nodes stay in front of {} plane{}", nodes_.size(), normals_.size(),
                       normals_.size() == 1 ? "" : "s");
  }

 private:
  /// A node that has touched a plane in this step, and the way on which it leaves it: along.n = 1, or zero when held.
  struct Contact {
    Index row;
    std::size_t plane;
    Vec3 along;
  };
  const Contact& contact(const PositionStep& step, std::size_t node, std::size_t plane);

  std::vector<Vec3> normals_;
  std::vector<double> distances_{0};
  std::vector<int> indices_;
  double tolerance_ = 0;

  double allowed_ = 0;  ///< tolerance of this step [m]
  std::vector<Index> nodes_;
  std::vector<Contact> contacts_;  ///< of this step; memory for all
  std::vector<int> contact_of_;    ///< index in contacts_ or -1, shape (nodes_, planes)
  Index worst_node_ = 0;
  std::size_t worst_plane_ = 0;
  double worst_depth_ = 0;
};

void PlaneConstraint::init() {
  PositionConstraint::init();
  if (normals_.empty()) throw ComponentError("there is no normal", "normal=\"0 0 1\"");
  if (distances_.size() == 1) distances_.resize(normals_.size(), double(distances_[0]));
  if (distances_.size() != normals_.size())
    throw ComponentError(fmt::format("d has {} values for {} normals", distances_.size(), normals_.size()),
                         fmt::format("1 value or {}", normals_.size()));
  for (std::size_t p = 0; p < normals_.size(); ++p) {
    const double length = normals_[p].norm();
    if (!(length > 0) || !std::isfinite(length))
      throw ComponentError(fmt::format("normal {} has the length {:g}", p, length), "a direction");
    normals_[p] /= length;
  }
  if (data().find("indices")->isSet()) {
    nodes_ = checkedNodes(indices_, state(), "indices");
  } else {
    nodes_ = allNodes(state());
  }
  if (tolerance_ > 0) return;
  double size = 0;
  for (const Vec3& p : nodePlaces(state(), state().rest_position))
    size = std::max(size, (p - state().rest_position[0]).norm());
  tolerance_ = 1e-12 * (size > 0 ? size : 1);
}

/// The contact of nodes_[node]; a new one closes the direction of the normal to the corrections of this step.
const PlaneConstraint::Contact& PlaneConstraint::contact(const PositionStep& step, std::size_t node,
                                                         std::size_t plane) {
  int& index = contact_of_[node * normals_.size() + plane];
  if (index >= 0) return contacts_[index];
  index = int(contacts_.size());
  const Index at = row(nodes_[node]);
  const Vec3& n = normals_[plane];
  const Vec3 free = step.mobility.isHeld(at) ? Vec3::Zero() : step.mobility.freePart(at, n);
  const double reach = free.dot(n);
  contacts_.push_back({at, plane, reach > 1e-12 ? Vec3(free / reach) : Vec3::Zero()});
  if (reach > 1e-12) step.mobility.restrict(at, n);
  return contacts_.back();
}

double PlaneConstraint::correctPositions(const PositionStep& step, Rows x, Rows reference) {
  double worst = 0;
  for (std::size_t p = 0; p < normals_.size(); ++p)
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Index at = row(nodes_[i]);
      const double depth = distances_[p] - normals_[p].dot(x[at]);
      if (!(depth > 0)) continue;
      if (depth > worst) {
        worst = worst_depth_ = depth;
        worst_node_ = nodes_[i] / state().rows_per_node;
        worst_plane_ = p;
      }
      const Vec3 push = depth * contact(step, i, p).along;
      x[at] += push;
      reference[at] += push;
    }
  return worst / allowed_;
}

double PlaneConstraint::correctVelocities(const PositionStep& step, ConstRows, Rows v) {
  if (contacts_.empty()) return 0;
  double worst = 0, fastest = 0;
  for (const Index node : nodes_) fastest = std::max(fastest, v[row(node)].squaredNorm());
  for (const Contact& contact : contacts_) {
    const double speed = normals_[contact.plane].dot(v[contact.row]);
    if (!(speed < 0) || contact.along.isZero()) continue;
    v[contact.row] -= speed * contact.along;
    worst = std::max(worst, -speed);
  }
  // of a body that comes to rest, what would not move it by the tolerance in a step is no velocity
  return worst / std::max(1e-12 * std::sqrt(fastest), allowed_ / step.dt);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(plane_constraint) {
  factory.add<stroma::PlaneConstraint>("PlaneConstraint", "Nodes do not penetrate planes");
}
