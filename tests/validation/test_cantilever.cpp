// SPDX-License-Identifier: LGPL-2.1-or-later
// The fixed beam of Nesme et al. 2005 under so small a weight that linear theory holds, against Timoshenko's beam:
//   w(s) = q / 24EI (s^4 - 4 l^3 s + 3 l^4) + q (l^2 - s^2) / 2kGA,   s = l - x, k = 5/6.
// A linear tetrahedron bends too stiffly by a part that falls with h^2 and adds to EI, so 1/w is nearly affine in h^2:
// Richardson's extrapolation is made on 1/w.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

constexpr double length = 40, width = 4, height = 2, young = 20e3, weight = 1e-3;
constexpr double bending = young * width * height * height * height / 12;  // EI [N m2]
constexpr double load = weight * width * height;                           // q [N/m], density 1
constexpr double tip_bending = load * length * length * length * length / (8 * bending);
constexpr double tip = tip_bending + load * length * length / (2 * 5. / 6 * young / 2 * width * height);

std::string grid(int cells) { return fmt::format("/grid.n={} {} {}", 20 * cells + 1, cells + 1, cells + 1); }
double tipDeflection(const Settings& settings) {
  const Displacements d = oneStep("cantilever_distributed", settings);
  EXPECT_FALSE(d.report.diverged) << d.report.reason;
  EXPECT_TRUE(d.report.newton_converged) << d.report.reason;
  return -d.meanAt(length).z();
}

/// Deflections for growing numbers of cells over the height.
void expectSecondOrder(const std::string& cutting, const std::vector<int>& cells, double tolerance) {
  std::vector<double> w;
  for (int n : cells) {
    w.push_back(tipDeflection({grid(n), "/beam/cut.cutting=" + cutting}));
    fmt::print("{:5} {:2} cells over the height: tip {:.6f} m, error {:.2f} %\n", cutting, n, w.back(),
               100 * (1 - w.back() / tip));
  }
  for (std::size_t i = w.size() - 2; i < w.size(); ++i) {
    const double order = std::log((tip - w[i - 1]) / (tip - w[i])) / std::log(double(cells[i]) / cells[i - 1]);
    fmt::print("{:5} observed order from {} to {} cells: {:.3f}\n", cutting, cells[i - 1], cells[i], order);
    EXPECT_GT(order, 1.8);
    EXPECT_LT(order, 2.2);
  }
  const double n1 = cells[cells.size() - 2], n2 = cells.back();
  const double limit = (n2 * n2 - n1 * n1) / (n2 * n2 / w.back() - n1 * n1 / w[w.size() - 2]);
  fmt::print("{:5} extrapolated to h = 0: {:.6f} m, Timoshenko {:.6f} m, difference {:.2g}\n", cutting, limit, tip,
             limit / tip - 1);
  EXPECT_NEAR(limit / tip, 1, tolerance);
}

TEST(Cantilever, FiveTetsConvergeAtSecondOrderToTimoshenko) { expectSecondOrder("five", {4, 6, 8, 10}, 2e-4); }
TEST(Cantilever, SixTetsConvergeAtSecondOrderToTimoshenko) { expectSecondOrder("six", {6, 8, 10}, 5e-4); }
TEST(Cantilever, TenTetsConvergeAtSecondOrderToTimoshenko) { expectSecondOrder("ten", {6, 8, 10}, 5e-4); }

TEST(Cantilever, MethodsAgreeInTheSmallLoadLimit) {
  const double small = tipDeflection({"/beam/fem.method=small"});
  EXPECT_LT(small, tip);
  for (const std::string method : {"large", "polar", "svd", "nodal"})
    for (const std::string update : {"none", "B", "B and V"}) {
      if (method == "nodal" && update != "none") continue;
      Settings settings{"/beam/fem.method=" + method};
      if (update != "none") settings.push_back("/beam/fem.updateStiffnessMatrix=true");
      if (update == "B and V") settings.push_back("/beam/fem.updateVolume=true");
      const double w = tipDeflection(settings);
      fmt::print("{:6} update {:8} tip {:.8f} m, apart from small {:.1e}\n", method, update, w, w / small - 1);
      // what is left is of second order in the rotation, 1.6e-3
      EXPECT_NEAR(w / small, 1, 1e-5) << method << " " << update;
    }
}

/// Beam theory does not know Poisson's ratio: near 1/2 linear tetrahedra lock, with a mean dilatation they do not. The
/// clamp stops the cross-section from narrowing, which the theory leaves out and which costs a few percent.
TEST(Cantilever, MeanDilatationDoesNotLock) {
  const auto error = [](const std::string& cutting, const std::string& poisson, const std::string& dilatation) {
    const double w = tipDeflection({grid(6), "/beam/cut.cutting=" + cutting, "/beam/fem.poissonRatio=" + poisson,
                                    "/beam/fem.dilatation=" + dilatation,
                                    // at 0.499 the weight is so small that the forces' round-off is 1e-4 of it
                                    "/beam/solver.relative_residual_tolerance_threshold=1e-3"});
    fmt::print("{:4}, nu {:5}, {:5} dilatation: tip {:.1f} % too stiff\n", cutting, poisson, dilatation,
               100 * (1 - w / tip));
    return 1 - w / tip;
  };
  for (const std::string cutting : {"six", "ten"}) {
    const double compressible = error(cutting, "0", "mean");
    EXPECT_LT(error(cutting, "0.499", "mean"), compressible + 0.05);
    EXPECT_GT(error(cutting, "0.499", "local"), compressible + 0.25);
  }
}

using Curve = std::vector<std::pair<double, double>>;  ///< s [m], deflection [m]

Curve deflection(const std::string& cutting, const std::string& poisson) {
  const Displacements d =
      oneStep("cantilever_distributed", {"/beam/fem.poissonRatio=" + poisson, "/beam/cut.cutting=" + cutting, grid(6)});
  Curve out;
  for (double s = 0; s <= 36; s += 1) out.emplace_back(s, -d.meanAt(length - s).z());
  return out;
}

/// What is left of the deflection without its linear part, the tangent at the free end, from s = 10 m on.
Curve curvedPart(const Curve& w) {
  const double slope = w[0].second - w[1].second;
  Curve out;
  for (const auto& [s, value] : w)
    if (s >= 10) out.emplace_back(s, value - w[0].second + slope * s);
  return out;
}

double slopeOnLogAxes(const Curve& points) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [s, d] : points) {
    const double x = std::log(s), y = std::log(d);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

Curve theory() {
  Curve out;
  for (double s = 10; s <= 36; s += 1)
    out.emplace_back(s, load * (s * s * s * s / (24 * bending) - s * s / (2 * 5. / 6 * young / 2 * width * height)));
  return out;
}

TEST(Cantilever, CurvedPartFallsWithTheFourthPower) {
  const double expected = slopeOnLogAxes(theory());
  EXPECT_NEAR(expected, 4, 0.1);  // shear takes a little from the small s
  for (const std::string poisson : {"0", "0.3", "0.45"}) {
    const Curve points = curvedPart(deflection("ten", poisson));
    const double slope = slopeOnLogAxes(points);
    fmt::print("ten, nu {:4}: slope on log axes {:.3f} (Timoshenko {:.3f}), at s = 36 m {:.5f} m (theory {:.5f})\n",
               poisson, slope, expected, points.back().second, theory().back().second);
    EXPECT_NEAR(slope, expected, 0.03);
  }
}

/// The larger Poisson's ratio, the smaller the deflection: not beam theory, which does not know it, but the locking of
/// linear tetrahedra, so it holds where a cut locks. With five tetrahedra per cell 0.3 lies 0.1 % above 0.
TEST(Cantilever, DeflectionsAreOrderedByPoissonsRatio) {
  for (const std::string cutting : {"six", "ten"}) {
    Curve before;
    for (const std::string poisson : {"0", "0.3", "0.45"}) {
      const Curve w = deflection(cutting, poisson);
      fmt::print("{}, nu {:4}: tip {:.6f} m\n", cutting, poisson, w[0].second);
      for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_LT(w[i].second, before[i].second) << "at s = " << w[i].first;
      before = w;
    }
  }
}

}  // namespace
}  // namespace stroma::test
