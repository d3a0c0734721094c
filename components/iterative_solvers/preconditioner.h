// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <memory>

#include "framework/algebra/linear_solver.h"
#include "framework/scene/archive.h"

namespace stroma {

class BlockJacobiInverse;

/// B, symmetric and positive definite, close to A^-1 and cheap to apply: what preconditions conjugate gradients. One
/// serves one matrix, which changes.
class ApproximateInverse {
 public:
  virtual ~ApproximateInverse() = default;
  /// Brings B up to date with the matrix. False when there is none: the report says why and, where it is known, in which
  /// row.
  virtual bool follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) = 0;
  /// z = B r.
  virtual void apply(ConstRows r, Rows z) = 0;
  /// What applies B where that is by the blocks of the diagonal; else null.
  virtual const BlockJacobiInverse* blockJacobi() const { return nullptr; }
  /// Told after each solve how many iterations it took: what is kept over several matrices is renewed by it.
  virtual void solved(const SolveReport&) {}
  /// Iterations of one solve after which a new B would be the better choice: the solve then goes on with that, see giveUp().
  virtual int patience() const { return std::numeric_limits<int>::max(); }
  /// The next follow() makes B anew. False: it is of this very matrix, or always is.
  virtual bool giveUp() { return false; }
  /// Forgets the values seen so far.
  virtual void reset() = 0;
  /// See LinearSolver::serializeFor().
  virtual void serialize(SystemMatrix& /*matrix*/, Archive&) {}
  /// See LinearSolver::keepFor().
  virtual void keep(const SystemMatrix&) {}
  virtual void takeBack(const SystemMatrix&) {}
  /// The multiple of its own diagonal that was added to the matrix so that a factorisation exists; 0: none.
  virtual double shift() const { return 0; }
};

/// A preconditioner as a component, for solvers that name it by a link. It holds the parameters; each solver that names
/// it has an inverse of its own for each of its matrices.
class Preconditioner : public Component {
 public:
  std::string roleText() const override { return "preconditioner"; }
  virtual std::unique_ptr<ApproximateInverse> makeInverse() const = 0;
  /// See LinearSolver::mostRows().
  virtual Index mostRows() const { return std::numeric_limits<Index>::max(); }
};

}  // namespace stroma
