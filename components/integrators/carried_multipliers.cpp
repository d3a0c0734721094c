// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of constraint that Newton's method carries (multipliers.h), and steps in which there are none.
#include <algorithm>

#include "components/integrators/multipliers.h"
#include "framework/scene/archive.h"

namespace stroma {

bool Multipliers::areFree() {
  if (largest(carried_) != 0) return false;
  findConditions();
  return std::ranges::all_of(rows_.rows(), [](const LagrangianRows::Row& row) {
    switch (row.kind) {
      case LagrangianRows::Kind::push: return row.value >= 0;
      case LagrangianRows::Kind::rub: return true;  // with the force of a push, which is none
      case LagrangianRows::Kind::given: return row.factor == 0;
      default: return false;
    }
  });
}

void Multipliers::giveNone() {
  solve_.l.setZero(solve_.g.size());
  knows_forces_ = true;
  give();
}

void Multipliers::addCarried(Rows out) const { axpy(1, carried_, out); }

void Multipliers::carry(Rows out) {
  takeDirections(), takeBends();
  clear(added_);
  share_ = 1;
  for (std::size_t i = 0; i < rows_.rows().size(); ++i)
    if (const double p = rule_.weight * solve_.l[Eigen::Index(i)]; p != 0) {
      if (!isAimed(i)) takeDirection(i);
      axpy(p, directions_[i], added_);
    }
  axpy(-1, carried_, added_);
  axpy(1, added_, carried_);
  axpy(1, added_, out);
}

void Multipliers::carryMixed(Mixing& mixing, ConstRows from, Rows to, Rows out) {
  axpy(-1, carried_, out);
  mixing.next(from, to, carried_);
  axpy(1, carried_, out);
}

void Multipliers::carryShare(double share, Rows out) {
  axpy(share - share_, added_, carried_);
  axpy(share - share_, added_, out);
  share_ = share;
}

void Multipliers::stepTaken() {
  if (empty()) return;
  swept_ = sweeping_;
  if (is_swept_) swept_ends_ = ends_;
  if (sweeps_) keepContactForces();
  if (!carries_) return;
  copy(carried_, last_);
  scale(1 / rule_.weight, last_);
}

void Multipliers::reset() {
  if (!empty()) clear(last_);
  swept_.resize(0), sweeping_.resize(0), swept_ends_.clear(), contact_forces_.clear();
  not_swept_.clear();
}

void Multipliers::serialize(Archive& archive) {
  if (empty()) return;
  archive.rows("forces_of_constraint", last_);
  if (!sweeps_) return;
  std::vector<double> swept(swept_.begin(), swept_.end());
  archive.list("forces_of_sweeps", swept), archive.list("ends_of_sweeps", swept_ends_);
  swept_ = Eigen::Map<const Eigen::VectorXd>(swept.data(), Eigen::Index(swept.size()));
  std::vector<int> names;
  std::vector<double> forces;
  for (const auto& [name, force] : contact_forces_) {
    names.insert(names.end(), name.begin(), name.end());
    forces.insert(forces.end(), force.begin(), force.end());
  }
  archive.list("names_of_contacts", names), archive.list("forces_of_contacts", forces);
  contact_forces_.clear();
  for (std::size_t i = 0; 2 * i + 1 < names.size(); ++i)
    contact_forces_[{names[2 * i], names[2 * i + 1]}] = {forces[3 * i], forces[3 * i + 1], forces[3 * i + 2]};
}

}  // namespace stroma
