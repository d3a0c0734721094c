// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/long_work.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

namespace stroma {
namespace {

constexpr double few_operations = 1e11;  // a few seconds
std::atomic<bool> wanted_at_all{true};

}  // namespace

void tellLongWork(bool wanted) { wanted_at_all = wanted; }

LongWork::LongWork(std::string what, double operations)
    : what_(std::move(what)),
      terminal_(isatty(STDERR_FILENO)),
      silent_(operations < few_operations || !wanted_at_all) {}

void LongWork::advise(const std::string& sentence) const {
  if (!silent_) fmt::print(stderr, "{}: {}\n", what_, sentence);
}

void LongWork::say(double share) {
  share = std::min(share, 1.0);
  const int step = int(share * (terminal_ ? 100 : 4));
  if (silent_ || step <= last_) return;
  last_ = step;
  const bool stays = terminal_ && share < 0.999;
  fmt::print(stderr, "{}{}: {:.0f} %{}", terminal_ ? "\r" : "", what_, 100 * share, stays ? "" : "\n");
  std::fflush(stderr);
}

}  // namespace stroma
