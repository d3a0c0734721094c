// SPDX-License-Identifier: LGPL-2.1-or-later
// Functions of the motion of one frame seen from another, with their derivatives carried along.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>

#include "framework/fem/pack.h"

namespace stroma {

/// A number and its derivatives with respect to the six numbers of a relative motion; there is room for eight, which fill registers.
struct Jet {
  double value = 0;
  Eigen::Matrix<double, 8, 1> slope = Eigen::Matrix<double, 8, 1>::Zero();
  Jet() = default;
  Jet(double number) : value(number) {}
  Jet(double number, int variable) : value(number) { slope[variable] = 1; }
};
inline Jet operator+(Jet a, const Jet& b) { return a.value += b.value, a.slope += b.slope, a; }
inline Jet operator-(Jet a, const Jet& b) { return a.value -= b.value, a.slope -= b.slope, a; }
inline Jet operator*(const Jet& a, const Jet& b) {
  Jet product(a.value * b.value);
  product.slope = a.value * b.slope + b.value * a.slope;
  return product;
}
/// The same of a pack of relative motions.
struct PackJet {
  Pack value{0.};
  std::array<Pack, 6> slope;
  PackJet() : PackJet(0.) {}
  PackJet(double number) : PackJet(Pack(number)) {}
  PackJet(Pack number) : value(number) { slope.fill(Pack(0.)); }
  PackJet(Pack number, int variable) : PackJet(number) { slope[std::size_t(variable)] = Pack(1.); }
};
inline PackJet operator+(PackJet a, const PackJet& b) {
  a.value += b.value;
  for (std::size_t k = 0; k < 6; ++k) a.slope[k] += b.slope[k];
  return a;
}
inline PackJet operator-(PackJet a, const PackJet& b) {
  a.value -= b.value;
  for (std::size_t k = 0; k < 6; ++k) a.slope[k] -= b.slope[k];
  return a;
}
inline PackJet operator*(const PackJet& a, const PackJet& b) {
  PackJet product(a.value * b.value);
  for (std::size_t k = 0; k < 6; ++k) product.slope[k] = fma(a.value, b.slope[k], b.value * a.slope[k]);
  return product;
}
inline Pack valueOf(Pack number) { return number; }
inline Pack valueOf(const PackJet& jet) { return jet.value; }
inline Pack chain(Pack, Pack value, Pack) { return value; }
inline PackJet chain(const PackJet& at, Pack value, Pack derivative) {
  PackJet result(value);
  for (std::size_t k = 0; k < 6; ++k) result.slope[k] = derivative * at.slope[k];
  return result;
}
inline double valueOf(double number) { return number; }
inline double valueOf(const Jet& jet) { return jet.value; }
/// A function of `at` from its value and its derivative there.
inline double chain(double, double value, double) { return value; }
inline Jet chain(const Jet& at, double value, double derivative) {
  Jet result(value);
  result.slope = derivative * at.slope;
  return result;
}

template <class T>
struct Triple {
  T x, y, z;
};
template <class T>
Triple<T> operator+(const Triple<T>& a, const Triple<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Triple<T> operator-(const Triple<T>& a, const Triple<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Triple<T> operator*(const T& s, const Triple<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
T dot(const Triple<T>& a, const Triple<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Triple<T> cross(const Triple<T>& a, const Triple<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// c(s) of dexp^-1(r) = I - [r]/2 + c [r]^2 as a function of s = |r|^2, and its first two derivatives.
template <class T>
struct InverseTerm {
  T c{}, c1{}, c2{};
  InverseTerm() = default;
  explicit InverseTerm(T s) {
    const auto is_large = s >= T(0.05);
    c = 1. / 12 + s * (1. / 720 + s * (1. / 30240 + s * (1. / 1209600 + s * (1. / 47900160 + s * 5.2841901e-10))));
    c1 = 1. / 720 + s * (2. / 30240 + s * (3. / 1209600 + s * (4. / 47900160 + s * 2.6420950e-9)));
    c2 = 2. / 30240 + s * (6. / 1209600 + s * (12. / 47900160 + s * 1.0568380e-8));
    if (!any(is_large)) return;
    // a = x cot x with x = |r|/2, so that a' = (a - a^2 - s/4) / 2s
    using std::tan;
    const T x = sqrt(s) * 0.5, a = x / tan(x), a1 = (a - a * a - s * 0.25) / (2. * s);
    const T a2 = (a1 * (1. - 2. * a) - 0.25) / (2. * s) - a1 / s;
    const T far = (1. - a) / s, far1 = (-a1 - far) / s;
    c = select(is_large, far, c), c1 = select(is_large, far1, c1), c2 = select(is_large, (-a2 - 2. * far1) / s, c2);
  }
};

/// An orientation as a unit quaternion.
template <class T>
struct Orientation {
  V3<T> v;
  T w;
  Orientation operator*(const Orientation& b) const { return {fma(w, b.v, fma(b.w, v, cross(v, b.v))), w * b.w - dot(v, b.v)}; }
  Orientation conjugate() const { return {-v, w}; }
  M3<T> axes() const {
    const V3<T> twice = v + v;
    const T xx = twice.x * v.x, yy = twice.y * v.y, zz = twice.z * v.z, xy = twice.x * v.y, yz = twice.y * v.z,
            zx = twice.z * v.x, wx = twice.x * w, wy = twice.y * w, wz = twice.z * w;
    return {{1. - yy - zz, xy + wz, zx - wy}, {xy - wz, 1. - xx - zz, yz + wx}, {zx + wy, yz - wx, 1. - xx - yy}};
  }
  /// The shortest of its rotation vectors.
  V3<T> logarithm() const {
    const T square = dot(v, v);
    const auto is_large = square >= T(0.01);
    T sum(0.);  // asin(s)/s, of which the first term that is left out is below 1e-17
    for (const double term : {143. / 10240, 231. / 13312, 63. / 2816, 35. / 1152, 5. / 112, 3. / 40, 1. / 6, 1.})
      sum = fma(sum, square, T(term));
    using std::atan2;
    if (any(is_large)) {
      const T sine = sqrt(square);
      sum = select(is_large, atan2(sine, abs(w)) / sine, sum);
    }
    return v * (sum * select(w < T(0.), T(-2.), T(2.)));
  }
};

/// dexp^-1(r) a, or with sign = 1 its transpose times a.
template <class T>
Triple<T> inverseTimes(const Triple<T>& r, const T& c, const Triple<T>& a, double sign = -1) {
  const Triple<T> once = cross(r, a);
  return a + T(sign * 0.5) * once + c * cross(r, once);
}

}  // namespace stroma
