// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/fem/pack.h"

namespace stroma {

/// Between the kernels' vectors and matrices (V3, M3 by columns, S3 symmetric) and Eigen's, for one element at a time:
/// in checks, fields for output and tests, never in a loop over packs.
inline V3<double> vectorOf(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 toEigen(const V3<double>& v) { return {v.x, v.y, v.z}; }
inline M3<double> fromEigen(const Mat3& m) { return {vectorOf(m.col(0)), vectorOf(m.col(1)), vectorOf(m.col(2))}; }
inline Mat3 toEigen(const M3<double>& m) {
  Mat3 out;
  out << toEigen(m.c0), toEigen(m.c1), toEigen(m.c2);
  return out;
}
inline Mat3 toEigen(const S3<double>& s) {
  Mat3 out;
  out << s.xx, s.xy, s.zx, s.xy, s.yy, s.yz, s.zx, s.yz, s.zz;
  return out;
}

}  // namespace stroma
