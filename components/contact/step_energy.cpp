// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/step_energy.h"

#include <algorithm>
#include <utility>

namespace stroma::contact {
namespace {

std::array<double, 6> settingsOf(const BarrierLaw& law) {
  return {law.stiffness, law.range, law.thickness, law.adhesion.strength, law.adhesion.peak, law.adhesion.range};
}

}  // namespace

StepEnergy::Pair StepEnergy::pairOf(const BarrierLaw& law, const Touch& touch) {
  const int piece = law.surfaces.pieceOf(touch.v[0]);
  if (touch.v[1] < 0) {
    int plane = 0;
    while (plane + 1 < int(law.planes.size()) && law.planes[std::size_t(plane)].normal != touch.n) ++plane;
    return {-1 - plane, piece};
  }
  int other = piece;
  for (const int vertex : touch.v)
    if (vertex >= 0 && law.surfaces.pieceOf(vertex) != piece) other = law.surfaces.pieceOf(vertex);
  return {std::min(piece, other), std::max(piece, other)};
}

StepEnergy::Account& StepEnergy::accountOf(const Pair& pair) {
  const auto at = std::ranges::lower_bound(accounts_, pair, {}, &Account::pair);
  return at != accounts_.end() && at->pair == pair ? *at : *accounts_.insert(at, Account{.pair = pair});
}

bool StepEnergy::isBackward(const Pair& pair) const {
  const auto at = std::ranges::lower_bound(accounts_, pair, {}, &Account::pair);
  return at != accounts_.end() && at->pair == pair && at->is_backward;
}

void StepEnergy::stepBegins() {
  has_start_ = false, rounds_ = 0;
  for (Account& account : accounts_) account.is_backward = false;
}

/// Nobody has moved bodies or obstacles since the last step, or changed what acts between them.
bool StepEnergy::isAsLeft(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  return end_ == x && moved_ == law.moved && law_ == settingsOf(law);
}

/// Shares change between steps, and U with them: that counts too, because U before is that of the end of the step before. What others
/// have changed does not.
void StepEnergy::startsAt(const BarrierLaw& law, const std::vector<Vec3>& x) {
  start_ = law.touches(x);
  has_start_ = true;
  if (isAsLeft(law, x)) return;
  for (Account& account : accounts_) account.before = 0;
  for (const Touch& touch : start_) accountOf(pairOf(law, touch)).before += law.slopesOf(touch).value;
}

void StepEnergy::look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way) {
  if (!has_start_) return;
  for (Account& account : accounts_) account.given = account.after = 0, account.touches = false;
  // forces of pairs sum up to zero; those of planes do not, and have moved along
  const auto workOf = [&](const Touch& touch) {
    Vec3 along = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      if (const auto v = std::size_t(touch.v[i]); touch.v[i] >= 0) along += touch.c[i] * (x[v] - start[v] - way);
    return law.forceOf(touch).dot(along);
  };
  for (const Touch& touch : start_)
    if (Account& account = accountOf(pairOf(law, touch)); !account.is_backward) account.given += 0.5 * workOf(touch);
  for (const Touch& touch : law.touches(x)) {
    Account& account = accountOf(pairOf(law, touch));
    account.given += (account.is_backward ? 1 : 0.5) * workOf(touch);
    account.after += law.slopesOf(touch).value;
    account.touches = true;
  }
}

/// One after another may turn out to be too much; after some rounds all go, which gives no more either.
bool StepEnergy::goesBackward() {
  constexpr double usual = 1e-3;
  constexpr int most_rounds = 4;
  if (!has_start_) return false;
  bool goes = false;
  for (Account& account : accounts_) {
    const double gains = account.gains();
    if (account.is_backward || !(gains > 0) || !(account.gained + gains > usual * std::max(account.most, account.after))) continue;
    account.is_backward = goes = true;
  }
  if (!goes) return false;
  if (++rounds_ >= most_rounds)
    for (Account& account : accounts_) account.is_backward = true;
  return true;
}

void StepEnergy::replace(Terms& terms, const BarrierLaw& law, const std::vector<Vec3>& x, Rows f) const {
  const std::vector<Touch>& touches = law.touches(x);
  for (std::size_t i = 0; i < touches.size(); ++i)
    if (Term& term = terms[i]; isBackward(pairOf(law, touches[i]))) term.force *= 2, term.m *= 2, term.slope *= 2;
  for (const Touch& touch : start_) {
    if (!isBackward(pairOf(law, touch))) continue;
    const Vec3 force = law.forceOf(touch);
    for (std::size_t i = 0; i < 4; ++i)
      if (touch.v[i] >= 0 && law.surfaces.moves(touch.v[i])) f[law.surfaces.rows[std::size_t(touch.v[i])]] -= touch.c[i] * force;
  }
}

double StepEnergy::replaced(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  double sum = 0;
  for (const Touch& touch : law.touches(x)) sum += (isBackward(pairOf(law, touch)) ? 2 : 1) * law.slopesOf(touch).value;
  for (const Touch& touch : start_) {
    if (!isBackward(pairOf(law, touch))) continue;
    const Vec3 force = law.forceOf(touch);
    for (std::size_t i = 0; i < 4; ++i)
      if (touch.v[i] >= 0 && law.surfaces.moves(touch.v[i])) sum += touch.c[i] * force.dot(x[std::size_t(touch.v[i])]);
  }
  return sum;
}

void StepEnergy::stepTaken(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way) {
  look(law, x, start, way);
  if (std::exchange(has_start_, false)) {
    for (Account& account : accounts_) {
      account.gained += account.gains(), account.before = account.after, account.most = std::max(account.most, account.after);
      account.is_backward = false;
    }
    std::erase_if(accounts_, [](const Account& account) { return !account.touches; });
    end_ = x, moved_ = law.moved, law_ = settingsOf(law);
  }
  rounds_ = 0;
}

void StepEnergy::serialize(Archive& archive) {
  std::vector<int> pairs;
  std::vector<double> sums{moved_.x(), moved_.y(), moved_.z()};
  sums.insert(sums.end(), law_.begin(), law_.end());
  const std::size_t first = sums.size();
  for (const Account& account : accounts_) {
    pairs.insert(pairs.end(), account.pair.begin(), account.pair.end());
    sums.insert(sums.end(), {account.before, account.gained, account.most});
  }
  archive.list("energy_pairs", pairs);
  archive.list("energy_sums", sums);
  archive.list("energy_end", end_);
  if (!archive.isReading()) return;
  moved_ = Vec3(sums[0], sums[1], sums[2]);
  std::copy_n(sums.begin() + 3, law_.size(), law_.begin());
  accounts_.clear(), stepBegins();
  for (std::size_t i = 0; 2 * i < pairs.size(); ++i) {
    const double* const sum = sums.data() + first + 3 * i;
    accounts_.push_back({.pair = {pairs[2 * i], pairs[2 * i + 1]}, .before = sum[0], .gained = sum[1], .most = sum[2]});
  }
}

}  // namespace stroma::contact
