// SPDX-License-Identifier: LGPL-2.1-or-later
// What every subcommand that loads a scene shares: its options, the factory and the modules.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/command/options.h"

namespace stroma::command {

/// Adds --set, --module and --threads.
void addSceneOptions(OptionList& options);

/// The factory and the modules behind it. Components are code in modules: a simulation must not outlive its session.
class Session {
 public:
  /// Opens the modules named by --module, sets the threads.
  explicit Session(const Values& values);

  /// Throws SceneError with every problem found.
  std::unique_ptr<Simulation> load(const std::string& scene_file, const std::vector<std::string>& more_overrides = {});

  Factory& factory() { return factory_; }
  Modules& modules() { return modules_; }

 private:
  Factory factory_;
  Modules modules_{factory_};
  std::vector<Override> overrides_;
};

/// Warnings (and notes, unless `quiet`) of a scene that loaded, to standard error; returns the warnings.
std::vector<std::string> reportProblems(const Scene& scene, bool quiet);

}  // namespace stroma::command
