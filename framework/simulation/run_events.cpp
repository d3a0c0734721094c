// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/run_events.h"

namespace stroma {

void RunLog::record(long step, InputChange change) {
  for (auto last = events_.rbegin(); last != events_.rend() && last->step == step; ++last) {
    auto* before = std::get_if<InputChange>(&last->what);
    if (!before) break;  // an edit may read what acts
    if (before->number != change.number) continue;
    if (!before->input || !change.input || !before->input->hasDerivativesOf(*change.input)) break;
    before->input = std::move(change.input);
    return;
  }
  events_.push_back({step, std::move(change)});
}

}  // namespace stroma
