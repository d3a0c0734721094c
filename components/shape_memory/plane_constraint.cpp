// SPDX-License-Identifier: LGPL-2.1-or-later
// PlaneConstraint: nodes do not penetrate planes, whatever force that takes.
//
//   n.x_i >= d  for each plane (unit normal n pointing to the free side, distance d from the origin)
//
// After each step a node behind a plane is moved back to it, along the normal, or along what other constraints leave free
// of it; then the part of its velocity that points into the plane is removed. The other parts stay: a node slides
// without friction and leaves the plane when anything draws it away. The push back does not enter the velocity, so nothing
// bounces. Until the end of the step the other position constraints move a node in contact along the plane only, so that
// they agree in a few turns. A node that fixed nodes' constraints hold behind a plane cannot be moved: the step's report
// says so.
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
#include <numeric>

#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class PlaneConstraint final : public PositionConstraint {
 public:
  void declare(DataTable& table) override {
    PositionConstraint::declare(table);
    table.add("normal", normals_).required().unit("-").help("normals of the planes, to the side that nodes may be on");
    table.add("d", distances_).unit("m").help("distance of each plane from the origin along its normal, or one for all");
    table.add("indices", indices_).help("nodes that do not penetrate; every node when not given");
    table.add("tolerance", tolerance_)
        .unit("m")
        .min(0, false)
        .help("depth that counts as none; 1e-12 of the body's size when not given");
  }
  void init() override;
  void compile() override { in_contact_.reserve(nodes_.size() * normals_.size()); }
  void begin(const PositionStep&) override { in_contact_.clear(); }
  double correctPositions(const PositionStep& step, Rows x, Rows reference) override;
  double correctVelocities(const PositionStep& step, ConstRows x, Rows v) override;
  std::string violation() const override {
    return fmt::format("node {} is {:.3g} m behind plane {} and held there", worst_node_, worst_depth_, worst_plane_);
  }
  std::string describe() const override {
    return fmt::format("{} nodes stay in front of {} plane{}", nodes_.size(), normals_.size(),
                       normals_.size() == 1 ? "" : "s");
  }

 private:
  struct Contact {
    Index row;
    std::size_t plane;
  };
  std::vector<Vec3> normals_;
  std::vector<double> distances_{0};
  std::vector<int> indices_;
  double tolerance_ = 1e-12;

  std::vector<Index> nodes_;
  std::vector<Contact> in_contact_;  ///< of this step; memory for all
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
    nodes_.resize(std::size_t(state().size()));
    std::iota(nodes_.begin(), nodes_.end(), 0);
  }
  if (data().find("tolerance")->isSet()) return;
  double size = 0;
  for (const Vec3& p : state().rest_position) size = std::max(size, (p - state().rest_position[0]).norm());
  tolerance_ = 1e-12 * (size > 0 ? size : 1);
}

double PlaneConstraint::correctPositions(const PositionStep& step, Rows x, Rows reference) {
  double worst = 0;
  for (std::size_t p = 0; p < normals_.size(); ++p) {
    const Vec3& n = normals_[p];
    for (const Index node : nodes_) {
      const Index at = row(node);
      const double depth = distances_[p] - n.dot(x[at]);
      if (!(depth > 0)) continue;
      if (depth > worst) worst = worst_depth_ = depth, worst_node_ = node, worst_plane_ = p;
      if (step.mobility.isHeld(at)) continue;
      const Vec3 along = step.mobility.freePart(at, n);
      const double reach = along.dot(n);
      if (reach < 1e-12) continue;
      const Vec3 push = depth / reach * along;
      x[at] += push;
      reference[at] += push;
      const bool known = std::any_of(in_contact_.begin(), in_contact_.end(), [&](const Contact& contact) {
        return contact.row == at && contact.plane == p;
      });
      if (!known) in_contact_.push_back({at, p});
      step.mobility.restrict(at, n);
    }
  }
  return worst / tolerance_;
}

double PlaneConstraint::correctVelocities(const PositionStep& step, ConstRows, Rows v) {
  double worst = 0;
  for (const Contact& contact : in_contact_) {
    const Vec3& n = normals_[contact.plane];
    const double speed = n.dot(v[contact.row]), scale = v[contact.row].norm();
    if (!(speed < 0)) continue;
    v[contact.row] -= speed * n;
    if (step.mobility.isHeld(contact.row)) continue;
    worst = std::max(worst, -speed / (1e-12 * scale));
  }
  return worst;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(plane_constraint) {
  factory.add<stroma::PlaneConstraint>("PlaneConstraint", "Nodes do not penetrate planes");
}
