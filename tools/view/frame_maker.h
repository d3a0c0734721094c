// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tools/view/audience.h"
#include "tools/view/hands.h"
#include "tools/view/watched_values.h"

namespace stroma::view {

/// Copies what is drawn out of a simulation, between steps. Positions cost one pass over the nodes. Fields of cells are
/// computed at most for a hundredth of the time; a page keeps the last ones.
class FrameMaker {
 public:
  FrameMaker(const Simulation& simulation, const Drawing& drawing) : simulation_(simulation), drawing_(drawing) {}

  /// Frame number `number` at time `time` [s]. `still`: nothing moves, so that fields are always wanted.
  std::shared_ptr<Packet> make(const Demand& demand, long number, double time, bool still);
  void forget() { fields_due_ = {}; }  ///< pages have no values of fields any more
  double fieldSeconds() const { return field_seconds_; }  ///< spent on fields so far

 private:
  void addPositions(Packet& packet, std::size_t body, bool all) const;
  void addVelocities(Packet& packet, const Field& field, bool all) const;
  void addNodeField(Packet& packet, const Field& field, bool all);
  void addCellField(Packet& packet, const Field& field, bool all);
  void addLoads(Packet& packet, bool all);

  const Simulation& simulation_;
  const Drawing& drawing_;
  std::vector<double> work_;
  std::vector<float> cell_values_;
  Vector loads_;
  double field_seconds_ = 0;
  std::chrono::steady_clock::time_point fields_due_{};
  std::set<int> fields_before_;
};

}  // namespace stroma::view
