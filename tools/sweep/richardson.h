// SPDX-License-Identifier: LGPL-2.1-or-later
// Extrapolation to size zero, and how far it can be trusted. Values u_1, u_2, u_3 at sizes s_1 < s_2 < s_3 with the error
// C s^p have
//   |u_3 - u_2| / |u_2 - u_1| = (s_3^p - s_2^p) / (s_2^p - s_1^p),
// which gives p, and the limit is u_1 + d, d = (u_1 - u_2) / ((s_2 / s_1)^p - 1).
//
// The uncertainty of the limit is a factor times the correction |d|, as in Roache's grid convergence index. How large the
// factor has to be is a question of statistics: it is such that the truth lies inside in 95 of 100 sequences of a kind.
// Xing and Stern took the factor from 98 samples, as a function of p over the order of the method; here it is taken from
// sequences with errors of mixed orders, singular, locking, oscillating and noisy ones, each also unevenly refined
// (tests/sweep/test_grid_convergence.cpp shows the share of each kind). As in Eca and Hoekstra's procedure an order that
// the method cannot have is not believed, and the range of the data then sets the scale; a fourth value tells the scatter.
// Sources: P. J. Roache, Verification and Validation in Computational Science and Engineering, 1998; T. Xing and F. Stern,
// Factors of safety for Richardson extrapolation, J. Fluids Eng. 132, 2010; L. Eca and M. Hoekstra, A procedure for the
// estimation of the numerical uncertainty of CFD calculations based on grid refinement studies, J. Comput. Phys. 262, 2014.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace stroma::sweep {

/// The order p from the two differences, `fine` = |u_2 - u_1| and `coarse` = |u_3 - u_2|; none when no p from 0.1 to 10
/// fits.
std::optional<double> fittedOrder(double s1, double s2, double s3, double fine, double coarse);

/// What (u_1 - u_2) is multiplied with to get from u_1 to the limit.
double correctionFactor(double s1, double s2, double order);

/// The slope of log(error) over log(size), by least squares; none with fewer than two distinct sizes.
std::optional<double> slopeOf(const std::vector<double>& sizes, const std::vector<double>& errors);

/// Three neighbours of a line of runs, as their distances.
struct Triple {
  double s1, s2, s3;
  double fine, coarse, whole;  ///< |u_1 - u_2|, |u_2 - u_3|, |u_1 - u_3|
  double cosine;               ///< between (u_1 - u_2) and (u_2 - u_3)
  /// Of meshes whose spacing does not fall alike in all directions: by how much it falls from the second to the first in
  /// the direction where it falls least. 0: it falls alike.
  double least_refinement = 0;
};

/// The truth lies inside in 95 of 100 cases.
struct Margin {
  double size = 0;
  std::string how;  ///< half a sentence
};

struct Extrapolation {
  std::optional<double> order;  ///< fitted, where the differences follow one
  double factor = 0;            ///< the limit is u_1 + factor (u_1 - u_2)
  double correction = 0;        ///< |limit - u_1|; without a limit the difference to the next finest
  Margin of_limit, of_finest;   ///< around the limit; around u_1

  bool hasLimit() const { return factor > 0; }
};

/// From three values.
Extrapolation extrapolate(const Triple& finest);
/// From four: `apart` is the distance between the two limits, `next` the extrapolation without the finest value.
Extrapolation confirmed(Extrapolation finest, const Extrapolation& next, double apart);
/// From two: the order 1 is assumed, and what it leaves counts three times.
Extrapolation ofTwo(double s1, double s2, double difference);

}  // namespace stroma::sweep
