// SPDX-License-Identifier: LGPL-2.1-or-later
// A place for Newton's method to begin from (RedundantForces::searchInside()).
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/integrators/redundant_blocks.h"

namespace stroma {

using Eigen::MatrixXd, Eigen::VectorXd;

namespace {

double squareIn(const auto& x) {
  const double along = x.tail(x.size() - 1).norm();
  return (x[0] - along) * (x[0] + along);
}

/// The part of the way d from x at which it leaves the cone.
double wayInside(const auto& x, const auto& d) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto n = x.size() - 1;
  const double a = squareIn(d), b = x[0] * d[0] - x.tail(n).dot(d.tail(n)), c = squareIn(x), root = b * b - a * c;
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
  d[0] = (l[0] * c[0] - l.tail(n).dot(c.tail(n))) / squareIn(l);
  d.tail(n) = (c.tail(n) - d[0] * l.tail(n)) / l[0];
  return t * d;
}

}  // namespace

/// A round of the interior-point method.
struct RedundantForces::Inside {
  const RedundantForces& of;
  VectorXd by, x, z, off, power, turn, dx, dz, middle, e;
  std::vector<Group> cones;
  Blocks blocks;
  double nu = 0, way = 1;

  Inside(RedundantForces& all, double size) : of(all), by(all.work_.by = scaleOf(all)), blocks(all, size) {
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
      const double xx = squareIn(p), zz = squareIn(s);
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
    blocks.solve(right, dx), blocks.timesW(dx, dz);
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

/// A place near the forces of a layer.
VectorXd RedundantForces::searchInside(double size) {
  constexpr int most_rounds = 40;
  constexpr double enough = 1e-8, least_way = 1e-6, short_way = 0.1, nothing = 1e-12, little = 1e-9;  // of nu
  Inside inside(*this, size);
  VectorXd best = inside.x;
  double least = none;
  for (int round = 0; round < most_rounds && !inside.cones.empty() && !isOver(); ++round) {
    const VectorXd q = inside.by.cwiseProduct(inside.x), r = offset_ + w_ * q + size * yields_.cwiseProduct(q);
    if (const double now = offOf(q, r); now < least) least = now, best = q;
    inside.nu = inside.mean(inside.x, inside.z);
    ++rounds, spend();
    const double nu = inside.nu / (size_ * size_);
    if (least < enough || !(nu > nothing) || !(inside.way > least_way) || (inside.way < short_way && nu < little)) break;
    if (!inside.prepare(r) || !inside.move()) break;
  }
  return best;
}

}  // namespace stroma
