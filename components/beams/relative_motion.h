// SPDX-License-Identifier: LGPL-2.1-or-later
// Functions of the motion of one frame seen from another, with their derivatives carried along.
#pragma once
#include <Eigen/Core>
#include <cmath>

namespace stroma {

/// A number and its derivatives with respect to the six numbers of a relative motion.
struct Jet {
  double value = 0;
  Eigen::Matrix<double, 6, 1> slope = Eigen::Matrix<double, 6, 1>::Zero();
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
struct InverseTerm {
  double c, c1, c2;
  explicit InverseTerm(double s) {
    if (s < 0.05) {
      c = 1. / 12 + s * (1. / 720 + s * (1. / 30240 + s * (1. / 1209600 + s * (1. / 47900160 + s * 5.2841901e-10))));
      c1 = 1. / 720 + s * (2. / 30240 + s * (3. / 1209600 + s * (4. / 47900160 + s * 2.6420950e-9)));
      c2 = 2. / 30240 + s * (6. / 1209600 + s * (12. / 47900160 + s * 1.0568380e-8));
      return;
    }
    // a = x cot x with x = |r|/2, so that a' = (a - a^2 - s/4) / 2s
    const double x = std::sqrt(s) / 2, a = x / std::tan(x), a1 = (a - a * a - s / 4) / (2 * s);
    const double a2 = (a1 * (1 - 2 * a) - 0.25) / (2 * s) - a1 / s;
    c = (1 - a) / s, c1 = (-a1 - c) / s, c2 = (-a2 - 2 * c1) / s;
  }
};

/// dexp^-1(r) a, or with sign = 1 its transpose times a.
template <class T>
Triple<T> inverseTimes(const Triple<T>& r, const T& c, const Triple<T>& a, double sign = -1) {
  const Triple<T> once = cross(r, a);
  return a + T(sign * 0.5) * once + c * cross(r, once);
}

}  // namespace stroma
