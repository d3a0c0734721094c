// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>

#include "components/iterative_solvers/solver_costs.h"
#include "components/iterative_solvers/symmetric_blocks.h"
#include "framework/algebra/per_matrix.h"
#include "framework/scene/spans.h"

namespace stroma {

class Node;
/// Whether some matrix of the scene may depend on places or velocities.
bool matrixDependsOnState(const Node& root);
/// What solvers by products share: `iterations`, `tolerance`, `template`, `graph`, the form of the product, and the
/// ends that need no iteration. Members are those of the solve that runs; what outlives it is kept for each matrix.
class KrylovSolver : public LinearSolver {
 public:
  void declare(DataTable& table) override;
  void init() override;
  bool needsSymmetric() const override { return true; }

 protected:
  // The following are inline for the reason given in vector.h.

  /// Makes what a solve needs besides a preconditioner. False when the solve is over: the report says why.
  bool begin(SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms, SolveReport& report) {
    graph_.clear();
    terms_ = terms;
    norm_b_ = norm(b);
    if (!std::isfinite(norm_b_)) {
      report.stop = SolveStop::not_finite;
      report.relative_residual = norm_b_;
      return false;
    }
    if (norm_b_ == 0) {
      clear(x);
      report.stop = SolveStop::zero_right_side;
      return false;
    }
    assembled_ = nullptr, halved_ = nullptr;
    if (form_ == Form::assembled || (form_ == Form::automatic && matrix.prefersAssembled(expected_iterations_)))
      takeMatrix(matrix, expected_iterations_);
    if (!isStopAsked()) return true;
    report.stop = SolveStop::stopped;
    report.relative_residual = 1;
    return false;
  }
  /// Where elements multiply for longer than was expected: whether the matrix does from here on, because so many products would
  /// have paid for it.
  bool assemblesLate(SystemMatrix& matrix, int products) {
    constexpr int often = 4;
    if (assembled_ || form_ != Form::automatic || products <= expected_iterations_ || products % often != 0) return false;
    if (!matrix.prefersAssembled(products)) return false;
    takeMatrix(matrix, products);
    return true;
  }
  /// out = A p
  void product(const SystemMatrix& matrix, ConstRows p, Rows out) const {
    if (!assembled_) return matrix.multiply(p, out);  // whose parts are heard
    const Span span("product", this);
    halved_ ? halved_->multiply(p, out) : assembled_->multiply(p, out);
  }
  /// Nanoseconds of that, estimated; 0: not known.
  double productCost(const SystemMatrix& matrix) const {
    return assembled_ ? BlockMatrix::productCost(assembled_->blocks(), halved_ != nullptr) : matrix.productCost();
  }
  /// r = b - A x; returns r.r. `work` has the shape of r.
  double residual(const SystemMatrix& matrix, ConstRows b, ConstRows x, Rows r, Rows work) const {
    copy(b, r);
    if (dot(x, x) != 0) {
      product(matrix, x, work);
      axpy(-1, work, r);
    }
    return dot(r, r);
  }
  /// The |b - A x| at which a solve ends.
  double target() const { return relativeTarget(terms_) * norm_b_; }
  double relativeTarget(const SolveTerms& terms) const { return std::max(tolerance(), terms.relative_residual); }
  bool isStopAsked() const { return terms_.stop.isStopAsked(); }
  /// A scene that writes `iterations` and no tolerance, as SOFA's do, has SOFA's.
  double tolerance() const { return is_capped_ && !tolerance_data_->isSet() ? 1e-5 : tolerance_; }
  /// Appends to `graph` as long as init() made room: no allocation in a step.
  void record(double relative_residual) {
    if (graph_.size() < graph_.capacity()) graph_.push_back(relative_residual);
  }

  /// Most products of a solve. The default is a safety net that no solve of a sound scene meets.
  int iterations_ = 20000;
  /// |b - A x| / |b| at which a solve ends.
  double tolerance_ = 1e-8;
  /// What a solve is taken to need when the form of the product is chosen, where the scene does not limit it.
  int expected_iterations_ = 100;
  double norm_b_ = 0;  ///< |b| of the solve that begin() opened
  SolveTerms terms_;   ///< its terms

 private:
  void takeMatrix(SystemMatrix& matrix, int products) {
    assembled_ = &matrix.assemble();
    halved_ = products >= few && matrix.symmetric() ? &halves_.of(matrix) : nullptr;
    if (halved_ && !halved_->follow(*assembled_, matrix.key())) halved_ = nullptr;
  }
  enum class Form { automatic, product, assembled };
  static constexpr int few = 3;  ///< iterations, for which halves of a matrix are not worth being copied
  std::string template_ = "auto";
  /// Relative residuals of the last solve, shape (iterations done); an output of the component.
  std::vector<double> graph_;
  /// Whether products go through the elements or the matrix; automatic asks the system for the cheaper.
  Form form_ = Form::automatic;
  bool is_capped_ = false;                  ///< the scene writes `iterations`
  const Data* tolerance_data_ = nullptr;    ///< the attribute
  const BlockMatrix* assembled_ = nullptr;  ///< null while products are matrix-free
  SymmetricBlocks* halved_ = nullptr;       ///< the same; null where it is not symmetric
  PerMatrix<SymmetricBlocks> halves_;
};

}  // namespace stroma
