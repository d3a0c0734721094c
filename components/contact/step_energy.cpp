// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/step_energy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stroma::contact {
namespace {

std::array<double, 6> settingsOf(const BarrierLaw& law) {
  return {law.stiffness, law.range, law.thickness, law.adhesion.strength, law.adhesion.peak, law.adhesion.range};
}

}  // namespace

StepEnergy::Pair StepEnergy::pairOf(const BarrierLaw& law, const std::array<int, 4>& v) {
  const int piece = law.surfaces.pieceOf(v[0]);
  if (v[1] < 0) return {v[1], piece};  // of a plane
  int other = piece;
  for (const int vertex : v)
    if (vertex >= 0 && law.surfaces.pieceOf(vertex) != piece) other = law.surfaces.pieceOf(vertex);
  return {std::min(piece, other), std::max(piece, other)};
}

StepEnergy::Account& StepEnergy::accountOf(const Pair& pair) {
  const auto at = std::ranges::lower_bound(accounts_, pair, {}, &Account::pair);
  return at != accounts_.end() && at->pair == pair ? *at : *accounts_.insert(at, Account{.pair = pair, .share = shareOf(pair)});
}

double StepEnergy::shareOf(const Pair& pair) const {
  const auto at = std::ranges::lower_bound(accounts_, pair, {}, &Account::pair);
  return at != accounts_.end() && at->pair == pair ? at->share : gives_up_ ? 1 : 0.5;
}

double StepEnergy::factorOf(const BarrierLaw& law, const std::array<int, 4>& v) const {
  return has_start_ ? shareOf(pairOf(law, v)) / of_end_ : 1;
}

double StepEnergy::rubbingPartOf(const BarrierLaw& law, const std::array<int, 4>& v) const {
  const double share = has_start_ ? shareOf(pairOf(law, v)) : 0.5;
  return share == 0.5 ? 0 : (1 - share) / of_end_;
}

double StepEnergy::partOf(const BarrierLaw& law, const Pull& pull, bool rubs) const {
  const double share = shareOf(pairOf(law, pull.v));
  return rubs && share != 0.5 ? 0 : (1 - share) / of_end_;
}

void StepEnergy::stepBegins() {
  has_start_ = gives_up_ = false, rounds_ = 0;
  start_.clear(), rubs_.clear(), touches_.clear();
  for (Account& account : accounts_) account.begin();
}

/// Nobody has moved bodies or obstacles since the last step, or changed what acts between them.
bool StepEnergy::isAsLeft(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  return end_ == x && moved_ == law.moved && law_ == settingsOf(law);
}

/// Shares change between steps, and U with them: that counts too, because U before is that of the end of the step before. What others
/// have changed does not.
void StepEnergy::startsAt(const BarrierLaw& law, const std::vector<Vec3>& x, double of_end, const Friction& friction) {
  stepBegins();
  has_start_ = true, of_end_ = of_end;
  const bool is_new = !isAsLeft(law, x);
  for (Account& account : accounts_) account.before = is_new ? 0 : account.before;
  touches_ = law.touches(x);
  for (const Touch& touch : touches_) {
    start_.push_back({touch.v, touch.c, law.forceOf(touch)});
    if (is_new) accountOf(pairOf(law, touch.v)).before += law.slopesOf(touch).value;
  }
  for (std::size_t k = 0; k < friction.slides.size(); ++k)
    rubs_.push_back({friction.slides[k].v, friction.slides[k].c, friction.terms()[k].force});
}

void StepEnergy::look(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way,
                      ConstRows rows) {
  if (!has_start_) return;
  for (Account& account : accounts_) account.by_start = account.by_end = account.after = 0, account.touches = false;
  // forces of pairs sum up to zero; those of planes do not, and have moved along
  ways_.find(start, x, rows);
  const auto workOf = [&](const auto& touch, const Vec3& force) {
    Vec3 along = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      if (const auto v = std::size_t(touch.v[i]); touch.v[i] >= 0)
        along += touch.c[i] * (ways_.of(v) - way);
    return force.dot(along);
  };
  for (const Pull& pull : start_) accountOf(pairOf(law, pull.v)).by_start += workOf(pull, pull.force);
  for (const Touch& touch : law.touches(x)) {
    Account& account = accountOf(pairOf(law, touch.v));
    account.by_end += workOf(touch, law.forceOf(touch));
    account.after += law.slopesOf(touch).value;
    account.touches = true;
  }
}

/// What it has given too much, 0 where that is next to nothing.
double StepEnergy::Account::excess() const {
  constexpr double usual = 1e-3;
  const double sum = gained + gains();
  return std::abs(sum) > usual * std::max({most, before, after}) ? sum : 0;
}

/// With the forces of the solve that has ended some s would be right. The next one is that at which s would be what it seems, by a
/// line through the last two, or sometimes the middle of what is left. They lie decades from 0 and from 1: log s/(1 - s) goes straight.
/// Bounds hold while all others keep theirs: where little is left between them and s seems to be far from there, the other one goes.
/// True: there is another s.
bool StepEnergy::Account::search(int round, bool is_alone) {
  constexpr double least = 1e-4, settled = 1e-3, farthest = 8;
  const auto placeOf = [](double s) { return std::log(s / (1 - s)); };
  const double sum = excess(), right = (before - after - gained - by_start) / (by_end - by_start);
  if (sum == 0 || !std::isfinite(right) || (sum < 0 && !(right > 0))) return false;
  const double place = placeOf(share), way = placeOf(std::clamp(right, least, 1 - least)) - place;
  if (std::abs(way) < settled) return false;
  (sum > 0 ? low : high) = place;
  if (!is_alone && high - low < std::max(settled, 0.2 * std::abs(way)))
    (sum > 0 ? high : low) = sum > 0 ? infinite : -infinite, is_searched = false;
  double next = place + way;
  if (is_searched && way != last_way) next = place - way * (place - last) / (way - last_way);
  const auto isBetween = [&] { return next > low && next < high; };
  if (!isBetween()) next = place + way;
  if (!isBetween() || (round % 6 == 0 && std::isfinite(high - low))) next = 0.5 * (std::max(low, -farthest) + std::min(high, farthest));
  last = place, last_way = way, is_searched = true;
  share = 1 / (1 + std::exp(-next));
  return true;
}

/// Where none has another s, or after some rounds, and a contact still gives too much, all go by the forces of the end alone. For a
/// convex U these never give too much, whatever the others do. So it is where rigid bodies turn and shares come near 0: their contacts
/// would end steps so near that the next ones may find no balance.
bool StepEnergy::goesOn() {
  constexpr int most_rounds = 16;
  constexpr double least_turning = 0.01;  // chosen on a box that tumbles in steps of 1 and 4 ms, and on a cylinder in a ring
  const bool is_alone = accounts_.size() == 1;
  if (!has_start_ || gives_up_) return false;
  bool goes = false;
  const auto is_small = [](const Account& account) { return account.share < least_turning; };
  if (++rounds_ < most_rounds)
    for (Account& account : accounts_) goes = account.search(rounds_, is_alone) || goes;
  if (goes && ways_.turns() && std::ranges::any_of(accounts_, is_small)) return giveUp(), true;
  const bool gives = std::ranges::any_of(accounts_, [](const Account& account) { return account.excess() > 0; });
  if (goes || !gives) return goes;
  if (is_alone && rounds_ <= most_rounds && std::isfinite(accounts_.front().high)) {  // an s that gives too little is known
    rounds_ = most_rounds, accounts_.front().share = 1 / (1 + std::exp(-accounts_.front().high));
    return true;
  }
  return giveUp(), true;
}

void StepEnergy::giveUp() {
  gives_up_ = true;
  for (Account& account : accounts_) account.share = 1;
}

void StepEnergy::forget() {
  RigidPaths ways = std::move(ways_);
  *this = {};
  ways_ = std::move(ways);
}

void StepEnergy::complete(Terms& terms, const BarrierLaw& law, const std::vector<Touch>& touches, Rows f) const {
  if (!has_start_) return;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const double factor = factorOf(law, touches[i].v);
    terms[i].force *= factor, terms[i].m *= factor, terms[i].slope *= factor;
  }
  for (const auto* pulls : {&start_, &rubs_})
    for (const Pull& pull : *pulls) {
      const Vec3 force = partOf(law, pull, pulls == &rubs_) * pull.force;
      for (std::size_t i = 0; i < 4; ++i)
        if (const int v = pull.v[i]; v >= 0 && law.surfaces.moves(v)) f[law.surfaces.rows[std::size_t(v)]] += pull.c[i] * force;
    }
}

double StepEnergy::energy(const BarrierLaw& law, const std::vector<Vec3>& x) const {
  double sum = 0;
  for (const Touch& touch : law.touches(x)) sum += factorOf(law, touch.v) * law.slopesOf(touch).value;
  for (const auto* pulls : {&start_, &rubs_})
    for (const Pull& pull : *pulls) {
      const Vec3 force = partOf(law, pull, pulls == &rubs_) * pull.force;
      for (std::size_t i = 0; i < 4; ++i)
        if (pull.v[i] >= 0) sum -= pull.c[i] * force.dot(x[std::size_t(pull.v[i])]);
    }
  return sum;
}

void StepEnergy::stepTaken(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& way,
                           ConstRows rows) {
  look(law, x, start, way, rows);
  if (std::exchange(has_start_, false)) {
    for (Account& account : accounts_) {
      account.most = std::max({account.most, account.before, account.after});
      account.gained += account.gains(), account.before = account.after;
      account.begin();
    }
    for (const Account& account : accounts_)
      if (!account.touches) parted_.add(account);
    std::erase_if(accounts_, [](const Account& account) { return !account.touches; });
    end_ = x, moved_ = law.moved, law_ = settingsOf(law);
  }
}

/// What is a hundredth of all that the barrier has stored in between does not count: so much the search may leave over many steps.
void StepEnergy::Contacts::add(const Account& account) {
  constexpr double usual = 0.01;
  ++all;
  if (!(std::abs(account.gained) > usual * account.most)) return;
  ++unkept;
  (account.gained > 0 ? given : lost) += std::abs(account.gained);
}

std::string StepEnergy::doubt(const std::string& others) const {
  Contacts contacts = parted_;
  for (const Account& account : accounts_) contacts.add(account);
  if (contacts.unkept == 0) return others;
  const std::string given = contacts.given > 0 ? fmt::format(" and {:.3g} J given", contacts.given) : "";
  return others + (others.empty() ? "" : "; ") +
         fmt::format("{} of {} contacts did not give back all that they took: {:.3g} J lost{}, because no share of the forces of a step's "
                     "start was found with which they do. A smaller dt or stiffness helps",
                     contacts.unkept, contacts.all, contacts.lost, given);
}

void StepEnergy::serialize(Archive& archive) {
  archive.value("contacts_parted", parted_.all), archive.value("contacts_unkept", parted_.unkept);
  archive.value("contacts_lost", parted_.lost), archive.value("contacts_given", parted_.given);
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
