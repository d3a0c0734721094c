// SPDX-License-Identifier: LGPL-2.1-or-later
// What forces of constraint change the nodes of a state by as if none were tied to another; uncoupled_constraint_correction.cpp.
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
  /// Where a step begins: of frames the inverses of their masses and inertias, of all masses of the state and of what follows it.
  void takeMasses(const System& system);
  /// Of the state's rows: what impulses along `direction` change velocities by. Vectors of the system.
  void respond(ConstRows direction, Rows response) const;
  /// Says of those in the scene of `integrator` that the matrix answers instead, and why: once for each reason.
  static void tellIdle(const Component& integrator, const std::string& why);

 private:
  void addMass(const Mass& mass);
  void takeWhole(const System& system);

  Link<State> mstate_{"mechanical state"};
  State* state_ = nullptr;
  std::vector<double> compliance_, each_;  ///< as given; of each node, or of a frame 7
  double default_compliance_ = 1e-5;
  bool by_rule_ = true;
  std::string idle_;                       ///< why it was told last that the matrix answers
  std::vector<Mat3> inverses_;             ///< of frames: of each row, shape (state's rows)
  std::vector<Mat3> couplings_;            ///< of each frame: what torques change the velocity of its centre by; empty: nothing
  Vector unit_, momentum_;                 ///< work space, where masses follow frames
};

}  // namespace stroma
