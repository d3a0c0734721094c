// SPDX-License-Identifier: LGPL-2.1-or-later
// What every subcommand that loads a scene shares: its options, and how it reports errors.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/command/options.h"
#include "tools/session/session.h"

namespace stroma::command {

/// Adds --set, --module and --threads.
void addSceneOptions(OptionList& options);

/// Opens the modules named by --module, sets the threads and the overrides of --set.
void configure(Session& session, const Values& values);

/// What --set, --dialect and --without-quirk override.
std::vector<Override> overridesOf(const Values& values);

/// Each as `--set` has it.
std::vector<Override> parseOverrides(const std::vector<std::string>& texts);

/// Calls `hear` with the problems that are raised after loading, for its lifetime. At most one exists.
class LateProblems {
 public:
  explicit LateProblems(std::function<void(const Problem&)> hear);
  ~LateProblems();
  LateProblems(const LateProblems&) = delete;

 private:
  void (*const before_)(const Problem&);
};

/// Warnings (and notes, unless `quiet`) of a scene that loaded, to standard error; returns the warnings.
std::vector<std::string> reportProblems(const Scene& scene, bool quiet);

}  // namespace stroma::command
