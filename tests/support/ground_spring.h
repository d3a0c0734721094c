// SPDX-License-Identifier: LGPL-2.1-or-later
// TestGroundSpring: each node is tied to its rest position, d = x - x_rest,
//   E = k/2 |d|^2 + c/4 |d|^4,   f = -(k + c |d|^2) d + t axis x d - b v + p cos(w time)
// with a damping b and a push p that the energy leaves out. A negative k with a positive c is a double well; the twist
// t (axis z) makes the stiffness unsymmetric and not conservative. `couple` adds a spring (k_couple/2 |d_i -
// d_{i+1}|^2) between neighbours in the list of nodes.
#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/force_field.h"
#include "framework/scene/factory.h"

namespace stroma::test {

class GroundSpring : public ForceField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("stiffness", stiffness_).help("k").unit("N/m");
    table.add("cubic", cubic_).help("c").unit("N/m^3");
    table.add("twist", twist_).help("t").unit("N/m");
    table.add("couple", couple_).help("k_couple").unit("N/m");
    table.add("damping", damping_).help("b").unit("N s/m");
    table.add("push", push_).help("p").unit("N");
    table.add("push_rate", push_rate_).help("w").unit("rad/s");
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = cubic_ == 0;
    traits.symmetric = twist_ == 0;
    traits.velocity_dependent = damping_ != 0;
    traits.time_dependent = !push_.isZero();
    traits.conservative = traits.symmetric && !traits.velocity_dependent && !traits.time_dependent;
    traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (Index i = 0; i < state().size(); ++i) {
      const double square = offset(x, i).squaredNorm();
      sum += stiffness_ / 2 * square + cubic_ / 4 * square * square;
      if (i > 0) sum += couple_ / 2 * (offset(x, i) - offset(x, i - 1)).squaredNorm();
    }
    return sum;
  }
  void setTime(double time) override { push_now_ = std::cos(push_rate_ * time) * push_; }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    x_.resize(state().size());
    for (Index i = 0; i < state().size(); ++i) {
      const Vec3 d = x_[i] = offset(x, i);
      const double *p = d.data(), *velocity = numbers(v, row(i)), *push = push_now_.data();
      const double k = stiffness_ + cubic_ * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), turned[] = {-p[1], p[0], 0};
      double* force = numbers(f, row(i));
      for (int c = 0; c < 3; ++c) force[c] += -k * p[c] + twist_ * turned[c] - damping_ * velocity[c] + push[c];
      if (i == 0) continue;
      const Vec3 pull = couple_ * (d - x_[i - 1]);
      f[row(i)] -= pull;
      f[row(i - 1)] += pull;
    }
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    for (Index i = 0; i < state().size(); ++i) {
      const double *p = x_[i].data(), *d = numbers(dx, row(i));
      const double k = stiffness_ + cubic_ * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), turned[] = {-d[1], d[0], 0};
      const double along = 2 * cubic_ * (p[0] * d[0] + p[1] * d[1] + p[2] * d[2]);
      double* force = numbers(df, row(i));
      for (int c = 0; c < 3; ++c) force[c] += factor * (-k * d[c] - along * p[c] + twist_ * turned[c]);
      if (i == 0) continue;
      const Vec3 pull = factor * couple_ * (dx[row(i)] - dx[row(i - 1)]);
      df[row(i)] -= pull;
      df[row(i - 1)] += pull;
    }
  }
  void addDampingProduct(ConstRows dv, double factor, Rows df) const override {
    for (Index i = 0; i < state().size(); ++i) df[row(i)] -= factor * damping_ * dv[row(i)];
  }
  void addDamping(double factor, BlockMatrix& matrix) const override {
    for (Index i = 0; i < state().size(); ++i) matrix.add(row(i), row(i), -factor * damping_ * Mat3::Identity());
  }
  void addDampingDiagonal(double factor, std::vector<double>& blocks) const override {
    for (Index i = 0; i < state().size(); ++i)
      for (int c : {0, 4, 8}) blocks[9 * std::size_t(row(i)) + std::size_t(c)] -= factor * damping_;
  }
  void addPattern(BlockPattern& pattern) const override {
    for (Index i = 1; i < state().size(); ++i) {
      pattern.addBlock(row(i), row(i - 1));
      pattern.addBlock(row(i - 1), row(i));
    }
  }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    const Mat3 couple = factor * couple_ * Mat3::Identity();
    for (Index i = 0; i < state().size(); ++i) {
      matrix.add(row(i), row(i), factor * block(i));
      if (i == 0) continue;
      matrix.add(row(i), row(i), -couple);
      matrix.add(row(i - 1), row(i - 1), -couple);
      matrix.add(row(i), row(i - 1), couple);
      matrix.add(row(i - 1), row(i), couple);
    }
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    for (Index i = 0; i < state().size(); ++i) {
      Mat3 k = block(i);
      k.diagonal().array() -= couple_ * ((i > 0) + (i + 1 < state().size()));
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) blocks[9 * std::size_t(row(i)) + std::size_t(3 * r + c)] += factor * k(r, c);
    }
  }

 private:
  Index row(Index i) const { return state().firstRow() + i; }
  Vec3 offset(ConstRows x, Index i) const {
    const double *now = numbers(x, row(i)), *rest = state().rest_position[std::size_t(i)].data();
    return {now[0] - rest[0], now[1] - rest[1], now[2] - rest[2]};
  }
  /// Of a row: tests are compiled without optimisation, and some make a million steps.
  static const double* numbers(ConstRows rows, Index row) { return rows.data + std::size_t(row) * row_doubles; }
  static double* numbers(Rows rows, Index row) { return rows.data + std::size_t(row) * row_doubles; }
  Mat3 block(Index i) const {
    const Vec3& d = x_[i];
    Mat3 k = -(stiffness_ + cubic_ * d.squaredNorm()) * Mat3::Identity() - 2 * cubic_ * d * d.transpose();
    k(0, 1) -= twist_;
    k(1, 0) += twist_;
    return k;
  }
  double stiffness_ = 0, cubic_ = 0, twist_ = 0, couple_ = 0, damping_ = 0, push_rate_ = 0;
  Vec3 push_ = Vec3::Zero(), push_now_ = Vec3::Zero();
  std::vector<Vec3> x_;  ///< offsets of the last addForce()
};

inline void registerGroundSpring(Factory& factory) {
  if (!factory.find("TestGroundSpring")) factory.add<GroundSpring>("TestGroundSpring", "springs to the rest positions");
}

}  // namespace stroma::test
