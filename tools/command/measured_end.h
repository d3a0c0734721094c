// SPDX-License-Identifier: LGPL-2.1-or-later
// The end of a run as `stroma sweep` reads it (tools/sweep/end_state.h): shapes, cells, and one quantity.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/session/mesh_changes.h"

namespace stroma::command {

/// A quantity of the scene: an attribute or an output, a field of cells, or the displacement, position or velocity of a
/// state. Its mean over nodes, or over cells by their volumes.
class MeasuredQuantity {
 public:
  /// `text`: PATH.NAME or PATH.NAME:NODES, NODES a list of numbers or a link to one ("@/liver/roi.indices"). Throws
  /// ComponentError with the nearest right name.
  MeasuredQuantity(const Simulation& simulation, const std::string& text);
  MeasuredQuantity(const MeasuredQuantity&) = delete;
  /// Whether it says what it is of when meshes have changed: not of cells or entries by their numbers.
  bool mayFollow() const { return chosen_.empty() || !state_.empty(); }
  bool choosesNodes() const { return !chosen_.empty() && !state_.empty(); }
  /// Meshes have changed: it is of what is left.
  void follow(const Simulation& simulation, const NodesNow& now);
  /// Of the present instant: one number or three.
  std::vector<double> now() const { return evaluate_(); }

 private:
  void find(const Simulation& simulation);
  void ofState(const State& state, const std::string& name);
  void ofData(const Data& data, const std::string& text);
  void ofCells(const Simulation& simulation, const ForceField& field, const std::string& name);
  [[noreturn]] static void failName(const Component& component, const std::string& name);

  std::string text_;         ///< as it was given
  std::string state_;        ///< path of the state that it is of, else empty
  std::vector<int> chosen_;  ///< nodes or cells; empty: all
  bool are_gone_ = false;    ///< those that were chosen
  std::function<std::vector<double>()> evaluate_;
};

/// Before a run: throws ComponentError where writeMeasuredEnd() would have cells that errors are not measured in.
void checkMeasurable(const Simulation& simulation);
/// Writes the present instant. Throws OutputError.
void writeMeasuredEnd(const Simulation& simulation, const MeasuredQuantity* quantity, const std::string& file);

}  // namespace stroma::command
