// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// The inertia tensor of an orientation in body axes, if it is not isotropic.
struct TurningInertia {
  Index row = 0;  ///< of the state
  Mat3 inertia = Mat3::Zero();  ///< J0 [kg m^2]
  bool turns = true;            ///< false: constant in fixed axes
};

/// The mass of the nodes of one state. Constant except for inertia tensors, which rotate with their bodies: J = R J0 R^T.
/// Vectors cover the whole system.
class Mass : public Component {
 public:
  std::string roleText() const override { return "mass"; }
  void declare(DataTable& table) override;  ///< mstate, rayleighMass, separateGravity and SOFA's drawing attributes
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }

  virtual void compile() {}
  /// Masses of the nodes [kg], shape (state().size()): the whole mass if isDiagonal(), apart from turningInertias(). Otherwise
  /// row sums, or positive numbers with the same total if row sums are not positive. For an orientation with a rotating
  /// inertia: a third of the trace of J [kg m^2].
  virtual const std::vector<double>& lumped() const = 0;
  /// Row sums of M [kg], which gravity acts on.
  virtual const std::vector<double>& rowSums() const { return lumped(); }
  virtual bool isDiagonal() const = 0;
  /// True if the inertia of nodes moved by a constraint must not reach their neighbours.
  bool leavesMovedAlone() const { return moved_alone_; }
  /// out += factor * M p. The default uses lumped().
  virtual void addProduct(ConstRows p, double factor, Rows out) const;
  /// True if it covers all `rows` rows and implements setProduct().
  virtual bool setsProducts(Index /*rows*/) const { return false; }
  /// out = factor * M p
  virtual void setProduct(ConstRows, double, Rows) const {}
  virtual void addPattern(BlockPattern&) const {}
  virtual void prepareAssembly(const BlockMatrix&) {}
  /// matrix += factor * M. The default uses lumped().
  virtual void addTo(double factor, BlockMatrix& matrix) const;
  /// blocks[row] += factor * M[row][row], shape (rows, 9). The default uses lumped().
  virtual void addDiagonal(double factor, std::vector<double>& blocks) const;
  const std::vector<TurningInertia>& turningInertias() const { return turning_; }
  bool turns() const { return !turning_.empty(); }
  /// Recomputes the inertias J at the orientations in x.
  void update(ConstRows x);
  /// f += M g, with the gravity of the component's node [m/s^2], by rowSums().
  void addGravity(Rows f) const;
  double kineticEnergy(ConstRows v) const;  ///< 1/2 v^T M v [J]
  double gravityEnergy(ConstRows x) const;  ///< -sum m g.x [J]
  double totalMass() const;                 ///< of the rows that are places [kg]

  double rayleigh_mass = 0;  ///< [1/s], local Rayleigh factor added to the integrator's

 protected:
  Link<State> mstate_{"mechanical state"};
  /// Call in init(): lumped() has a third of the trace in these rows.
  void setTurningInertias(std::vector<TurningInertia> inertias) { turning_ = std::move(inertias), excess_.clear(), turns_.clear(); }
  /// out += factor (J - trace J/3) p for these rows. An override of addProduct() calls it.
  void addTurningProduct(ConstRows p, double factor, Rows out) const;
  /// True if the mass is also defined on rows that are not points. Otherwise init() rejects frames and numbers.
  virtual bool takesAllRows() const { return false; }

 private:
  State* state_ = nullptr;
  std::vector<TurningInertia> turning_;
  const std::vector<Mat3>& excess() const;
  std::vector<double> turns_;         ///< orientations at the x of the last update(), shape (turning_, 4) or empty
  mutable std::vector<Mat3> excess_;  ///< J - trace J/3 there, in fixed axes, computed on demand
  mutable bool excess_outdated_ = false;
  bool separate_gravity_ = false, moved_alone_ = false;
  mutable Vector work_;  ///< M v of kineticEnergy(), allocated on first use by a mass that is not diagonal
};

}  // namespace stroma
