// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace stroma {

namespace {

using Quaternion = Eigen::Quaterniond;  // coefficients x, y, z, w as in a row

Quaternion exponential(const Vec3& r) {
  const double angle = r.norm();
  // sin(a/2)/a = 1/2 - a^2/48 + a^4/3840
  const double square = angle * angle;
  const double factor = angle < 1e-2 ? 0.5 - square / 48 + square * square / 3840 : std::sin(angle / 2) / angle;
  Quaternion q;
  q.vec() = factor * r;
  q.w() = std::cos(angle / 2);
  return q;
}

/// The rotation vector of q or -q, the shorter one.
Vec3 logarithm(const Quaternion& q) {
  const double sine = q.vec().norm();
  if (sine == 0) return Vec3::Zero();
  const double sign = q.w() < 0 ? -1 : 1;
  return sign * 2 * std::atan2(sine, std::abs(q.w())) / sine * q.vec();
}

}  // namespace

void Motion::compile(const std::vector<State*>& states) {
  turning_.clear();
  kinds_.clear();
  Index rows = 0;
  for (const State* state : states) rows = std::max(rows, state->firstRow() + state->size());
  for (const State* state : states) {
    if (state->row_kinds.empty()) continue;
    kinds_.resize(std::size_t(rows), RowKind::place);
    std::copy(state->row_kinds.begin(), state->row_kinds.end(), kinds_.begin() + state->firstRow());
  }
  for (std::size_t row = 0; row < kinds_.size(); ++row)
    if (kinds_[row] == RowKind::turn) turning_.push_back(Index(row));
}

RowKind Motion::kindOf(Index row) const { return kinds_.empty() ? RowKind::place : kinds_[std::size_t(row)]; }

void Motion::turnBy(const Vec3& r, double* row) {
  if (r.isZero(0)) return;
  Eigen::Map<Quaternion> q(row);
  q = exponential(r) * q;
  q.normalize();  // round-off must not add up
  if (q.w() < 0) q.coeffs() = -q.coeffs();
}

void Motion::differenceOfRow(ConstRows x1, Rows x0, Index row) {
  const std::size_t first = std::size_t(row) * row_doubles;
  x0[row] = logarithm(Quaternion(x1.data + first) * Quaternion(x0.data + first).conjugate());
  x0.data[first + 3] = 0;
}

}  // namespace stroma
