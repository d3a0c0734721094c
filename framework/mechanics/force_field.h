// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

struct CellKind;

/// Properties of a force field that let the plan skip work. The defaults promise nothing.
struct ForceTraits {
  bool linear = false;              ///< force is affine in x
  bool constant_stiffness = false;  ///< K does not change: assemble and factor once
  bool symmetric = false;           ///< K = K^T
  bool conservative = false;        ///< force = -grad energy, for every shape
  bool has_stiffness = true;        ///< false: K = 0, products and assembly are skipped
  bool exact_tangent = false;       ///< K is the derivative of the force, not an approximation of it
  bool velocity_dependent = false;  ///< C = df/dv is used; addForce may read v without it
  bool time_dependent = false;      ///< setTime() changes the force
  bool forces_balance = false;      ///< internal: forces sum to zero and vanish at the rest shape
  bool torques_balance = false;     ///< internal: torques sum to zero too
  bool has_rest_shape = false;      ///< a body far larger than at rest has burst; implied by forces_balance
  bool lagged = false;              ///< depends on a quantity from before the step
  bool decided_outside = false;     ///< a program computes it and may change it without an edit
  bool undamped = false;            ///< contact stiffness: the integrator's rayleighStiffness excludes it
};

/// A force on the nodes of one state, or between states. Vectors cover the whole system (rows as in State::firstRow()).
/// K = df/dx and C = df/dv are derivatives of the force at the (x, v) of the last addForce() call; one pattern of
/// blocks serves both.
class ForceField : public Component {
 public:
  std::string roleText() const override { return "force field"; }
  void declare(DataTable& table) override;  ///< mstate, rayleighStiffness
  void init() override;                     ///< finds the state
  State& state() const { return *state_; }
  /// Every state that the force acts on or depends on.
  virtual std::vector<State*> states() const { return {state_}; }

  virtual ForceTraits traits() const = 0;
  /// Called once by the System when row numbers are known: build whatever depends on them.
  virtual void compile() {}
  /// With traits().time_dependent: the time [s] at which forces are evaluated, the end of a step.
  virtual void setTime(double) {}
  /// Potential energy [J] at x. Where traits().conservative is false: the stored elastic energy, for monitoring.
  virtual double energy(ConstRows x) const = 0;
  /// f += force [N] at (x, v); prepares the stiffness at x.
  virtual void addForce(ConstRows x, ConstRows v, Rows f) = 0;
  /// False: the force and derivatives of the last addForce() are zero, like contact where nothing touches. Called in every product.
  virtual bool acts() const { return true; }
  /// df += factor * K dx.
  virtual void addStiffnessProduct(ConstRows dx, double factor, Rows df) const = 0;
  /// Adds the blocks of the system matrix that K and C fill.
  virtual void addPattern(BlockPattern& pattern) const = 0;
  /// Increases when addPattern() would add different blocks, as pairs come and go. Only addForce() and setTime() may
  /// increase it. A stored matrix then gets a new pattern before its next assembly.
  virtual long patternRevision() const { return 0; }
  /// Called once per pattern of the matrix: look up slots.
  virtual void prepareAssembly(const BlockMatrix&) {}
  /// matrix += factor * K.
  virtual void addStiffness(double factor, BlockMatrix& matrix) const = 0;
  /// blocks[row] += factor * K[row][row], shape (rows, 9).
  virtual void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const = 0;
  /// The same three for C; called, and therefore overridden, only with traits().velocity_dependent.
  virtual void addDampingProduct(ConstRows dv, double factor, Rows df) const;
  virtual void addDamping(double factor, BlockMatrix& matrix) const;
  virtual void addDampingDiagonal(double factor, std::vector<double>& blocks) const;
  /// f += force(x) + factor * K(x) dx in one pass. Override it where the two can share work.
  virtual void addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f) {
    addForce(x, v, f);
    addStiffnessProduct(dx, factor, f);
  }
  /// Estimated cost [ns] of one product and of one assembly on one core, used to choose between matrix-free and assembled.
  struct Cost {
    double product = 0, assembly = 0;
  };
  virtual Cost cost() const { return {}; }
  /// Describes the worst element at x in a report of divergence ("tetrahedron 12 (nodes 3 4 8 9): J = -0.3"), or is
  /// empty.
  virtual std::string worstElement(ConstRows) const { return {}; }
  /// Says why x is outside the range of validity of the law, or is empty. Called at the end of a run.
  virtual std::string doubt(ConstRows) const { return {}; }
  /// Named per-cell fields for output ("vonMises", "J"), computed only when an observer asks for them.
  virtual std::vector<std::string> cellFields() const { return {}; }
  virtual void cellField(const std::string&, ConstRows /*x*/, std::vector<double>& /*out*/) const {}
  /// The cells of the mesh that have values, and the components per value (a symmetric tensor has six: xx yy zz xy yz zx).
  struct CellFieldShape {
    const CellKind* kind = nullptr;
    std::size_t width = 1;
  };
  virtual CellFieldShape cellFieldShape(const std::string& /*name*/) const { return {}; }

  double rayleigh_stiffness = 0;  ///< [s], local Rayleigh factor added to the integrator's

 protected:
  Link<State> mstate_{"mechanical state"};
  /// True if the force is also defined on rows that are not points, or on the centres of frames. Otherwise init() rejects
  /// frames and numbers.
  virtual bool takesAllRows() const { return false; }

 private:
  State* state_ = nullptr;
};

}  // namespace stroma
