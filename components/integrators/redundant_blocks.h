// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/redundant_forces.h"

namespace stroma {

/// Solves (A (W + size Y) + B) d = right, with rows and columns of W multiplied by `by`.
struct RedundantForces::Blocks {
  const RedundantForces& of;
  Eigen::VectorXd by, yields;
  Work& work;
  Eigen::MatrixXd &p = work.p, &q = work.q;  ///< P and Q
  Eigen::MatrixXd &a = work.a, &b = work.b;  ///< blocks, each from the first column

  Blocks(RedundantForces& all, Eigen::VectorXd scale, double size)
      : of(all), by(std::move(scale)), yields(size * by.cwiseAbs2().cwiseProduct(of.yields_)), work(all.work_) {
    p = by.asDiagonal() * of.p_;
    q = by.asDiagonal() * of.q_;
    a.setZero(p.rows(), of.widest_);
    b = a;
    for (const auto& [at, rows] : of.all_) b.block(at, 0, rows, rows).setIdentity();
  }
  void multiply(const Eigen::MatrixXd& blocks, const auto& m, auto& out) const {
    out.resize(m.rows(), m.cols());
    for (const auto& [at, rows] : of.all_)
      out.middleRows(at, rows).noalias() = blocks.block(at, 0, rows, rows).lazyProduct(m.middleRows(at, rows));
  }
  Eigen::VectorXd times(const Eigen::MatrixXd& blocks, const Eigen::VectorXd& v) const {
    Eigen::VectorXd out;
    multiply(blocks, v, out);
    return out;
  }
  /// (W + size Y) v
  Eigen::VectorXd timesW(const Eigen::VectorXd& v) const {
    Eigen::VectorXd out = of.w_ * by.cwiseProduct(v);
    return by.cwiseProduct(out) + yields.cwiseProduct(v);
  }
  void factor() {
    work.inverse = b;
    for (const auto& [at, rows] : of.all_) {
      const Eigen::MatrixXd c = a.block(at, 0, rows, rows) * yields.segment(at, rows).asDiagonal();
      work.inverse.block(at, 0, rows, rows) = (c + b.block(at, 0, rows, rows)).inverse();
    }
    multiply(a, p, work.half);
    multiply(work.inverse, work.half, work.slim);
    work.small.noalias() = q.transpose() * work.slim;
    work.small.diagonal().array() += 1;
    work.lu.compute(work.small);
  }
  Eigen::VectorXd solveOnce(const Eigen::VectorXd& right) const {
    const Eigen::VectorXd y = times(work.inverse, right);
    return y - work.slim * work.lu.solve(q.transpose() * y);
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    const Eigen::VectorXd d = solveOnce(right);
    return d + solveOnce(right - times(b, d) - times(a, timesW(d)));
  }
};

}  // namespace stroma
