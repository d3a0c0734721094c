// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the forces l for which the conditions g + W l hold. W is dense, and symmetric up to small differences.
//   equal   = 0
//   push    >= 0, l >= 0 and one of them zero; or l at its upper bound and the condition negative
//   rub     = 0, or |l_t| = mu l_n opposing the condition, with l_n of the preceding push (Coulomb)
//   given   l is prescribed
// Each is the zero of a function of r = g + W l, scaled so that W has a unit diagonal; conditions of different units
// (a length, a volume) can then be combined:
//   equal r,   push l - max(0, l - r),   rub l_t - (l_t - r_t/c cut to the length mu l_n)
// c is at least the largest eigenvalue of the tangential block of W. Newton's method finds the zero, with the derivative of the
// current piece of the function (Alart and Curnier 1991). Near the solution it takes one iteration per contact that changes
// between open, sticking and slipping. It finds no forces for nearly redundant rows: these are regularised towards their
// previous values (settle()). If that fails, Newton's method restarts from the result of an interior-point method
// (interior_forces.cpp), of projected Gauss-Seidel sweeps (Jourdan, Alart and Jean 1998), and of convex searches.
// Nothing is allocated if Newton's method suffices and the number of rows with an unknown force does not change.
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "framework/algebra/stop.h"
#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma {

class ConditionForces {
 public:
  using Kind = LagrangianRows::Kind;
  using Row = LagrangianRows::Row;
  /// The largest violation at the end of a step.
  struct Violation {
    std::size_t row = 0;
    double off = 0;     ///< violation of a condition, divided by the length of its gradient [m]
    bool rubs = false;  ///< the violated law is Coulomb's
  };
  /// The length of the tangential force that would stop the slip, and its bound mu q_n.
  struct Friction {
    double wanted = 0, bound = 0;
    bool slips() const { return wanted > bound; }
  };
  /// The function of a push with force q and condition r.
  static double offOfPush(double q, double r, double most) { return std::abs(q - std::clamp(q - r, 0.0, most)); }
  /// Cuts q_t - r_t / c, which would stop the slip, to Coulomb's bound.
  template <typename Tangents>
  static Friction cutFriction(Tangents& wanted, double mu, double push) {
    const Friction friction{wanted.norm(), mu * std::max(push, 0.0)};
    if (friction.slips()) wanted *= friction.bound / friction.wanted;
    return friction;
  }

  long searches = 0, steps = 0, rounds = 0;  ///< totals of solve(): calls, Newton steps, interior-point iterations
  double spent = 0, budget = std::numeric_limits<double>::infinity();  ///< of eliminations: sum of rows^3; beyond it searches end
  double enough = 0;          ///< of unsettled(): no search is made if the initial l has no more
  double contradiction = 0;   ///< twice the residual that a search has left; no search is made below it. 0 at the start of a step
  Eigen::MatrixXd w;          ///< W of the rows whose force is not given as zero, shape (such rows, such rows)
  Eigen::VectorXd g;          ///< the conditions without forces, shape (rows); solve() adds forces that are given
  Eigen::VectorXd l;          ///< forces [N], shape (rows); on entry the initial guess
  std::vector<double> sizes;  ///< lengths of the gradients: what moves less than round-off of this is held

  /// It can be stopped, and the forces are then those of the best iterate. `allowed`: the tolerance of each row [m];
  /// rows within a thousandth of it start no search. Empty: no tolerance.
  void solve(const std::vector<Row>& rows, StopToken stop = {}, const std::vector<double>& allowed = {});
  /// The largest residual of the functions above, over the conditions that do not hold without forces.
  double unsettled() const { return unsettled_; }
  /// The functions above, where the rows of the last solve() have come to (Row::value). `allowed`: by how much each row may be
  /// off without being looked at; empty: nothing.
  Violation worst(const std::vector<Row>& rows, const std::vector<double>& allowed = {});

 private:
  /// Rows [first, end): one that is equal, or a push and what rubs there.
  struct Group {
    bool pushes = false;
    int first = 0, end = 0;
    double mu = 0, rate = 0;  ///< c
    double most = std::numeric_limits<double>::infinity();
    // in a Newton step
    bool is_active = true, slips = false;
    double at = 0;    ///< the bound that q takes where it is not active
    double turn = 0;  ///< where it slips: which part of what would hold it friction can take
    int tangents() const { return end - first - 1; }
  };
  /// scaled_ without its zeros, by columns.
  struct Packed {
    std::vector<int> begins, rows;
    std::vector<double> numbers;
    void set(const Eigen::MatrixXd& w);
  };
  using Square = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

  void scaleRows(const std::vector<Row>& rows);
  void findGroups(const std::vector<Row>& rows);
  void restart(const Eigen::VectorXd& q);
  void change(int row, double to);
  void findWanted(const Group& group);
  double offAt(const Group& group) const;
  double offAlong(const Group& group);
  double residual();
  void note();
  bool isOver() const { return stop_.isStopAsked() || spent > budget; }
  bool isLittle(double part = 1e-3);
  void newton();
  void settle();
  void sweep();
  void searchInside(const Eigen::VectorXd* slides = nullptr);
  void searchWithSlides();
  bool newtonStep();
  void findActive();
  Square linearise();
  bool eliminate(Square a);

  std::vector<Group> groups_;
  std::vector<std::size_t> live_;  ///< rows whose force is not given as zero; all below are of these alone
  Eigen::VectorXd scale_, offset_, q_, r_, best_, least_;  ///< scaled; q_: forces, r_ = offset_ + scaled_ q_
  Eigen::MatrixXd scaled_;
  Eigen::VectorXd wanted_, across_;  ///< friction that holds a slide; its directions where it cannot, shape (rows)
  Friction friction_;                ///< of wanted_
  Packed packed_;
  std::vector<int> active_;          ///< unknowns of a Newton step
  std::vector<double> derivative_;   ///< on them, row by row
  Eigen::VectorXd step_;             ///< its first numbers are those of active_
  double size_ = 0, unsettled_ = 0;
  StopToken stop_;
  std::span<const double> allowed_;
};

}  // namespace stroma
