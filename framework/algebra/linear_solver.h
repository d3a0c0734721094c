// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <memory>
#include <span>
#include <string_view>

#include "framework/algebra/block_matrix.h"
#include "framework/algebra/stop.h"
#include "framework/scene/component.h"

namespace stroma {

/// Identifies a matrix, its pattern and its values. Equal keys mean equal numbers: whatever was derived from one (an
/// analysis, factors, an inverse diagonal) is valid for the other.
struct MatrixKey {
  const void* matrix = nullptr;  ///< SystemMatrix::identity(); null: no matrix
  long pattern = 0;              ///< the owner's pattern revision
  long values = 0;               ///< the owner's value revision
  double shift = 0;              ///< added to the diagonal, see SystemMatrix::key()
  bool operator==(const MatrixKey&) const = default;
};

/// The matrix of one linear solve, P (m M + k K) P + (I - P), available as a product or as an assembled matrix; P projects
/// onto the free directions. Implemented by MechanicalMatrix.
class SystemMatrix {
 public:
  SystemMatrix() = default;
  SystemMatrix(SystemMatrix&&) = default;
  SystemMatrix& operator=(SystemMatrix&&) = default;
  virtual ~SystemMatrix() = default;
  /// Distinguishes this matrix from all others for as long as anyone holds the pointer. Solvers keep a weak pointer beside
  /// their data, so that a later matrix at the same address is never confused with a destroyed one.
  const std::shared_ptr<const int>& identity() const { return identity_; }
  /// The current revision. `values` changes if and only if some value may have changed; `pattern` changes when blocks
  /// appear or disappear. A view of another matrix with a shifted diagonal has that matrix's identity and revisions, and the
  /// added multiple as `shift`.
  virtual MatrixKey key() const = 0;
  virtual Index rows() const = 0;
  /// out = A p, without assembling the matrix. Fixed directions of p must be zero and stay zero.
  virtual void multiply(ConstRows p, Rows out) const = 0;
  /// The assembled matrix, always the same object; eliminated directions have a diagonal entry of similar size. Assembled at
  /// most once per key().
  virtual const BlockMatrix& assemble() = 0;
  /// The same object if only its pattern is needed: its values may be older than key() says.
  virtual const BlockMatrix& pattern() { return assemble(); }
  /// The 3x3 diagonal blocks, shape (rows, 9), row-major: for preconditioners, without assembling the rest.
  virtual void diagonalBlocks(std::vector<double>& blocks) const = 0;
  virtual bool symmetric() const = 0;  ///< false if some term is not symmetric
  /// True if every term of the matrix is already stored assembled, or cheaper assembled than as a product.
  virtual bool prefersAssembled(int expected_products) const = 0;
  virtual double productCost() const { return 0; }  ///< estimated cost of multiply() [ns], used in ratios; 0: unknown
  virtual double assemblyCost() const { return -1; }  ///< the same for assemble(); below 0: unknown; 1e30: unknown for some terms
  /// Positions of the nodes of the rows, accurate enough to estimate how the matrix has rotated since an earlier one; empty
  /// (count 0) if rows are not nodes in space.
  virtual ConstRows positions() const { return {}; }
  /// Every row is a place that is not tied to others: its block may be rotated independently.
  virtual bool isOfLooseNodes() const { return positions().count > 0; }
  virtual bool hasTurns() const { return false; }  ///< some rows are orientations: a residual has forces and torques
  virtual std::string describeRow(Index row) const = 0;  ///< path of the component behind this row, for messages

 protected:
  /// A view of another matrix.
  explicit SystemMatrix(std::shared_ptr<const int> identity) : identity_(std::move(identity)) {}

 private:
  std::shared_ptr<const int> identity_ = std::make_shared<const int>(0);
};

/// Why a solve ended.
enum class SolveStop {
  converged,
  iteration_limit,
  breakdown,
  not_definite,
  not_finite,
  zero_right_side,
  stagnated,
  stopped,  ///< requested by SolveTerms::stop: there is no solution
};
std::string_view describe(SolveStop stop);

struct SolveReport {
  SolveStop stop = SolveStop::converged;
  int iterations = 0;            ///< 1 for a direct solve
  double relative_residual = 0;  ///< |b - A x| / |b| as the solver knows it
  bool factored = false;         ///< this solve included a factorisation
  Index row = -1;                ///< the row at which a factorisation broke down, otherwise -1
  bool usable() const { return stop != SolveStop::not_finite && stop != SolveStop::not_definite && stop != SolveStop::stopped; }
  /// Adds the report of another right-hand side with the same matrix; `stop` is the worst of all. False: no solution is possible.
  bool add(const SolveReport& one);
};

/// What the caller of a solve requests besides the equations.
struct SolveTerms {
  /// A sufficient |b - A x| / |b|: iterative solvers stop there even if their own tolerance is tighter. 0: their own
  /// tolerance.
  double relative_residual = 0;
  StopToken stop{};  ///< a stopped solve ends within a product or a supernode, without a solution
};

/// Solves A x = b for any number of integrators. Whatever it keeps between calls (factors, work space, the last solution)
/// is kept per matrix: see PerMatrix.
class LinearSolver : public Component {
 public:
  std::string roleText() const override { return "linear solver"; }
  /// x is the initial guess on entry (zero unless the caller has a better one).
  virtual SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms = {}) = 0;
  /// The same for each right-hand side b[i] and its x[i]: one after the other by default.
  virtual SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms = {});
  /// Writes or reads the data of this matrix that affects the bits of later solves, see Component::serialize(): the last
  /// solution, factors of former values. Whatever can be recomputed from the matrix is not included.
  virtual void serializeFor(SystemMatrix& /*matrix*/, Archive&) {}
  /// Called before a step, and after a rejected one: the data of serializeFor() is then restored.
  virtual void keepFor(SystemMatrix& /*matrix*/) {}
  virtual void takeBackFor(SystemMatrix& /*matrix*/) {}
  /// True for solvers that need a symmetric matrix; System reports an error for other pairings when it compiles.
  virtual bool needsSymmetric() const = 0;
  /// Rows of the largest matrix that it accepts; System checks this in the same way.
  virtual Index mostRows() const { return std::numeric_limits<Index>::max(); }
};

}  // namespace stroma
