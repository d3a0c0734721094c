// SPDX-License-Identifier: LGPL-2.1-or-later
// Published problems: Cook's membrane by a law that this test adds itself, as a module outside the tree would, and the
// deforming bar of Land et al. 2015.
#include <fmt/format.h>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "components/hyperelasticity/hyperelastic_kernels.h"
#include "components/hyperelasticity/point_kernels.h"
#include "components/hyperelasticity/point_law.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace stroma::hyperelastic;

/// The law of deal.II's code gallery, "Quasi-static finite-strain compressible elasticity", W = mu/2 (J^-2/3 I1 - 3) +
/// k/4 (J^2 - 1 - 2 ln J).
struct IsochoricNeoHookean {
  using Set = First;
  template <class T>
  struct Parameters {
    T mu, bulk;
  };
  static auto energy(const auto& J, const auto& I1, const auto& p) {
    const auto L = log(J);
    return 0.5 * p.mu * (exp((-2. / 3) * L) * I1 - 3.) + 0.25 * p.bulk * (J * J - 1. - 2. * L);
  }
};

/// A law of the test's own, and a field that knows it: the module has its own list of laws and kernels.
void offerLaw() {
  pointKernels().hexahedra = pointLawOf<HexahedronPoints>;
  HyperelasticLaw law =
      lawOf<IsochoricNeoHookean>("IsochoricNeoHookean", "mu/2 (J^-2/3 I1 - 3) + bulk/4 (J^2 - 1 - 2 ln J)",
                                 {{"mu", "Pa", "shear modulus", true}, {"bulk", "Pa", "bulk modulus", true}});
  law.infinite_at_zero = true;
  offerHyperelasticLaw(law);
  factory().add<HyperelasticForceField>("HexahedraWithALawOfTheTest", "",
                                        [](auto& field) { field.kind = &cell_kinds::hexahedron; });
}

/// n x n cells, one over the thickness of 1 mm; z held everywhere, traction of 62.5 kPa upwards on the right edge.
std::string cook(int n) {
  std::string position, cells, held;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n, t = double(j) / n, low = 44 * s, high = 44 + 16 * s;
        position += fmt::format("{} {} {} ", 0.048 * s, 1e-3 * (low + t * (high - low)), 0.001 * k);
        if (i == 0) held += fmt::format("{} ", node(i, j, k));
        if (k > 0 || i == n || j == n) continue;
        for (int c : {node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0), node(i, j, 1),
                      node(i + 1, j, 1), node(i + 1, j + 1, 1), node(i, j + 1, 1)})
          cells += fmt::format("{} ", c);
      }
  std::string forces, loaded;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j) {
      const double length = 0.016 / n * (j == 0 || j == n ? 0.5 : 1);
      loaded += fmt::format("{} ", node(n, j, k));
      forces += fmt::format("0 {} 0 ", 62.5e3 * length * 0.0005);
    }
  const double mu = 422.5e3, bulk = 2 * mu * 1.3 / (3 * 0.4);
  return fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver newton_iterations="60"/><SparseLDLSolver/>
  <MeshTopology position="{}" hexahedra="{}"/><MechanicalObject/><UniformMass totalMass="1"/>
  <FixedProjectiveConstraint indices="{}"/><PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 0 1"/>
  <ConstantForceField indices="{}" forces="{}"/>
  <HexahedraWithALawOfTheTest materialName="IsochoricNeoHookean" mu="{}" bulk="{}"/></Node>)",
      position, cells, held, loaded, forces, mu, bulk);
}

TEST(HyperelasticBenchmarks, CooksMembrane) {
  offerLaw();
  const std::pair<int, double> published[] = {{2, 8.638}, {4, 12.07}, {8, 13.86}, {16, 14.49}};
  for (const auto& [n, expected] : published) {
    Simulation simulation = simulationFromText(cook(n));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const System& system = *simulation.systems()[0];
    const auto& rest = simulation.states()[0]->rest_position;
    // (48, 52) is a node for every even n
    double up = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (rest[i].x() > 0.0479 && std::abs(rest[i].y() - 0.052) < 1e-6) up = system.x[Index(i)].y() - rest[i].y();
    std::printf("Cook's membrane %2d x %2d: %.3f mm (published %.4g)\n", n, n, up * 1e3, expected);
    EXPECT_NEAR(up * 1e3, expected, 0.005);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
