// SPDX-License-Identifier: LGPL-2.1-or-later
// The response of a state to constraint forces, as if its nodes were not coupled; uncoupled_constraint_correction.cpp.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

class UncoupledConstraintCorrection final : public Component {
 public:
  std::string roleText() const override { return "constraint correction"; }
  void declare(DataTable& table) override;
  void init() override;
  State& state() const { return *state_; }
  /// At the start of a step: inverts masses and inertias of frames, summed over the state and the states mapped from it.
  void takeMasses(const System& system);
  /// The change of velocities by impulses along `direction`, for the rows of the state. Vectors of the system.
  void respond(ConstRows direction, Rows response) const;
  /// Warns that those in the scene of `integrator` have no effect because the matrix is used, and why: once per reason.
  static void tellIdle(const Component& integrator, const std::string& why);

 private:
  void addMass(const Mass& mass);
  void takeWhole(const System& system);

  Link<State> mstate_{"mechanical state"};
  State* state_ = nullptr;
  std::vector<double> compliance_, each_;  ///< as given; of each node, or of a frame 7
  double default_compliance_ = 1e-5;
  bool by_rule_ = true;
  std::string idle_;                       ///< the last reason of that warning
  std::vector<Mat3> inverses_;             ///< of frames: of each row, shape (state's rows)
  std::vector<Mat3> couplings_;            ///< per frame: change of its centre's velocity by torques; empty: none
  Vector unit_, momentum_;                 ///< work space, where masses follow frames
};

}  // namespace stroma
