// SPDX-License-Identifier: LGPL-2.1-or-later
// A place for Newton's method to begin from (ConditionForces::searchInside()): an interior-point method for Coulomb's law.
// With x = (mu l_n, l_t) and z = (r_n / mu + |r_t|, r_t) of each group, both are in the cone x_0 >= |x_t| and x . z = 0 (De Saxce
// and Feng 1998). A round goes towards x o z = share nu e, nu the mean of x . z; |r_t| is (|r_t|^2 + smooth nu)^.5:
//   (W + F) dx = share nu x^-1 - z - (z(x) - z),   F x = z,   F = e (2 w w^T - J),   J = diag(1, -1, -1),   e = |z| / |x|
// with |x|^2 = x_0^2 - |x_t|^2 and w the middle of z / |z| and J x / |x|, |w| = 1 (Nesterov and Todd 1998). Of rows that are equal
// z = 0 and x is free. W then has the derivative of |r_t|, but after a short way, where it leads out of the cones. Where nothing
// decides between sticking and slipping, half of the digits are found: Newton's method is tried each time nu is a tenth of what it was.
// Where that and sweeps lead nowhere, each search has |r_t| fixed, which is a convex problem: at first zero, then halfway to
// those that the search before has found (Acary, Cadoux, Lemarechal and Malick 2011).
#include <cmath>
#include <utility>
#include <vector>

#include "framework/mechanics/condition_forces.h"

namespace stroma {

namespace {

double squareOf(const auto& x) {
  const double along = x.tail(x.size() - 1).norm();
  return (x[0] - along) * (x[0] + along);
}

bool isInside(const Eigen::VectorXd& x, const Eigen::VectorXd& way, int at, int size, double part) {
  const Eigen::VectorXd there = (x + part / 0.99 * way).segment(at, size);
  return there[0] > 0 && squareOf(there) > 0;
}

/// target = share nu x^-1 - z, and F on top of a. False: a place is on the border.
bool addScaling(const auto& x, const auto& z, double goal, Eigen::Ref<Eigen::MatrixXd> a, Eigen::Ref<Eigen::VectorXd> target) {
  const double xx = squareOf(x), zz = squareOf(z);
  if (!(xx > 0 && zz > 0)) return false;
  const Eigen::Index n = x.size() - 1;
  target = -goal / xx * x - z;
  target[0] += 2 * goal / xx * x[0];
  Eigen::VectorXd w = z / std::sqrt(zz);
  const Eigen::VectorXd u = x / std::sqrt(xx);
  const double size = std::sqrt(2 * (1 + u.dot(w))), e = std::sqrt(zz / xx);
  w[0] += u[0], w.tail(n) -= u.tail(n);
  a += 2 * e / (size * size) * w * w.transpose();
  a.diagonal().array() += e;
  a(0, 0) -= 2 * e;
  return true;
}

}  // namespace

/// Notes the best place. `slides`: |r_t| at the first row of each group; null: as they come.
void ConditionForces::searchInside(const Eigen::VectorXd* slides) {
  constexpr int most_rounds = 60;
  constexpr double enough = 1e-11, least_way = 1e-8, regular = 1e-12, shorter = 0.95;
  constexpr double smooth = 0.03, short_way = 0.1, early = 1e-4, again = 0.1;  // of nu: where Newton's method is tried
  const Eigen::Index count = offset_.size();
  Eigen::VectorXd by = Eigen::VectorXd::Zero(count), x = by, z = by, dx, dz, off, target, units;
  std::vector<std::pair<int, int>> cones;  // first row, rows
  for (const Group& group : groups_) {
    by.segment(group.first, group.end - group.first).setOnes();
    if (group.tangents() > 0) by[group.first] = 1 / group.mu;
    if (group.pushes) x[group.first] = z[group.first] = size_, cones.push_back({group.first, group.end - group.first});
  }
  const Eigen::MatrixXd w = by.asDiagonal() * scaled_ * by.asDiagonal();
  Eigen::MatrixXd a, turned;
  double way = 1, share = 0.1, tried = early * size_ * size_;  // share: of nu, that is left
  for (int round = 0; round < most_rounds && unsettled_ > enough && !isOver(); ++round) {
    restart(by.cwiseProduct(x)), note(), ++rounds;
    spent += std::pow(double(count), 3);
    off = by.cwiseProduct(r_) - z;
    double nu = 0;
    for (const auto& [at, size] : cones) nu += x.segment(at, size).dot(z.segment(at, size)) / double(cones.size());
    if (nu < tried) {
      tried = again * nu;
      newton(), note();
      if (unsettled_ < enough) return;
    }
    turned = w;
    for (const auto& [at, size] : cones) {
      const auto along = z.segment(at + 1, size - 1);
      const double length = slides ? (*slides)[at] : std::sqrt(along.squaredNorm() + (size > 1 ? smooth * nu : 0));
      off[at] += length;
      if (slides || size == 1 || way < short_way) continue;
      off[at] += along.dot(off.segment(at + 1, size - 1)) / length;
      turned.row(at) += along.transpose() / length * w.middleRows(at + 1, size - 1);
    }
    a = turned, target.setZero(count);
    a.diagonal().array() += regular;
    for (const auto& [at, size] : cones)
      if (!addScaling(x.segment(at, size), z.segment(at, size), share * nu, a.block(at, at, size, size), target.segment(at, size))) return;
    units = a.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
    a = units.asDiagonal() * a * units.asDiagonal();
    dx = units.cwiseProduct(a.lu().solve(units.cwiseProduct(target - off)));
    dz = turned * dx + off;
    way = 1;
    for (const auto& [at, size] : cones)
      while (way > least_way && !(isInside(x, dx, at, size, way) && isInside(z, dz, at, size, way))) way *= shorter;
    if (!(way > least_way) || !dx.allFinite()) return;
    x += way * dx;
    for (const auto& [at, size] : cones) z.segment(at, size) += way * dz.segment(at, size);
    share = way > 0.9 ? 0.01 : way > 0.5 ? 0.1 : 0.5;
  }
}

void ConditionForces::searchWithSlides() {
  constexpr double near = 1e-9;
  Eigen::VectorXd slides = Eigen::VectorXd::Zero(offset_.size());
  for (int k = 0; k < 20 && unsettled_ > near && !isLittle() && !isOver(); ++k) {
    searchInside(&slides);
    for (const Group& group : groups_)
      slides[group.first] += (k == 0 ? 1 : 0.5) * (r_.segment(group.first + 1, group.tangents()).norm() - slides[group.first]);
  }
}

}  // namespace stroma
