// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of more conditions than degrees of freedom, as of rigid bodies whose faces touch at many points: W (condition_forces.h) is
// P Q^T with fewer columns than rows. Such rows are redundant, and their forces not unique. A small compliance selects among all
// solutions: with r + size Y (q - where) instead of r, and the relative compliances Y of the rows (GuessesForces), the solution
// is unique. It is found with where = 0, which is the pressure of a thin elastic layer (Winkler), and then iterated with `where` at the
// last solution until the conditions themselves hold: proximal points (Rockafellar 1976). Newton's method finds each, from the forces of
// the previous step. If it fails, sweeps find some solution (redundant_sweeps.cpp). If these fail too, Newton's method starts from an
// interior-point method with a larger size, which is then reduced.
//
// With x = (mu l_n, l_t) and z = (r_n / mu + |r_t|, r_t) of each group, both are in the cone x_0 >= |x_t| and x . z = 0 (De Saxce
// and Feng 1998). An iteration aims at x o z = share nu e, nu the mean of x . z; |r_t| is (|r_t|^2 + smooth nu^2 / (x_0^2 + nu))^.5:
//   (W + F) dx = share nu x^-1 - z - T ((T x)^-1 o c) - (z(x) - z),   F x = z,   F = T T = e (2 w w^T - J),   J = diag(1, -1, -1)
// with |x|^2 = x_0^2 - |x_t|^2, e = |z| / |x|, w the middle of z / |z| and J x / |x|, |w| = 1 (Nesterov and Todd 1998), and
// c = T dx o T^-1 dz of a predictor without share (Mehrotra 1992). For equalities z = 0 and x is free. W then includes the
// derivative D r of |r_t|, except after a short step; F is (1 - D) F.
//
// Newton's method is that of condition_forces.h. Both solve, with blocks A and B of groups,
//   (A (W + size Y) + B) d = b,   C = A size Y + B:   d = y - C^-1 A P (1 + Q^T C^-1 A P)^-1 Q^T y,   y = C^-1 b
// and once more for the residual with W itself, which is not quite symmetric if directions rotate in a step.
#pragma once
#include <Eigen/Dense>
#include <limits>
#include <utility>
#include <vector>

#include "components/integrators/body_rows.h"
#include "framework/algebra/stop.h"
#include "framework/mechanics/condition_forces.h"

namespace stroma {

class RedundantForces {
 public:
  using Kind = LagrangianRows::Kind;
  using Row = LagrangianRows::Row;

  /// The problem to solve; w covers the `live` rows, everything else all rows.
  struct Problem {
    const std::vector<Row>& rows;
    const std::vector<std::size_t>& live;
    const Eigen::MatrixXd& w;
    const Eigen::VectorXd& g;
    const std::vector<double>&sizes, &yields, &allowed;  ///< allowed: as of ConditionForces::solve()
    double at_rest;  ///< no search is made if the relative error of the forces is below this
    bool goes_on;    ///< l is from this step, at slightly different positions of the bodies
    bool is_repeated;  ///< the caller evaluates the result and searches again from there
    double budget;   ///< limit of `spent`; beyond it the search ends
    const BodyRows* bodies = nullptr;  ///< replaces w for the rows `live`; sweeps only
    double factor = 0;                 ///< with `bodies`: factor of BodyRows::couple()
  };
  /// True if find() would only make sweeps for these rows, so that w is not needed.
  bool wouldSweep(const std::vector<Row>& rows, const std::vector<std::size_t>& live, int bodies, bool goes_on) const;
  /// l: initial guess and result. False: the conditions are not redundant, or nothing better was found; l is unchanged.
  bool find(const Problem& problem, Eigen::VectorXd& l, StopToken stop);
  /// The residual with the forces found, relative to the largest condition violated without forces.
  double unsettled() const { return off_; }
  /// The residual of rows that slightly contradict each other; otherwise 0. As ConditionForces::contradiction.
  double contradiction() const { return contradiction_; }
  /// As ConditionForces::worst(), after a find() with `bodies`.
  ConditionForces::Violation worst(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const std::vector<double>& sizes,
                                   const std::vector<double>& allowed) const;
  /// The forces are from sweeps, with residuals of a fraction of the tolerances.
  bool areSwept() const { return is_swept_; }
  /// The forces are the initial guess of the last find().
  bool areInitialGuess() const { return are_initial_guess_; }
  /// Begins a step: neither is true before a find().
  void forget() { is_swept_ = are_initial_guess_ = false; }
  double spent = 0;            ///< by the last find(): sum of rows times columns^2 per step
  long steps = 0, rounds = 0, sweeps = 0;  ///< totals of find(): Newton steps, interior-point iterations, sweeps

 private:
  struct Blocks;
  static constexpr int most_tangents = 2;
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 1 + most_tangents, 1 + most_tangents>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 1 + most_tangents, 1>;
  /// Rows [first, first + size): one equality, or a push with its friction.
  struct Group {
    bool pushes = false;
    Eigen::Index first = 0, size = 1;
    double mu = 0, rate = 0;  ///< rate: of the tangents' block of W
    SmallMatrix own;          ///< its block of W
    Eigen::Index tangents() const { return size - 1; }
  };
  /// Work space of Blocks, of which there is one at a time, and of Newton's method, so that steps allocate nothing.
  struct Work {
    Eigen::MatrixXd p, q, a, b, inverse, slim, half, small;
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
    Eigen::VectorXd by, yields, scaled, product, y, few, few_solved, left, pulled, turned;
    Eigen::VectorXd right, way, was, at, r, where, found, noted;
    std::vector<char> is_open;
  };
  struct Inside;
  /// A point and its state, and the change of both: by a sweep, and by extrapolation of earlier sweeps. The state is the values of the
  /// conditions, or with bodies their motion.
  struct Sweeps {
    std::vector<std::pair<std::size_t, std::size_t>> first;  ///< of each group, in `rows` and in `numbers`
    std::vector<Eigen::Index> rows;
    std::vector<double> numbers, slides;  ///< slides: alpha per group
    Eigen::VectorXd at, state, step, state_step, way, state_way;
    void pack(const RedundantForces& of);
    void add(std::size_t group, Eigen::Index size, const SmallVector& change);
  };
  static constexpr double none = std::numeric_limits<double>::infinity();
  static constexpr double expensive = 7.5e6;  ///< if a Newton step costs more, sweeps are tried first
  static constexpr double layer_compliance = 1e-6;  ///< compliance of the layer, relative to the mean diagonal of W
  static constexpr double settled = 1e-13, rounded = 1e-11, near = 1e-9, coarse = 1e-6;  ///< of the largest condition without forces

  bool scaleRows(const Problem& problem, const Eigen::VectorXd& l);
  void findCompliances(const Problem& problem);
  bool findGroups(const Problem& problem);
  bool findRoots(double most);
  bool isSingular() const { return p_.cols() < (w_.diagonal().array() > 0).count(); }
  double offOf(const Group& group, const Eigen::VectorXd& q, const SmallVector& r) const;
  double offAlong(const Group& group, const Eigen::VectorXd& q, const SmallVector& r) const;
  double coupling(Eigen::Index i, Eigen::Index j) const;
  void takeBodies(const Problem& problem);
  void findState(const Eigen::VectorXd& q, Eigen::VectorXd& state);
  SmallVector conditionsOf(const Group& group, const Eigen::VectorXd& state) const;
  double offOf(const Eigen::VectorXd& q, const Eigen::VectorXd& r) const;
  bool isLittle(const Problem& problem, double part) const;
  bool isDone(const Problem& problem) const;
  bool findNear(const Problem& problem);
  bool findInside(const Problem& problem);
  void conditions(const Eigen::VectorXd& q, Eigen::VectorXd& r);
  void stepFrom(Eigen::VectorXd& q, Eigen::VectorXd& r, double size);
  void linearise(Blocks& blocks);
  double newton(double size, const Eigen::VectorXd& where, Eigen::VectorXd& q);
  bool layer(double size, Eigen::VectorXd& q);
  void draw(const Problem& problem, double size, Eigen::VectorXd& q);
  Eigen::VectorXd searchInside(double size);
  SmallVector wantedBy(const Group& group, const Eigen::VectorXd& q, const SmallVector& r, double& slide) const;
  bool sweepToLaws(const Problem& problem, int most, double enough, bool stands);
  void sweepOnce();
  static double goalOf(int sweeps, double most);
  double sweep(const Problem& problem, int most, double enough, double at_once, Eigen::VectorXd& q);
  double farthest(const Problem& problem, const Eigen::VectorXd& q, const Eigen::VectorXd& state) const;
  void note(const Eigen::VectorXd& q);
  bool take(const Problem& problem, Eigen::VectorXd& l);
  void spend() { spent += double(w_.rows()) * double(p_.cols()) * double(p_.cols()); }
  bool isOver() const { return stop_.isStopAsked() || spent > budget_; }

  std::vector<Group> groups_;                              ///< of rows that something moves
  std::vector<std::pair<Eigen::Index, Eigen::Index>> all_;  ///< first row and rows of all groups and other rows
  Eigen::Index widest_ = 1;
  Eigen::VectorXd scale_, offset_, yields_, start_, best_;  ///< in units in which W has a diagonal of one; start_, best_: forces
  Eigen::MatrixXd w_, p_, q_;                               ///< W, P and Q
  bool is_swept_ = false, are_initial_guess_ = false;
  double size_ = 0, off_ = 0, contradiction_ = 0;           ///< off_: of best_, of size_
  std::vector<BodyRows::Row> body_rows_;                    ///< in the place of w_, in its units; empty: there is w_
  Eigen::Index motion_size_ = 0;                            ///< numbers of the motion of all bodies
  Eigen::VectorXd motion_;                                  ///< work space
  Eigen::MatrixXd whole_p_, whole_q_;                       ///< work space, as is
  Work work_;
  Sweeps sweeps_;
  double budget_ = 0;
  StopToken stop_;
};

}  // namespace stroma
