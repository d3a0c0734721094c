// SPDX-License-Identifier: LGPL-2.1-or-later
// The end-loaded cantilever in large deflection against the elastica, EI theta'' = -P cos theta, theta(0) = 0,
// theta'(L) = 0, here by shooting. A mesh of linear tetrahedra is stiffer in bending than the beam: its own EI is taken
// from a run with a load so small that linear theory holds, which leaves the error of the large rotation alone; and
// meshes are refined to see the error of bending go.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

struct Tip {
  double drop = 0, x = 0;  ///< of the length
};

/// theta'(L) for theta'(0) = k, and where the tip is: Runge-Kutta of fourth order.
double shoot(double load, double k, Tip& tip) {
  using Four = std::array<double, 4>;  // theta, theta', x, drop
  const auto rate = [load](const Four& y) {
    return Four{y[1], -load * std::cos(y[0]), std::cos(y[0]), std::sin(y[0])};
  };
  const auto plus = [](const Four& y, double s, const Four& d) {
    return Four{y[0] + s * d[0], y[1] + s * d[1], y[2] + s * d[2], y[3] + s * d[3]};
  };
  Four y{0, k, 0, 0};
  const int steps = 500;  // to 1e-10
  const double h = 1. / steps;
  for (int i = 0; i < steps; ++i) {
    const Four a = rate(y), b = rate(plus(y, h / 2, a)), c = rate(plus(y, h / 2, b)), d = rate(plus(y, h, c));
    y = plus(plus(plus(plus(y, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  tip = {y[3], y[2]};
  return y[1];
}

/// load: P L^2 / EI
Tip elastica(double load) {
  Tip tip;
  double low = 0, high = load;  // theta'(L) grows with theta'(0); a straight beam would need k = load
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (shoot(load, middle, tip) > 0 ? high : low) = middle;
  }
  return tip;
}

Settings mesh(int cells) { return {fmt::format("/grid.n={} 2 {}", 50 * cells + 1, cells + 1)}; }
Tip bend(double load, Settings settings) {
  settings.push_back(fmt::format("/beam/pull.totalForce=0 0 {}", -0.016 * load));
  const Displacements d = oneStep("elastica", settings);
  EXPECT_FALSE(d.report.diverged) << d.report.reason;
  EXPECT_TRUE(d.report.newton_converged) << d.report.reason;
  const Vec3 u = d.meanAt(1);
  return {-u.z(), 1 + u.x()};
}
/// EI of the mesh over EI of the beam, from w = P L^3 / 3EI.
double stiffening(const Settings& settings) {
  Settings small = settings;
  small.push_back("/beam/fem.method=small");
  // the load is so small that the residual cannot fall further
  small.push_back("/beam/solver.relative_residual_tolerance_threshold=1e-5");
  return 0.01 / 3 / bend(0.01, small).drop;
}

TEST(Elastica, ShootingGivesThePublishedNumbers) {
  const double published[5][3] = {
      {1, .30172, .94357}, {2, .49346, .83936}, {3, .60325, .74558}, {5, .71379, .61237}, {10, .81061, .44500}};
  for (const auto& [load, drop, x] : published) {
    EXPECT_NEAR(elastica(load).drop, drop, 1e-5);
    EXPECT_NEAR(elastica(load).x, x, 1e-5);
  }
}

struct Variant {
  std::string method, update;
};
/// The name of the test, which must not hold an address.
void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.method << " " << variant.update; }
class ElasticaOfMethod : public testing::TestWithParam<Variant> {};

TEST_P(ElasticaOfMethod, FollowsTheElasticaOfTheMeshsOwnStiffness) {
  Settings settings = mesh(4);
  const double stiffer = stiffening(settings);
  settings.push_back("/beam/fem.method=" + GetParam().method);
  if (GetParam().update != "none") settings.push_back("/beam/fem.updateStiffnessMatrix=true");
  if (GetParam().update == "BV") settings.push_back("/beam/fem.updateVolume=true");
  for (double load : {1, 2, 3, 5, 10}) {
    const Tip tip = bend(load, settings), expected = elastica(load / stiffer);
    fmt::print("{:5} {:4} PL2/EI {:2}: drop {:.5f} (elastica {:.5f}), x {:.5f} ({:.5f})\n", GetParam().method,
               GetParam().update, load, tip.drop, expected.drop, tip.x, expected.x);
    const double apart = std::max(std::abs(tip.drop - expected.drop), std::abs(tip.x - expected.x));
    // The strip is not infinitely thin: shear and stretch are of the order (h/L)^2 = 4e-4. The QR frame with a constant
    // B makes torques of its own, which show here.
    const bool has_torques = GetParam().method == "large" && GetParam().update == "none";
    EXPECT_LT(apart, has_torques ? 1.2e-2 : 1e-3) << load;
    if (has_torques) {
      EXPECT_GT(apart, 2e-3) << load;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ElasticaOfMethod,
                         testing::Values(Variant{"large", "none"}, Variant{"large", "B"}, Variant{"large", "BV"},
                                         Variant{"polar", "none"}, Variant{"polar", "B"}, Variant{"polar", "BV"},
                                         Variant{"svd", "none"}, Variant{"svd", "B"}, Variant{"svd", "BV"}),
                         [](const auto& tested) { return tested.param.method + "_" + tested.param.update; });

TEST(Elastica, RefinementReachesTheElasticaItself) {
  for (double load : {1, 10}) {
    const Tip expected = elastica(load);
    double before = 1;
    Tip coarse, fine;
    for (int cells : {2, 4, 8}) {
      coarse = fine;
      fine = bend(load, mesh(cells));
      const double error = std::abs(fine.drop - expected.drop);
      fmt::print("PL2/EI {:2}, {} cells over the thickness: drop {:.5f}, x {:.5f}, error {:.5f}\n", load, cells,
                 fine.drop, fine.x, error);
      EXPECT_LT(error, before / 2.5);
      before = error;
    }
    const double limit = fine.drop + (fine.drop - coarse.drop) / 3;
    fmt::print("PL2/EI {:2}: extrapolated drop {:.5f}, elastica {:.5f}\n", load, limit, expected.drop);
    EXPECT_NEAR(limit, expected.drop, 1e-3);
  }
}

/// The torques of the QR frame with a constant B are of the order of stress times strain, add up along the beam, and do
/// not fall with the size of the elements.
TEST(Elastica, LargeWithAConstantBConvergesToSomethingElse) {
  const auto limit = [](const std::string& update) {
    double drop[2];
    for (int i = 0; i < 2; ++i) {
      Settings settings = mesh(4 << i);
      settings.push_back("/beam/fem.method=large");
      settings.push_back("/beam/fem.updateStiffnessMatrix=" + update);
      drop[i] = bend(5, settings).drop;
    }
    fmt::print("large, update {:5}: drop {:.5f}, {:.5f}, extrapolated {:.4f}, elastica {:.4f}\n", update, drop[0],
               drop[1], drop[1] + (drop[1] - drop[0]) / 3, elastica(5).drop);
    return drop[1] + (drop[1] - drop[0]) / 3;
  };
  EXPECT_NEAR(limit("true"), elastica(5).drop, 1e-3);
  EXPECT_GT(limit("false"), elastica(5).drop + 5e-3);
}

}  // namespace
}  // namespace stroma::test
