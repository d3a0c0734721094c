// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/motion.h"

#include <algorithm>

#include "framework/mechanics/frames.h"

namespace stroma {

void Motion::compile(const std::vector<State*>& states) {
  turning_.clear(), kinds_.clear();
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
  q = turnedBy(r) * q;
  q.normalize();  // round-off must not add up
}

Vec3 Motion::increment(ConstRows x0, ConstRows x1, Index row, Index to) const {
  if (kindOf(row) != RowKind::turn) return x1[to] - x0[row];
  return rotationVector(orientationIn(x1, to) * orientationIn(x0, row).conjugate());
}

void Motion::advanceRow(const Vec3& dx, Rows x, Index row) const {
  if (kindOf(row) == RowKind::turn)
    turnBy(dx, x.data + std::size_t(row) * row_doubles);
  else
    x[row] += dx;
}

}  // namespace stroma
