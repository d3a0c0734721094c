// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of constraint that Newton's method carries (multipliers.h), and steps in which there are none.
#include <algorithm>
#include <cmath>
#include <utility>

#include "components/integrators/multipliers.h"
#include "framework/scene/archive.h"

namespace stroma {

bool Multipliers::areFree() {
  if (largest(carried_.now()) != 0) return false;
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

void Multipliers::clearForces() {
  solve_.l.setZero(solve_.g.size());
  knows_forces_ = true;
  give();
}

bool Multipliers::keepInitialViolation() {
  constexpr double held = 1e-9;  // of the place: less is no way
  violation_share_ = 1;
  findConditions();
  const double size = largest(system_->independent(system_->x));
  way_.assign(rows_.rows().size(), 0);
  bool has_way = false;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const LagrangianRows::Row& row = rows_.rows()[i];
    const bool is_off = row.kind == LagrangianRows::Kind::equal || (row.kind == LagrangianRows::Kind::push && row.value < 0);
    if (!is_off) continue;
    way_[i] = row.value;
    has_way = has_way || std::abs(row.value) > held * size * solve_.sizes[i];
  }
  return has_way;
}

/// g(x) becomes g(x) - (1 - share) g(x0).
void Multipliers::subtractInitialViolation() {
  const LagrangianRows all = std::exchange(rows_, {});
  std::size_t next = 0;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const LagrangianRows::Row& row = all.rows()[i];
    rows_.begin(row.kind, row.value - (1 - violation_share_) * way_[i], row.factor);
    for (const auto& [at, gradient] : all.entriesOf(row)) rows_.add(at, gradient);
    for (; next < all.bends().size() && all.bends()[next].row == i; ++next) {
      rows_.bend(all.bends()[next].size);
      for (const auto& [at, b] : all.entriesOf(all.bends()[next])) rows_.addToBend(at, b);
    }
  }
}

void Multipliers::addCarried(Rows out) const { axpy(1, carried_.now(), out); }

void Multipliers::carry(Rows out) {
  takeDirections(), takeBends();
  const Rows sum = carried_.beginChange();
  for (std::size_t i = 0; i < rows_.rows().size(); ++i)
    if (const double p = rule_.weight * solve_.l[Eigen::Index(i)]; p != 0) {
      if (!hasDirection(i)) takeDirection(i);
      axpy(p, directions_[i], sum);
    }
  carried_.change(out);
}

void CarriedForces::resize(Index rows) {
  for (Vector* vector : {&now_, &last_, &added_}) vector->resize(rows);
}

Rows CarriedForces::beginChange() {
  clear(added_);
  share_ = 1;
  return added_;
}

void CarriedForces::change(Rows out) {
  axpy(-1, now_, added_);
  axpy(1, added_, now_);
  axpy(1, added_, out);
}

void CarriedForces::changeShare(double share, Rows out) {
  axpy(share - share_, added_, now_);
  axpy(share - share_, added_, out);
  share_ = share;
}

void CarriedForces::mix(Mixing& mixing, ConstRows from, Rows to, Rows out) {
  axpy(-1, now_, out);
  mixing.next(from, to, now_);
  axpy(1, now_, out);
}

void Multipliers::stepTaken() {
  if (empty()) return;
  swept_ = sweeping_;
  if (is_swept_) swept_ends_ = ends_;
  if (sweeps_) keepContactForces();
  if (!carries_) return;
  carried_.end(rule_.weight);
}

void Multipliers::reset() {
  if (!empty()) carried_.forget();
  swept_.resize(0), sweeping_.resize(0), swept_ends_.clear(), contact_forces_.clear();
  not_swept_.clear();
}

void Multipliers::serialize(Archive& archive) {
  if (empty()) return;
  archive.rows("forces_of_constraint", carried_.last());
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
