// SPDX-License-Identifier: LGPL-2.1-or-later
// The end of a run as `stroma sweep` reads it (tools/sweep/end_state.h): shapes, cells, and one quantity.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::command {

/// A quantity of the scene: an attribute or an output, a field of cells, or the displacement, position or velocity of a
/// state. Its mean over nodes, or over cells by their volumes.
class MeasuredQuantity {
 public:
  /// `text`: PATH.NAME or PATH.NAME:NODES, NODES a list of numbers or a link to one ("@/liver/roi.indices"). Throws
  /// ComponentError with the nearest right name.
  MeasuredQuantity(const Simulation& simulation, const std::string& text);
  MeasuredQuantity(const MeasuredQuantity&) = delete;
  /// Of the present instant: one number or three.
  std::vector<double> now() const { return evaluate_(); }

 private:
  void ofState(const State& state, const std::string& name);
  void ofData(const Data& data, const std::string& text);
  void ofCells(const Simulation& simulation, const ForceField& field, const std::string& name);
  [[noreturn]] static void failName(const Component& component, const std::string& name);

  std::vector<int> chosen_;  ///< nodes or cells; empty: all
  std::function<std::vector<double>()> evaluate_;
};

/// Writes the present instant. Throws OutputError.
void writeMeasuredEnd(const Simulation& simulation, const MeasuredQuantity* quantity, const std::string& file);

}  // namespace stroma::command
