// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>

namespace stroma::test {

/// A double that counts the operations done with it: + - * / and a square root one each, a multiply-add two;
/// comparisons, selections, signs and absolute values none.
struct Counted {
  double value = 0;
  Counted() = default;
  explicit Counted(double v) : value(v) {}
  static inline long flops = 0;
};
inline Counted counted(double value, int flops) {
  Counted::flops += flops;
  return Counted(value);
}
inline Counted operator+(Counted a, Counted b) { return counted(a.value + b.value, 1); }
inline Counted operator-(Counted a, Counted b) { return counted(a.value - b.value, 1); }
inline Counted operator*(Counted a, Counted b) { return counted(a.value * b.value, 1); }
inline Counted operator/(Counted a, Counted b) { return counted(a.value / b.value, 1); }
inline Counted operator-(Counted a) { return Counted(-a.value); }
inline Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
inline Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
inline bool operator<(Counted a, Counted b) { return a.value < b.value; }
inline bool operator>(Counted a, Counted b) { return a.value > b.value; }
inline bool operator<=(Counted a, Counted b) { return a.value <= b.value; }
inline Counted fma(Counted a, Counted b, Counted c) { return counted(a.value * b.value + c.value, 2); }
inline Counted sqrt(Counted a) { return counted(std::sqrt(a.value), 1); }
inline Counted reciprocalSqrt(Counted a) { return counted(1 / std::sqrt(a.value), 2); }
inline Counted roughFourthRoot(Counted a) { return counted(std::sqrt(std::sqrt(a.value)), 2); }
inline Counted abs(Counted a) { return Counted(std::abs(a.value)); }
inline Counted maximum(Counted a, Counted b) { return a.value < b.value ? b : a; }
inline Counted select(bool condition, Counted a, Counted b) { return condition ? a : b; }

}  // namespace stroma::test
