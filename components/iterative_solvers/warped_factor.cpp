// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/warped_factor.h"

#include <stdexcept>

#include "framework/scene/node.h"

namespace stroma {
namespace {

constexpr double block_product_seconds = 3e-9;

/// Turns q to the rotation nearest to A (largest trace of R^T A), from the q given (Mueller, Bender, Chentanez, Macklin
/// 2016): works for any A, also one that inverts or has lost a rank.
void followRotation(const Mat3& a, Eigen::Quaterniond& q) {
  for (int i = 0; i < 10; ++i) {
    const Mat3 r = q.toRotationMatrix();
    const Vec3 axis = r.col(0).cross(a.col(0)) + r.col(1).cross(a.col(1)) + r.col(2).cross(a.col(2));
    const double scale = std::abs((r.transpose() * a).trace()) + 1e-9 * a.norm();
    if (!(scale > 0)) return;
    const double angle = axis.norm() / scale;
    if (!(angle > 1e-7)) return;
    q = Eigen::AngleAxisd(angle, axis.normalized()) * q;
    q.normalize();
  }
}

}  // namespace

void WarpedFactor::turn(const BlockMatrix& matrix, ConstRows x) {
  for (Index i = 0; i < matrix.rows(); ++i) {
    Mat3 a = Mat3::Zero();
    for (Index s = matrix.rowStart()[i]; s < matrix.rowStart()[i + 1]; ++s) {
      const Index j = matrix.columns()[s];
      a += (x[j] - x[i]) * (positions_[j] - positions_[i]).transpose();
    }
    followRotation(a, rotations_[i]);
    matrices_[i] = rotations_[i].toRotationMatrix();
  }
  turned_ = true;
}

bool WarpedFactor::follow(SystemMatrix& matrix, SolveReport& report) {
  start_ = std::chrono::steady_clock::now();
  const bool factor = renew_ || !fits(matrix);
  if (!factor && key_ == matrix.key()) return true;
  const ConstRows positions = matrix.positions();
  fresh_ = factor;
  if (!factor) {
    if (positions.count > 0) turn(matrix.pattern(), positions);
    key_ = matrix.key();
    return true;
  }
  rows_ = -1;
  factors_ = solver_.factor(matrix, report);
  if (!factors_) return false;
  if (work_.count() != matrix.rows()) work_.resize(matrix.rows());
  if (positions.count > 0) {
    if (positions_.count() != positions.count) positions_.resize(positions.count);
    copy(positions, positions_);
    rotations_.assign(positions.count, Eigen::Quaterniond::Identity());
    matrices_.resize(positions.count);
  }
  rows_ = matrix.rows(), key_ = matrix.key();
  factored_values_ = matrix.assemble().values();
  renew_ = turned_ = false;
  iteration_seconds_ = factors_->cost().apply + block_product_seconds * matrix.assemble().blocks();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start_;
  spent_ = renewal_ == Renewal::clock ? took.count() : factors_->cost().factor;
  solves_ = 0;
  start_ = std::chrono::steady_clock::now();
  return true;
}

void WarpedFactor::serialize(SystemMatrix& matrix, Archive& archive) {
  // factors of a pattern that has gone are made anew by the next follow(): their values are not worth keeping
  if (!archive.isReading() && !fits(matrix)) rows_ = -1, factored_values_.clear();
  bool is_current = rows_ >= 0 && key_ == matrix.key();
  archive.value("rows", rows_);
  archive.value("current", is_current);
  archive.value("renew", renew_);
  archive.value("fresh", fresh_);
  archive.value("turned", turned_);
  archive.value("rough", rough_);
  archive.value("iteration_seconds", iteration_seconds_);
  archive.value("spent", spent_);
  archive.value("solves", solves_);
  archive.rows("positions", positions_);
  archive.list("rotations", rotations_);
  archive.list("factored_values", factored_values_);
  if (!archive.isReading() || rows_ < 0) return;
  factors_ = rows_ == matrix.rows() ? solver_.factorValues(matrix, factored_values_) : nullptr;
  if (!factors_)
    throw std::runtime_error(
        "the checkpoint holds a factored matrix of another pattern: it was written by another scene");
  key_ = matrix.key();
  if (!is_current) key_.values = -1;
  if (work_.count() != rows_) work_.resize(rows_);
  matrices_.clear();
  for (const Eigen::Quaterniond& rotation : rotations_) matrices_.push_back(rotation.toRotationMatrix());
}

void WarpedFactor::apply(ConstRows r, Rows z) {
  const auto applyFactors = [this](ConstRows in, Rows out) {
    rough_ ? factors_->applyRoughly(in, out) : factors_->apply(in, out);
  };
  if (!turned_) return applyFactors(r, z);
  for (Index i = 0; i < r.count; ++i) work_[i] = matrices_[i].transpose() * r[i];
  applyFactors(work_, z);
  for (Index i = 0; i < r.count; ++i) z[i] = (matrices_[i] * z[i]).eval();
}

void WarpedFactor::solved(int iterations) {
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start_;
  const double cost = renewal_ == Renewal::clock ? took.count() : iterations * iteration_seconds_;
  spent_ += cost;
  ++solves_;
  // a factor of the very matrix that needs this many is ill-conditioned beyond single precision
  constexpr int most_of_a_fresh_factor = 20;
  if (fresh_ && iterations > most_of_a_fresh_factor) rough_ = false;
  renew_ = renewal_ != Renewal::never && !fresh_ && cost > spent_ / solves_;
}

DirectSolver& factorSource(const Component& user, const Link<DirectSolver>& link) {
  if (DirectSolver* linked = link.get()) return *linked;
  DirectSolver* found = nullptr;
  for (const auto& component : user.node().components()) {
    auto* solver = dynamic_cast<DirectSolver*>(component.get());
    if (!solver) continue;
    if (found)
      throw ComponentError(
          found->path() + " and " + solver->path() + " both factor: it is not clear whose factors are meant",
          "linearSolver=\"@" + found->name() + "\"");
    found = solver;
  }
  if (!found)
    throw ComponentError(user.node().path() + " has no direct solver whose factors could be turned",
                         "a direct solver in the same node, or linearSolver=\"@path\"", "add <SparseLDLSolver/>");
  found->ensureReady();
  return *found;
}

}  // namespace stroma
