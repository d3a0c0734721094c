// SPDX-License-Identifier: LGPL-2.1-or-later
// Pairs of points, triangles and edges in exact arithmetic: squared distances as rational numbers, and motions that meet at a place and
// a time that are exact numbers, because points, weights and velocities are whole multiples of powers of two.
#pragma once
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <random>

#include "framework/collision/pair_distances.h"

namespace stroma::test::exact_pairs {

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& p);
std::array<Exact, 4> exact(const FourPoints& x);
Exact operator-(const Exact& a, const Exact& b);
Exact operator+(const Exact& a, const Exact& b);
Exact operator*(const Rational& s, const Exact& a);
Rational dot(const Exact& a, const Exact& b);
Exact cross(const Exact& a, const Exact& b);
Rational square(const Exact& a);

/// Squared distance of a point from a triangle, or of two segments.
Rational squaredDistance(PairKind kind, const std::array<Exact, 4>& x);

class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  int whole(int low, int high);
  /// Multiples of 2^-10 between -1 and 1.
  Vec3 point();

 private:
  std::mt19937 random_;
};

/// x + when dx has a point of both sides in common, exactly. `degenerate`: bits, see its definition.
void makeMeeting(Numbers& numbers, PairKind kind, unsigned degenerate, double& when, FourPoints& x, FourPoints& dx);

}  // namespace stroma::test::exact_pairs
