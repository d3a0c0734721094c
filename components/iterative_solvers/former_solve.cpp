// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/former_solve.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "components/iterative_solvers/node_rotation.h"

namespace stroma {
namespace {

/// Of each node, by what its neighbours in the pattern have turned.
std::vector<Mat3> turnsOf(const BlockMatrix& pattern, ConstRows x, ConstRows was) {
  constexpr double enough = 1e-4;  // [rad]
  const Index rows = x.count;
  std::vector<Mat3> turns(static_cast<std::size_t>(rows));
  for (Index first = 0; first < rows; first += 8) {
    EightRotations eight;
    for (Index k = 0; k < 8; ++k) {
      const Index i = std::min(first + k, rows - 1);
      Mat3 a = Mat3::Zero();
      for (Index s = pattern.rowStart()[i]; s < pattern.rowStart()[i + 1]; ++s) {
        const Index j = pattern.columns()[s];
        a += (x[j] - x[i]) * (was[j] - was[i]).transpose();
      }
      eight.a.row(k) = Eigen::Map<const Eigen::Array<double, 1, 9>>(a.data());
    }
    eight.follow(enough);
    for (Index k = 0; k < std::min<Index>(8, rows - first); ++k) {
      Eigen::Quaterniond q;
      q.coeffs() = eight.q.row(k).transpose();
      turns[std::size_t(first + k)] = q.toRotationMatrix();
    }
  }
  return turns;
}

}  // namespace

void FormerSolve::keep(const SystemMatrix& matrix, int number, ConstRows b, ConstRows x) {
  const auto made = std::make_shared<Kept>();
  made->x = Vector(x.count), made->b = Vector(b.count);
  copy(x, made->x), copy(b, made->b);
  if (const ConstRows positions = matrix.positions(); positions.count == x.count) {
    made->positions = Vector(positions.count);
    copy(positions, made->positions);
  }
  kept_ = made;
  number_ = number;
}

double FormerSolve::drift(SystemMatrix& matrix) const {
  if (!kept_ || kept_->x.count() != matrix.rows()) return -1;
  Vector x(matrix.rows()), b(matrix.rows()), r(matrix.rows());
  copy(kept_->x, x), copy(kept_->b, b);
  if (kept_->positions.count() == matrix.rows() && matrix.positions().count == matrix.rows()) {
    const std::vector<Mat3> turns = turnsOf(matrix.pattern(), matrix.positions(), kept_->positions);
    for (Index i = 0; i < x.count(); ++i) {
      x[i] = (turns[std::size_t(i)] * x[i]).eval();
      b[i] = (turns[std::size_t(i)] * b[i]).eval();
    }
  }
  std::vector<double> blocks;
  matrix.diagonalBlocks(blocks);
  matrix.multiply(x, r);
  axpy(-1, b, r);
  double sum = 0;
  for (Index i = 0; i < r.count(); ++i) {
    const Vec3 left = r[i];
    sum += left.dot(Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(i)).inverse() * left);
  }
  const double drift = std::sqrt(sum / dot(x, b));
  return std::isfinite(drift) ? drift : -1;
}

void FormerSolve::serialize(Archive& archive) {
  bool exists = bool(kept_);
  archive.value("former_exists", exists);
  archive.value("former_number", number_);
  if (!exists) return kept_.reset();
  if (archive.isReading()) kept_ = std::make_shared<Kept>();
  archive.rows("former_x", kept_->x);
  archive.rows("former_b", kept_->b);
  archive.rows("former_positions", kept_->positions);
}

double ratePerDecade(double drift) {
  const double wide = std::sqrt(1 + drift), of_spectrum = (wide - 1) / (wide + 1);
  return 1 / -std::log10(std::clamp(drift < 1 ? 2 * drift / (1 + 12 * drift) : of_spectrum, 1e-12, 1 - 1e-6));
}

void Drifts::note(int age_now, double drift) {
  if (drift < 0) return;
  if (age_now == 1 || first < 0) first = std::max(first, drift / age_now);
  if (age_now > age || drift > after(age_now)) last = drift, age = age_now;
}

double Drifts::after(int matrices) const {
  if (age <= 1) return first * matrices;
  return std::max(std::min(first, last), first + (last - first) * (matrices - 1) / (age - 1));
}

void Drifts::serialize(Archive& archive) {
  archive.value("drift_first", first);
  archive.value("drift_last", last);
  archive.value("drift_age", age);
}

}  // namespace stroma
