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

/// The attributes that have changed in a run. All changes are recorded.
class RunEdits {
 public:
  RunEdits(const std::unique_ptr<Node>& root, const Systems& systems, Snapshots& snapshots, RunClock& clock, RunLog& log,
           RunWatch& watch);
  RunEdits(const RunEdits&) = delete;

  /// See Simulation::setAttribute().
  Diagnostics set(const std::string& path, const std::string& attribute, const std::string& text);
  /// Throws ComponentError if the attribute cannot change at all.
  void check(const std::string& path, const std::string& attribute) const { check(LiveEdit(*root_, path, attribute)); }
  /// Each attribute once, in the order of their last changes.
  std::vector<Override> all() const;
  /// The attributes of the scene as loaded.
  void takeBack();
  /// Reading restores the values at the time of the checkpoint.
  void serialize(Archive& archive);

 private:
  struct Edit {
    std::string path, attribute, original, text;
    DataOrigin origin = DataOrigin::by_default;  ///< of `original`
  };
  /// Rejects changes of anything that a precomputed matrix depends on, and treats an integrator that moves the bodies of
  /// others as theirs.
  void check(const LiveEdit& edit) const;
  /// Makes an edit, or throws and leaves everything unchanged.
  void change(LiveEdit& edit, const LiveEdit::Value& value, Diagnostics& messages);

  const std::unique_ptr<Node>& root_;  ///< the tree may be replaced
  const Systems& systems_;
  Snapshots& snapshots_;
  RunClock& clock_;
  RunLog& log_;
  RunWatch& watch_;
  /// One per changed attribute, in the order of their last changes: repeated in this order they produce the same values, even
  /// if one attribute is linked to another.
  std::vector<Edit> edits_;
};

}  // namespace stroma
