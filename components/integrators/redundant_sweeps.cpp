// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of many contacts determined only by friction and weight, as in a heap (RedundantForces::sweep()). Each group in turn
// takes the forces required by its own law while all others are fixed (Gauss and Seidel; Jourdan, Alart and Jean 1998). With b
// = r - W q of the group, a sliding one has r_t = -alpha q_t with alpha > 0:
//   q_t = -(W_tt + alpha)^-1 (b_t + W_tn q_n),   r_n = 0,   |q_t| = mu q_n
// which is an equation for alpha alone; alpha = 0 is sticking. The cost of a sweep depends on how many contacts share bodies, or only
// on the number of contacts if all rows belong to rigid bodies (body_rows.h).
//
// Sweeps are accelerated: after each one, with the change d, a fraction of the previous direction p is added, which restarts
// if the two oppose each other (Nesterov 1983; O'Donoghue and Candes 2015; Mazhar, Heyn, Negrut and Tasora 2015):
//   q <- q + d + b p,   p <- d + b p,   b = (k - 1) / (k + 2),   k = 0 where p . d < 0
// Forces limited only by friction, as of a body wedged between two others, grow by a constant amount in each sweep, but with p
// by increasing amounts.
#include <algorithm>
#include <cmath>
#include <limits>
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

  /// |q_t| - mu q_n with r_n = 0 and r_t = -alpha q_t, and its derivative.
  std::pair<double, double> tooMuch(double alpha) {
    const double a = w_tt(0, 0) + alpha, d = w_tt(1, 1) + alpha, b = w_tt(0, 1), c = w_tt(1, 0), size = 1 / (a * d - b * c);
    const auto solve = [&](const Vector2d& v) { return Vector2d((d * v[0] - b * v[1]) * size, (a * v[1] - c * v[0]) * size); };
    const Vector2d u = solve(b_t), z = solve(w_tn);
    const double turned = 1 / (w_nn - w_nt.dot(z));
    q_n = (w_nt.dot(u) - b_n) * turned;
    q_t = -u - q_n * z;
    const double length = q_t.norm();
    // (W_tt + alpha) q_t + w_tn q_n = -b_t and w_nt q_t + w_nn q_n = -b_n, by alpha
    const Vector2d less = solve(q_t);
    const double n_by = w_nt.dot(less) * turned;
    const Vector2d t_by = -less - n_by * z;
    return {length - mu * q_n, (length > 0 ? q_t.dot(t_by) / length : 0) - mu * n_by};
  }
  /// `alpha`: where the search begins and ends.
  void solve(double& alpha) {
    constexpr int most = 50;
    constexpr double little = 1e-12, grow = 8;
    if (!(b_n < 0)) {
      q_n = 0, q_t.setZero();
      return;
    }
    const double unit = w_tt(0, 0) + w_tt(1, 1);
    if (double low = 1e-12 * unit; tooMuch(low).first > 0) {
      double high = std::numeric_limits<double>::infinity();
      if (!(alpha > low)) alpha = unit;
      for (int k = 0; k < most; ++k) {  // Newton's method, between what is too little and too much
        const auto [off, by] = tooMuch(alpha);
        if (std::abs(off) <= little * mu * std::abs(q_n)) break;
        (off > 0 ? low : high) = alpha;
        alpha -= off / by;
        if (!(alpha > low && alpha < high)) alpha = std::isinf(high) ? grow * low : 0.5 * (low + high);
      }
    }
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
}

/// The group takes `change` more.
void RedundantForces::Sweeps::add(std::size_t group, Eigen::Index size, const SmallVector& change) {
  const auto [begin, number] = first[group];
  const std::size_t end = first[group + 1].first;
  const double* w = numbers.data() + number;
  if (size == 3) {
    for (std::size_t k = begin; k < end; ++k, w += 3) state[rows[k]] += w[0] * change[0] + w[1] * change[1] + w[2] * change[2];
    return;
  }
  for (std::size_t k = begin; k < end; ++k)
    for (Eigen::Index i = 0; i < size; ++i) state[rows[k]] += *w++ * change[i];
}

/// What follows from forces for all groups: conditions, or the motion of bodies.
void RedundantForces::findState(const VectorXd& q, VectorXd& state) {
  if (body_rows_.empty()) return conditions(q, state);
  state.setZero(motion_size_);
  for (std::size_t k = 0; k < body_rows_.size(); ++k)
    if (const double force = q[Eigen::Index(k)]; force != 0) body_rows_[k].move(force, state.data());
}

RedundantForces::SmallVector RedundantForces::conditionsOf(const Group& group, const VectorXd& state) const {
  if (body_rows_.empty()) return state.segment(group.first, group.size);
  SmallVector r(group.size);
  for (Eigen::Index k = 0; k < group.size; ++k) {
    const Eigen::Index row = group.first + k;
    r[k] = offset_[row] + body_rows_[std::size_t(row)].along(state.data());
  }
  return r;
}

/// What a group takes while all others stay.
RedundantForces::SmallVector RedundantForces::wantedBy(const Group& group, const VectorXd& q, const SmallVector& r, double& slide) const {
  const Eigen::Index at = group.first, n = group.tangents();
  SmallVector wanted(group.size);
  if (n == 0) {
    const double to = q[at] - r[0] / group.own(0, 0);
    wanted[0] = group.pushes ? std::max(to, 0.0) : to;
    return wanted;
  }
  Alone alone{.w_nn = group.own(0, 0), .b_n = r[0], .mu = group.mu};
  alone.w_tt.diagonal().setConstant(group.rate);  // of what has one way to slide
  for (Eigen::Index i = 0; i < n; ++i) {
    alone.w_tn[i] = group.own(1 + i, 0), alone.w_nt[i] = group.own(0, 1 + i);
    for (Eigen::Index j = 0; j < n; ++j) alone.w_tt(i, j) = group.own(1 + i, 1 + j);
    alone.b_n -= alone.w_nt[i] * q[at + 1 + i];
  }
  alone.b_n -= alone.w_nn * q[at];
  for (Eigen::Index i = 0; i < n; ++i) {
    alone.b_t[i] = r[1 + i] - alone.w_tn[i] * q[at];
    for (Eigen::Index j = 0; j < n; ++j) alone.b_t[i] -= alone.w_tt(i, j) * q[at + 1 + j];
  }
  alone.solve(slide);
  wanted[0] = alone.q_n;
  for (Eigen::Index i = 0; i < n; ++i) wanted[i + 1] = alone.q_t[i];
  return wanted;
}

/// All groups in turn, from `at` with r of it.
void RedundantForces::sweepOnce() {
  Sweeps& s = sweeps_;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const SmallVector r = conditionsOf(group, s.state), wanted = wantedBy(group, s.at, r, s.slides[g]);
    const SmallVector change = wanted - s.at.segment(group.first, group.size);
    if (change.isZero(0)) continue;
    if (body_rows_.empty())
      s.add(g, group.size, change);
    else
      for (Eigen::Index k = 0; k < group.size; ++k) body_rows_[std::size_t(group.first + k)].move(change[k], s.state.data());
    s.at.segment(group.first, group.size) = wanted;
  }
  constexpr double of_row = 24;
  spent += body_rows_.empty() ? double(s.numbers.size()) : of_row * double(body_rows_.size()), ++sweeps;
}

/// What rows may be off by after so many sweeps, as a part of what they may at all: the more sweeps it takes the more.
double RedundantForces::goalOf(int sweeps, double most) {
  constexpr double least = 0.01, few = 100, power = 1.3;
  return std::clamp(least * std::pow(sweeps / few, power), least, most);
}

/// At least one, whose forces are within their cones, from q; q becomes the best place. What it is off by, as farthest().
/// `at_once`: no less is asked for.
double RedundantForces::sweep(const Problem& problem, int most, double enough, double at_once, VectorXd& q) {
  Sweeps& s = sweeps_;
  if (body_rows_.empty()) s.pack(*this);
  const int first_looks = 8, between = body_rows_.empty() ? 1 : 4;  // to look costs half of a sweep where W is not at hand
  s.slides.assign(groups_.size(), 0);
  s.at = q;
  findState(s.at, s.state);
  s.way.setZero(q.size()), s.state_way.setZero(s.state.size());
  double least = none;
  for (int k = 0, turn = 0; k < most && least > std::max(goalOf(k, enough), at_once) && !isOver(); ++k) {
    s.step = s.at, s.state_step = s.state;
    sweepOnce();
    if (k < first_looks || k % between == 0 || k + 1 == most) {
      const double off = farthest(problem, s.at, s.state);
      if (!std::isfinite(off)) break;
      if (off < least) least = off, q = s.at;
    }
    s.step = s.at - s.step, s.state_step = s.state - s.state_step;
    turn = s.step.dot(s.way) < 0 ? 0 : turn + 1;
    const double again = turn > 0 ? (turn - 1) / (turn + 2.0) : 0;
    s.at += again * s.way, s.state += again * s.state_way;
    s.way = again * s.way + s.step, s.state_way = again * s.state_way + s.state_step;
  }
  return least;
}

/// Forces of `most` sweeps from the best place, which becomes that where they end. False: rows are off by more than `enough` of what they
/// may. `stands`: those of the round before are such.
bool RedundantForces::sweepToLaws(const Problem& problem, int most, double enough, bool stands) {
  constexpr double still = 0.1, part = 0.02;
  if (problem.allowed.empty()) return false;
  VectorXd& q = work_.found;
  q = best_;
  findState(q, sweeps_.state);
  double off = farthest(problem, q, sweeps_.state);
  are_initial_guess_ = stands && off <= still;
  const double at_once = problem.is_repeated ? part * off : 0;  // bodies are elsewhere before the next
  if (!are_initial_guess_) off = sweep(problem, most, enough, at_once, q);
  best_ = q;
  conditions(q, work_.noted);
  off_ = offOf(q, work_.noted);
  return is_swept_ = off <= std::max({enough, at_once, stands ? still : 0});
}

/// By how much the row that is farthest from its law is off, of what it may. Round-off of the largest condition is always allowed.
double RedundantForces::farthest(const Problem& problem, const VectorXd& q, const VectorXd& state) const {
  double most = 0;
  for (const Group& group : groups_) {
    const std::size_t row = problem.live[std::size_t(group.first)];
    const double allowed = std::max(problem.allowed[row] * problem.sizes[row] * scale_[group.first], near * size_);
    const double off = offOf(group, q, conditionsOf(group, state)) / allowed;
    if (!(off <= most) && !std::isnan(most)) most = off;  // a NaN stays
  }
  return most;
}

}  // namespace stroma
