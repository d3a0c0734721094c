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

/// A value, its derivatives a, b, c, d by the variables and the second ones aa, ab, ... of them.
template <class V, class A, class B, class C, class D, class AA, class AB, class AC, class AD, class BB, class BC,
          class BD, class CC, class CD, class DD>
struct Jet {
  V value;
  A a;
  B b;
  C c;
  D d;
  AA aa;
  AB ab;
  AC ac;
  AD ad;
  BB bb;
  BC bc;
  BD bd;
  CC cc;
  CD cd;
  DD dd;
};
template <class T>
constexpr bool is_jet = false;
template <class... T>
constexpr bool is_jet<Jet<T...>> = true;
template <class T>
concept AJet = is_jet<T>;
template <class T>
concept Number = is_number<T>;

/// Variable 0 (J), 1, 2 or 3 (invariants).
template <int index, Number T>
auto variable(const T& value) {
  const T one(1.);
  constexpr Zero o;
  if constexpr (index == 0)
    return Jet{value, one, o, o, o, o, o, o, o, o, o, o, o, o, o};
  else if constexpr (index == 1)
    return Jet{value, o, one, o, o, o, o, o, o, o, o, o, o, o, o};
  else if constexpr (index == 2)
    return Jet{value, o, o, one, o, o, o, o, o, o, o, o, o, o, o};
  else
    return Jet{value, o, o, o, one, o, o, o, o, o, o, o, o, o, o};
}

/// The jet with this value and f of the derivatives of x, or of x and y.
template <class T, AJet X>
auto mapped(const T& value, const X& x, auto&& f) {
  return Jet{value,   f(x.a),  f(x.b),  f(x.c),  f(x.d),  f(x.aa), f(x.ab), f(x.ac),
             f(x.ad), f(x.bb), f(x.bc), f(x.bd), f(x.cc), f(x.cd), f(x.dd)};
}
template <class T, AJet X, AJet Y>
auto mapped(const T& value, const X& x, const Y& y, auto&& f) {
  return Jet{value,         f(x.a, y.a),   f(x.b, y.b),   f(x.c, y.c),   f(x.d, y.d),
             f(x.aa, y.aa), f(x.ab, y.ab), f(x.ac, y.ac), f(x.ad, y.ad), f(x.bb, y.bb),
             f(x.bc, y.bc), f(x.bd, y.bd), f(x.cc, y.cc), f(x.cd, y.cd), f(x.dd, y.dd)};
}

template <AJet X, AJet Y>
auto operator+(const X& x, const Y& y) {
  return mapped(x.value + y.value, x, y, [](const auto& dx, const auto& dy) { return dx + dy; });
}
template <AJet X, AJet Y>
auto operator-(const X& x, const Y& y) {
  return mapped(x.value - y.value, x, y, [](const auto& dx, const auto& dy) { return dx - dy; });
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
             first(x.d, y.d),
             second(x.aa, y.aa, x.a, y.a, x.a, y.a),
             second(x.ab, y.ab, x.a, y.a, x.b, y.b),
             second(x.ac, y.ac, x.a, y.a, x.c, y.c),
             second(x.ad, y.ad, x.a, y.a, x.d, y.d),
             second(x.bb, y.bb, x.b, y.b, x.b, y.b),
             second(x.bc, y.bc, x.b, y.b, x.c, y.c),
             second(x.bd, y.bd, x.b, y.b, x.d, y.d),
             second(x.cc, y.cc, x.c, y.c, x.c, y.c),
             second(x.cd, y.cd, x.c, y.c, x.d, y.d),
             second(x.dd, y.dd, x.d, y.d, x.d, y.d)};
}
template <Number S, AJet X>
auto operator*(const S& s, const X& x) {
  return mapped(s * x.value, x, [&](const auto& dx) { return s * dx; });
}
template <AJet X, Number S>
auto operator*(const X& x, const S& s) {
  return s * x;
}
template <AJet X, Number S>
auto operator+(const X& x, const S& s) {
  return mapped(x.value + s, x, [](const auto& dx) { return dx; });
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
             df * x.d,
             second(x.aa, x.a, x.a),
             second(x.ab, x.a, x.b),
             second(x.ac, x.a, x.c),
             second(x.ad, x.a, x.d),
             second(x.bb, x.b, x.b),
             second(x.bc, x.b, x.c),
             second(x.bd, x.b, x.d),
             second(x.cc, x.c, x.c),
             second(x.cd, x.c, x.d),
             second(x.dd, x.d, x.d)};
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
  visit(x.a), visit(x.b), visit(x.c), visit(x.d), visit(x.aa), visit(x.ab), visit(x.ac), visit(x.ad);
  visit(x.bb), visit(x.bc), visit(x.bd), visit(x.cc), visit(x.cd), visit(x.dd);
}
/// How many derivatives are not always zero.
template <class V, class... D>
constexpr int derivativeCount(const Jet<V, D...>*) {
  return (int(NotZero<D>) + ...);
}

}  // namespace stroma::hyperelastic
