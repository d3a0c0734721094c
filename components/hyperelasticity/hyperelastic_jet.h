// SPDX-License-Identifier: LGPL-2.1-or-later
// A strain energy and its first two derivatives with respect to J and up to two invariants of C, from the energy alone.
// A law is written once as an expression of J and invariants; on plain numbers it is the energy, on jets it carries the
// derivatives along. A derivative that is zero whatever the numbers has the type Zero, and everything multiplied by it
// vanishes when the law is compiled: a sum of terms f(J) g(I) costs what it would written by hand.
#pragma once
#include <cmath>
#include <concepts>

#include "framework/fem/pack.h"

namespace stroma::hyperelastic {

using std::exp;
using std::log;

/// The number that is always zero.
struct Zero {};
template <class T>
concept NotZero = !std::same_as<T, Zero>;

inline Zero operator+(Zero, Zero) { return {}; }
inline Zero operator-(Zero, Zero) { return {}; }
inline Zero operator-(Zero) { return {}; }
inline Zero operator*(Zero, Zero) { return {}; }
template <NotZero T>
T operator+(Zero, const T& a) {
  return a;
}
template <NotZero T>
T operator+(const T& a, Zero) {
  return a;
}
template <NotZero T>
T operator-(const T& a, Zero) {
  return a;
}
template <NotZero T>
T operator-(Zero, const T& a) {
  return -a;
}
template <NotZero T>
Zero operator*(Zero, const T&) {
  return {};
}
template <NotZero T>
Zero operator*(const T&, Zero) {
  return {};
}

template <class T>
constexpr bool is_number = std::same_as<T, double> || std::same_as<T, Pack>;
/// s a, for a vector or matrix a.
template <NotZero S, class A>
A scaled(const S& s, const A& a) {
  return a * s;
}
template <class A>
Zero scaled(Zero, const A&) {
  return {};
}

/// A value, its derivatives a, b, c by the variables and the second ones aa, ab, ... of them.
template <class V, class A, class B, class C, class AA, class AB, class AC, class BB, class BC, class CC>
struct Jet {
  V value;
  A a;
  B b;
  C c;
  AA aa;
  AB ab;
  AC ac;
  BB bb;
  BC bc;
  CC cc;
};
template <class T>
constexpr bool is_jet = false;
template <class... T>
constexpr bool is_jet<Jet<T...>> = true;
template <class T>
concept AJet = is_jet<T>;
template <class T>
concept Number = is_number<T>;

/// Variable 0 (J), 1 or 2 (invariants).
template <int index, Number T>
auto variable(const T& value) {
  const T one(1.);
  constexpr Zero o;
  if constexpr (index == 0)
    return Jet{value, one, o, o, o, o, o, o, o, o};
  else if constexpr (index == 1)
    return Jet{value, o, one, o, o, o, o, o, o, o};
  else
    return Jet{value, o, o, one, o, o, o, o, o, o};
}

template <AJet X, AJet Y>
auto operator+(const X& x, const Y& y) {
  return Jet{x.value + y.value, x.a + y.a,   x.b + y.b,   x.c + y.c,   x.aa + y.aa,
             x.ab + y.ab,       x.ac + y.ac, x.bb + y.bb, x.bc + y.bc, x.cc + y.cc};
}
template <AJet X, AJet Y>
auto operator-(const X& x, const Y& y) {
  return Jet{x.value - y.value, x.a - y.a,   x.b - y.b,   x.c - y.c,   x.aa - y.aa,
             x.ab - y.ab,       x.ac - y.ac, x.bb - y.bb, x.bc - y.bc, x.cc - y.cc};
}
template <AJet X, AJet Y>
auto operator*(const X& x, const Y& y) {
  const auto first = [&](const auto& dx, const auto& dy) { return dx * y.value + x.value * dy; };
  const auto second = [&](const auto& xx, const auto& yy, const auto& x1, const auto& y1, const auto& x2,
                          const auto& y2) { return (xx * y.value + x.value * yy) + (x1 * y2 + x2 * y1); };
  return Jet{x.value * y.value,
             first(x.a, y.a),
             first(x.b, y.b),
             first(x.c, y.c),
             second(x.aa, y.aa, x.a, y.a, x.a, y.a),
             second(x.ab, y.ab, x.a, y.a, x.b, y.b),
             second(x.ac, y.ac, x.a, y.a, x.c, y.c),
             second(x.bb, y.bb, x.b, y.b, x.b, y.b),
             second(x.bc, y.bc, x.b, y.b, x.c, y.c),
             second(x.cc, y.cc, x.c, y.c, x.c, y.c)};
}
template <Number S, AJet X>
auto operator*(const S& s, const X& x) {
  return Jet{s * x.value, s * x.a, s * x.b, s * x.c, s * x.aa, s * x.ab, s * x.ac, s * x.bb, s * x.bc, s * x.cc};
}
template <AJet X, Number S>
auto operator*(const X& x, const S& s) {
  return s * x;
}
template <AJet X, Number S>
auto operator+(const X& x, const S& s) {
  return Jet{x.value + s, x.a, x.b, x.c, x.aa, x.ab, x.ac, x.bb, x.bc, x.cc};
}
template <AJet X, Number S>
auto operator-(const X& x, const S& s) {
  return x + (-s);
}
/// F(x), from F and its two derivatives at the value of x.
template <Number T, AJet X>
auto chain(const X& x, const T& f, const T& df, const T& ddf) {
  const auto second = [&](const auto& xx, const auto& x1, const auto& x2) { return df * xx + ddf * (x1 * x2); };
  return Jet{f,
             df * x.a,
             df * x.b,
             df * x.c,
             second(x.aa, x.a, x.a),
             second(x.ab, x.a, x.b),
             second(x.ac, x.a, x.c),
             second(x.bb, x.b, x.b),
             second(x.bc, x.b, x.c),
             second(x.cc, x.c, x.c)};
}
template <AJet X>
auto exp(const X& x) {
  const auto f = exp(x.value);
  return chain(x, f, f, f);
}
template <AJet X>
auto log(const X& x) {
  const decltype(x.value) inverse = 1. / x.value;
  return chain(x, log(x.value), inverse, -inverse * inverse);
}

/// (max(0, x))^2. The second derivative jumps from 0 to 2 at x = 0, where a fibre at rest is: within round-off of zero
/// it is that of a stretched fibre, so that a rest shape has one tangent however its positions are rounded.
template <Number T>
T squaredPositivePart(const T& x) {
  const T positive = maximum(x, T(0.));
  return positive * positive;
}
template <AJet X>
auto squaredPositivePart(const X& x) {
  using T = std::remove_cvref_t<decltype(x.value)>;
  const T positive = maximum(x.value, T(0.));
  return chain(x, positive * positive, 2. * positive, select(x.value > T(-1e-10), T(2.), T(0.)));
}

/// Calls f(derivative) for each derivative of a jet that is not always zero, in a fixed order.
template <AJet X, class F>
void forEachDerivative(X& x, F&& f) {
  const auto visit = [&](auto& d) {
    if constexpr (NotZero<std::remove_cvref_t<decltype(d)>>) f(d);
  };
  visit(x.a), visit(x.b), visit(x.c), visit(x.aa), visit(x.ab), visit(x.ac), visit(x.bb), visit(x.bc), visit(x.cc);
}
/// How many derivatives are not always zero.
template <class V, class... D>
constexpr int derivativeCount(const Jet<V, D...>*) {
  return (int(NotZero<D>) + ...);
}

}  // namespace stroma::hyperelastic
