// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// The mass of the nodes of one state; constant. Vectors are the whole system's.
class Mass : public Component {
 public:
  std::string roleText() const override { return "mass"; }
  void declare(DataTable& table) override;  ///< mstate, rayleighMass, separateGravity and SOFA's drawing attributes
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }

  virtual void compile() {}
  /// Row sums [kg] ([kg m^2] for orientations), shape (state().size()): the whole mass when isDiagonal().
  virtual const std::vector<double>& lumped() const = 0;
  virtual bool isDiagonal() const = 0;
  /// out += factor * M p. The default uses lumped().
  virtual void addProduct(ConstRows p, double factor, Rows out) const;
  virtual void addPattern(BlockPattern&) const {}
  virtual void prepareAssembly(const BlockMatrix&) {}
  /// matrix += factor * M. The default uses lumped().
  virtual void addTo(double factor, BlockMatrix& matrix) const;
  /// blocks[row] += factor * M[row][row], shape (rows, 9). The default uses lumped().
  virtual void addDiagonal(double factor, std::vector<double>& blocks) const;
  /// f += M g, with the gravity of the component's node [m/s^2]. The default uses lumped().
  void addGravity(Rows f) const;
  double kineticEnergy(ConstRows v) const;  ///< 1/2 v^T M v [J]
  double gravityEnergy(ConstRows x) const;  ///< -sum m g.x [J]
  double totalMass() const;                 ///< of what has a place [kg]

  double rayleigh_mass = 0;  ///< [1/s], local Rayleigh factor added to the integrator's

 protected:
  Link<State> mstate_{"mechanical state"};

 private:
  State* state_ = nullptr;
  bool separate_gravity_ = false;
  mutable Vector work_;  ///< M v of kineticEnergy(), allocated when first asked for a mass that is not diagonal
};

}  // namespace stroma
