// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of actions on any bytes: refused with a sentence, or events that are written and read back as they are.
#include <sstream>

#include "framework/scene/diagnostics.h"
#include "tests/fuzz/fuzz.h"
#include "tools/session/action_file.h"

namespace {

using namespace stroma;

RecordedActions parsed(const std::string& text) {
  std::istringstream stream(text);
  return parseActions(stream, "fuzz.actions");
}

/// Each that ends has begun, steps ascend, and a ball has no nodes.
void requireOrder(const std::vector<RunEvent>& events) {
  long step = 0;
  for (const RunEvent& event : events) {
    fuzz::require(event.step >= step, "steps do not ascend");
    step = event.step;
    const auto* change = std::get_if<InputChange>(&event.what);
    if (!change) continue;
    fuzz::require(change->number > 0, "an input has no number");
    if (change->input && change->input->ball)
      fuzz::require(change->input->nodes.empty() && change->input->targets.empty(), "a ball has nodes");
  }
}

}  // namespace

STROMA_FUZZ_TARGET(actions) {
  RecordedActions actions;
  try {
    actions = parsed({reinterpret_cast<const char*>(data), size});
  } catch (const SceneError& error) {
    fuzz::require(error.diagnostics().errorCount() > 0, "refused without a sentence");
    fuzz::require(error.diagnostics().errorCount() <= told_action_problems + 1, "too many problems are told");
    return 0;
  }
  requireOrder(actions.events);
  // what was read has a text, and the text is read: neither may throw
  const std::string text = printActions(actions);
  fuzz::require(printActions(parsed(text)) == text, "what was written reads back as something else");
  return 0;
}
