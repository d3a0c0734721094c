// SPDX-License-Identifier: LGPL-2.1-or-later
// What became of a disturbed scene.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/stress/cases.h"

namespace stroma::stress {

enum class Ending {
  good,        ///< back at the shape of the undisturbed run, or the checked property holds
  runs,        ///< finite to the last step and no doubt; not, or not yet, at the undisturbed shape
  elsewhere,   ///< at rest in another shape, indistinguishable from a right one
  doubt,       ///< finite to the last step, with a sentence why it may be no result
  stops,       ///< refused or stopped, with a sentence
  unfinished,  ///< took longer than a case may
  breaks       ///< a crash, a number that is not finite, a stop without a sentence, a promise that is broken
};
constexpr int endings = 7;
const char* wordOf(Ending ending);

struct Outcome {
  Ending ending = Ending::breaks;
  std::vector<std::string> sentences;  ///< of a stop, a doubt, a break
  long steps = 0;                      ///< that were made
  double distance = -1;                ///< of the worst node from its place in the undisturbed run [sizes]; -1: unknown
};

/// A case with what became of it.
struct Result {
  Case what;
  Outcome outcome;
};

nlohmann::ordered_json toJson(const Outcome& outcome);
Outcome outcomeFrom(const nlohmann::ordered_json& json);

}  // namespace stroma::stress
