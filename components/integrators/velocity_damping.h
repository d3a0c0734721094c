// SPDX-License-Identifier: LGPL-2.1-or-later
// Damping of velocities after a step, which any integrator may have:
//
//   v *= exp(-h vdamping),  then v = 0 where |v| < velocityThreshold
#pragma once
#include <cmath>

#include "framework/scene/data.h"
#include "framework/simulation/system.h"

namespace stroma {

class VelocityDamping {
 public:
  double rate = 0;  ///< [1/s]

  void declare(DataTable& table) {
    table.add("vdamping", rate).atOnce().help("decay rate of the velocity, applied after the step").unit("1/s").min(0);
    table.add("velocityThreshold", threshold_)
        .atOnce()
        .help("after the step slower nodes are stopped: their velocity is set to zero; for frames rotation is included")
        .unit("m/s")
        .min(0);
  }
  /// At the end of a step of length h.
  void apply(System& system, double h) const {
    if (rate != 0) scale(std::exp(-h * rate), system.v);
    if (threshold_ > 0)
      for (const State* state : system.states()) stopSlowNodes(*state, system.v);
  }

 private:
  void stopSlowNodes(const State& state, Rows v) const {
    for (Index first = state.firstRow(); first < state.firstRow() + state.size(); first += state.rows_per_node) {
      double square = 0;
      for (Index row = first; row < first + state.rows_per_node; ++row) square += v[row].squaredNorm();
      if (square < threshold_ * threshold_)
        for (Index row = first; row < first + state.rows_per_node; ++row) v[row].setZero();
    }
  }

  double threshold_ = 0;  ///< [m/s]
};

}  // namespace stroma
