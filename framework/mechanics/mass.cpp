// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/mass.h"

#include <immintrin.h>

#include <algorithm>

#include "framework/algebra/parallel.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/node.h"

namespace stroma {

namespace {

constexpr Index piece_rows = 16384;  ///< rows that one thread takes at a time

/// target += factor mass source, row by row; the second a row at a time, with the same bits.
void addScaledRows(double factor, const double* mass, const double* source, double* target, Index rows) {
  for (Index i = 0; i < row_doubles * rows; ++i) target[i] += factor * mass[i / row_doubles] * source[i];
}
[[gnu::target("avx")]] void addWholeRows(double factor, const double* mass, const double* source, double* target, Index rows) {
  for (Index i = 0; i < rows; ++i, source += row_doubles, target += row_doubles)
    _mm256_storeu_pd(target, _mm256_loadu_pd(target) + _mm256_set1_pd(factor * mass[i]) * _mm256_loadu_pd(source));
}

}  // namespace

void Mass::addProduct(ConstRows p, double factor, Rows out) const {
  static const auto add = __builtin_cpu_supports("avx") ? addWholeRows : addScaledRows;
  const double *mass = lumped().data(), *source = state().segment(p).data;
  double* target = state().segment(out).data;
  const Index size = state().size();
  parallelFor(int((size + piece_rows - 1) / piece_rows), [=](int piece) {
    const Index begin = piece * piece_rows;
    const std::size_t from = std::size_t(begin) * row_doubles;
    add(factor, mass + begin, source + from, target + from, std::min(size - begin, piece_rows));
  });
  addTurningProduct(p, factor, out);
}

void Mass::update(ConstRows x) {
  turns_.resize(turning_.size() * row_doubles);
  for (std::size_t i = 0; i < turning_.size(); ++i)
    std::copy_n(state().segment(x).data + std::size_t(turning_[i].row) * row_doubles, row_doubles, turns_.data() + i * row_doubles);
  excess_outdated_ = true;
}

const std::vector<Mat3>& Mass::excess() const {
  if (!excess_outdated_) return excess_;
  excess_outdated_ = false;
  excess_.resize(turning_.size());
  for (std::size_t i = 0; i < turning_.size(); ++i) {
    const Mat3& inertia = turning_[i].inertia;
    excess_[i] = inertia - inertia.trace() / 3 * Mat3::Identity();
    if (!turning_[i].turns) continue;
    const Mat3 turn = Quaternion(turns_.data() + i * row_doubles).toRotationMatrix();
    excess_[i] = turn * excess_[i] * turn.transpose();
  }
  return excess_;
}

void Mass::addTurningProduct(ConstRows p, double factor, Rows out) const {
  const ConstRows from = state().segment(p);
  const Rows to = state().segment(out);
  for (std::size_t i = 0; i < excess().size(); ++i) to[turning_[i].row] += factor * (excess_[i] * from[turning_[i].row]);
}

void Mass::addTo(double factor, BlockMatrix& matrix) const {
  const std::vector<double>& mass = lumped();
  const Index first = state().firstRow();
  for (Index i = 0; i < state().size(); ++i) {
    double* block = matrix.values().data() + std::size_t(matrix.diagonal()[first + i]) * 9;
    for (int c : {0, 4, 8}) block[c] += factor * mass[i];
  }
  for (std::size_t i = 0; i < excess().size(); ++i)
    matrix.add(matrix.diagonal()[std::size_t(first + turning_[i].row)], factor * excess_[i]);
}

void Mass::addDiagonal(double factor, std::vector<double>& blocks) const {
  const std::vector<double>& mass = lumped();
  const Index first = state().firstRow();
  for (Index i = 0; i < state().size(); ++i)
    for (int c : {0, 4, 8}) blocks[std::size_t(first + i) * 9 + std::size_t(c)] += factor * mass[i];
  for (std::size_t i = 0; i < excess().size(); ++i)
    for (int c = 0; c < 9; ++c) blocks[std::size_t(first + turning_[i].row) * 9 + std::size_t(c)] += factor * excess_[i](c / 3, c % 3);
}

// M g = (row sums) g for any mass, because g is the same at all places. Only places have a weight.
void Mass::addGravity(Rows f) const {
  const std::vector<double>& mass = rowSums();
  const Vec3 gravity = node().gravity();
  const Rows f_here = state().segment(f);
  for (Index i = 0; i < f_here.count; ++i)
    if (state().kindOf(i) == RowKind::place) f_here[i] += mass[i] * gravity;
}

double Mass::kineticEnergy(ConstRows v) const {
  double sum = 0;
  const ConstRows v_here = state().segment(v);
  if (isDiagonal() && !turns()) {
    const std::vector<double>& mass = lumped();
    for (Index i = 0; i < v_here.count; ++i) sum += mass[i] * v_here[i].squaredNorm();
    return 0.5 * sum;
  }
  if (work_.count() != v.count) work_.resize(v.count);
  clear(work_);
  addProduct(v, 1, work_);
  const ConstRows momentum = state().segment(work_.rows());
  for (Index i = 0; i < v_here.count; ++i) sum += momentum[i].dot(v_here[i]);
  return 0.5 * sum;
}

double Mass::gravityEnergy(ConstRows x) const {
  const std::vector<double>& mass = rowSums();
  const Vec3 gravity = node().gravity();
  const ConstRows x_here = state().segment(x);
  double sum = 0;
  for (Index i = 0; i < x_here.count; ++i)
    if (state().kindOf(i) == RowKind::place) sum -= mass[i] * gravity.dot(x_here[i]);
  return sum;
}

double Mass::totalMass() const {
  const std::vector<double>& mass = lumped();
  double sum = 0;
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (state().kindOf(Index(i)) == RowKind::place) sum += mass[i];
  return sum;
}

}  // namespace stroma
