// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/scene/live_edit.h"
#include "framework/scene/load.h"
#include "framework/simulation/run_clock.h"
#include "framework/simulation/run_events.h"
#include "framework/simulation/run_watch.h"

namespace stroma {

/// The attributes that have changed in a run. What is done to them is recorded.
class RunEdits {
 public:
  RunEdits(const std::unique_ptr<Node>& root, const Systems& systems, Snapshots& snapshots, RunClock& clock, RunLog& log,
           RunWatch& watch);
  RunEdits(const RunEdits&) = delete;

  /// See Simulation::setAttribute().
  Diagnostics set(const std::string& path, const std::string& attribute, const std::string& text);
  /// Throws ComponentError when it cannot change, whatever its new value.
  void check(const std::string& path, const std::string& attribute) const { check(LiveEdit(*root_, path, attribute)); }
  /// Each attribute once, in the order of their last changes.
  std::vector<Override> all() const;
  /// The attributes of the scene as it was loaded.
  void takeBack();
  /// Reading: attributes get the values that they had when the checkpoint was written.
  void serialize(Archive& archive);

 private:
  struct Edit {
    std::string path, attribute, original, text;
    DataOrigin origin = DataOrigin::by_default;  ///< of `original`
  };
  /// An integrator that has computed its matrix beforehand follows no change of what the matrix was made of, and one that
  /// moves the bodies of others stands for them.
  void check(const LiveEdit& edit) const;
  /// Makes an edit, or leaves everything as it was and throws.
  void change(LiveEdit& edit, const LiveEdit::Value& value, Diagnostics& messages);

  const std::unique_ptr<Node>& root_;  ///< another tree may come to stand there
  const Systems& systems_;
  Snapshots& snapshots_;
  RunClock& clock_;
  RunLog& log_;
  RunWatch& watch_;
  /// One per attribute that has changed, in the order of their last changes: applied in this order they leave the same
  /// values, also where one attribute follows another by a link.
  std::vector<Edit> edits_;
};

}  // namespace stroma
