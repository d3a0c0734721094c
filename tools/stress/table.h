// SPDX-License-Identifier: LGPL-2.1-or-later
// What has become of all cases: as a table, as JSON, and as a page.
#pragma once
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/stress/outcome.h"
#include "tools/stress/stresser.h"

namespace stroma::stress {

/// A campaign as it stands.
struct Findings {
  const StressRequest& request;
  long steps = 0;                     ///< of each case
  long open = 0;                      ///< cases of the list that time did not allow
  std::vector<Result> results;        ///< by number
  std::vector<std::string> doubts{};  ///< of the undisturbed run

  long count(Ending ending) const;
};

/// Cases with one sentence, but for the numbers in it.
struct Like {
  std::string sentence;  ///< of the first
  std::vector<const Result*> cases;
};
std::vector<Like> alike(const Findings& findings, Ending ending);

/// A sentence without what differs from case to case.
std::string withoutNumbers(const std::string& text);

/// A word as a shell takes it.
std::string quoted(const std::string& word);
/// The options of a request that say which scene it is, and more overrides.
std::string optionsOf(const StressRequest& request, const std::vector<Override>& more);

/// What repeats one case alone.
std::string commandOf(const StressRequest& request, long steps, long number);

std::string tableOf(const Findings& findings);
nlohmann::ordered_json jsonOf(const Findings& findings);
/// One HTML file without anything from elsewhere.
std::string pageOf(const Findings& findings);

}  // namespace stroma::stress
