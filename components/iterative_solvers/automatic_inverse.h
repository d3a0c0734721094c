// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "components/iterative_solvers/former_solve.h"
#include "components/iterative_solvers/multigrid.h"
#include "components/iterative_solvers/solver_costs.h"
#include "components/iterative_solvers/sweeps.h"
#include "components/iterative_solvers/warped_factor.h"

namespace stroma {

/// Block Jacobi until its iterations say that multigrid, factors of former matrices or a direct solver cost less. Each way has an
/// estimate of a solve and of what comes before the first one, in nanoseconds, from counts and from the size of the matrix. A
/// change has to pay in as many solves as there have been, and in those of 8 matrices more; a solve that gets on too slowly is
/// ended for it, and goes on from where it is. What was chosen and costs more than another way did is given up once that has cost
/// as much as a hierarchy or a factorisation. No clock is read: each run does the same.
///
/// A matrix that a way refuses as not definite is reported as such, and the next one goes the same way: Newton's method meets
/// such matrices and adds to their diagonal. Only many refusals in a row bring block Jacobi for good.
class AutomaticInverse final : public ApproximateInverse {
 public:
  enum class Way : int { block_jacobi, multigrid, factors, direct };
  using MakeFactors = std::function<DirectSolver&()>;
  /// `may_change`: false for a scene that caps iterations or wants no matrix.
  explicit AutomaticInverse(bool may_change, MakeFactors make_factors = {})
      : may_change_(may_change), make_factors_(std::move(make_factors)) {}

  /// Before follow(): nanoseconds of a product (0: not known), the relative residual that is wanted, and whether nothing in the
  /// scene changes the matrix.
  void begin(double product, double target, bool is_constant = false) {
    product_ = product, target_ = std::max(target, 1e-16), start_ = 1, has_begun_ = true, is_constant_ = is_constant;
  }
  /// So many solves of one matrix begin now. What noteSides() counts was solved without follow().
  void expectSides(std::size_t count) { sides_ = double(count); }
  void noteSides(std::size_t count) { now_.solves += int(count); }
  /// From here on, in the solve that runs.
  void noteProduct(double product) { product_ = product; }
  bool follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) override;
  void apply(ConstRows r, Rows z) override {
    const Way way = by_blocks_ ? Way::block_jacobi : now_.way;
    way == Way::multigrid ? multigrid_.apply(r, z) : way == Way::factors ? factors_->apply(r, z) : blocks_.apply(r, z);
  }
  const BlockJacobiInverse* blockJacobi() const override { return by_blocks_ || now_.way == Way::block_jacobi ? &blocks_ : nullptr; }
  /// After follow(): the direct solver solves, and not an iteration.
  bool isDirect() const { return now_.way == Way::direct; }
  /// So will the next solve with this matrix.
  bool staysDirect() const { return isDirect() && now_.next == Way::direct && !isRefused(); }
  /// The matrix has no factors, or no hierarchy.
  void noteRefusal();
  /// Multigrid refused this matrix, and block Jacobi tries it.
  bool isSecondTry() const { return by_blocks_; }
  /// Whether the solve should go on by another way than the present one, which giveUp() takes.
  bool isLost(int iterations, double residual) {
    const bool is_asked = may_change_ && !by_blocks_ && iterations % 8 == 0 && iterations >= 16 && rows_ >= few_nodes;
    return is_asked && isSlow(iterations, residual);
  }
  void solved(const SolveReport& report) override;
  /// After a whole solve A x = b: what tells how far later matrices have drifted, where factors might serve.
  void keepSolve(ConstRows b, ConstRows x);
  int patience() const override;
  bool giveUp() override;
  void reset() override;
  void serialize(SystemMatrix& matrix, Archive& archive) override;
  void keep(const SystemMatrix& matrix) override;
  void takeBack(const SystemMatrix& matrix) override;

  /// What preconditions now, and why.
  std::string choice() const;
  int changes() const { return now_.changes; }
  /// Another number where choice() has another reason.
  int reason() const { return 16 * now_.changes + 4 * int(now_.way) + 2 * now_.at_once + isRefused(); }
  /// Iterations that the next solve to such a residual and those with the same matrix are expected to take: by what former ones
  /// have taken.
  int expectedIterations(double target) const;

 private:
  static constexpr std::size_t ways = 4;
  /// Bodies of fewer nodes are solved before it matters.
  static constexpr Index few_nodes = 100;
  /// Back and forth, and then it stays.
  static constexpr int most_changes = 4;
  /// A change has to gain this much, as estimates are no better; by drifts more.
  static constexpr double worth_changing = 1.15, worth_by_drifts = 1.25;
  /// Solves that share a matrix: a direct solver is made for them.
  static constexpr double several = 2;
  /// Iterations for a decade by factors of the very matrix.
  static constexpr double most_own_rate = 1;
  /// In a row. An iteration of Newton's method tries up to nine matrices until one is definite.
  static constexpr int most_refusals = 20;

  /// Of the meshes that a body had before the present one: a changed mesh restarts the rest. Iterations hardly differ from mesh to mesh.
  struct Lessons {
    double lifetime = 0;               ///< matrices of a mesh, a moving mean; 0: the mesh has not changed
    double decades = 0;                ///< as in Memory, and the following
    std::array<double, ways> rates{};
    bool jacobi_is_guess = false;
    double blocks_each = 0;            ///< of a row; 0: not known
    double expected_rate = 0;
    FactorCosts factor_costs;          ///< as they were counted; order 0: they were not
    bool isEmpty() const { return lifetime == 0; }
    /// `name`: of the numbers in the archive.
    void serialize(const std::string& name, Archive& archive);
    bool operator==(const Lessons&) const = default;
  };

  /// What later solves depend on.
  struct Memory {
    Way way = Way::block_jacobi, next = Way::block_jacobi;  ///< from the next matrix or solve on
    int changes = 0;
    double lost = 0;                   ///< what the present way cost more than another would have [ns]
    std::array<double, ways> rates{};  ///< iterations for a decade of the residual; 0: not known
    std::array<double, ways> spent{}, gained{};  ///< of a solve: iterations and decades, moving means
    double decades = 0;                ///< that a solve gains, a moving mean
    double with_factors = 0;           ///< of all solves by factors, with factorisations [ns]
    int factor_solves = 0;             ///< these
    int factored_solves = 0;           ///< with those by the direct solver
    double fresh_rate = 0;             ///< iterations for a decade by factors of the very matrix
    double given_up = 0;               ///< on a solve by former factors that new ones end [ns]
    double product = 0;                ///< by the force fields [ns]; 0: not known
    int multigrid_solves = 0;
    int renewals = 0;                  ///< of hierarchies
    FormerSolve former;                ///< empty: drifts are not followed now
    Drifts drifts;                     ///< of matrices
    int next_former = 1;               ///< the matrix from which on another solve is kept
    double wasted = 0;                 ///< with hierarchies that were given up in a solve [ns]
    int solves = 0, matrices = 0, patterns = 0;
    int refusals = 0;                  ///< in a row
    Index blocks = 0;                  ///< of the matrix; 0: its pattern is not known so far
    double expected_rate = least_multigrid_rate;  ///< of multigrid, by the pattern
    bool jacobi_is_guess = false;      ///< its rate: no solve by it has come to its end
    bool may_factor = true;
    bool has_new_pattern = false;      ///< since the last solve by factors
    bool at_once = false;              ///< former factors do not serve: each matrix is factored
    FactorCosts factor_costs;          ///< estimated, and then those of the factors
    bool is_counted = false;           ///< these are not the least that the laws allow
    MatrixKey key;                     ///< of the last solve
    Lessons lessons;
    void serialize(Archive& archive);
  };
  bool isRefused() const { return now_.refusals >= most_refusals; }
  std::size_t at(Way way) const { return std::size_t(way); }
  static bool isFactored(Way way) { return way == Way::factors || way == Way::direct; }
  bool mayBe(Way way) const { return !isFactored(way) || (now_.may_factor && make_factors_); }
  double iteration(Way way) const;
  double setup(Way way) const;
  double factorisation() const;
  double turning(Way way) const;
  double byFactors(double each, double drift) const;
  double solveByFormer(double each, double renewal) const;
  double renewing() const;
  double cycle() const;
  double assembly() const { return IterationCosts::assembly(*matrix_); }
  bool isConstant() const;
  double direct() const;
  double blocks() const {
    const double each = now_.lessons.blocks_each > 0 ? now_.lessons.blocks_each : IterationCosts::usual_blocks;
    return now_.blocks > 0 ? double(now_.blocks) : each * rows_;
  }
  double solve(Way way) const;
  double byJacobi(double iterations) const;
  /// Factors of the very matrix take many iterations: what multiplies is not what was factored.
  bool isUnlikeItsFactors() const { return now_.fresh_rate > most_own_rate; }
  double byFresh() const;
  double solveByOwn() const;
  double decades() const { return now_.decades > 0 ? now_.decades : -std::log10(target_); }
  double perMatrix() const { return std::max(sides_, double(now_.solves) / std::max(1, now_.matrices)); }
  double horizon() const;
  Lessons lessonsOfAll() const;
  void serializeLessons(Archive& archive);
  void chooseByLessons();
  bool isSlow(int iterations, double residual);
  Way cheapest(double present, double left) const;
  bool findCheaper(double rate, double left);
  void estimateFactors();
  void notePattern();
  void countFactors();
  void change(Way way);
  void note(SystemMatrix& matrix);
  bool followBy(Way way, SystemMatrix& matrix, SolveReport& report, StopToken stop);
  WarpedFactor& factors();
  bool canFactor();
  bool refuse(SystemMatrix& matrix, SolveReport& report, StopToken stop);
  void noteRate(double iterations, double gained, double part);
  void judge(double cost);
  void takeFactorsOfEach(double gain);
  Way bestOfOthers() const;
  void followDrifts(SystemMatrix& matrix);
  bool mightFactorsPay() const;
  void avoidMultigrid(SystemMatrix& matrix);

  bool may_change_;
  MakeFactors make_factors_;
  double product_ = 0, target_ = 1e-8;
  double sides_ = 1;        ///< solves with this matrix, where they are known
  double start_ = 1;        ///< relative residual that the present part of a solve starts from
  bool has_begun_ = false;  ///< a solve that follow() has not counted
  bool leaves_ = false;     ///< isLost() said so
  bool renews_ = false;     ///< for a new hierarchy
  bool is_constant_ = false;
  bool factored_ = false;   ///< in the solve that runs
  bool is_guess_ = false;   ///< what the present way costs: another one has to gain twice as much
  bool by_blocks_ = false;  ///< the solve that runs is a second try
  Index rows_ = 0;
  SystemMatrix* matrix_ = nullptr;  ///< of the solve that runs
  BlockJacobiInverse blocks_;
  Multigrid multigrid_;
  std::unique_ptr<WarpedFactor> factors_;  ///< null: not needed so far
  Memory now_, kept_;
};

}  // namespace stroma
