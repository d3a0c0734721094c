// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "components/iterative_solvers/solver_costs.h"
#include "components/iterative_solvers/warped_factor.h"
#include "framework/algebra/linear_solver.h"
#include "framework/scene/archive.h"

namespace stroma {

class Node;

/// What factors that serve later matrices have cost, and what factors of each matrix would have [s]. Iterations are tried for as long
/// as all matrices together, this one factored after them, cost no more than `worth` times as much as factors of each: so a body whose
/// matrices former factors do not serve loses little.
struct FormerFactorAccount {
  double spent = 0, of_each = 0;

  static constexpr double worth = 1.15, refinements = 3;
  static double ofOne(const WarpedFactor::Prices& prices) { return prices.factor + refinements * prices.iteration; }
  /// That the next matrix may take by former factors.
  int mostIterations(const WarpedFactor::Prices& prices) const;
  void addFormer(int iterations, const WarpedFactor::Prices& prices) { spent += iterations * prices.iteration; }
  /// A solve by factors of the very matrix, `made` for it.
  void addFactors(bool made, const WarpedFactor::Prices& prices) { spent += made ? ofOne(prices) : 0; }
  /// Of a matrix that factors of each would have factored.
  void endMatrix(const WarpedFactor::Prices& prices) { of_each += ofOne(prices); }
  void serialize(Archive& archive);
};

/// Whether a solve needs no other one after it.
inline bool isOver(SolveStop stop) {
  return stop == SolveStop::converged || stop == SolveStop::stopped || stop == SolveStop::not_finite;
}

/// What AutomaticLinearSolver has chosen for a matrix, and remembers of the solves since.
struct EquilibriumChoice {
  enum class Way : int { open, factors, multigrid };
  /// Pressures as unknowns, see mixed_solve.h; `way` is for solves that they do not serve. Expected: the first solve looks whether the
  /// values of the matrix are those of the force fields, and may refute it.
  enum class Pressures : int { none, expected, unknowns, refuted, given_up };

  Way way = Way::open;
  int patience = 0;            ///< iterations of a solve by multigrid
  bool is_close = false;       ///< factors cost less where diagonal blocks hardly smooth, which the first solve finds out
  bool is_rough = false;       ///< they do
  int lost_iterations = 0;     ///< by multigrid, when it was given up in a solve
  double left = 0;             ///< the relative residual then
  bool keeps_factors = false;  ///< for later matrices
  int refusals = 0;            ///< of matrices, by conjugate gradients with their own factors
  bool is_indefinite = false;  ///< a matrix was so: there the round-off of a solve decides which way a body goes
  FormerFactorAccount account = {};
  int solves = 0;              ///< by multigrid
  double spent = 0;            ///< on these [s]
  bool is_strict = false;      ///< loose solves have led to where the matrix is not definite
  int strict_failures = 0;     ///< strict ones have done so too
  bool was_definite = false;   ///< the matrix solved before
  Pressures pressures = Pressures::none;
  int lost_with_pressures = 0;  ///< iterations, of the solve that gave them up
  double left_with_pressures = 0;  ///< the relative residual then
  double rate = 0;             ///< iterations by multigrid for a decade of the residual, in the last solve; 0: not known

  /// The most that a strict solve leaves of |b|.
  static constexpr double strict = 0.01;
  /// And one by former factors: Newton's method then takes about as many iterations as with factors of each matrix.
  static constexpr double by_former = 1e-4;
  /// Where such a solve has come to an end before that, but to what Newton's method has asked for: that is not thrown away for new factors.
  static void acceptEnough(double asked, SolveReport& report) {
    const bool is_enough = report.stop == SolveStop::iteration_limit && report.relative_residual <= std::min(asked, strict);
    if (is_enough) report.stop = SolveStop::converged;
  }
  /// What is solved loosely can move a body to where its matrix is not definite, which a better solve would not have done. Solves are
  /// strict once that has happened. Where strict ones have led there too, they are of no use.
  void noteDefinite(const SolveReport& report);
  /// Of a solve to this share of |b|: by what the last one took; of the first one few where it is loose, and else `usual`.
  int expectedIterations(double target, bool is_loose, int usual) const;
  /// `began`: the share of |b| that was left where a solve by multigrid began.
  void noteRate(const SolveReport& report, double began);
  /// After a solve by multigrid of Newton's method: true when so many would have paid for factors, and these fit into half of the memory.
  /// `made`: with a new hierarchy.
  bool isDear(const SolverCosts& costs, int iterations, bool has_patches, bool made);
  /// Whether the first choice proved wrong.
  bool isChanged() const { return pressures == Pressures::given_up || (way == Way::factors && (lost_iterations > 0 || solves > 0)); }
  bool hasPressures() const { return pressures == Pressures::expected || pressures == Pressures::unknowns; }
  /// After a solve that has failed.
  void givePressuresUp(const SolveReport& report);
  /// Why pressures are no unknowns any more, to be added to the reason. Empty: they are, or never were.
  std::string ofPressures() const;
  /// Whether conjugate gradients may try former factors.
  bool triesFormer() const { return keeps_factors && !is_indefinite && refusals < most_refusals; }
  /// In words, for factors by `type`.
  std::string ofFactors(const std::string& type, const std::string& reason) const;
  void serialize(Archive& archive);

 private:
  static constexpr int most_refusals = 3;
};

/// The first choice for a matrix, by estimates from its counts; `costs` are theirs, `reason` says them in words. Factors are for
/// `most_factored` rows at most, and serve later matrices only where these change with the state.
EquilibriumChoice chooseFirst(SystemMatrix& matrix, const Node& root, Index most_factored, SolverCosts& costs, std::string& reason);

/// Looks at the values of the first matrix where pressures are expected. True where the choice has changed.
bool refutesPressures(SystemMatrix& matrix, const Node& root, EquilibriumChoice& choice);

/// The output `estimates` of AutomaticLinearSolver. `has_patches`: a hierarchy needs them.
std::vector<double> estimateSolves(SystemMatrix& matrix, bool has_patches);

/// The |b - A x| / |b| that round-off leaves, whatever solves: that of D x, D the diagonal blocks.
double roundOff(const SystemMatrix& matrix, ConstRows b, ConstRows x);
/// Whether factors would leave as much as this relative residual, or half of it.
bool isAtRoundOff(const SystemMatrix& matrix, ConstRows b, ConstRows x, double left);

}  // namespace stroma
