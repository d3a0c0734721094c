// SPDX-License-Identifier: LGPL-2.1-or-later
// What forces are to an energy, to products and to each other.
#pragma once
#include "tests/support/field_under_test.h"

namespace stroma::test {

/// The slope of the energy along the direction of `t`, against the force `f` at x.
inline void expectForceOfEnergy(FieldUnderTest& t, const Vector& f) {
  const double step = 1e-4 * t.typicalEdge();
  Vector ahead(t.x.count()), behind(t.x.count());
  copy(t.x, ahead);
  copy(t.x, behind);
  axpy(step, t.direction, ahead);
  axpy(-step, t.direction, behind);
  const double slope = (t.field().energy(ahead) - t.field().energy(behind)) / (2 * step);
  EXPECT_NEAR(-slope, dot(f, t.direction), 1e-6 * std::sqrt(dot(f, f) * dot(t.direction, t.direction))) << "force is not -grad energy";
}

inline void expectForceAndProductInOnePass(FieldUnderTest& t) {
  const Vector f = t.force(), product = t.product(t.direction);
  Vector both(t.x.count()), separate(t.x.count());
  t.field().addForceAndProduct(t.x, t.v_zero, t.direction, 1.5, both);
  copy(f, separate);
  axpy(1.5, product, separate);
  EXPECT_LT(relativeDifference(separate, both), 1e-13) << "force and product in one pass";
  t.field().addForceAndProduct(t.x, t.v_zero, t.direction, -1e6, both);
  axpy(1, f, separate);
  axpy(-1e6, product, separate);
  EXPECT_LT(relativeDifference(separate, both), 1e-13) << "product in one pass, added";
}

inline void expectNoResultant(const FieldUnderTest& t, const Vector& f) {
  const Momentum momentum = momentumOf(t.x, f);
  EXPECT_LT(momentum.force, 1e-12);
  EXPECT_LT(momentum.torque, 1e-12);
}

}  // namespace stroma::test
