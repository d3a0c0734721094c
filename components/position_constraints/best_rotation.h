// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>

#include "framework/fem/local_frame.h"

namespace stroma {

/// The best rotation of A = sum p q^T, p current and q at rest.
inline Mat3 bestRotation(const Mat3& a) {
  const double scale = 1 / std::max(a.norm(), 1e-300);
  const auto column = [&](int c) { return V3<double>{a(0, c) * scale, a(1, c) * scale, a(2, c) * scale}; };
  const M3<double> r = local_frame::bestRotation(M3<double>{column(0), column(1), column(2)});
  Mat3 out;
  out << r.c0.x, r.c1.x, r.c2.x, r.c0.y, r.c1.y, r.c2.y, r.c0.z, r.c1.z, r.c2.z;
  return out;
}

}  // namespace stroma
