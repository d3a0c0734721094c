// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/redundant_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {

using Eigen::MatrixXd, Eigen::VectorXd;

bool RedundantForces::scaleRows(const Problem& problem, const VectorXd& l) {
  const auto& [rows, live, w, g, sizes, yields, allowed, at_rest, goes_on, is_repeated, budget, bodies, factor] = problem;
  const auto count = Eigen::Index(live.size());
  const auto ownOf = [&](Eigen::Index k) {
    if (!bodies) return w(k, k);
    const BodyRows::Row& row = bodies->rows()[std::size_t(k)];
    return BodyRows::couple(row, row, factor);
  };
  double most = 0;
  for (Eigen::Index k = 0; k < count; ++k)
    if (const double size = sizes[live[std::size_t(k)]]; size > 0) most = std::max(most, std::abs(ownOf(k)) / (size * size));
  scale_.resize(count), offset_.resize(count), start_.setZero(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t row = live[std::size_t(k)];
    const double own = ownOf(k), size = sizes[row];
    if (!(own >= 0)) return false;  // what buckles
    scale_[k] = rows[row].kind == Kind::rub && k > 0 ? scale_[k - 1] : own > 1e-14 * most * size * size ? 1 / std::sqrt(own) : 0;
    offset_[k] = scale_[k] * g[Eigen::Index(row)];
    if (scale_[k] > 0) start_[k] = l[Eigen::Index(row)] / scale_[k];
  }
  body_rows_.clear();
  if (bodies)
    takeBodies(problem);
  else
    w_ = scale_.asDiagonal() * w * scale_.asDiagonal();
  findCompliances(problem);
  return true;
}

/// Their rows, so that the motion of all bodies is the sum of forces times y, and conditions are along j.
void RedundantForces::takeBodies(const Problem& problem) {
  body_rows_ = problem.bodies->rows();
  motion_size_ = 0;
  for (std::size_t k = 0; k < body_rows_.size(); ++k) {
    BodyRows::Row& row = body_rows_[k];
    for (std::size_t side = 0; side < 2; ++side) {
      row.j[side] *= scale_[Eigen::Index(k)], row.y[side] *= problem.factor * scale_[Eigen::Index(k)];
      motion_size_ = std::max(motion_size_, Eigen::Index(row_doubles) * row.at[side] + BodyRows::width);
    }
  }
}

/// Of W.
double RedundantForces::coupling(Eigen::Index i, Eigen::Index j) const {
  return body_rows_.empty() ? w_(i, j) : BodyRows::couple(body_rows_[std::size_t(i)], body_rows_[std::size_t(j)], 1);
}

/// In the units of W, one in the mean; rows that say nothing of it are as the mean.
void RedundantForces::findCompliances(const Problem& problem) {
  yields_.setZero(scale_.size());
  double sum = 0, known = 0;
  for (Eigen::Index k = 0; k < scale_.size(); ++k) {
    yields_[k] = problem.yields[problem.live[std::size_t(k)]] * scale_[k] * scale_[k];
    if (yields_[k] > 0) sum += yields_[k], ++known;
  }
  for (double& each : yields_) each = each > 0 ? each * known / sum : 1;
}

/// False where forces are given or have a bound.
bool RedundantForces::findGroups(const Problem& problem) {
  groups_.clear(), all_.clear();
  widest_ = 1, size_ = 0;
  const auto count = Eigen::Index(problem.live.size());
  const auto at = [&](Eigen::Index k) -> const Row& { return problem.rows[problem.live[std::size_t(k)]]; };
  for (Eigen::Index i = 0; i < count;) {
    const Row& row = at(i);
    if (row.kind == Kind::given || (row.kind == Kind::push && row.factor > 0)) return false;
    Group group{.pushes = row.kind == Kind::push, .first = i};
    Eigen::Index end = i + 1;
    while (group.pushes && end < count && at(end).kind == Kind::rub) ++end;
    const Eigen::Index tangents = end - i - 1;
    if (tangents > most_tangents) return false;
    if (tangents > 0 && at(i + 1).factor > 0) {
      group.mu = at(i + 1).factor, group.size = end - i;
    }
    group.own.resize(group.size, group.size);
    for (Eigen::Index k = 0; k < group.size; ++k)
      for (Eigen::Index j = 0; j < group.size; ++j) group.own(k, j) = coupling(i + k, i + j);
    if (group.size > 1) {
      group.rate = group.own.bottomRightCorner(tangents, tangents).cwiseAbs().rowwise().sum().maxCoeff();
      if (!(group.rate > 0)) return false;
    }
    const bool moves = scale_[i] > 0 && group.own(0, 0) > 0 && row.kind != Kind::rub;
    if (moves) groups_.push_back(group), size_ = std::max(size_, group.pushes ? -offset_[i] : std::abs(offset_[i]));
    const Eigen::Index held = moves ? group.size : 0;
    if (held > 0) all_.push_back({i, held}), widest_ = std::max(widest_, held);
    for (Eigen::Index k = i + held; k < end; ++k) all_.push_back({k, 1}), start_[k] = 0;
    i = end;
  }
  return size_ > 0;
}

/// By elimination with pivots of the diagonal. False: a step of Newton's method with them would cost more than `most`.
bool RedundantForces::findRoots(double most) {
  constexpr double little = 1e-11;
  const Eigen::Index count = w_.rows();
  VectorXd& left = work_.left;
  left = w_.diagonal();
  MatrixXd &p = whole_p_, &q = whole_q_;
  p.resize(count, count), q.resize(count, count);
  work_.y.resize(count), work_.pulled.resize(count);
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0, at = 0; k < count; ++k) {
    const double pivot = left.maxCoeff(&at);
    rank = k;
    if (!(pivot > little)) break;
    rank = k + 1;
    if (double(count) * double(rank) * double(rank) > most) return false;
    p.col(k) = w_.col(at);
    q.col(k) = w_.row(at).transpose();
    work_.y.head(k) = q.row(at).head(k);  // as columns, which products take as they are
    work_.pulled.head(k) = p.row(at).head(k);
    p.col(k).noalias() -= p.leftCols(k) * work_.y.head(k);
    q.col(k).noalias() -= q.leftCols(k) * work_.pulled.head(k);
    q.col(k) /= pivot;
    left -= p.col(k).cwiseProduct(q.col(k));
    left[at] = 0;
  }
  p_ = p.leftCols(rank);
  q_ = q.leftCols(rank);
  return true;
}

/// The function of the laws (condition_forces.h).
double RedundantForces::offOf(const Group& group, const VectorXd& q, const SmallVector& r) const {
  const Eigen::Index at = group.first, n = group.tangents();
  const double off = group.pushes ? ConditionForces::offOfPush(q[at], r[0], none) : std::abs(r[0]);
  return n == 0 ? off : std::max(off, offAlong(group, q, r));
}

/// Of what rubs.
double RedundantForces::offAlong(const Group& group, const VectorXd& q, const SmallVector& r) const {
  const Eigen::Index at = group.first, n = group.tangents();
  SmallVector wanted = q.segment(at + 1, n) - r.tail(n) / group.rate;
  ConditionForces::cutFriction(wanted, group.mu, q[at]);
  return group.rate * (wanted - q.segment(at + 1, n)).cwiseAbs().maxCoeff();
}

/// The largest of all, of size_.
double RedundantForces::offOf(const VectorXd& q, const VectorXd& r) const {
  double worst = 0;
  for (const Group& group : groups_) worst = std::max(worst, offOf(group, q, r.segment(group.first, group.size)));
  return q.allFinite() && r.allFinite() ? worst / size_ : none;
}

/// best_ is off by less than this part of what each row may.
bool RedundantForces::isLittle(const Problem& problem, double part) const {
  if (problem.allowed.empty()) return false;
  return std::all_of(groups_.begin(), groups_.end(), [&](const Group& group) {
    const std::size_t row = problem.live[std::size_t(group.first)];
    return off_ * size_ <= part * problem.allowed[row] * problem.sizes[row] * scale_[group.first];
  });
}

bool RedundantForces::isDone(const Problem& problem) const {
  constexpr double little = 1e-3;  // of what rows may be off by
  return !(off_ > near) || isLittle(problem, little);
}

/// r = g + W q
void RedundantForces::conditions(const VectorXd& q, VectorXd& r) {
  if (!body_rows_.empty()) {
    findState(q, motion_), r.resize(q.size());
    for (Eigen::Index k = 0; k < q.size(); ++k) r[k] = offset_[k] + body_rows_[std::size_t(k)].along(motion_.data());
    return;
  }
  work_.product.noalias() = w_ * q;
  r = offset_ + work_.product;
}

/// A step of Newton's method, work_.way. What is open has its force taken away first; q and r follow.
void RedundantForces::stepFrom(VectorXd& q, VectorXd& r, double size) {
  ++steps, spend();
  work_.by.setOnes(q.size());
  Blocks blocks(*this, size);
  work_.was = q;
  work_.is_open.clear();
  for (const Group& group : groups_) {
    work_.is_open.push_back(group.pushes && !(q[group.first] > r[group.first]));
    if (work_.is_open.back()) q.segment(group.first, group.size).setZero();
  }
  work_.left = q - work_.was;
  blocks.timesW(work_.left, work_.pulled);
  r += work_.pulled;
  linearise(blocks);
  blocks.factor();
  blocks.solve(work_.right, work_.way);
}

/// A and B at work_.at and work_.r, and the right side.
void RedundantForces::linearise(Blocks& blocks) {
  const VectorXd &q = work_.at, &r = work_.r;
  VectorXd& right = work_.right;
  right.setZero(q.size());
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const Group& group = groups_[k];
    if (work_.is_open[k]) continue;
    const Eigen::Index at = group.first, n = group.tangents();
    blocks.a.block(at, 0, n + 1, n + 1).setIdentity();
    blocks.b.block(at, 0, n + 1, n + 1).setZero();
    right.segment(at, n + 1) = -r.segment(at, n + 1);
    if (n == 0) continue;
    const SmallVector wanted = q.segment(at + 1, n) - r.segment(at + 1, n) / group.rate;
    const double length = wanted.norm(), bound = group.mu * std::max(q[at], 0.0);
    if (length <= bound) continue;
    const SmallVector across = wanted / length;
    const SmallMatrix one = SmallMatrix::Identity(n, n), turned = bound / length * (one - across * across.transpose());
    blocks.a.block(at + 1, 1, n, n) = turned / group.rate;
    blocks.b.block(at + 1, 1, n, n) = one - turned;
    blocks.b.block(at + 1, 0, n, 1) = -group.mu * across;
    right.segment(at + 1, n) = bound * across - q.segment(at + 1, n);
  }
}

/// Steps from q while they help; q becomes the best. What it is off by.
double RedundantForces::newton(double size, const VectorXd& where, VectorXd& q) {
  constexpr int most = 12;
  VectorXd &at = work_.at, &r = work_.r;
  const auto look = [&] {
    conditions(at, r);
    r += size * yields_.cwiseProduct(at - where);
    return offOf(at, r);
  };
  at = q;
  double now = look(), least = now;
  for (int k = 0; k < most && now > settled && !isOver(); ++k) {
    stepFrom(at, r, size);
    at += work_.way;
    const double last = std::exchange(now, look());
    if (now < least) least = now, q = at;
    if (!std::isfinite(now) || !(now > rounded || now < 0.5 * last)) break;
  }
  return least;
}

void RedundantForces::note(const VectorXd& q) {
  conditions(q, work_.noted);
  if (const double now = offOf(q, work_.noted); now < off_) off_ = now, best_ = q;
}

/// The forces of a layer that yields, from q. False: they were not found.
bool RedundantForces::layer(double size, VectorXd& q) {
  work_.where.setZero(q.size());
  return newton(size, work_.where, q) <= near;
}

/// Proximal points from q, until the conditions hold.
void RedundantForces::draw(const Problem& problem, double size, VectorXd& q) {
  constexpr int most = 20, look = 3;
  constexpr double little = 1e-3;
  note(q);
  double before = off_;
  for (int turn = 1; turn <= most && off_ > rounded && !isOver(); ++turn) {
    work_.where = q;
    if (newton(size, work_.where, q) > near) break;
    note(q);
    if (turn % look == 0 && (isLittle(problem, little) || !(off_ < 0.5 * std::exchange(before, off_)))) break;
  }
}

bool RedundantForces::find(const Problem& problem, VectorXd& l, StopToken stop) {
  constexpr int some = 1000, many = 10000;
  constexpr double well = 0.05, enough = 0.3;  // of what rows may be off by
  stop_ = stop, are_initial_guess_ = false, contradiction_ = 0, budget_ = problem.budget, spent = 0;
  const bool was_swept = std::exchange(is_swept_, false) && problem.goes_on;
  if (problem.live.empty() || !scaleRows(problem, l) || !findGroups(problem)) return false;
  off_ = none, best_ = start_, note(start_);
  if (!(off_ > rounded) || isLittle(problem, problem.at_rest)) return true;
  const bool is_dear = was_swept || problem.bodies || !findRoots(expensive);
  if (!is_dear && findNear(problem)) return take(problem, l);
  if ((is_dear || isSingular()) && sweepToLaws(problem, some, is_dear ? enough : well, was_swept)) return take(problem, l);
  if (is_dear && problem.is_repeated) return is_swept_ = take(problem, l);
  if (is_dear) findRoots(none);
  if (findInside(problem)) return take(problem, l);
  if (!isSingular()) return false;
  sweepToLaws(problem, many, enough, false);  // nothing else finds more
  return take(problem, l);
}

/// Rows of free bodies say the same at most of half of what these can move by.
bool RedundantForces::wouldSweep(const std::vector<Row>& rows, const std::vector<std::size_t>& live, int bodies, bool goes_on) const {
  const double count = double(live.size()), rank = std::min(count, 6. * bodies) / 2;
  if (!(is_swept_ && goes_on) && count * rank * rank <= expensive) return false;
  return std::ranges::none_of(live, [&](std::size_t row) {
    return rows[row].kind == Kind::given || (rows[row].kind == Kind::push && rows[row].factor > 0);
  });
}

ConditionForces::Violation RedundantForces::worst(const std::vector<Row>& rows, const std::vector<std::size_t>& live,
                                                  const std::vector<double>& sizes, const std::vector<double>& allowed) const {
  ConditionForces::Violation found;
  const auto note = [&](std::size_t row, double off, bool rubs) {
    if (sizes[row] > 0) off /= sizes[row];
    if (!allowed.empty() && off <= allowed[row]) return;
    if (!(off <= found.off) && !std::isnan(found.off)) found = {row, off, rubs};
  };
  auto group = groups_.begin();
  std::size_t next = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_live = next < live.size() && live[next] == i;
    const bool is_found = is_live && group != groups_.end() && group->first == Eigen::Index(next);
    next += is_live;
    if (!is_found) {  // nothing moves it
      if (rows[i].kind == Kind::equal || (rows[i].kind == Kind::push && !(rows[i].value >= 0))) note(i, std::abs(rows[i].value), false);
      continue;
    }
    SmallVector r(group->size);
    for (Eigen::Index k = 0; k < group->size; ++k) r[k] = scale_[group->first] * rows[i + std::size_t(k)].value;
    note(i, offOf(Group{.pushes = group->pushes, .first = group->first}, best_, r.head(1)) / scale_[group->first], false);
    if (group->size > 1) note(i + 1, offAlong(*group, best_, r) / scale_[group->first + 1], true);
    ++group;
  }
  return found;
}

/// From the forces before, with what of them pushes and sticks.
bool RedundantForces::findNear(const Problem& problem) {
  constexpr double unchanged = 1e-8;  // so little of the largest condition moves forces along where they were
  VectorXd& q = work_.found;
  q = start_;
  if (problem.goes_on || off_ < unchanged) {
    draw(problem, layer_compliance, q);
    if (isDone(problem)) return true;
    q = start_;
  }
  if (!layer(layer_compliance, q)) return false;
  draw(problem, layer_compliance, q);
  return off_ < coarse || isDone(problem);
}

/// From those of thicker layers.
bool RedundantForces::findInside(const Problem& problem) {
  VectorXd& q = work_.found;
  bool is_found = false;
  for (double first = layer_compliance; !is_found && first < 0.1 && !isOver(); first *= 100) {
    q = searchInside(first), is_found = layer(first, q);
    for (double size = first / 10; is_found && size > 0.5 * layer_compliance; size /= 10) is_found = layer(size, q);
  }
  if (is_found) draw(problem, layer_compliance, q);
  return off_ < coarse || isDone(problem);
}

/// l = best_
bool RedundantForces::take(const Problem& problem, VectorXd& l) {
  if (off_ > near) contradiction_ = 2 * off_ * size_;
  for (std::size_t k = 0; k < problem.live.size(); ++k)
    l[Eigen::Index(problem.live[k])] = scale_[Eigen::Index(k)] * best_[Eigen::Index(k)];
  return true;
}

}  // namespace stroma
