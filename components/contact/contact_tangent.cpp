// SPDX-License-Identifier: LGPL-2.1-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

static Slopes pushing(const BarrierLaw& law, const Touch& touch) {
  if (law.is_penalty) return Penalty(touch.gap, touch.range);
  return Barrier(touch.gap, touch.range);
}

Slopes BarrierLaw::slopesOf(const Touch& touch) const {
  const Slopes sum = pushingOf(touch);
  if (!touch.of_surface || !(adhesion.strength > 0)) return sum;
  const Slopes pull = adhesion.at(touch.gap);
  return {sum.value + touch.share * pull.value, sum.slope + touch.share * pull.slope, sum.curvature + touch.share * pull.curvature};
}

Slopes BarrierLaw::pushingOf(const Touch& touch) const {
  const Slopes push = pushing(*this, touch);
  const double scale = stiffness * touch.share;
  return {scale * push.value, scale * push.slope, scale * push.curvature};
}

double BarrierLaw::pushOf(const Touch& touch) const { return -stiffness * touch.share * pushing(*this, touch).slope; }
double BarrierLaw::pullOf(const Touch& touch) const { return touch.of_surface ? touch.share * adhesion.at(touch.gap).slope : 0; }

Term BarrierLaw::termOf(const Touch& touch, const std::vector<Vec3>& x, Tangent tangent) const {
  Term term;
  for (std::size_t i = 0; i < 4; ++i) term.rows[i] = touch.v[i] >= 0 ? surfaces.rows[std::size_t(touch.v[i])] : -1;
  term.c = touch.c;
  const Slopes energy = slopesOf(touch);
  term.force = -energy.slope * touch.n;
  term.m = energy.curvature * touch.n * touch.n.transpose();
  if (tangent != Tangent::whole && energy.curvature < 0) term.m.setZero();
  const Mat3 along = term.m;
  if (tangent == Tangent::whole || (tangent == Tangent::definite && energy.slope < 0)) addTurning(touch, x, energy.slope, term);
  if (tangent == Tangent::definite && term.slope != 0) term.m = along, keepPositive(term);
  return term;
}

/// Of a term that pushes and has no turning of its own in m: see Term.
void BarrierLaw::keepPositive(Term& term) {
  double cc = 0, ww = 0;
  for (std::size_t i = 0; i < 4; ++i) cc += term.c[i] * term.c[i], ww += term.w[i].squaredNorm();
  if (!(ww > 0)) return void(term.slope = 0);
  // Near the surface half of the part by which closest points slide is kept, which needs the least besides to stay positive. Far from it,
  // as from the centre of a large sphere, all is kept: nothing else tells how the normal turns. Between, the part grows with the distance.
  const double near = std::sqrt(cc / ww);
  term.slope *= std::clamp(0.5 * term.distance / near, 0.5, 1.0);
  term.distance = std::max(term.distance, near);
  term.m -= term.slope / term.distance * (Mat3::Identity() - term.n * term.n.transpose());
}

/// `slope`: of the energy by the distance. Nothing is added where two sides are nearly parallel.
void BarrierLaw::addTurning(const Touch& touch, const std::vector<Vec3>& x, double slope, Term& term) const {
  if (touch.v[1] < 0) return;  // planes do not turn
  const auto place = [&](std::size_t i) -> const Vec3& { return x[std::size_t(touch.v[i])]; };
  std::array<std::array<double, 4>, 2> slides{};  // by how much each weight changes
  std::array<Vec3, 2> along, dual;
  int count = 0;
  for (const double side : {1.0, -1.0}) {
    std::size_t base = 4;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!(side * touch.c[i] > 0)) continue;
      if (base == 4) {
        base = i;
      } else if (touch.v[i] != touch.v[base] && count < 2) {
        auto& slide = slides[std::size_t(count)];
        slide[base] = -1, slide[i] = 1;
        along[std::size_t(count++)] = place(i) - place(base);
      }
    }
  }
  constexpr double least = 1e-6;
  const double aa = count > 0 ? along[0].squaredNorm() : 0, bb = count > 1 ? along[1].squaredNorm() : 0,
               ab = count > 1 ? along[0].dot(along[1]) : 0, determinant = aa * bb - ab * ab;
  if ((count > 0 && !(aa > 0)) || (count > 1 && !(determinant > least * aa * bb))) return;
  Mat3 across = Mat3::Zero();
  if (count < 2) {
    across = Mat3::Identity() - touch.n * touch.n.transpose();
    if (count == 1) dual[0] = along[0] / aa, across -= dual[0] * along[0].transpose();
  } else {
    dual = {Vec3((bb * along[0] - ab * along[1]) / determinant), Vec3((aa * along[1] - ab * along[0]) / determinant)};
  }
  Vec3 difference = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) difference += touch.c[i] * place(i);
  term.distance = difference.norm();
  term.n = touch.n, term.slope = slope;
  term.m += slope / term.distance * across;
  for (std::size_t i = 0; i < 4; ++i)
    for (int k = 0; k < count; ++k) term.w[i] += slides[std::size_t(k)][i] * dual[std::size_t(k)];
}

Mat3 Term::derivative(std::size_t i, std::size_t j) const {
  Mat3 k = -c[i] * c[j] * m;
  if (slope != 0)
    k += slope * (n * (distance * w[i].dot(w[j]) * n + c[j] * w[i]).transpose() + c[i] * w[j] * n.transpose());
  return k;
}

void Terms::addForce(Rows f) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i)
      if (t.rows[i] >= 0) f[t.rows[i]] += t.c[i] * t.force;
}

namespace {
template <class Displacement>
void addProductOf(const Term& t, Displacement displacement, double factor, Rows df) {
  Vec3 sum = Vec3::Zero(), turned = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    if (t.rows[i] >= 0) {
      const Vec3 p = displacement(t.rows[i]);
      sum += t.c[i] * p, turned += t.n.dot(p) * t.w[i];
    }
  const Vec3 product = factor * (t.slope * turned - t.m * sum), far = factor * t.slope * (sum + t.distance * turned);
  for (std::size_t i = 0; i < 4; ++i)
    if (t.rows[i] >= 0) df[t.rows[i]] += t.c[i] * product + t.w[i].dot(far) * t.n;
}
}  // namespace

void Terms::addProduct(ConstRows dx, double factor, Rows df) const {
  for (const Term& t : *this) addProductOf(t, [&](Index row) { return Vec3(dx[row]); }, factor, df);
}

/// Only how sides move against each other counts.
void Terms::addPush(const Vec3& way, Rows df) const {
  for (const Term& t : *this) addProductOf(t, [&](Index) { return way; }, -1, df);
}

void Terms::addPattern(BlockPattern& pattern) const {
  for (const Term& t : *this) {
    std::array<Index, 4> rows;
    int count = 0;
    for (const Index row : t.rows)
      if (row >= 0) rows[std::size_t(count++)] = row;
    pattern.addClique(rows.data(), count);
  }
}

void Terms::addTo(double factor, BlockMatrix& matrix) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (t.rows[i] >= 0 && t.rows[j] >= 0 && t.c[i] * t.c[j] != 0)
          matrix.add(t.rows[i], t.rows[j], factor * t.derivative(i, j));
}

void Terms::addDiagonal(double factor, std::vector<double>& blocks) const {
  for (const Term& t : *this)
    for (std::size_t i = 0; i < 4; ++i) {
      if (t.rows[i] < 0) continue;
      const Mat3 k = t.derivative(i, i);
      double* block = blocks.data() + std::size_t(t.rows[i]) * 9;
      for (int l = 0; l < 9; ++l) block[l] += factor * k(l / 3, l % 3);
    }
}

}  // namespace stroma::contact
