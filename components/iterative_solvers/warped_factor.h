// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "components/iterative_solvers/former_matrix.h"
#include "components/iterative_solvers/preconditioner.h"
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// The factors of a former matrix A_0, turned by how much each node's surroundings have turned since:
///   B = R A_0^-1 R^T,   R block-diagonal (Courtecuisse, Allard, Duriez, Cotin 2010).
/// R_i is the rotation nearest to sum_j (x_j - x_i)(X_j - X_i)^T over the neighbours j of node i in the graph of A_0,
/// X the positions when A_0 was factored. Without positions R = I.
///
/// The factors are renewed when a solve cost more than the solves since the last factorisation on average, the factorisation
/// included: to go on would raise that average. It is one for a decade of the residual and for what comes before the first, as loose
/// solves and others may take turns. A solve that takes longer than a factorisation is given up for
/// one. Where that happens to the first matrix after a factorisation, the next ones are factored at once: two, and up to sixteen
/// where it happens again. Blocks that come and go in the pattern, as pairs in contact do, count as other values.
class WarpedFactor final : public ApproximateInverse {
 public:
  enum class Renewal {
    estimate,  ///< costs from counts of operations: each run does the same
    clock,     ///< costs by the clock: what is renewed when may differ from run to run
    never
  };
  explicit WarpedFactor(DirectSolver& solver, Renewal renewal = Renewal::estimate)
      : solver_(solver), renewal_(renewal) {}

  bool follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) override;
  void apply(ConstRows r, Rows z) override;
  void solved(const SolveReport& report) override {
    now_.last = report.relative_residual;
    solved(report, std::exchange(now_.left, 1));
  }
  /// A solve, or the part of one that began where `began` of |b| was left.
  void solved(const SolveReport& report, double began);
  int patience() const override;
  bool giveUp() override {
    if (now_.fresh || renewal_ == Renewal::never) return false;
    if (now_.served == 1) now_.failures = std::min(now_.failures + 1, 4), now_.at_once = 1 << now_.failures;
    now_.left = now_.last;
    return now_.renew = true;
  }
  void keep(const SystemMatrix& matrix) override {
    kept_ = now_, kept_current_ = isCurrent(matrix);
    solver_.keepFor(former_);
  }
  /// Factors that were renewed meanwhile are made again from the values before when they are needed.
  void takeBack(const SystemMatrix& matrix) override;
  /// With the values that were factored: they are factored again when they are needed.
  void serialize(SystemMatrix& matrix, Archive& archive) override;
  /// The next follow() factors where the matrix is another one.
  void factorNext() { now_.at_once = std::max(now_.at_once, 1); }
  /// The last follow() was with this matrix.
  bool isOf(const SystemMatrix& matrix) const { return fits(matrix) && isCurrent(matrix); }
  /// It factored.
  bool isFresh() const { return now_.fresh; }
  /// Right after that: the solve that the direct solver makes of the very matrix. It is worth as much as one that leaves `enough` of |b|.
  SolveReport solveFresh(ConstRows b, Rows x, const SolveTerms& terms, double enough);
  /// Estimated seconds of what was factored last; 0: nothing was.
  struct Prices {
    double factor = 0, iteration = 0;
  };
  Prices prices() const { return {now_.factor_seconds, now_.iteration_seconds}; }
  /// Of the factors that follow() has left.
  Factorisation::Cost cost() const { return factors_->cost(); }
  /// Gives the factors to the direct solver's own use for this matrix. reset() follows.
  void handOver(SystemMatrix& matrix) {
    factors_ = nullptr;
    solver_.handOver(former_, matrix);
  }
  void reset() override {
    now_ = kept_ = {};
    origins_ = {}, factored_ = none;
  }

 private:
  /// Factors are kept, and of as many nodes. What is never renewed for its costs is renewed for another pattern, and where an
  /// edit has changed what the matrix is made of.
  bool fits(const SystemMatrix& matrix) const {
    return now_.rows == matrix.rows() && (renewal_ != Renewal::never || now_.key.pattern == matrix.key().pattern);
  }
  /// Is the matrix that of the last follow(), as far as the steps that were taken go?
  bool isCurrent(const SystemMatrix& matrix) const { return now_.key == matrix.key() || taken_back_ == matrix.key(); }
  void turn(ConstRows positions);
  bool renew(SystemMatrix& matrix, SolveReport& report, StopToken stop);
  bool makeAgain(SolveReport& report, StopToken stop);
  void noteRotations();
  void judgePrecision(int iterations, double rate);

  /// Where the factors were made.
  struct Origin {
    Vector positions;  ///< X
    BlockMatrix matrix;  ///< A_0
    bool symmetric = true;
    void serialize(Archive& archive);
  };
  /// What later solves depend on.
  struct Memory {
    Index rows = -1;
    MatrixKey key;       ///< of the last follow()
    bool renew = false;  ///< the next follow() factors
    bool fresh = false;  ///< the last follow() factored
    bool turned = false;
    bool rough = true;             ///< factors are applied in single precision
    double rough_rate = 0;         ///< iterations for a decade when that was given up; 0: it was not
    double iteration_seconds = 0;  ///< estimate of one product and one application
    double factor_seconds = 0;     ///< of a factorisation
    double spent = 0;              ///< seconds since the last factorisation, with it
    double gained = 0;             ///< since then: decades, and one for each solve
    double last = 1;               ///< what the last solve, or part of one, left of |b|
    double left = 1;               ///< the same where that was given up and goes on
    int served = 0;                ///< matrices since then
    int at_once = 0;               ///< matrices that are to be factored without a trial
    int failures = 0;              ///< of factors with the first matrix after their own, in a row
    std::size_t origin = 0;        ///< which of origins_
    std::vector<Eigen::Quaterniond> rotations;
  };

  DirectSolver& solver_;
  Renewal renewal_;
  FormerMatrix former_;
  Factorisation* factors_ = nullptr;  ///< the solver's for former_, kept from one renewal to the next
  std::size_t factored_ = none;       ///< of which origin they are
  static constexpr std::size_t none = 2;
  std::array<Origin, 2> origins_;  ///< that of the step before stays until the step is taken
  Memory now_, kept_;
  bool kept_current_ = false;
  MatrixKey taken_back_;  ///< what a step that was taken back left of the matrix of now_
  std::chrono::steady_clock::time_point start_;
  Vector work_;
  std::vector<Mat3> matrices_;  ///< of the rotations, shape (rows)
};

/// The one direct solver that `link` names or else the node of `user` holds. Throws ComponentError.
DirectSolver& factorSource(const Component& user, const Link<DirectSolver>& link);

}  // namespace stroma
