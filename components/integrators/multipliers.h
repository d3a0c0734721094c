// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of Lagrangian constraints in an implicit step. The step without them has found u, with its matrix A of A du = b.
// Impulses p = weight l along the gradients J then change
//   u by c = A^-1 J^T p,   x by displacement c,   conditions g(x) by W (p - p_before),   W = displacement J A^-1 J^T
// W is dense, of as many solves with A as there are rows. What is equal is eliminated, the rest is swept by projected
// Gauss and Seidel until nothing changes: p >= 0 for what pushes, and the force of what rubs is cut at mu times that. Then
// g and J are computed anew where x has come to, and it is repeated until x = x_free + displacement A^-1 J(x)^T p and g holds:
// forces have the directions of the end of the step. Where that would swing, those found so far are kept as they are.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

class Multipliers {
 public:
  void compile(System& system);
  bool empty() const { return !system_ || system_->actors().lagrangian_constraints.empty(); }
  /// Where the step starts.
  void begin();
  /// Moves x and v of the system until the conditions hold; `change`: what v has changed by in the step, follows.
  /// A report that did not converge says by how much they do not.
  void correct(LinearSolver& solver, SystemMatrix& matrix, double displacement, double weight, Rows change,
               StopToken stop, StepReport& report);

 private:
  void findConditions();
  bool haveGradientsChanged() const;
  bool respond(LinearSolver& solver, SystemMatrix& matrix, double displacement, StopToken stop, StepReport& report);
  void solveImpulses(double weight);
  void sweep(const Eigen::MatrixXd& w, const Eigen::VectorXd& g, const std::vector<int>& rows);
  void apply(double displacement, Rows change);
  double violation() const;
  void give(double weight);

  System* system_ = nullptr;
  LagrangianRows rows_, old_rows_;
  Eigen::MatrixXd w_;            ///< W
  Eigen::VectorXd impulse_, reference_, g_;
  std::vector<Vector> responses_;  ///< A^-1 J^T of each row, shape (independent rows)
  Vector start_, work_, right_side_;
  Vector free_;             ///< x without forces of constraint
  Vector whole_, before_;   ///< what they change u by, now and a round ago
  bool keeps_direction_ = false;
  // of the projected Gauss and Seidel, in the step under way
  int sweeps_left_ = 0;
  double unsettled_ = 0;  ///< by how much the last sweep changed the conditions, of the largest one
  std::vector<double> forces_;
};

}  // namespace stroma
