// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/command/options.h"
#include "tools/session/children.h"

namespace stroma::command {

/// What --jobs and --limit say. Throws UsageError.
inline JobLimits jobLimitsOf(const Values& values) {
  constexpr double shortest = 0.01, longest = 1e7;
  JobLimits limits;
  limits.at_once = within(values, "jobs", 1, 1, 1024);
  limits.seconds = within(values, "limit", limits.seconds, shortest, longest);
  return limits;
}

}  // namespace stroma::command
