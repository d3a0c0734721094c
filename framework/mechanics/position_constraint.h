// SPDX-License-Identifier: LGPL-2.1-or-later
// Conditions on positions that hold exactly after each step, whatever force that takes ("non-quantified force
// components" in Nesme et al. 2005, section 4; the constraint forces of SHAKE and RATTLE, Ryckaert 1977, Andersen
// 1983).
#pragma once
#include <vector>

#include "framework/mechanics/projective_constraint.h"

namespace stroma {

/// How a correction may move nodes: W = P / m, with the lumped mass m and the projector P of the node's constraints. Rows of
/// the system. Tied nodes are corrected one by one, and the system takes their mean after every sweep.
class Mobility {
 public:
  /// 1/m of each independent row [1/kg], 0 if the node never moves. Must outlive this object.
  void allocate(const std::vector<double>& inverse_mass);
  /// Drops all restrictions except those of projective constraints.
  void reset(const std::vector<NodeProjector>& projectors);
  double inverseMass(Index row) const { return (*inverse_mass_)[row]; }  ///< [1/kg]
  /// P g
  Vec3 freePart(Index row, const Vec3& g) const {
    const Index slot = slot_of_row_[row];
    return slot < 0 ? g : Vec3(projectors_[slot].projector * g);
  }
  /// W g
  Vec3 times(Index row, const Vec3& g) const { return inverseMass(row) * freePart(row, g); }
  bool isHeld(Index row) const;    ///< cannot move at all
  bool isGuided(Index row) const;  ///< can move in some directions only
  /// Blocks the node along the unit vector n for the rest of the step.
  void restrict(Index row, const Vec3& n);

 private:
  const std::vector<double>* inverse_mass_ = nullptr;  ///< shape (rows)
  std::vector<Index> slot_of_row_;                     ///< shape (rows), -1: free
  std::vector<NodeProjector> projectors_;              ///< at most one per row; memory for all rows
};

/// The step to correct.
struct PositionStep {
  double dt = 0;       ///< [s]
  double t_end = 0;    ///< [s]
  ConstRows x_start;   ///< positions at the start of the step [m], shape (rows)
  Mobility& mobility;  ///< shared by all constraints of the system
};

/// After the integrator has moved x and v, the position constraints correct x in sweeps until all hold. Then
/// v += (correction of x) / dt, and further sweeps correct v until no velocity violates a constraint. Corrections are
/// along W times the gradient at the START of the step for x, and at its end for v. They leave the linear momentum of the
/// lumped masses unchanged to round-off. Angular momentum is unchanged too if x1 = x0 + dt v1 (Euler methods), and
/// otherwise up to dt times the correction.
class PositionConstraint : public Component {
 public:
  std::string roleText() const override { return "position constraint"; }
  void declare(DataTable& table) override;  ///< mstate
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }
  Index row(Index node) const { return state_->firstRow() + node; }

  /// Called once when row numbers are known: allocate what steps need.
  virtual void compile() {}
  /// Starts a correction, with the positions and velocities of the integrator.
  virtual void begin(const PositionStep&) {}
  /// Makes x satisfy this constraint. Returns the violation before that, in units of the tolerance: at most 1 is converged.
  /// The change of v is the difference to `reference`; a correction that must not enter v is applied to both.
  virtual double correctPositions(const PositionStep& step, Rows x, Rows reference) = 0;
  /// Makes v satisfy the derivative of this constraint at x. Returns as above.
  virtual double correctVelocities(const PositionStep& step, ConstRows x, Rows v) = 0;
  /// Describes the violation at the last correctPositions(): "the volume is 3.1e-4 m^3 instead of 3e-4 m^3".
  virtual std::string violation() const = 0;
  /// One line for `explain`.
  virtual std::string describe() const = 0;
  /// True if it also acts on the centres of frames.
  virtual bool takesFrames() const { return false; }

 protected:
  /// The resolution of the positions of these nodes [m]: 8 eps times the largest coordinate. No tolerance is smaller.
  double roundOff(ConstRows x, const std::vector<Index>& nodes) const;

  Link<State> mstate_{"mechanical state"};

 private:
  State* state_ = nullptr;
};

}  // namespace stroma
