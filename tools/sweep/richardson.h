// SPDX-License-Identifier: LGPL-2.1-or-later
// Extrapolation to size zero. Values u_1, u_2, u_3 at sizes s_1 < s_2 < s_3 with the error C s^p have
//   |u_3 - u_2| / |u_2 - u_1| = (s_3^p - s_2^p) / (s_2^p - s_1^p),
// which gives p, and the limit is u_1 + (u_1 - u_2) / ((s_2 / s_1)^p - 1).
// Source: Roache, Verification and Validation in Computational Science and Engineering, 1998.
#pragma once
#include <optional>
#include <vector>

namespace stroma::sweep {

/// The order p from the two differences, `fine` = |u_2 - u_1| and `coarse` = |u_3 - u_2|; none when no p from 0.1 to 10
/// fits.
std::optional<double> fittedOrder(double s1, double s2, double s3, double fine, double coarse);

/// What (u_1 - u_2) is multiplied with to get from u_1 to the limit.
double correctionFactor(double s1, double s2, double order);

/// The slope of log(error) over log(size), by least squares; none with fewer than two distinct sizes.
std::optional<double> slopeOf(const std::vector<double>& sizes, const std::vector<double>& errors);

}  // namespace stroma::sweep
