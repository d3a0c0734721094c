// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

struct CellKind;

/// The properties of a force field, so that the plan can skip work. A trait that is not set promises nothing.
struct ForceTraits {
  bool linear = false;              ///< force is affine in x
  bool constant_stiffness = false;  ///< K does not change: assemble and factor once
  bool symmetric = false;           ///< K = K^T
  bool conservative = false;        ///< force = -grad energy, for every shape
  bool has_stiffness = true;        ///< false: K = 0, products and assembly are skipped
  bool exact_tangent = false;       ///< K is the derivative of the force, not an approximation of it
  bool velocity_dependent = false;  ///< C = df/dv is asked for; addForce may read v without one
  bool time_dependent = false;      ///< setTime() changes the force
  bool forces_balance = false;      ///< internal: forces sum to zero and vanish at the rest shape
  bool torques_balance = false;     ///< internal: torques sum to zero too
  bool has_rest_shape = false;      ///< a body far larger than at rest has burst; implied by forces_balance
  bool lagged = false;              ///< depends on a quantity from before the step
  bool decided_outside = false;     ///< controlled by a program, which may change it without an edit
  bool undamped = false;            ///< stiffness of contact: an integrator's rayleighStiffness leaves K out
};

/// A force on the nodes of a state, or between states. Vectors are the whole system's (rows as in State::firstRow()).
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
  /// Called once by the System when rows are known: build what depends on row numbers.
  virtual void compile() {}
  /// With traits().time_dependent: the time [s] that the forces are evaluated for, the end of a step.
  virtual void setTime(double) {}
  /// Potential energy [J] at x. Where traits().conservative is false: the stored elastic energy, for monitoring.
  virtual double energy(ConstRows x) const = 0;
  /// f += force [N] at (x, v); prepares the stiffness at x.
  virtual void addForce(ConstRows x, ConstRows v, Rows f) = 0;
  /// False: force and derivatives of the last addForce() are zero, as of contact where nothing touches. Asked in each product.
  virtual bool acts() const { return true; }
  /// df += factor * K dx.
  virtual void addStiffnessProduct(ConstRows dx, double factor, Rows df) const = 0;
  /// Which blocks of the system matrix K and C touch.
  virtual void addPattern(BlockPattern& pattern) const = 0;
  /// Grows when addPattern() would add other blocks than before, as pairs come and go; only addForce() and setTime() may
  /// make it grow. A matrix that is kept then gets a new pattern before it is assembled the next time.
  virtual long patternRevision() const { return 0; }
  /// Called when the matrix has got its pattern, for each pattern once: look up slots.
  virtual void prepareAssembly(const BlockMatrix&) {}
  /// matrix += factor * K.
  virtual void addStiffness(double factor, BlockMatrix& matrix) const = 0;
  /// blocks[row] += factor * K[row][row], shape (rows, 9).
  virtual void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const = 0;
  /// The same three for C; called only with traits().velocity_dependent, and then to be overridden.
  virtual void addDampingProduct(ConstRows dv, double factor, Rows df) const;
  virtual void addDamping(double factor, BlockMatrix& matrix) const;
  virtual void addDampingDiagonal(double factor, std::vector<double>& blocks) const;
  /// f += force(x) + factor * K(x) dx in one pass; a field that can share the work overrides it.
  virtual void addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f) {
    addForce(x, v, f);
    addStiffnessProduct(dx, factor, f);
  }
  /// Estimated nanoseconds of one product and of one assembly on one core, for the choice matrix-free or assembled.
  struct Cost {
    double product = 0, assembly = 0;
  };
  virtual Cost cost() const { return {}; }
  /// A sentence on the worst element at x, for a report of divergence ("tetrahedron 12 (nodes 3 4 8 9): J = -0.3"),
  /// or empty.
  virtual std::string worstElement(ConstRows) const { return {}; }
  /// A sentence on why x is outside the range of validity of the law, or empty. Asked at the end of a run.
  virtual std::string doubt(ConstRows) const { return {}; }
  /// Named per-cell fields for output ("vonMises", "J"): computed only when an observer asks. Empty name list: none.
  virtual std::vector<std::string> cellFields() const { return {}; }
  virtual void cellField(const std::string&, ConstRows /*x*/, std::vector<double>& /*out*/) const {}
  /// Which cells of its mesh have the values, and how many numbers each has (of a symmetric tensor six, xx yy zz xy yz zx).
  struct CellFieldShape {
    const CellKind* kind = nullptr;
    std::size_t width = 1;
  };
  virtual CellFieldShape cellFieldShape(const std::string& /*name*/) const { return {}; }

  double rayleigh_stiffness = 0;  ///< [s], local Rayleigh factor added to the integrator's

 protected:
  Link<State> mstate_{"mechanical state"};
  /// True where the force has a meaning for other rows than points, or for the centres of frames: init() refuses frames
  /// and numbers otherwise.
  virtual bool takesAllRows() const { return false; }

 private:
  State* state_ = nullptr;
};

}  // namespace stroma
