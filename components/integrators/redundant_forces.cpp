// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/redundant_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stroma {

using Eigen::MatrixXd, Eigen::VectorXd;

namespace {

constexpr double none = std::numeric_limits<double>::infinity();
constexpr double settled = 1e-13, rounded = 1e-11, near = 1e-10;  // of the largest condition without forces

double squareOf(const auto& x) {
  const double along = x.tail(x.size() - 1).norm();
  return (x[0] - along) * (x[0] + along);
}

/// The part of the way d from x at which it leaves the cone.
double wayInside(const auto& x, const auto& d) {
  const auto n = x.size() - 1;
  const double a = squareOf(d), b = x[0] * d[0] - x.tail(n).dot(d.tail(n)), c = squareOf(x), root = b * b - a * c;
  const double way = d[0] < 0 ? -x[0] / d[0] : none;
  if (!(root >= 0) || !(b < 0 || a < 0)) return way;
  const double touch = b < 0 ? c / (std::sqrt(root) - b) : -(b + std::sqrt(root)) / a;
  return touch > 0 ? std::min(way, touch) : way;
}

/// size (2 v v^T - J)
MatrixXd reflection(double size, const VectorXd& v) {
  MatrixXd m = 2 * size * v * v.transpose();
  m.diagonal().array() += size, m(0, 0) -= 2 * size;
  return m;
}

/// T ((T x)^-1 o c), c = T dx o T^-1 dz
VectorXd correction(const VectorXd& w, double e, const VectorXd& x, const VectorXd& dx, const VectorXd& dz) {
  const auto n = x.size() - 1;
  VectorXd v = w / std::sqrt(2 * (w[0] + 1));
  v[0] += 1 / std::sqrt(2 * (w[0] + 1));
  const MatrixXd t = reflection(std::sqrt(e), v);
  v.tail(n) *= -1;
  const VectorXd l = t * x, a = t * dx, b = reflection(1 / std::sqrt(e), v) * dz;
  VectorXd c = a[0] * b + b[0] * a, d = c;
  c[0] = a.dot(b);
  d[0] = (l[0] * c[0] - l.tail(n).dot(c.tail(n))) / squareOf(l);
  d.tail(n) = (c.tail(n) - d[0] * l.tail(n)) / l[0];
  return t * d;
}

}  // namespace

/// Solves (A W + B) d = right.
struct RedundantForces::Blocks {
  const std::vector<std::pair<Eigen::Index, Eigen::Index>>& groups;
  MatrixXd w, root;  ///< W with its shift, and L
  VectorXd shift;
  MatrixXd a, b;  ///< blocks, each from the first column
  MatrixXd inverse, slim;
  Eigen::PartialPivLU<MatrixXd> lu;

  Blocks(const RedundantForces& of, const VectorXd& by, double size)
      : groups(of.all_), w(by.asDiagonal() * of.w_ * by.asDiagonal()), root(by.asDiagonal() * of.root_), shift(size * by.cwiseAbs2()) {
    w.diagonal() += shift;
    a.setZero(w.rows(), of.widest_), b = a;
    for (const auto& [at, rows] : groups) b.block(at, 0, rows, rows).setIdentity();
  }
  MatrixXd times(const MatrixXd& blocks, const MatrixXd& m) const {
    MatrixXd out(m.rows(), m.cols());
    for (const auto& [at, rows] : groups)
      out.middleRows(at, rows).noalias() = blocks.block(at, 0, rows, rows).lazyProduct(m.middleRows(at, rows));
    return out;
  }
  void factor() {
    inverse = b;
    for (const auto& [at, rows] : groups) {
      const MatrixXd c = a.block(at, 0, rows, rows) * shift.segment(at, rows).asDiagonal();
      inverse.block(at, 0, rows, rows) = (c + b.block(at, 0, rows, rows)).inverse();
    }
    slim = times(inverse, times(a, root));
    lu.compute(MatrixXd::Identity(root.cols(), root.cols()) + root.transpose() * slim);
  }
  VectorXd solveOnce(const VectorXd& right) const {
    const VectorXd y = times(inverse, right);
    return y - slim * lu.solve(root.transpose() * y);
  }
  VectorXd solve(const VectorXd& right) const {
    const VectorXd d = solveOnce(right);
    return d + solveOnce(right - times(b, d) - times(a, w * d));
  }
};

bool RedundantForces::scaleRows(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const MatrixXd& w, const VectorXd& g,
                                const std::vector<double>& sizes, const VectorXd& l) {
  const auto count = Eigen::Index(live.size());
  double most = 0;
  for (Eigen::Index k = 0; k < count; ++k)
    if (const double size = sizes[live[std::size_t(k)]]; size > 0) most = std::max(most, std::abs(w(k, k)) / (size * size));
  scale_.resize(count), offset_.resize(count), start_.setZero(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t row = live[std::size_t(k)];
    const double own = w(k, k), size = sizes[row];
    if (!(own >= 0)) return false;  // what buckles
    scale_[k] = rows[row].kind == Kind::rub && k > 0 ? scale_[k - 1] : own > 1e-14 * most * size * size ? 1 / std::sqrt(own) : 0;
    offset_[k] = scale_[k] * g[Eigen::Index(row)];
    if (scale_[k] > 0) start_[k] = l[Eigen::Index(row)] / scale_[k];
  }
  w_ = scale_.asDiagonal() * w * scale_.asDiagonal();
  return true;
}

/// False where forces are given or have a bound.
bool RedundantForces::findGroups(const std::vector<Row>& rows, const std::vector<std::size_t>& live) {
  groups_.clear(), all_.clear();
  widest_ = 1, size_ = 0;
  const auto count = Eigen::Index(live.size());
  const auto at = [&](Eigen::Index k) -> const Row& { return rows[live[std::size_t(k)]]; };
  for (Eigen::Index i = 0; i < count;) {
    const Row& row = at(i);
    if (row.kind == Kind::given || (row.kind == Kind::push && row.factor > 0)) return false;
    Group group{.pushes = row.kind == Kind::push, .first = i};
    Eigen::Index end = i + 1;
    while (group.pushes && end < count && at(end).kind == Kind::rub) ++end;
    const Eigen::Index tangents = end - i - 1;
    if (tangents > 0 && at(i + 1).factor > 0) {
      group.mu = at(i + 1).factor, group.size = end - i;
      group.rate = w_.block(i + 1, i + 1, tangents, tangents).cwiseAbs().rowwise().sum().maxCoeff();
      if (!(group.rate > 0)) return false;
    }
    const bool moves = scale_[i] > 0 && w_(i, i) > 0 && row.kind != Kind::rub;
    if (moves) groups_.push_back(group), size_ = std::max(size_, group.pushes ? -offset_[i] : std::abs(offset_[i]));
    const Eigen::Index held = moves ? group.size : 0;
    if (held > 0) all_.push_back({i, held}), widest_ = std::max(widest_, held);
    for (Eigen::Index k = i + held; k < end; ++k) all_.push_back({k, 1}), start_[k] = 0;
    i = end;
  }
  return size_ > 0;
}

/// By Cholesky's method with pivots. False: W is not symmetric, or has too many columns.
bool RedundantForces::findRoot() {
  constexpr double symmetric = 1e-9, little = 1e-13;
  if (!((w_ - w_.transpose()).cwiseAbs().maxCoeff() <= symmetric)) return false;
  const Eigen::Index count = w_.rows();
  VectorXd left = w_.diagonal();
  MatrixXd root(count, count / 2);
  for (Eigen::Index k = 0, at = 0; k < root.cols(); ++k) {
    if (!(left.maxCoeff(&at) > little)) {
      root_ = root.leftCols(k);
      return true;
    }
    root.col(k) = w_.col(at);
    root.col(k).noalias() -= root.leftCols(k) * root.row(at).head(k).transpose();
    root.col(k) /= std::sqrt(left[at]);
    left -= root.col(k).cwiseAbs2();
    left[at] = 0;
  }
  return false;
}

/// The largest function of the laws (condition_forces.h), of size_.
double RedundantForces::offOf(const VectorXd& q, const VectorXd& r) const {
  double worst = 0;
  for (const Group& group : groups_) {
    const Eigen::Index at = group.first, n = group.tangents();
    worst = std::max(worst, std::abs(group.pushes ? q[at] - std::max(q[at] - r[at], 0.0) : r[at]));
    if (n == 0) continue;
    VectorXd wanted = q.segment(at + 1, n) - r.segment(at + 1, n) / group.rate;
    const double length = wanted.norm(), bound = group.mu * std::max(q[at], 0.0);
    if (length > bound) wanted *= bound / length;
    worst = std::max(worst, group.rate * (wanted - q.segment(at + 1, n)).cwiseAbs().maxCoeff());
  }
  return q.allFinite() && r.allFinite() ? worst / size_ : none;
}

/// A step of Newton's method with a shift. What is open has its force taken away first; q and r follow.
VectorXd RedundantForces::stepFrom(VectorXd& q, VectorXd& r, double shift) const {
  Blocks blocks(*this, VectorXd::Ones(q.size()), shift);
  VectorXd right = VectorXd::Zero(q.size()), was = q;
  const auto isOpen = [](const Group& group, const VectorXd& l, const VectorXd& at) {
    return group.pushes && !(l[group.first] > at[group.first]);
  };
  std::vector<char> is_open;
  for (const Group& group : groups_) {
    is_open.push_back(isOpen(group, q, r));
    if (is_open.back()) q.segment(group.first, group.size).setZero();
  }
  r += blocks.w * (q - was);
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const Group& group = groups_[k];
    if (is_open[k]) continue;
    const Eigen::Index at = group.first, n = group.tangents();
    blocks.a.block(at, 0, n + 1, n + 1).setIdentity(), blocks.b.block(at, 0, n + 1, n + 1).setZero();
    right.segment(at, n + 1) = -r.segment(at, n + 1);
    if (n == 0) continue;
    const VectorXd wanted = q.segment(at + 1, n) - r.segment(at + 1, n) / group.rate;
    const double length = wanted.norm(), bound = group.mu * std::max(q[at], 0.0);
    if (length <= bound) continue;
    const VectorXd across = wanted / length;
    const MatrixXd one = MatrixXd::Identity(n, n), turned = bound / length * (one - across * across.transpose());
    blocks.a.block(at + 1, 1, n, n) = turned / group.rate, blocks.b.block(at + 1, 1, n, n) = one - turned;
    blocks.b.block(at + 1, 0, n, 1) = -group.mu * across;
    right.segment(at + 1, n) = bound * across - q.segment(at + 1, n);
  }
  blocks.factor();
  return blocks.solve(right);
}

/// Steps from q while they help; q becomes the best. What it is off by.
double RedundantForces::newton(double shift, const VectorXd& where, VectorXd& q) const {
  constexpr int most = 12;
  const auto conditions = [&](const VectorXd& at) -> VectorXd { return offset_ + w_ * at + shift * (at - where); };
  VectorXd at = q, r = conditions(at);
  double now = offOf(at, r), least = now;
  for (int k = 0; k < most && now > settled && !stop_.isStopAsked(); ++k) {
    at += stepFrom(at, r, shift);
    r = conditions(at);
    const double last = std::exchange(now, offOf(at, r));
    if (now < least) least = now, q = at;
    if (!std::isfinite(now) || !(now > rounded || now < 0.5 * last)) break;
  }
  return least;
}

void RedundantForces::note(const VectorXd& q) {
  if (const double now = offOf(q, offset_ + w_ * q); now < off_) off_ = now, best_ = q;
}

/// Proximal points, the first from q with `where`. False: this one was not found. last_ is the last of them.
bool RedundantForces::draw(double shift, VectorXd where, VectorXd q) {
  constexpr int most = 8;
  double before = none;
  for (int turn = 0; turn < most && !stop_.isStopAsked(); ++turn) {
    if (newton(shift, where, q) > rounded && turn == 0) {
      note(q);
      return false;
    }
    note(q);
    where = last_ = q;
    if (!(off_ > settled) || (turn > 1 && !(off_ < 0.5 * before))) break;
    before = off_;
  }
  return true;
}

bool RedundantForces::find(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const MatrixXd& w, const VectorXd& g,
                           const std::vector<double>& sizes, VectorXd& l, StopToken stop) {
  stop_ = stop, contradiction_ = 0;
  if (live.empty() || !scaleRows(rows, live, w, g, sizes, l) || !findGroups(rows, live) || !findRoot()) return false;
  off_ = none, best_ = start_;
  note(start_);
  bool is_found = !(off_ > settled);
  if (!is_found) {
    is_found = draw(1e-6, start_, start_);
    for (const double shift : {1e-6, 1e-4, 1e-2}) {
      if (is_found || off_ < near || stop_.isStopAsked()) break;
      is_found = draw(shift, VectorXd::Zero(start_.size()), searchInside(shift));
      for (double less = 0.01 * shift; is_found && less > 1e-7 && off_ > near; less *= 0.01) draw(less, last_, last_);
    }
    if (is_found && off_ > near) contradiction_ = 2 * off_ * size_;
  }
  if (!is_found && !(off_ < near)) return false;
  for (std::size_t k = 0; k < live.size(); ++k) l[Eigen::Index(live[k])] = scale_[Eigen::Index(k)] * best_[Eigen::Index(k)];
  return true;
}

/// A round of the interior-point method.
struct RedundantForces::Inside {
  const RedundantForces& of;
  VectorXd by, x, z, off, power, turn, dx, dz, middle, e;
  std::vector<Group> cones;
  Blocks blocks;
  double nu = 0, way = 1;

  Inside(const RedundantForces& all, double shift) : of(all), by(scaleOf(all)), blocks(all, by, shift) {
    x.setZero(by.size()), z = off = power = turn = middle = e = x;
    for (const Group& group : of.groups_) {
      blocks.a.block(group.first, 0, group.size, group.size).setIdentity();
      blocks.b.block(group.first, 0, group.size, group.size).setZero();
      if (group.pushes) x[group.first] = z[group.first] = of.size_, cones.push_back(group);
    }
  }
  static VectorXd scaleOf(const RedundantForces& all) {
    VectorXd scale = VectorXd::Zero(all.offset_.size());
    for (const Group& group : all.groups_) {
      scale.segment(group.first, group.size).setOnes();
      if (group.tangents() > 0) scale[group.first] = 1 / group.mu;
    }
    return scale;
  }
  double mean(const VectorXd& a, const VectorXd& b) const {
    double sum = 0;
    for (const Group& cone : cones) sum += a.segment(cone.first, cone.size).dot(b.segment(cone.first, cone.size));
    return sum / double(cones.size());
  }
  /// F, x^-1 and what z is off by. False: a place is on the border.
  bool prepare(const VectorXd& r) {
    constexpr double smooth = 0.1, short_way = 0.1;
    off = by.cwiseProduct(r) - z;
    turn.setZero();
    for (const Group& cone : cones) {
      const Eigen::Index at = cone.first, n = cone.tangents();
      const VectorXd p = x.segment(at, n + 1), s = z.segment(at, n + 1);
      const double xx = squareOf(p), zz = squareOf(s);
      if (!(xx > 0 && zz > 0)) return false;
      const double length = std::sqrt(s.tail(n).squaredNorm() + (n > 0 ? smooth * nu * nu / (p[0] * p[0] + nu) : 0));
      if (way >= short_way && n > 0) turn.segment(at + 1, n) = s.tail(n) / length;
      off[at] += turn.segment(at + 1, n).dot(off.segment(at + 1, n)) + length;
      power.segment(at, n + 1) = -p / xx, power[at] *= -1;
      const VectorXd u = p / std::sqrt(xx);
      VectorXd m = s / std::sqrt(zz);
      const double scale = 1 / std::sqrt(2 * (1 + u.dot(m)));
      m[0] += u[0], m.tail(n) -= u.tail(n), m *= scale;
      middle.segment(at, n + 1) = m, e[at] = std::sqrt(zz / xx);
      MatrixXd f = reflection(e[at], m);
      f.row(0) -= turn.segment(at + 1, n).transpose() * f.bottomRows(n);
      blocks.b.block(at, 0, n + 1, n + 1) = f;
    }
    blocks.factor();
    return true;
  }
  /// The way dx, dz; which part of it stays inside.
  double go(double goal, const VectorXd& less) {
    VectorXd right = goal * power - less - z - off;
    for (const Group& cone : cones)
      right[cone.first] -= turn.segment(cone.first + 1, cone.tangents()).dot(right.segment(cone.first + 1, cone.tangents()));
    dx = blocks.solve(right), dz = blocks.w * dx;
    double part = none;
    for (const Group& cone : cones) {
      dz[cone.first] += turn.segment(cone.first + 1, cone.tangents()).dot(dz.segment(cone.first + 1, cone.tangents()));
      dz.segment(cone.first, cone.size) += off.segment(cone.first, cone.size);
      for (const auto& [place, d] : {std::pair(&x, &dx), std::pair(&z, &dz)})
        part = std::min(part, wayInside(place->segment(cone.first, cone.size), d->segment(cone.first, cone.size)));
    }
    return part;
  }
  bool move() {
    constexpr double whole = 0.99, shorter = 0.2, centred = 0.7;
    VectorXd less = VectorXd::Zero(x.size());
    const VectorXd no_less = less;
    const double first = std::min(1.0, go(0, less)), ratio = std::max(mean(x + first * dx, z + first * dz), 0.0) / nu;
    const double share = std::clamp(ratio * ratio, 1e-3, 1.0);
    for (const Group& cone : cones) {
      const auto of_cone = [&cone](const VectorXd& v) -> VectorXd { return v.segment(cone.first, cone.size); };
      less.segment(cone.first, cone.size) = correction(of_cone(middle), e[cone.first], of_cone(x), of_cone(dx), of_cone(dz));
    }
    way = whole * go(share * nu, less);
    if (way < shorter) way = whole * go(share * nu, no_less);
    if (way < shorter) way = whole * go(std::max(share, centred) * nu, no_less);
    way = std::min(way, 1.0);
    if (!dx.allFinite() || !dz.allFinite()) return false;
    x += way * dx;
    for (const Group& cone : cones) z.segment(cone.first, cone.size) += way * dz.segment(cone.first, cone.size);
    return true;
  }
};

/// A place near the forces with a shift.
VectorXd RedundantForces::searchInside(double shift) const {
  constexpr int most_rounds = 40;
  constexpr double enough = 1e-8, least_way = 1e-6, short_way = 0.1, nothing = 1e-12, little = 1e-9;  // of nu
  Inside inside(*this, shift);
  VectorXd best = inside.x;
  double least = none;
  for (int round = 0; round < most_rounds && !inside.cones.empty() && !stop_.isStopAsked(); ++round) {
    const VectorXd q = inside.by.cwiseProduct(inside.x), r = offset_ + w_ * q + shift * q;
    if (const double now = offOf(q, r); now < least) least = now, best = q;
    inside.nu = inside.mean(inside.x, inside.z);
    const double nu = inside.nu / (size_ * size_);
    if (least < enough || !(nu > nothing) || !(inside.way > least_way) || (inside.way < short_way && nu < little)) break;
    if (!inside.prepare(r) || !inside.move()) break;
  }
  return best;
}

}  // namespace stroma
