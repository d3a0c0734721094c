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

/// Identifies a matrix, its pattern and its values. Equal keys mean equal numbers: what was computed for one (an
/// analysis, factors, an inverse diagonal) is valid for the other.
struct MatrixKey {
  const void* matrix = nullptr;  ///< SystemMatrix::identity(); null: no matrix
  long pattern = 0;              ///< the owner's count of patterns
  long values = 0;               ///< the owner's count of values
  double shift = 0;              ///< of the diagonal, see SystemMatrix::key()
  bool operator==(const MatrixKey&) const = default;
};

/// The matrix of one linear solve, P (m M + k K) P + (I - P), seen as a product or as an assembled matrix; P projects
/// onto the free directions. Implemented by MechanicalMatrix.
class SystemMatrix {
 public:
  SystemMatrix() = default;
  SystemMatrix(SystemMatrix&&) = default;
  SystemMatrix& operator=(SystemMatrix&&) = default;
  virtual ~SystemMatrix() = default;
  /// Tells this matrix from all others for as long as someone holds it. Solvers hold it weakly beside what they keep for
  /// a matrix: a matrix that is made later, at the same place in memory, is then never taken for one that has died.
  const std::shared_ptr<const int>& identity() const { return identity_; }
  /// Which matrix this is now. `values` changes when any value may have changed, and only then; `pattern` changes when
  /// blocks have come or gone. A view of another matrix with more on its diagonal has that one's identity and counts, and
  /// the multiple that it adds as `shift`.
  virtual MatrixKey key() const = 0;
  virtual Index rows() const = 0;
  /// out = A p, without building the matrix; fixed directions of p must be zero and stay zero.
  virtual void multiply(ConstRows p, Rows out) const = 0;
  /// The assembled matrix (the same object at each call; eliminated directions carry a number like the others there). Assembled at
  /// most once for each key().
  virtual const BlockMatrix& assemble() = 0;
  /// The same object where its pattern alone is wanted: its values may be older than key() says.
  virtual const BlockMatrix& pattern() { return assemble(); }
  /// The 3x3 diagonal blocks, shape (rows, 9), row-major: for preconditioners, without assembling the rest.
  virtual void diagonalBlocks(std::vector<double>& blocks) const = 0;
  virtual bool symmetric() const = 0;  ///< false when some term is not
  /// True when every term of the matrix is already kept assembled or is cheaper assembled than as a product.
  virtual bool prefersAssembled(int expected_products) const = 0;
  virtual double productCost() const { return 0; }  ///< of multiply() [ns], estimated, for ratios; 0: not known
  virtual double assemblyCost() const { return -1; }  ///< of assemble() [ns], likewise; below 0: not known; 1e30: of part of the terms
  /// Where the nodes of the rows are, near enough to tell how the matrix has turned since another one; nothing (count
  /// 0) when rows are not nodes in space.
  virtual ConstRows positions() const { return {}; }
  /// Every row is a place that is not tied to others: its block may be rotated independently.
  virtual bool isOfLooseNodes() const { return positions().count > 0; }
  virtual bool hasTurns() const { return false; }  ///< some rows are turns: a residual holds forces and torques
  virtual std::string describeRow(Index row) const = 0;  ///< path of the component to blame for it, for messages

 protected:
  /// A view of another matrix.
  explicit SystemMatrix(std::shared_ptr<const int> identity) : identity_(std::move(identity)) {}

 private:
  std::shared_ptr<const int> identity_ = std::make_shared<const int>(0);
};

/// Why an iterative or direct solve ended.
enum class SolveStop {
  converged,
  iteration_limit,
  breakdown,
  not_definite,
  not_finite,
  zero_right_side,
  stagnated,
  stopped,  ///< somebody asked for it (SolveTerms::stop): there is no solution
};
std::string_view describe(SolveStop stop);

struct SolveReport {
  SolveStop stop = SolveStop::converged;
  int iterations = 0;            ///< 1 for a direct solve
  double relative_residual = 0;  ///< |b - A x| / |b| as the solver knows it
  bool factored = false;         ///< a factorisation was made in this solve
  Index row = -1;                ///< the row where a factorisation broke down, -1 otherwise
  bool usable() const { return stop != SolveStop::not_finite && stop != SolveStop::not_definite && stop != SolveStop::stopped; }
  /// Adds the report of another right side with the same matrix: `stop` becomes the worst of all. False: stop solving.
  bool add(const SolveReport& one);
};

/// What the caller of one solve passes besides the equations.
struct SolveTerms {
  /// The |b - A x| / |b| that suffices: iterative solvers stop there even if their own tolerance is tighter.
  /// 0: their own tolerance.
  double relative_residual = 0;
  StopToken stop{};  ///< a solve that is asked to stop ends within a product or a supernode, without a solution
};

/// Solves A x = b for any number of integrators. What is kept between calls (factors, work space, a last solution) is
/// kept per matrix: see PerMatrix.
class LinearSolver : public Component {
 public:
  std::string roleText() const override { return "linear solver"; }
  /// x on entry is the initial guess (zero unless the caller knows better).
  virtual SolveReport solve(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms = {}) = 0;
  /// The same for each right side b[i] and its x[i]: one after the other, unless a solver knows better.
  virtual SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms = {});
  /// Writes or reads what is kept for this matrix and bits of later solves depend on, see Component::serialize(): a last
  /// solution to start from, factors of former values. What is made again from the matrix is not part of it.
  virtual void serializeFor(SystemMatrix& /*matrix*/, Archive&) {}
  /// Before a step, and after one that is not taken: what serializeFor() knows is then again what it was.
  virtual void keepFor(SystemMatrix& /*matrix*/) {}
  virtual void takeBackFor(SystemMatrix& /*matrix*/) {}
  /// True for solvers that need a symmetric matrix; System rejects the pairing at compile time with an error.
  virtual bool needsSymmetric() const = 0;
  /// Rows of the largest matrix that it takes; System rejects larger ones likewise.
  virtual Index mostRows() const { return std::numeric_limits<Index>::max(); }
};

}  // namespace stroma
