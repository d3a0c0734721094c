// SPDX-License-Identifier: LGPL-2.1-or-later
// Values that spread in tetrahedra against closed forms of the heat equation.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

/// A bar of `cells` cubes, each cut into tetrahedra, of the length 1 along x; values from `start`(x), those at both ends held.
template <class Start>
std::string bar(int cells, Start&& start, const std::string& field, const std::string& solver = "firstOrder='true'", double dt = 1e-3) {
  std::string values, ends;
  for (int node = 0; node < 4 * (cells + 1); ++node) {
    const int i = node % (cells + 1);
    values += fmt::format("{:.17g} ", start(double(i) / cells));
    if (i == 0 || i == cells) ends += fmt::format("{} ", node);
  }
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0">
      <RegularGridTopology name="grid" n="{} 2 2" min="0 0 0" max="1 {} {}"/>
      <TetrahedronSetTopologyContainer name="cells"/><Hexa2TetraTopologicalMapping input="@grid" output="@cells"/>
      <MechanicalObject name="places" position="@grid.position"/>
      <Node name="heat"><EulerImplicitSolver {}/><SparseLDLSolver/><MechanicalObject name="T" template="Vec1" position="{}"/>
        <DiagonalMass massDensity="2" topology="@../cells" geometryState="@../places"/><FixedProjectiveConstraint indices="{}"/>
        <TetrahedronDiffusionFEMForceField topology="@../cells" {}/></Node></Node>)",
                     dt, cells + 1, 1. / cells, 1. / cells, solver, values, ends, field);
}

double largestError(Simulation& simulation, int cells, const std::function<double(double)>& exact) {
  const State& state = *simulation.systems()[0]->states()[0];
  double error = 0;
  for (Index node = 0; node < state.size(); ++node)
    error = std::max(error, std::abs(Vec3(state.x()[node])[0] - exact(double(node % (cells + 1)) / cells)));
  return error;
}

/// What has come to rest between two held ends is linear, to round-off.
TEST(TetrahedronDiffusion, RestIsLinear) {
  Simulation simulation = simulationFromText(bar(6, [](double x) { return x == 0 ? 1 : x == 1 ? 4 : 0.; }, "", "firstOrder='true'", 1e3));
  for (int step = 0; step < 8; ++step) simulation.step();
  EXPECT_LT(largestError(simulation, 6, [](double x) { return 1 + 3 * x; }), 1e-10);
}

/// sin(pi x) decays with the rate D pi^2 / rho; the error falls with the square of the size of the cells.
TEST(TetrahedronDiffusion, ASineDecaysAtItsRate) {
  const double pi = std::numbers::pi, rate = 0.5 * pi * pi / 2, dt = 1e-3, steps = 100;
  const auto error = [&](int cells) {
    Simulation simulation =
        simulationFromText(bar(cells, [&](double x) { return std::sin(pi * x); }, "constantDiffusionCoefficient='0.5'"));
    for (int step = 0; step < steps; ++step) simulation.step();
    const double left = std::pow(1 + rate * dt, -steps);  // of backward Euler
    return largestError(simulation, cells, [&](double x) { return left * std::sin(pi * x); });
  };
  const double coarse = error(8), fine = error(16);
  EXPECT_LT(coarse, 0.02);
  EXPECT_GT(coarse, 1e-5);
  EXPECT_NEAR(coarse / fine, 4, 0.6);
}

/// D of each tetrahedron: twice as much in one half of a bar, half the slope there.
TEST(TetrahedronDiffusion, EachTetrahedronHasItsOwn) {
  std::string each;
  for (int cell = 0; cell < 4; ++cell)
    for (int tetrahedron = 0; tetrahedron < 6; ++tetrahedron) each += cell < 2 ? "1 " : "2 ";
  Simulation simulation = simulationFromText(bar(4, [](double x) { return x < 1 ? 0. : 3.; },
                                                 "tetrahedronDiffusionCoefficient='" + each + "'", "firstOrder='true'", 1e3));
  for (int step = 0; step < 8; ++step) simulation.step();
  EXPECT_LT(largestError(simulation, 4, [](double x) { return x < 0.5 ? 4 * x : 1 + 2 * x; }), 1e-10);
}

/// What varies along fibres spreads as many times as quickly, and what varies across them as without.
TEST(TetrahedronDiffusion, FibresLeadAlongThemAlone) {
  const auto after = [](const std::string& field) {
    Simulation simulation = simulationFromText(bar(5, [](double x) { return x * x; }, field));
    for (int step = 0; step < 30; ++step) simulation.step();
    const State& state = *simulation.systems()[0]->states()[0];
    std::vector<double> values;
    for (Index node = 0; node < state.size(); ++node) values.push_back(Vec3(state.x()[node])[0]);
    return values;
  };
  const std::string fibres = "constantDiffusionCoefficient='0.5' anisotropyRatio='3' transverseAnisotropyArray=";
  const auto along = after(fibres + "'1 0 0'"), across = after(fibres + "'0 0.6 0.8'");
  const auto three = after("constantDiffusionCoefficient='1.5'"), one = after("constantDiffusionCoefficient='0.5'");
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(along[i], three[i], 1e-12);
    EXPECT_NEAR(across[i], one[i], 1e-12);
  }
  EXPECT_GT(std::abs(three[2] - one[2]), 1e-3);
}

TEST(TetrahedronDiffusion, SaysWhatDoesNotFit) {
  const auto told = [](const std::string& field) { return problemsOf(bar(1, [](double x) { return x; }, field)); };
  expectContains(told("anisotropyRatio='2'"), "transverseAnisotropyArray has 0 directions for 6 tetrahedra");
  expectContains(told("tetrahedronDiffusionCoefficient='1 2'"), "2 values for ");
  EXPECT_EQ(told("anisotropyRatio='0.1' transverseAnisotropyArray='0 0 1'"), "");
  expectContains(told("anisotropyRatio='0.1' transverseAnisotropyArray='0 0 2'"), "has the length 2");
  expectContains(problemsOf("<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/>"
                            "<TetrahedronSetTopologyContainer position='0 0 0 1 0 0 "
                            "0 1 0 0 0 1' tetrahedra='0 1 2 3'/><MechanicalObject/><UniformMass totalMass='1'/>"
                            "<TetrahedronDiffusionFEMForceField/></Node>"),
                 "are no single numbers");
  // places that are no points, and a cell without volume: told of this component, before anything runs
  const auto lies = [](const std::string& places, const std::string& link) {
    return problemsOf("<Node name='root'><TetrahedronSetTopologyContainer name='cells' position='0 0 0  1 0 0  0 1 0  0 0 1' "
                      "tetrahedra='0 1 2 3'/><MechanicalObject name='places' " + places + "/><Node name='heat'>"
                      "<EulerImplicitSolver firstOrder='true'/><SparseLDLSolver/><MechanicalObject name='T' template='Vec1' "
                      "position='1 0 0 0'/><UniformMass vertexMass='1'/><TetrahedronDiffusionFEMForceField name='spread' "
                      "topology='@../cells' constantDiffusionCoefficient='1' mechanicalObject='" + link + "'/></Node></Node>");
  };
  const std::string points = "position='0 0 0  1 0 0  0 1 0  0 0 1'";
  EXPECT_EQ(lies(points, "@../places"), "");
  const std::string frames = lies("template='Rigid3' position='0 0 0 0 0 0 1  1 0 0 0 0 0 1  0 1 0 0 0 0 1  0 0 1 0 0 0 1'", "@../places");
  expectContains(frames, "/heat/spread");
  expectContains(frames, "the nodes of /places are no points");
  expectContains(lies(points, "@T"), "the nodes of /heat/T are no points");
  const std::string inverted = lies("position='0 0 0  0 1 0  1 0 0  0 0 1'", "@../places");
  expectContains(inverted, "/heat/spread");
  expectContains(inverted, "tetrahedron 0 has a volume of -0.167");
}

}  // namespace
}  // namespace stroma::test
