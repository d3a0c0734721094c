// SPDX-License-Identifier: LGPL-2.1-or-later
// Motions of textbooks with closed answers, as a user writes them: a bar that hits a wall, a block that sticks and slips, a stress that
// relaxes while the strain is large, a pendulum with a wide swing, tissue that gives off its fluid sideways.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/meshes.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double pi = std::numbers::pi;

template <class List>
std::string flat(const List& list) {
  std::string out;
  for (const auto& item : list)
    for (const auto& number : item) out += fmt::format("{:.17g} ", double(number));
  return out;
}
std::string chosen(const Mesh& mesh, const std::function<bool(const Vec3&)>& choose) {
  std::string out;
  for (std::size_t i = 0; i < mesh.position.size(); ++i)
    if (choose(mesh.position[i])) out += fmt::format("{} ", i);
  return out;
}
Mesh block(int n, int m, int l, const std::function<Vec3(const Vec3&)>& map) {
  Mesh mesh = gridMesh(n, m, l);
  for (Vec3& p : mesh.position) p = map(p.cwiseQuotient(Vec3(n, m, l)));
  return mesh;
}
std::string cells(const Mesh& mesh) {
  return fmt::format(R"(<MeshTopology name="mesh" position="{}" hexahedra="{}"/>)", flat(mesh.position), flat(mesh.hexahedra));
}
void step(Simulation& simulation) {
  const StepReport report = simulation.step();
  ASSERT_TRUE(!report.failed() && !report.unsolved) << report.reason;
}
const std::vector<Vec3>& vectorsOf(const Simulation& simulation, const char* path, const char* name) {
  return *std::get<std::vector<Vec3>*>(findComponent(simulation.root(), path)->data().find(name)->pointer());
}
/// A bar flies against a wall with the speed v: rho c v presses on it for 2 L/c, c = sqrt(E/rho), while a wave goes to its end and back.
TEST(TextbookMotion, ABarHitsAWall) {
  constexpr double rho = 1000, modulus = 1e6, length = 1, v = 0.1, area = 0.01, dt = 2e-4;
  const double c = std::sqrt(modulus / rho), transit = 2 * length / c;
  const Mesh mesh = block(40, 1, 1, [&](const Vec3& u) -> Vec3 { return {0.0105 + length * u.x(), 0.1 * u.y(), 0.1 * u.z()}; });
  std::string velocity;
  for (std::size_t i = 0; i < mesh.position.size(); ++i) velocity += fmt::format("{} 0 0 ", -v);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerImplicitSolver newtonIterations="30"/><SparseLDLSolver/>{}
  <MechanicalObject name="dofs" velocity="{}"/><DiagonalMass massDensity="{}"/>
  <HexahedronFEMForceField method="small" youngModulus="{}" poissonRatio="0"/>
  <PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 1 1"/>
  <ConstraintContact name="wall" planes="1 0 0 0" contactDistance="0.01"/></Node>)",
      dt, cells(mesh), velocity, rho, modulus));
  double first = 0, last = 0, sum = 0;
  int count = 0;
  while (simulation.time() < 1.3 * transit) {
    step(simulation);
    double force = 0;
    for (const Vec3& each : vectorsOf(simulation, "/wall", "contactForces")) force += each.x();
    if (force > 1e-3 * rho * c * v * area) first = first > 0 ? first : simulation.time(), last = simulation.time();
    if (simulation.time() > 0.2 * transit && simulation.time() < 0.8 * transit) sum += force, ++count;
  }
  std::printf("force %.4f, contact %.4f of the closed forms\n", sum / count / (rho * c * v * area), (last - first + dt) / transit);
  EXPECT_NEAR(sum / count / (rho * c * v * area), 1, 2e-3);
  EXPECT_NEAR((last - first + dt) / transit, 1, 0.015);
}

/// A rigid block on a plane, drawn by a spring k whose end goes on at V: it sticks up to mu_s m g, slips with mu_k m g, and does so again
/// after 2 a/V + 2 (pi - atan(a w/V))/w, a = (mu_s - mu_k) m g/k, w = sqrt(k/m).
TEST(TextbookMotion, ABlockSticksAndSlips) {
  constexpr double k = 100, speed = 0.02, edge = 0.1, weight = 9.81, rest = 0.3, dt = 2e-3;
  const Mesh mesh = block(1, 1, 1, [&](const Vec3& u) -> Vec3 { return edge * (u - Vec3(0.5, 0.5, 0.5)); });
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{0}" gravity="0 0 -9.81"><EulerImplicitSolver newtonIterations="30"/><SparseLDLSolver/>
  <Node name="block"><MechanicalObject name="frame" template="Rigid3" position="0 0 0.0599 0 0 0 1"/>
  <UniformMass totalMass="1" inertia="{1} {1} {1}"/><Node name="skin">
  <MeshTopology position="{2}" quads="0 2 3 1  4 5 7 6  0 1 5 4  1 3 7 5  3 2 6 7  2 0 4 6"/><MechanicalObject/><RigidMapping/>
  <BarrierContact name="floor" planes="0 0 1 0" contactDistance="0.01" stiffness="1e5" friction="{3}" staticFriction="0.5"/></Node></Node>
  <Node name="hand"><MechanicalObject name="hand" position="1 0 0.0599"/><UniformMass totalMass="1"/>
  <LinearMovementProjectiveConstraint indices="0" keyTimes="0 100" movements="0 0 0 {4} 0 0"/></Node>
  <SpringForceField object1="@block/frame" object2="@hand/hand" springsIndices1="0" springsIndices2="0" stiffness="{5}" lengths="1"/>
  </Node>)",
      dt, edge * edge / 6, flat(mesh.position), rest, 100 * speed, k));
  const double a = (0.5 - rest) * weight / k, w = std::sqrt(k), period = 2 * a / speed + 2 * (pi - std::atan(a * w / speed)) / w;
  std::vector<double> slips;
  double before = 0, largest = 0;
  while (simulation.time() < 5.5) {
    step(simulation);
    double force = 0;
    for (const Vec3& each : vectorsOf(simulation, "/block/skin/floor", "frictionForces")) force -= each.x();
    largest = std::max(largest, force);
    const double v = simulation.systems()[0]->v[0].x();
    if (v > 1.5 * speed && before <= 1.5 * speed) slips.push_back(simulation.time());
    before = v;
  }
  ASSERT_EQ(slips.size(), 2u);
  std::printf("period %.3f s (%.3f), first slip %.3f s (%.3f), largest friction %.3f N (%.3f)\n", slips[1] - slips[0], period, slips[0],
              0.5 * weight / (k * speed), largest, 0.5 * weight);
  EXPECT_NEAR(slips[0], 0.5 * weight / (k * speed), 0.03);
  EXPECT_NEAR(slips[1] - slips[0], period, 0.04);
  EXPECT_NEAR(largest, 0.5 * weight, 0.01);
}

/// A column with held sides is pressed to seven tenths of its length at a constant speed and held: P = l S, S the integral of
/// g(t - s) dS_0, S_0 = (lambda + 2 mu)(l^2 - 1)/2 and g a Prony series of three terms; ten and more of its times apart.
TEST(TextbookMotion, AStressThatRelaxesAtLargeStrain) {
  constexpr double modulus = 20e3, nu = 0.3, stiffness = modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  const std::array<double, 3> share{0.2, 0.3, 0.25}, tau{0.05, 0.5, 5};
  const auto exact = [&](double time, double ramp) {
    double sum = 0;
    const int n = 4000;
    for (int i = 0; i < n; ++i) {
      const double s = std::min(time, ramp) * (i + 0.5) / n, l = 1 - 0.3 * s / ramp;
      double g = 1;
      for (std::size_t k = 0; k < 3; ++k) g -= share[k] * (1 - std::exp(-(time - s) / tau[k]));
      sum += g * stiffness * l * (-0.3 / ramp) * std::min(time, ramp) / n;
    }
    return (1 - 0.3 * std::min(1., time / ramp)) * sum;
  };
  const Mesh mesh = gridMesh(1, 1, 1);
  for (const double ramp : {0.02, 1.})
    for (const bool second : {false, true}) {
      Simulation simulation = simulationFromText(fmt::format(
          R"(<Node name="root" dt="{}" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>{}<MechanicalObject/>
  <HexahedronHyperelasticityFEMForceField materialName="StVenantKirchhoff" youngModulus="{}" poissonRatio="{}" viscous="true"
  ParameterAlpha="0.2 0.3 0.25" ParameterTau="0.05 0.5 5" viscousUpdate="{}"/>
  <PartialFixedProjectiveConstraint fixAll="true" fixedDirections="1 1 0"/><FixedProjectiveConstraint indices="0-3"/>
  <PartialLinearMovementProjectiveConstraint indices="4-7" movedDirections="0 0 1" keyTimes="0 {} 100" movements="0 0 0 0 0 -0.3 0 0 -0.3"/>
  </Node>)",
          ramp / 40, cells(mesh), modulus, nu, second ? "exponential" : "backward", ramp));
      simulation.states()[0]->requestForce();
      for (const double until : {ramp, 2 * ramp}) {
        while (simulation.time() < until - 1e-9) step(simulation);
        double stress = 0;
        for (const Index node : {4, 5, 6, 7}) stress -= simulation.states()[0]->f()[node].z();
        EXPECT_NEAR(stress / exact(until, ramp), 1, second ? 1e-4 : 5e-3) << ramp << " s, " << until << " s";
      }
    }
}

/// A bar that hangs on its edge and swings from the horizontal: T = 4 K(sin 45) sqrt(I/(m g L/2)), half of it from one passage to the next.
TEST(TextbookMotion, ABarSwingsFromTheHorizontal) {
  constexpr double length = 0.2, h = 0.02, dt = 2e-3;
  const Mesh mesh = block(10, 1, 2, [&](const Vec3& u) -> Vec3 { return {length * u.x(), h * u.y(), h * (u.z() - 0.5)}; });
  for (const char* rule : {"TrapezoidalRuleSolver", "NewmarkImplicitSolver"}) {
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="{}" gravity="0 0 -9.81"><{} newtonIterations="20"/><SparseLDLSolver/>{}<MechanicalObject/>
  <MeshMatrixMass massDensity="1000"/><HexahedronFEMForceField method="svd" youngModulus="1e7" poissonRatio="0.3"/>
  <FixedProjectiveConstraint indices="{}"/></Node>)",
        dt, rule, cells(mesh), chosen(mesh, [](const Vec3& p) { return p.x() < 1e-9 && std::abs(p.z()) < 1e-9; })));
    const double period = 4 * std::comp_ellint_1(std::sqrt(0.5)) * std::sqrt((length * length / 3 + h * h / 12) / (9.81 * length / 2));
    std::vector<double> passages;
    double before = 1;
    while (passages.size() < 2 && simulation.time() < 1.2 * period) {
      step(simulation);
      const double x = simulation.systems()[0]->x[10].x() + simulation.systems()[0]->x[54].x();
      if (x * before < 0) passages.push_back(simulation.time() - dt * x / (x - before));
      before = x;
    }
    ASSERT_EQ(passages.size(), 2u);
    EXPECT_NEAR((passages[1] - passages[0]) / (period / 2), 1, 1e-3) << rule;
  }
}

/// Mandel's plate between rigid plates that are pressed together from t = 0 on; the fluid leaves at its sides, x = a, and the pressure in
/// the middle first rises above what the load gave it. p = 2 p_0 sum sin b (1 - cos b)/(b - sin b cos b) exp(-b^2 c t/a^2) over the roots
/// of tan b = b (1 - nu)/(1/2 - nu), p_0 = F/(2 a), for an incompressible fluid (Abousleiman and others 1996).
TEST(TextbookMotion, MandelsPlate) {
  constexpr double a = 0.01, b = 0.002, modulus = 1e5, nu = 0.2, permeability = 1e-13, load = 0.01, q = (1 - nu) / (0.5 - nu);
  constexpr int steps = 160;
  const double consolidation = permeability * modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), unit = a * a / consolidation;
  const auto exact = [&](double time) {
    double sum = 0;
    for (int i = 0; i < 40; ++i) {
      double low = i * pi + 1e-3, high = (i + 0.5) * pi - 1e-9;
      for (int k = 0; k < 60; ++k) {
        const double middle = (low + high) / 2;
        (std::tan(middle) < q * middle ? low : high) = middle;
      }
      sum += 2 * std::sin(low) * (1 - std::cos(low)) / (low - std::sin(low) * std::cos(low)) * std::exp(-low * low * time / unit);
    }
    return sum;
  };
  const Mesh mesh = block(10, 1, 1, [&](const Vec3& u) -> Vec3 { return {a * u.x(), b * u.y(), a * u.z()}; });
  std::string relations;
  for (int node = 23; node < 44; ++node) relations += fmt::format("22 {} ", node);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>{}<MechanicalObject/>
  <HexahedronHyperelasticityFEMForceField materialName="StVenantKirchhoff" youngModulus="{}" poissonRatio="{}"/>
  <HexahedronPorousForceField name="fluid" coupling="implicit" fluidFraction="0.8" bulkModulus="0.1" limitModulus="1e8" permeability="{}"
  drainedIndices="10 21 32 43"/><PartialFixedProjectiveConstraint indices="0 11 22 33" fixedDirections="1 0 0"/>
  <PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 1 0"/>
  <PartialFixedProjectiveConstraint indices="0-21" fixedDirections="0 0 1"/>
  <LinearRelationProjectiveConstraint coefficients="1 -1" directions="0 0 1" indices="{}"/>
  <ConstantForceField indices="22" totalForce="0 0 {}"/></Node>)",
      0.5 * unit / steps, cells(mesh), modulus, nu, permeability, relations, -load * b));
  double highest = 0;
  for (const double at : {0.05, 0.1, 0.2, 0.4}) {
    while (simulation.time() < (at - 1e-9) * unit) step(simulation);
    const Component* fluid = findComponent(simulation.root(), "/fluid");
    const auto& pressures = *std::get<std::vector<double>*>(fluid->data().find("pressure")->pointer());
    const double pressure = pressures[0] / (load / (2 * a));
    std::printf("t = %.2f a^2/c: p/p_0 = %.4f (%.4f)\n", at, pressure, exact(at * unit));
    EXPECT_NEAR(pressure, exact(at * unit), 4e-3);
    highest = std::max(highest, pressure);
  }
  EXPECT_GT(highest, 1.09);
}

/// A ball of one point and a thickness has no edge by which pairs are looked for; from rest its first step was refused.
TEST(TextbookMotion, AThickPointComesToRestOnAPlane) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.005" gravity="0 0 -10"><EulerImplicitSolver/><SparseLDLSolver/>
  <MechanicalObject position="0 0 0.105"/><PointSetTopologyContainer position="0 0 0.105"/><UniformMass totalMass="1"/>
  <ConstraintContact contactDistance="0.001" thickness="0.1" planes="0 0 1 0"/></Node>)");
  for (int i = 0; i < 40; ++i) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(!report.failed() && !report.unsolved && report.constraints_converged) << i << report.reason << report.constraint_reason;
  }
  EXPECT_NEAR(simulation.systems()[0]->x[0].z(), 0.101, 2e-6);
}

}  // namespace
}  // namespace stroma::test
