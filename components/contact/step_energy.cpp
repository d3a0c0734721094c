// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/step_energy.h"

#include <algorithm>
#include <utility>

namespace stroma::contact {

void StepEnergy::startsAt(const BarrierLaw& law, const std::vector<Vec3>& x) {
  start_forces_.resize(x.size()), end_forces_.resize(x.size());
  law.sumForces(x, start_forces_);
  if (!std::exchange(is_known_, true)) before_ = law.energy(x);
  has_start_ = true;
}

/// Shares change between steps, and U with them: that counts too, because U before is that of the end of the step before.
void StepEnergy::look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way) {
  if (!has_start_) return;
  law.sumForces(x, end_forces_);
  after_ = law.energy(x);
  double given = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 mean = is_backward_ ? end_forces_[v] : Vec3(0.5 * (start_forces_[v] + end_forces_[v]));
    // forces of pairs sum up to zero; those of planes do not, and have moved along
    given += mean.dot(x[v] - start[v] - way);
  }
  gains_ = given + after_ - before_;
}

bool StepEnergy::goesBackward() {
  constexpr double usual = 1e-3;
  if (!has_start_ || is_backward_ || !(gains_ > 0) || !(gained_ + gains_ > usual * std::max(most_, after_))) return false;
  return is_backward_ = true;
}

void StepEnergy::replace(Terms& terms, const Surfaces& surfaces, Rows f) const {
  for (Term& term : terms) term.force *= 2, term.m *= 2, term.slope *= 2;
  for (std::size_t v = 0; v < start_forces_.size(); ++v)
    if (const Index row = surfaces.rows[v]; row >= 0) f[row] -= start_forces_[v];
}

double StepEnergy::replaced(double energy, const Surfaces& surfaces, const std::vector<Vec3>& x) const {
  double sum = 2 * energy;
  for (std::size_t v = 0; v < start_forces_.size(); ++v)
    if (surfaces.rows[v] >= 0) sum += start_forces_[v].dot(x[v]);
  return sum;
}

void StepEnergy::stepTaken() {
  if (std::exchange(has_start_, false)) gained_ += gains_, before_ = after_, most_ = std::max(most_, after_);
  is_backward_ = false;
}

void StepEnergy::serialize(Archive& archive) {
  archive.value("energy_known", is_known_);
  archive.value("energy_before", before_);
  archive.value("energy_gained", gained_);
  archive.value("energy_most", most_);
}

}  // namespace stroma::contact
