// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "framework/scene/text.h"

namespace stroma::sweep {

double parseGoal(const std::string& text) {
  std::string rest;
  for (const char c : text)
    if (c != ' ') rest += c;
  double bound = 0;
  const bool is_share = rest.ends_with('%');
  if (is_share) rest.pop_back();
  if (!rest.starts_with("error<") || !readNumber(rest.substr(6), bound) || !(bound > 0))
    throw std::invalid_argument(fmt::format("--goal {}: expected \"error<1%\" or \"error<0.01\"", inQuotes(text)));
  return is_share ? bound / 100 : bound;
}

GoalSearch::GoalSearch(const std::vector<Axis>& axes, double bound)
    : axes_(axes), bound_(bound), least_seconds_(std::numeric_limits<double>::infinity()) {
  std::vector<std::size_t> choice(axes.size(), 0);
  for (;;) {
    choices_.push_back(choice);
    std::size_t a = axes.size();
    while (a > 0 && ++choice[a - 1] == axes[a - 1].size()) choice[--a] = 0;
    if (a == 0) break;
  }
  fates_.assign(choices_.size(), Fate::open);
}

bool GoalSearch::isAtLeastAsFine(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (a[i] != b[i] && !(axes_[i].isOrdered() && axes_[i].isFiner(a[i], b[i]))) return false;
  return true;
}

void GoalSearch::learn(const std::vector<std::size_t>& choice, const Shown& shown) {
  const bool keeps = shown.has_result && shown.error < bound_;
  if (keeps && shown.seconds < least_seconds_) {
    cheapest_ = choice;
    least_seconds_ = shown.seconds;
  }
  if (shown.has_result) made_.push_back({choice, shown.seconds});
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    if (choices_[i] == choice) fates_[i] = Fate::run;
    if (fates_[i] != Fate::open) continue;
    const bool is_finer = isAtLeastAsFine(choices_[i], choice), is_coarser = isAtLeastAsFine(choice, choices_[i]);
    if ((keeps && is_finer) || (shown.has_result && !keeps && is_coarser)) fates_[i] = Fate::spoken_for;
  }
  for (const Made& made : made_)
    for (std::size_t i = 0; i < choices_.size(); ++i)
      if (fates_[i] == Fate::open && made.seconds >= least_seconds_ && isAtLeastAsFine(choices_[i], made.choice))
        fates_[i] = Fate::spoken_for;
}

std::vector<std::size_t> GoalSearch::next() const {
  std::vector<std::size_t> best;
  std::size_t most = 0;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    if (fates_[i] != Fate::open) continue;
    std::size_t finer = 0, coarser = 0;
    for (std::size_t k = 0; k < choices_.size(); ++k) {
      if (fates_[k] != Fate::open || k == i) continue;
      finer += isAtLeastAsFine(choices_[k], choices_[i]);
      coarser += isAtLeastAsFine(choices_[i], choices_[k]);
    }
    const std::size_t decided = 1 + std::min(finer, coarser);
    if (best.empty() || decided > most) {
      best = choices_[i];
      most = decided;
    }
  }
  return best;
}

}  // namespace stroma::sweep
