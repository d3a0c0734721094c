// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/integrators/redundant_forces.h"

namespace stroma {

/// Solves (A (W + size Y) + B) d = right, with rows and columns of W multiplied by `by`. Nothing is allocated while sizes stay.
struct RedundantForces::Blocks {
  const RedundantForces& of;
  Work& work;
  Eigen::VectorXd &by = work.by, &yields = work.yields;
  Eigen::MatrixXd &p = work.p, &q = work.q;  ///< P and Q
  Eigen::MatrixXd &a = work.a, &b = work.b;  ///< blocks, each from the first column

  /// With `by` of the work space.
  Blocks(RedundantForces& all, double size) : of(all), work(all.work_) {
    yields = size * by.cwiseAbs2().cwiseProduct(of.yields_);
    p = by.asDiagonal() * of.p_;
    q = by.asDiagonal() * of.q_;
    a.setZero(p.rows(), of.widest_);
    b = a;
    for (const auto& [at, rows] : of.all_) b.block(at, 0, rows, rows).setIdentity();
  }
  void multiply(const Eigen::MatrixXd& blocks, const auto& m, auto& out) const {
    out.resize(m.rows(), m.cols());
    for (Eigen::Index k = 0; k < m.cols(); ++k)
      for (const auto& [at, rows] : of.all_)
        for (Eigen::Index i = at; i < at + rows; ++i) {
          double sum = blocks(i, 0) * m(at, k);
          for (Eigen::Index j = 1; j < rows; ++j) sum += blocks(i, j) * m(at + j, k);
          out(i, k) = sum;
        }
  }
  /// out = (W + size Y) v
  void timesW(const Eigen::VectorXd& v, Eigen::VectorXd& out) const {
    work.scaled = by.cwiseProduct(v);
    work.product.noalias() = of.w_ * work.scaled;
    out = by.cwiseProduct(work.product) + yields.cwiseProduct(v);
  }
  void factor() {
    work.inverse = b;
    for (const auto& [at, rows] : of.all_) {
      const SmallMatrix c = a.block(at, 0, rows, rows) * yields.segment(at, rows).asDiagonal();
      work.inverse.block(at, 0, rows, rows) = SmallMatrix(c + b.block(at, 0, rows, rows)).inverse();
    }
    multiply(a, p, work.half);
    multiply(work.inverse, work.half, work.slim);
    work.small.noalias() = q.transpose() * work.slim;
    work.small.diagonal().array() += 1;
    work.lu.compute(work.small);
  }
  void solveOnce(const Eigen::VectorXd& right, Eigen::VectorXd& out) const {
    multiply(work.inverse, right, work.y);
    work.few.noalias() = q.transpose() * work.y;
    work.few_solved = work.lu.solve(work.few);
    work.product.noalias() = work.slim * work.few_solved;
    out = work.y - work.product;
  }
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& d) const {
    solveOnce(right, d);
    timesW(d, work.pulled);
    multiply(b, d, work.left), multiply(a, work.pulled, work.turned);
    work.left = right - work.left - work.turned;
    solveOnce(work.left, work.turned);
    d += work.turned;
  }
};

}  // namespace stroma
