// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/position_constraint.h"

#include <algorithm>
#include <limits>

namespace stroma {

void Mobility::allocate(const std::vector<double>& inverse_mass) {
  inverse_mass_ = &inverse_mass;
  slot_of_row_.assign(inverse_mass.size(), -1);
  projectors_.reserve(inverse_mass.size());
}

void Mobility::reset(const std::vector<NodeProjector>& projectors) {
  for (const NodeProjector& held : projectors_) slot_of_row_[held.row] = -1;
  projectors_.assign(projectors.begin(), projectors.end());
  for (std::size_t i = 0; i < projectors_.size(); ++i) slot_of_row_[projectors_[i].row] = Index(i);
}

bool Mobility::isHeld(Index row) const {
  if (inverseMass(row) == 0) return true;
  const Index slot = slot_of_row_[row];
  return slot >= 0 && projectors_[slot].projector.isZero(0);
}

bool Mobility::isGuided(Index row) const { return !isHeld(row) && slot_of_row_[row] >= 0; }

double PositionConstraint::roundOff(ConstRows x, const std::vector<Index>& nodes) const {
  double largest = 0;
  for (const Index node : nodes) largest = std::max(largest, x[row(node)].cwiseAbs().maxCoeff());
  return 8 * std::numeric_limits<double>::epsilon() * largest;
}

// Of the free directions u = P u those with n.u = 0 stay: (P n).u = 0.
void Mobility::restrict(Index row, const Vec3& n) {
  Index& slot = slot_of_row_[row];
  if (slot < 0) {
    slot = Index(projectors_.size());
    projectors_.push_back({row, Mat3::Identity()});
  }
  Mat3& p = projectors_[slot].projector;
  const Vec3 direction = p * n;
  const double square = direction.squaredNorm();
  if (square < 1e-20) return;
  p -= direction * direction.transpose() / square;
  if (p.norm() < 1e-9) p.setZero();  // three directions taken: what is left is round-off
}

}  // namespace stroma
