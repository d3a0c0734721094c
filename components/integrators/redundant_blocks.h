// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/redundant_forces.h"

namespace stroma {

/// Solves (A (W + size Y) + B) d = right, with rows and columns of W multiplied by `by`.
struct RedundantForces::Blocks {
  const RedundantForces& of;
  Eigen::VectorXd by, yields;
  Eigen::MatrixXd p, q;  ///< P and Q
  Eigen::MatrixXd a, b;  ///< blocks, each from the first column
  Eigen::MatrixXd inverse, slim;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;

  Blocks(const RedundantForces& all, Eigen::VectorXd scale, double size)
      : of(all), by(std::move(scale)), yields(size * by.cwiseAbs2().cwiseProduct(of.yields_)), p(by.asDiagonal() * of.p_),
        q(by.asDiagonal() * of.q_) {
    a.setZero(p.rows(), of.widest_), b = a;
    for (const auto& [at, rows] : of.all_) b.block(at, 0, rows, rows).setIdentity();
  }
  Eigen::MatrixXd times(const Eigen::MatrixXd& blocks, const Eigen::MatrixXd& m) const {
    Eigen::MatrixXd out(m.rows(), m.cols());
    for (const auto& [at, rows] : of.all_)
      out.middleRows(at, rows).noalias() = blocks.block(at, 0, rows, rows).lazyProduct(m.middleRows(at, rows));
    return out;
  }
  /// (W + size Y) v
  Eigen::VectorXd timesW(const Eigen::VectorXd& v) const {
    Eigen::VectorXd out = of.w_ * by.cwiseProduct(v);
    return by.cwiseProduct(out) + yields.cwiseProduct(v);
  }
  void factor() {
    inverse = b;
    for (const auto& [at, rows] : of.all_) {
      const Eigen::MatrixXd c = a.block(at, 0, rows, rows) * yields.segment(at, rows).asDiagonal();
      inverse.block(at, 0, rows, rows) = (c + b.block(at, 0, rows, rows)).inverse();
    }
    slim = times(inverse, times(a, p));
    lu.compute(Eigen::MatrixXd::Identity(p.cols(), p.cols()) + q.transpose() * slim);
  }
  Eigen::VectorXd solveOnce(const Eigen::VectorXd& right) const {
    const Eigen::VectorXd y = times(inverse, right);
    return y - slim * lu.solve(q.transpose() * y);
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    const Eigen::VectorXd d = solveOnce(right);
    return d + solveOnce(right - times(b, d) - times(a, timesW(d)));
  }
};

}  // namespace stroma
