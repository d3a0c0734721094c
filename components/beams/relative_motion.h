// SPDX-License-Identifier: LGPL-2.1-or-later
// Functions of the motion of one frame seen from another, with their derivatives carried along.
#pragma once
#include <array>
#include <cmath>

#include "framework/fem/pack.h"

namespace stroma {

/// A number of each pair of a batch, and its derivatives with respect to the six numbers of the relative motion.
struct PackJet {
  Pack value;
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
/// A function of `at` from its value and its derivative there.
inline Pack chain(Pack, Pack value, Pack) { return value; }
inline PackJet chain(const PackJet& at, Pack value, Pack derivative) {
  PackJet result(value);
  for (std::size_t k = 0; k < 6; ++k) result.slope[k] = derivative * at.slope[k];
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

/// c(s) of dexp^-1(r) = I - [r]/2 + c [r]^2 as a function of s = |r|^2, and its first two derivatives: the series
/// sum of 2 zeta(2k)/(2 pi)^2k s^(k-1) up to s = 1, where what is left out is below round-off.
template <class T>
struct InverseTerm {
  T c{}, c1{}, c2{};
  InverseTerm() = default;
  explicit InverseTerm(T s) {
    constexpr std::array series{1. / 12,
                                1. / 720,
                                1. / 30240,
                                1. / 1209600,
                                1. / 47900160,
                                5.284190138687493e-10,
                                1.3382536530684679e-11,
                                3.389680296322583e-13,
                                8.586062056277845e-15,
                                2.1748686985580619e-16,
                                5.5090028283602295e-18,
                                1.3954464685812523e-19,
                                3.5347070396294675e-21};
    const auto is_large = s >= T(1.);
    c = T(series[12]), c1 = T(12 * series[12]), c2 = T(12 * 11 * series[12]);
#pragma GCC unroll 16
    for (int k = 11; k >= 0; --k) {
      const double term = series[std::size_t(k)];
      c = fma(c, s, T(term));
      if (k > 0) c1 = fma(c1, s, T(k * term));
      if (k > 1) c2 = fma(c2, s, T(k * (k - 1) * term));
    }
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
  /// The shortest of its rotation vectors, 2 asin(|v|)/|v| v where w is not negative. Up to a third of a turn without
  /// trigonometry: from a sixth on twice the one of half of the turn, (v/2w', w') with w' = sqrt((1 + w)/2).
  V3<T> logarithm() const {
    const T square = dot(v, v), cosine = abs(w);
    T factor = arcSine(square);
    if (const auto is_large = square > T(0.25); any(is_large)) {
      const T half = sqrt(fma(cosine, T(0.5), T(0.5)));
      T other = arcSine(T(0.5) - cosine * 0.5) / half;
      if (const auto is_larger = cosine < T(0.5); any(is_larger)) {
        using std::atan2;
        const T sine = sqrt(square);
        other = select(is_larger, atan2(sine, cosine) / sine, other);
      }
      factor = select(is_large, other, factor);
    }
    return v * (factor * select(w < T(0.), T(-2.), T(2.)));
  }

 private:
  /// asin(sqrt(s))/sqrt(s) for s up to 1/4, to 3e-17: the polynomial that is exact in the zeros of Chebyshev's of degree 13.
  static T arcSine(T s) {
    T sum(0.03187962140081284);
    for (const double term : {-0.016187392271599134, 0.019513468251252167, 0.0065293020047365695, 0.012170138592391726,
                              0.01388484282640208, 0.01735977964134998, 0.022371749733164054, 0.03038195969768514,
                              0.044642856805998936, 0.07500000000385201, 0.16666666666664942, 1.})
      sum = fma(sum, s, T(term));
    return sum;
  }
};

/// dexp^-1(r) a, or with sign = 1 its transpose times a.
template <class T>
Triple<T> inverseTimes(const Triple<T>& r, const T& c, const Triple<T>& a, double sign = -1) {
  const Triple<T> once = cross(r, a);
  return a + T(sign * 0.5) * once + c * cross(r, once);
}

}  // namespace stroma
