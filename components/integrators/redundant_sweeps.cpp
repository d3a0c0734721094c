// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of many contacts that nothing but friction and weight divide, as in a heap (RedundantForces::sweep()). Each group in turn takes
// the forces that its own law wants while all others stay (Gauss and Seidel; Jourdan, Alart and Jean 1998). With b = r - W q of
// the group, a sliding one has r_t = -alpha q_t with alpha > 0:
//   q_t = -(W_tt + alpha)^-1 (b_t + W_tn q_n),   r_n = 0,   |q_t| = mu q_n
// which is an equation for alpha alone; alpha = 0 sticks. A sweep costs as much as contacts share bodies.
//
// A sweep is followed by a part of the way p that the sweeps before went, d what the sweep changes, and that begins anew where they
// oppose each other (Nesterov 1983; O'Donoghue and Candes 2015; Mazhar, Heyn, Negrut and Tasora 2015):
//   q <- q + d + b p,   p <- d + b p,   b = (k - 1) / (k + 2),   k = 0 where p . d < 0
// Forces that only friction bounds, as of a body that two others wedge, grow by the same in each sweep: with p by more and more.
#include <algorithm>
#include <cmath>
#include <utility>

#include "components/integrators/redundant_forces.h"

namespace stroma {

using Eigen::VectorXd, Eigen::Vector2d, Eigen::Matrix2d;

namespace {

/// A contact by itself: r = b + W q.
struct Alone {
  double w_nn, b_n, mu;
  Vector2d w_tn = Vector2d::Zero(), w_nt = Vector2d::Zero(), b_t = Vector2d::Zero();
  Matrix2d w_tt = Matrix2d::Zero();
  double q_n = 0;
  Vector2d q_t = Vector2d::Zero();

  /// |q_t| - mu q_n with r_n = 0 and r_t = -alpha q_t.
  double tooMuch(double alpha) {
    const double a = w_tt(0, 0) + alpha, d = w_tt(1, 1) + alpha, b = w_tt(0, 1), c = w_tt(1, 0), size = a * d - b * c;
    const auto solve = [&](const Vector2d& v) { return Vector2d((d * v[0] - b * v[1]) / size, (a * v[1] - c * v[0]) / size); };
    const Vector2d u = solve(b_t), z = solve(w_tn);
    q_n = -(b_n - w_nt.dot(u)) / (w_nn - w_nt.dot(z));
    q_t = -u - q_n * z;
    return q_t.norm() - mu * q_n;
  }
  /// `alpha`: where the search begins and ends.
  void solve(double& alpha) {
    constexpr int most = 60;
    constexpr double little = 1e-13, grow = 8;
    const double least = 1e-12 * (w_tt(0, 0) + w_tt(1, 1)), unit = w_tt(0, 0) + w_tt(1, 1);
    if (!(b_n < 0)) {
      q_n = 0, q_t.setZero();
      return;
    }
    double low = least, off_low = tooMuch(least);
    if (!(off_low > 0)) return;
    double high = alpha > 2 * least ? alpha : unit, off_high = tooMuch(high);
    for (int k = 0; k < most && off_high > 0; ++k) low = high, off_low = off_high, high *= grow, off_high = tooMuch(high);
    double at = high;
    for (int k = 0, side = 0; k < most && !(high - low < little * high); ++k) {  // the rule of false position, of Illinois
      at = (low * off_high - high * off_low) / (off_high - off_low);
      if (!(at > low && at < high)) at = 0.5 * (low + high);
      const double off = tooMuch(at);
      if (std::abs(off) <= little * mu * std::abs(q_n)) break;
      if (off > 0) {
        low = at, off_low = off;
        if (std::exchange(side, 1) == 1) off_high *= 0.5;
      } else {
        high = at, off_high = off;
        if (std::exchange(side, -1) == -1) off_low *= 0.5;
      }
    }
    alpha = at;
    q_n = std::max(q_n, 0.0);
    if (const double length = q_t.norm(); length > mu * q_n) q_t *= mu * q_n / length;
  }
};

}  // namespace

/// W by columns without its zeros: those of a group together, as they reach the same rows.
void RedundantForces::Sweeps::pack(const RedundantForces& of) {
  first.clear(), rows.clear(), numbers.clear();
  for (const Group& group : of.groups_) {
    first.push_back({rows.size(), numbers.size()});
    for (Eigen::Index i = 0; i < of.w_.rows(); ++i) {
      const auto of_group = of.w_.row(i).segment(group.first, group.size);
      if (of_group.isZero(0)) continue;
      rows.push_back(i);
      for (const double number : of_group) numbers.push_back(number);
    }
  }
  first.push_back({rows.size(), numbers.size()});
  slides.assign(of.groups_.size(), 0);
}

/// The group takes `change` more.
void RedundantForces::Sweeps::add(std::size_t group, Eigen::Index size, const SmallVector& change) {
  const auto [begin, number] = first[group];
  const std::size_t end = first[group + 1].first;
  const double* w = numbers.data() + number;
  if (size == 3) {
    for (std::size_t k = begin; k < end; ++k, w += 3) r[rows[k]] += w[0] * change[0] + w[1] * change[1] + w[2] * change[2];
    return;
  }
  for (std::size_t k = begin; k < end; ++k)
    for (Eigen::Index i = 0; i < size; ++i) r[rows[k]] += *w++ * change[i];
}

/// What a group takes while all others stay.
RedundantForces::SmallVector RedundantForces::wantedBy(const Group& group, const VectorXd& q, const VectorXd& r, double& slide) const {
  const Eigen::Index at = group.first, n = group.tangents();
  SmallVector wanted(group.size);
  const auto w = w_.block(at, at, group.size, group.size);
  wanted[0] = q[at] - r[at] / w(0, 0);
  if (group.pushes) wanted[0] = std::max(wanted[0], 0.0);
  if (n == 0) return wanted;
  const SmallVector b = r.segment(at, group.size) - w * q.segment(at, group.size);
  Alone alone{.w_nn = w(0, 0), .b_n = b[0], .mu = group.mu};
  alone.w_tt.diagonal().setConstant(group.rate);
  alone.w_tn.head(n) = w.col(0).tail(n), alone.w_nt.head(n) = w.row(0).tail(n).transpose();
  alone.b_t.head(n) = b.tail(n), alone.w_tt.topLeftCorner(n, n) = w.bottomRightCorner(n, n);
  alone.solve(slide);
  wanted[0] = alone.q_n, wanted.tail(n) = alone.q_t.head(n);
  return wanted;
}

/// All groups in turn, from `at` with r of it.
void RedundantForces::sweepOnce() {
  Sweeps& s = sweeps_;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const SmallVector wanted = wantedBy(group, s.at, s.r, s.slides[g]), change = wanted - s.at.segment(group.first, group.size);
    if (change.isZero(0)) continue;
    s.add(g, group.size, change);
    s.at.segment(group.first, group.size) = wanted;
  }
  spent += double(s.numbers.size()), ++sweeps;
}

/// From q, until rows are off by no more than `part` of what they may; q becomes the best place. What it is off by.
double RedundantForces::sweep(const Problem& problem, double part, int most, VectorXd& q) {
  Sweeps& s = sweeps_;
  s.pack(*this);
  s.at = q;
  conditions(s.at, s.r);
  s.way.setZero(q.size()), s.r_way.setZero(q.size());
  double least = farthest(problem, s.at, s.r);
  for (int k = 0, turn = 0; k < most && least > part && !isOver(); ++k) {
    s.step = s.at, s.r_step = s.r;
    sweepOnce();
    const double off = farthest(problem, s.at, s.r);
    if (!std::isfinite(off)) break;
    if (off < least) least = off, q = s.at;
    s.step = s.at - s.step, s.r_step = s.r - s.r_step;
    turn = s.step.dot(s.way) < 0 ? 0 : turn + 1;
    const double again = turn > 0 ? (turn - 1) / (turn + 2.0) : 0;
    s.at += again * s.way, s.r += again * s.r_way;
    s.way = again * s.way + s.step, s.r_way = again * s.r_way + s.r_step;
  }
  return least;
}

/// Forces of sweeps from the best place, which becomes that where they end. False: rows are off by too much of what they may. `stands`:
/// the place is one of sweeps itself.
bool RedundantForces::sweepToLaws(const Problem& problem, int most, bool stands) {
  constexpr double goal = 0.01, still = 0.1, enough = 0.5;
  if (problem.allowed.empty()) return false;
  VectorXd& q = work_.found;
  q = best_;
  conditions(q, work_.noted);
  double off = farthest(problem, q, work_.noted);
  if (!stands || off > still) off = sweep(problem, goal, most, q);
  best_ = q;
  conditions(q, work_.noted);
  off_ = offOf(q, work_.noted);
  return is_swept_ = off <= enough;
}

/// By how much the row that is farthest from its law is off, of what it may. Round-off of the largest condition is always allowed.
double RedundantForces::farthest(const Problem& problem, const VectorXd& q, const VectorXd& r) const {
  double most = 0;
  for (const Group& group : groups_) {
    const std::size_t row = problem.live[std::size_t(group.first)];
    const double allowed = std::max(problem.allowed[row] * problem.sizes[row] * scale_[group.first], near * size_);
    const double off = offOf(group, q, r) / allowed;
    if (!(off <= most) && !std::isnan(most)) most = off;  // a NaN stays
  }
  return most;
}

}  // namespace stroma
