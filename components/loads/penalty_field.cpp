// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/loads/penalty_field.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/node_indices.h"

namespace stroma {

void PenaltyField::declare(DataTable& table) {
  ForceField::declare(table);
  table.add("damping", damping_constant_).help("force over velocity and depth").unit("N s/m^2").min(0);
  table.add("explicitDamping", explicit_damping_).help("damping has no part in derivatives, as in SOFA");
  table.add("indices", indices_).help("nodes in contact with the surface; every node by default");
  table.add("localRange", range_).help("first node and the one after the last that feel the surface; -1: no bound");
  for (const char* name : {"color", "bwdColor", "draw"}) table.addVisualOnly(name);
}

void PenaltyField::init() {
  ForceField::init();
  const bool listed = data().find("indices")->isSet(), ranged = data().find("localRange")->isSet();
  if (listed && ranged) throw ComponentError("indices and localRange are both given", "one of them");
  if (listed) {
    nodes_ = checkedNodes(indices_, state(), "indices");
    return;
  }
  nodes_ = allNodes(state());
  if (!ranged) return;
  const Index first = range_.empty() ? 0 : std::max(range_[0], 0), end = range_.size() == 2 && range_[1] >= 0 ? range_[1] : state().nodes();
  if (range_.size() != 2 || first >= end || end > state().nodes())
    throw ComponentError(fmt::format("localRange is no range of the {} nodes of {}", state().nodes(), state().path()),
                         fmt::format("two numbers: first < last <= {}", state().nodes()));
  nodes_ = {nodes_.begin() + first, nodes_.begin() + end};
}

ForceTraits PenaltyField::traits() const {
  ForceTraits traits;
  traits.symmetric = true;
  traits.velocity_dependent = damping_constant_ > 0 && !explicit_damping_;
  traits.conservative = damping_constant_ == 0 || !explicit_damping_;  // damping that no C says is in no energy
  traits.exact_tangent = damping_constant_ == 0;
  return traits;
}

void PenaltyField::compile() { setNodes(nodes_, damping_constant_ > 0 && !explicit_damping_); }

double PenaltyField::energy(ConstRows x) const {
  double sum = 0;
  for (const Group& row : rows_) {
    const double g = depth(x[row[0]]).g, k = stiffness_constant_, limit = largest_force_;
    if (!(g > 0)) continue;
    sum += limit > 0 && k * g > limit ? limit * g - limit * limit / (2 * k) : k / 2 * g * g;
  }
  return sum;
}

void PenaltyField::addForce(ConstRows x, ConstRows v, Rows f) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Index row = rows_[i][0];
    const Depth depth_here = depth(x[row]);
    const auto& [g, n, hessian, in_front] = depth_here;
    Mat3& stiffness = stiffness_[i].blocks[0];
    if (!damping_.empty()) damping_[i].setZero();
    if (!(g > 0)) {
      stiffness.setZero();
      continue;
    }
    if (explicit_damping_) {
      const double damping = in_front ? -damping_constant_ : damping_constant_;
      Vec3 force = -stiffness_constant_ * g * n - damping * g * v[row];
      if (const double size = force.norm(); largest_force_ > 0 && size > largest_force_) force *= largest_force_ / size;
      f[row] += force;
      stiffness = -stiffness_constant_ * (g * hessian + n * n.transpose());
      continue;
    }
    const bool limited = largest_force_ > 0 && stiffness_constant_ * g > largest_force_;
    const double force = limited ? largest_force_ : stiffness_constant_ * g;
    f[row] -= force * n;
    stiffness = -force * hessian;
    double along = limited ? 0 : stiffness_constant_;
    if (damping_constant_ > 0) f[row] -= damping_constant_ * g * v[row];
    if (!damping_.empty()) {
      along += damping_constant_ * v[row].dot(n);
      damping_[i].blocks[0] = -damping_constant_ * g * Mat3::Identity();
    }
    stiffness -= along * n * n.transpose();
  }
}

}  // namespace stroma
