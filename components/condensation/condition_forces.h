// SPDX-License-Identifier: LGPL-2.1-or-later
// The forces l with which conditions g + W l hold, of a body whose compliance W is known and dense, symmetric
// but for small differences:
//   equal   = 0
//   push    >= 0, l >= 0 and one of both zero; or l at a largest force and the condition below zero
//   rub     = 0, or |l_t| = mu l_n against the condition, l_n that of the push before (Coulomb)
//   given   l is known
// Each is the zero of a function, with r = g + W l in units in which W has a diagonal of one:
//   equal r,   push l - max(0, l - r),   rub l_t - (l_t - r_t/c cut to the length mu l_n)
// c: at least the largest eigenvalue of the tangents' block of W. Newton's method solves for the zero, with the derivative of the
// piece of the function where it is (Alart and Curnier 1991). Near the solution it takes as many iterations as contacts change
// between open, sticking and slipping. Where it does not come nearer, sweeps of projected Gauss and Seidel go before it tries
// again.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma {

class ConditionForces {
 public:
  using Row = LagrangianRows::Row;

  Eigen::MatrixXd w;          ///< W, shape (rows, rows)
  Eigen::VectorXd g;          ///< the conditions without forces, shape (rows)
  Eigen::VectorXd l;          ///< forces [N], shape (rows); where the search begins
  std::vector<double> sizes;  ///< lengths of the gradients: what moves less than round-off of this is held

  void solve(const std::vector<Row>& rows);
  /// By how much the functions above are off, of the largest condition that does not hold without forces.
  double unsettled() const { return unsettled_; }

 private:
  /// Rows [first, end): one that is equal or given, or a push and what rubs there.
  struct Group {
    LagrangianRows::Kind kind;
    int first, end;
    double mu, most;  ///< most: in scaled units
  };
  void scaleRows(const std::vector<Row>& rows);
  void findGroups(const std::vector<Row>& rows);
  bool moves(int row) const { return scaled_(row, row) > 0; }
  double sizeOfConditions() const;
  /// At least the largest eigenvalue of the tangents' block.
  double rateOf(const Group& group) const;
  double residual();
  void sweep();
  void change(int row, double to);
  void cutToBound(Eigen::Ref<Eigen::VectorXd> tangents, double bound) const;
  bool newtonStep();
  void linearise(const Group& group);
  void addActive(int row, double value);

  std::vector<Group> groups_;
  Eigen::VectorXd scale_, offset_, q_, r_, best_, wanted_;  ///< scaled; q_: forces, r_ = offset_ + scaled_ q_
  Eigen::MatrixXd scaled_;
  std::vector<int> active_;                ///< unknowns of a Newton step
  Eigen::MatrixXd derivative_, jacobian_;  ///< on all rows, row by row; on those that are active
  Eigen::VectorXd value_, step_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  double unsettled_ = 0;
};

}  // namespace stroma
