// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of many conditions on few ways to move, as of rigid bodies whose faces meet in many points: W (condition_forces.h) is
// P Q^T with fewer columns than rows. Such rows say the same, and no force is the only one. Of all that hold, those are taken that
// give way as little as they can: with r + size Y (q - where) instead of r, Y what rows yield in comparison (SharesForces), there
// is one solution. It is found with where = 0, which is the pressure of a thin elastic layer (Winkler), and then drawn from where
// it is until the conditions themselves hold: proximal points (Rockafellar 1976). Newton's method finds each, from the forces of
// the step before. Where it does not, sweeps find any that hold (redundant_sweeps.cpp). Where these do not either, it begins from an
// interior-point method with a larger size, which is then made smaller.
//
// With x = (mu l_n, l_t) and z = (r_n / mu + |r_t|, r_t) of each group, both are in the cone x_0 >= |x_t| and x . z = 0 (De Saxce
// and Feng 1998). A round goes towards x o z = share nu e, nu the mean of x . z; |r_t| is (|r_t|^2 + smooth nu^2 / (x_0^2 + nu))^.5:
//   (W + F) dx = share nu x^-1 - z - T ((T x)^-1 o c) - (z(x) - z),   F x = z,   F = T T = e (2 w w^T - J),   J = diag(1, -1, -1)
// with |x|^2 = x_0^2 - |x_t|^2, e = |z| / |x|, w the middle of z / |z| and J x / |x|, |w| = 1 (Nesterov and Todd 1998), and
// c = T dx o T^-1 dz of a first way without share (Mehrotra 1992). Of rows that are equal z = 0 and x is free. W then has the
// derivative D r of |r_t|, but after a short way; F is (1 - D) F.
//
// Newton's method is that of condition_forces.h. Both solve, with blocks A and B of groups,
//   (A (W + size Y) + B) d = b,   C = A size Y + B:   d = y - C^-1 A P (1 + Q^T C^-1 A P)^-1 Q^T y,   y = C^-1 b
// and once more for what that leaves with W itself, which is not quite symmetric where directions turn in a step.
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

  /// What is searched for; all but w, of the `live` rows, are of all rows.
  struct Problem {
    const std::vector<Row>& rows;
    const std::vector<std::size_t>& live;
    const Eigen::MatrixXd& w;
    const Eigen::VectorXd& g;
    const std::vector<double>&sizes, &yields, &allowed;  ///< allowed: as of ConditionForces::solve()
    double at_rest;  ///< forces that are off by less than this part of it are not searched for again
    bool goes_on;    ///< l has been found in this step, where bodies were a little elsewhere
    bool comes_again;  ///< what the forces lead to is looked at, and they are searched for again from there
    double budget;   ///< of `spent`; beyond it the search ends
    const BodyRows* bodies = nullptr;  ///< in the place of w: the rows `live`; by sweeps alone
    double factor = 0;                 ///< with `bodies`, as of BodyRows::couple()
  };
  /// find() without w is right for these rows: no other search than sweeps would be made.
  bool wouldSweep(const std::vector<Row>& rows, const std::vector<std::size_t>& live, int bodies, bool goes_on) const;
  /// l: where the search begins and ends. False: these are not such conditions, or nothing better was found; l is as it was.
  bool find(const Problem& problem, Eigen::VectorXd& l, StopToken stop);
  /// What is off with the forces found, of the largest condition that does not hold without forces.
  double unsettled() const { return off_; }
  /// What is off, where rows contradict each other by a little; else 0. As ConditionForces::contradiction.
  double contradiction() const { return contradiction_; }
  /// As ConditionForces::worst(), after a find() with `bodies`.
  ConditionForces::Violation worst(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const std::vector<double>& sizes,
                                   const std::vector<double>& allowed) const;
  /// They are those of sweeps, and off by a part of what rows may be.
  bool areSwept() const { return is_swept_; }
  /// They are those that the last find() began from.
  bool haveStood() const { return has_stood_; }
  /// A step begins, where neither is true before a find().
  void forget() { is_swept_ = has_stood_ = false; }
  double spent = 0;            ///< on the last find(): rows times columns^2 of each step
  long steps = 0, rounds = 0, sweeps = 0;  ///< of all find(): Newton steps, rounds of the interior-point method, sweeps

 private:
  struct Blocks;
  static constexpr int most_tangents = 2;
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 1 + most_tangents, 1 + most_tangents>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 1 + most_tangents, 1>;
  /// Rows [first, first + size): one that is equal, or a push and what rubs there.
  struct Group {
    bool pushes = false;
    Eigen::Index first = 0, size = 1;
    double mu = 0, rate = 0;  ///< rate: of the tangents' block of W
    SmallMatrix own;          ///< its block of W
    Eigen::Index tangents() const { return size - 1; }
  };
  /// Of Blocks, of which there is one at a time, and of Newton's method, so that steps allocate nothing.
  struct Work {
    Eigen::MatrixXd p, q, a, b, inverse, slim, half, small;
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
    Eigen::VectorXd by, yields, scaled, product, y, few, few_solved, left, pulled, turned;
    Eigen::VectorXd right, way, was, at, r, where, found, noted;
    std::vector<char> is_open;
  };
  struct Inside;
  /// A place and its state, and how both change: by a sweep, and by the way of those before. The state is that of conditions, or with
  /// bodies their motion.
  struct Sweeps {
    std::vector<std::pair<std::size_t, std::size_t>> first;  ///< of each group, in `rows` and in `numbers`
    std::vector<Eigen::Index> rows;
    std::vector<double> numbers, slides;  ///< slides: alpha of each group
    Eigen::VectorXd at, state, step, state_step, way, state_way;
    void pack(const RedundantForces& of);
    void add(std::size_t group, Eigen::Index size, const SmallVector& change);
  };
  static constexpr double none = std::numeric_limits<double>::infinity();
  static constexpr double dear = 7.5e6;  ///< where a step of Newton's method costs more, sweeps are tried before it
  static constexpr double thin = 1e-6;  ///< the layer, of the mean of W's diagonal
  static constexpr double settled = 1e-13, rounded = 1e-11, near = 1e-9, coarse = 1e-6;  ///< of the largest condition without forces

  bool scaleRows(const Problem& problem, const Eigen::VectorXd& l);
  void findYields(const Problem& problem);
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
  bool is_swept_ = false, has_stood_ = false;
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
