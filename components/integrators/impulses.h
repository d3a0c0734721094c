// SPDX-License-Identifier: LGPL-2.1-or-later
// The impulses with which conditions hold that are linear in them, g + W p:
//   equal   = 0
//   push    >= 0, p >= 0 and one of both zero; or p at a largest impulse and the condition below zero
//   rub     = 0, or p has mu times the impulse of the push before, against the condition (Coulomb)
//   given   p is known
// W is scaled to a diagonal of one, so that conditions of different units (a length, a volume) may meet. What is equal is
// eliminated, the rest is swept by projected Gauss and Seidel until nothing changes.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma {

class Impulses {
 public:
  using Row = LagrangianRows::Row;

  Eigen::MatrixXd w;              ///< W, shape (rows, rows)
  Eigen::VectorXd g;              ///< the conditions without impulses, shape (rows)
  Eigen::VectorXd p;              ///< impulses [N s], shape (rows); sweeps begin there
  std::vector<double> sizes;      ///< lengths of the gradients: what moves less than round-off of this is held

  /// `weight` [s] makes impulses of the forces that rows have. Sweeps are those that are left of startSweeps().
  void solve(const std::vector<Row>& rows, double weight);
  void startSweeps() { sweeps_left_ = most_sweeps, unsettled_ = 0; }
  /// By how much the last sweep changed the conditions, of the largest one.
  double unsettled() const { return unsettled_; }

 private:
  static constexpr int most_sweeps = 20000;

  void scaleRows(const std::vector<Row>& rows);
  void eliminate();
  void sweep(const std::vector<Row>& rows, double weight);
  double sweepOnce(const std::vector<Row>& rows, double least);
  double change(int row, double by);
  double rub(int first, int end, double bound, double least);

  // in scaled units; of what is not equal those after the elimination
  std::vector<int> equal_, other_;
  Eigen::VectorXd scale_, scaled_g_, values_, offset_, reduced_g_, residual_, total_, most_, wanted_;
  Eigen::MatrixXd scaled_, inner_, coupling_, eliminated_, reduced_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  int sweeps_left_ = 0;
  double unsettled_ = 0;
};

}  // namespace stroma
