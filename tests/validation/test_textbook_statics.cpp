// SPDX-License-Identifier: LGPL-2.1-or-later
// Equilibria of textbooks with closed or published answers, as a user writes them: torsion of rubber, a column beyond its buckling load,
// a bent beam drawn out of its plane, a beam on springs, fibres off the axis, a thick sphere past its limit point, a rotating disc.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "framework/simulation/expectation.h"
#include "tests/support/meshes.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double pi = std::numbers::pi;
constexpr const char* statics = R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>)";

template <class List>
std::string text(const List& list) {
  std::string out;
  for (const auto& item : list)
    for (const auto& number : item) out += fmt::format("{:.17g} ", double(number));
  return out;
}
/// Numbers of the nodes that `choose` accepts.
std::string nodesWhere(const Mesh& mesh, const std::function<bool(const Vec3&)>& choose) {
  std::string out;
  for (std::size_t i = 0; i < mesh.position.size(); ++i)
    if (choose(mesh.position[i])) out += fmt::format("{} ", i);
  return out;
}
std::string topology(const Mesh& mesh) {
  return fmt::format(R"(<MeshTopology name="mesh" position="{}" hexahedra="{}"/><MechanicalObject name="dofs"/>)", text(mesh.position),
                     text(mesh.hexahedra));
}
std::string rollers(const Mesh& mesh, const std::string& directions, const std::function<bool(const Vec3&)>& choose) {
  return fmt::format(R"(<PartialFixedProjectiveConstraint indices="{}" fixedDirections="{}"/>)", nodesWhere(mesh, choose), directions);
}
/// The unit cube in n x m x l hexahedra, mapped.
Mesh mapped(int n, int m, int l, const std::function<Vec3(const Vec3&)>& map) {
  Mesh mesh = gridMesh(n, m, l);
  for (Vec3& p : mesh.position) p = map(p.cwiseQuotient(Vec3(n, m, l)));
  return mesh;
}
/// A square from -1 to 1 to the unit disc, without corners near the middle.
Vec3 onDisc(double x, double y) {
  const double r = std::max(std::abs(x), std::abs(y)), norm = std::hypot(x, y);
  const double factor = r > 0 ? 1 - r + r * r / norm : 1;
  return {x * factor, y * factor, 0};
}

/// After one step.
struct Solved {
  Simulation simulation;
  explicit Solved(const std::string& scene) : simulation(simulationFromText(scene)) { step(); }
  void step() {
    const StepReport report = simulation.step();
    EXPECT_TRUE(!report.failed() && !report.unsolved) << report.reason;
  }
  Vec3 at(Index row) const { return simulation.systems()[0]->x[row]; }
};
/// The net force on each row of the first state; held nodes bear it.
std::vector<Vec3> forcesOf(Solved& solved) {
  System& system = *solved.simulation.systems()[0];
  Vector f(system.allRows()), v(system.allRows());
  system.computeForce(system.x, v, f);
  std::vector<Vec3> forces;
  for (Index i = 0; i < system.allRows(); ++i) forces.push_back(f[i]);
  return forces;
}

/// Rivlin's torsion of a cylinder of Mooney-Rivlin rubber, one radian over its length of two radii: M = pi tau a^4 (c1 + c2), and it
/// pushes its ends apart by N = -pi tau^2 a^4 (c1 + 2 c2)/2. Meshes of 4 and 8 cells across, extrapolated by h^2.
TEST(TextbookStatics, TorsionOfRubber) {
  constexpr double a = 0.01, length = 0.02, c1 = 20e3, c2 = 10e3, twist = 1 / length;
  std::array<double, 2> moment{}, push{};
  for (const int k : {0, 1}) {
    const int n = 4 << k;
    const Mesh mesh = mapped(n, n, n, [&](const Vec3& u) -> Vec3 {
      return a * onDisc(2 * u.x() - 1, 2 * u.y() - 1) + Vec3(0, 0, length * u.z());
    });
    const auto at_top = [&](const Vec3& p) { return p.z() > length - 1e-9; };
    Solved solved(fmt::format(
        R"({}{}<HexahedronHyperelasticityFEMForceField materialName="MooneyRivlin" c1="{}" c2="{}" k0="2e8"/>{}
  <AffineMovementProjectiveConstraint indices="{}" beginConstraintTime="0" endConstraintTime="1"
  rotation="{} {} 0 {} {} 0 0 0 1"/></Node>)",
        statics, topology(mesh), c1, c2, rollers(mesh, "1 1 1", [](const Vec3& p) { return p.z() < 1e-9; }), nodesWhere(mesh, at_top),
        std::cos(1.), -std::sin(1.), std::sin(1.), std::cos(1.)));
    const std::vector<Vec3> forces = forcesOf(solved);
    for (std::size_t i = 0; i < mesh.position.size(); ++i)
      if (at_top(mesh.position[i])) {
        moment[std::size_t(k)] -= solved.at(Index(i)).cross(forces[i]).z();
        push[std::size_t(k)] -= forces[i].z();
      }
  }
  const double m = pi * twist * std::pow(a, 4) * (c1 + c2), n = -pi * twist * twist * std::pow(a, 4) * (c1 + 2 * c2) / 2;
  std::printf("moment / closed form %.4f %.4f, push %.4f %.4f\n", moment[0] / m, moment[1] / m, push[0] / n, push[1] / n);
  EXPECT_NEAR((4 * moment[1] - moment[0]) / 3 / m, 1, 3e-3);
  EXPECT_NEAR((4 * push[1] - push[0]) / 3 / n, 1, 3e-3);
}

std::string beams(const std::string& positions, int count, double modulus, double ratio, double radius, const std::string& more) {
  std::string edges;
  for (int i = 0; i < count; ++i) edges += fmt::format("{} {} ", i, i + 1);
  return fmt::format(R"({}<MeshTopology edges="{}"/><MechanicalObject name="dofs" template="Rigid3" position="{}"/>
  <BeamFEMForceField youngModulus="{}" poissonRatio="{}" radius="{}"/>{}</Node>)",
                     statics, edges, positions, modulus, ratio, radius, more);
}
std::string straight(int count, double length) {
  std::string out;
  for (int i = 0; i <= count; ++i) out += fmt::format("{:.17g} 0 0 0 0 0 1 ", length * i / count);
  return out;
}

/// A clamped column beyond its buckling load P_cr: with K(k) = (pi/2) sqrt(P/P_cr), x/L = 2 E(k)/K(k) - 1 and y/L = 2 k/K(k). Its end is
/// moved there in a few steps, from straight, with a force from the side that chooses the side, and bears P. In small steps one of them
/// ends beside the bifurcation, where one direction is a thousand times softer than all others.
TEST(TextbookStatics, AColumnBeyondItsBucklingLoad) {
  constexpr double r = 0.01, modulus = 1e9;
  const double critical = pi * pi * modulus * pi * std::pow(r, 4) / 4 / 4;
  struct Case {
    double load;
    int steps, beams;
    double side;
  };
  for (const Case& c : {Case{1.293, 5, 16, 1e-4}, Case{1.518, 5, 16, 1e-4}, Case{1.884, 5, 16, 1e-4}, Case{1.05, 3, 16, 1e-4},
                        Case{1.05, 20, 16, 1e-6}, Case{1.293, 10, 16, 1e-3}, Case{1.518, 10, 16, 1e-4}, Case{1.884, 20, 16, 1e-4},
                        Case{1.293, 10, 40, 1e-6}, Case{1.884, 3, 40, 1e-3}}) {
      const double load = c.load;
      double low = 0, high = 1;
      for (int i = 0; i < 60; ++i) {
        const double k = (low + high) / 2;
        (std::comp_ellint_1(k) < pi / 2 * std::sqrt(load) ? low : high) = k;
      }
      const double x = 2 * std::comp_ellint_2(low) / std::comp_ellint_1(low) - 1, y = 2 * low / std::comp_ellint_1(low);
      Solved solved(beams(straight(c.beams, 1), c.beams, modulus, 0.3, r,
                          fmt::format(R"(<FixedProjectiveConstraint indices="0"/>
  <PartialLinearMovementProjectiveConstraint indices="{}" movedDirections="1 0 0 0 0 0" keyTimes="0 {}"
  movements="0 0 0 0 0 0 {} 0 0 0 0 0"/>
  <ConstantForceField indices="{}" forces="0 {} 0 0 0 0"/>)",
                                      c.beams, c.steps, x - 1, c.beams, c.side * critical)));
      for (int i = 1; i < c.steps; ++i) solved.step();
      // a step of many times the strain of buckling passes through modes that may end on either side
      EXPECT_NEAR(std::abs(solved.at(2 * c.beams).y()), y, 3e-4) << load << " in " << c.steps;
      EXPECT_NEAR(forcesOf(solved)[std::size_t(2 * c.beams)].x() / critical, load, 4e-4 * load) << load << " in " << c.steps;
    }
}

/// A chain of stiff springs that starts slack, pressed and too short: a catenary of the parameter a, 2 a sinh(l/2a) = S, sags by
/// a (cosh(l/2a) - 1) and pulls by rho g a. Error of order h^2.
TEST(TextbookStatics, ASlackChainHangs) {
  constexpr double span = 1, length = 1.2, density = 0.1;
  double low = 0.1, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(span / 2 / a) > length ? low : high) = a;
  }
  const double sag = low * (std::cosh(span / 2 / low) - 1);
  for (const int n : {20, 40})
    for (const double stiffness : {1e4, 1e5}) {
      std::string places, masses, lengths;
      for (int i = 0; i <= n; ++i) {
        const double x = 2. * i / n - 1;
        places += fmt::format("{} {} 0 ", span * i / n, -0.32 * (1 - x * x));
        masses += fmt::format("{} ", density * length / n * (i % n == 0 ? 0.5 : 1));
        lengths += i < n ? fmt::format("{} ", length / n) : "";
      }
      const Solved solved(fmt::format(
          R"(<Node name="root" dt="1" gravity="0 -9.81 0"><StaticSolver/><SparseLDLSolver/><MechanicalObject position="{}"/>
  <DiagonalMass vertexMass="{}"/><FixedProjectiveConstraint indices="0 {}"/>
  <SpringForceField springsIndices1="0-{}" springsIndices2="1-{}" lengths="{}" stiffness="{}"/></Node>)",
          places, masses, n, n - 1, n, lengths, stiffness * n));
      EXPECT_NEAR(-solved.at(n / 2).y() / sag, 1, n == 20 ? 2e-3 : 6e-4) << n << " " << stiffness;
    }
}

/// A beam along an eighth of a circle of radius 100, drawn out of its plane at its end (Bathe and Bolourchi 1979; the places are those of
/// Simo and Vu-Quoc 1986): E = 1e7, nu = 0, moments of area 1/12. A round section of that has 2 % more area than theirs.
TEST(TextbookStatics, ABentBeamIsDrawnOutOfItsPlane) {
  constexpr int count = 16;
  const double radius = std::pow(4 / pi / 12, 0.25);
  std::string places;
  for (int i = 0; i <= count; ++i) {
    const double angle = pi / 4 * i / count;
    places += fmt::format("{:.17g} {:.17g} 0 0 0 {:.17g} {:.17g} ", 100 * std::sin(angle), 100 * (1 - std::cos(angle)), std::sin(angle / 2),
                          std::cos(angle / 2));
  }
  const auto tip = [&](double load) -> Vec3 {
    return Solved(beams(places, count, 1e7, 0, radius,
                        fmt::format(R"(<FixedProjectiveConstraint indices="0"/>
  <ConstantForceField indices="{}" forces="0 0 {} 0 0 0"/>)",
                                    count, load)))
        .at(2 * count);
  };
  EXPECT_LT((tip(300) - Vec3(58.84, 22.33, 40.08)).norm(), 0.2) << tip(300).transpose();
  EXPECT_LT((tip(600) - Vec3(47.23, 15.79, 53.37)).norm(), 0.2) << tip(600).transpose();
}

/// A long beam on springs of k per length sinks under a load P in its middle by P b/(2 k), b = (k/4 E I)^(1/4); error of order h^4.
TEST(TextbookStatics, ABeamOnSprings) {
  constexpr double length = 4, k = 2000, r = 0.02, modulus = 1e7, load = 0.1;
  const double b = std::pow(k / (modulus * pi * std::pow(r, 4)), 0.25);
  for (const int count : {20, 40}) {
    std::string stiffness;
    for (int i = 0; i <= count; ++i) stiffness += fmt::format("{:.17g} ", k * length / count * (i % count == 0 ? 0.5 : 1));
    const Solved solved(beams(
        straight(count, length), count, modulus, 0.3, r,
        fmt::format(R"(<RestShapeSpringsForceField points="0-{}" stiffness="{}" angularStiffness="0"/>
  <PartialFixedProjectiveConstraint indices="0" fixedDirections="0 0 0 1 0 0"/><ConstantForceField indices="{}" forces="0 {} 0 0 0 0"/>)",
                    count, stiffness, count / 2, -load)));
    EXPECT_NEAR(-solved.at(count).y() / (load * b / (2 * k)), 1, count == 20 ? 1e-2 : 6e-4);
  }
}

/// A cube with fibres at 30 degrees is stretched along x by 1.2 and otherwise free: the fibres shear it. Shear, widths and stress are
/// those that minimise the law's energy, found by a search that knows the formula of the energy alone (Nelder and Mead).
TEST(TextbookStatics, FibresOffTheAxisShearACube) {
  const Mesh mesh = gridMesh(1, 1, 1);
  struct Case {
    const char* law;
    double shear, width, height, stress;
  };
  for (const Case& c : {Case{R"(materialName="TransverselyIsotropic" mu="1e3" lambda="2e4" k1="5e3" k2="2")", -0.241317, 0.891981,
                             0.959117, 1491.5553},
                        Case{R"(materialName="TransverselyIsotropicMooneyRivlin" ParameterSet="500 200 100 8 3000 1.15 20000")",
                             -0.034823, 0.915615, 0.924, 755.9314}}) {
    Solved solved(fmt::format(
        R"({}{}<HexahedronHyperelasticityFEMForceField {} AnisotropyDirections="{:.17g} 0.5 0"/>
  <PartialLinearMovementProjectiveConstraint indices="1 3 5 7" movedDirections="1 0 0" keyTimes="0 1" movements="0 0 0 0.2 0 0"/>
  <PartialFixedProjectiveConstraint indices="0 2 4 6" fixedDirections="1 0 0"/>
  <PartialFixedProjectiveConstraint indices="0" fixedDirections="0 1 1"/>
  <PartialFixedProjectiveConstraint indices="4" fixedDirections="0 1 0"/></Node>)",
        statics, topology(mesh), c.law, std::sqrt(0.75)));
    EXPECT_NEAR(solved.at(1).y(), c.shear, 1e-5) << c.law;
    EXPECT_NEAR(solved.at(2).y(), c.width, 1e-5) << c.law;
    EXPECT_NEAR(solved.at(4).z(), c.height, 1e-5) << c.law;
    double stress = 0;
    const std::vector<Vec3> forces = forcesOf(solved);
    for (const std::size_t i : {1, 3, 5, 7}) stress -= forces[i].x();
    EXPECT_NEAR(stress, c.stress, 1e-5 * c.stress) << c.law;
  }
}

/// A disc that spins: its rim goes out by rho w^2 b^3 (1 - nu)/(4 E), and its middle has (3 + nu)/8 rho w^2 b^2 of stress both ways, which
/// Expect and Monitor can read.
TEST(TextbookStatics, ADiscThatSpins) {
  constexpr double b = 0.1, modulus = 1e6, nu = 0.3, load = 1000. * 100;
  const int n = 12;
  const Mesh mesh = mapped(n, n, 1, [&](const Vec3& u) -> Vec3 { return b * onDisc(u.x(), u.y()) + Vec3(0, 0, 0.002 * u.z()); });
  const double stress = (3 + nu) / 8 * load * b * b;
  Solved solved(fmt::format(
      R"({}{}<HexahedronFEMForceField name="fem" method="small" youngModulus="{}" poissonRatio="{}"/>
  <FormulaForceField per="volume" force="{}*x; {}*y; 0"/>{}{}{}
  <Expect name="right" of="/fem.stress" nodes="0 1" is="{}" tolerance="0.01" when="always"/>
  <Expect name="wrong" of="/fem.stress" nodes="0" is="{}" when="always"/></Node>)",
      statics, topology(mesh), modulus, nu, load, load, rollers(mesh, "1 0 0", [](const Vec3& p) { return p.x() < 1e-9; }),
      rollers(mesh, "0 1 0", [](const Vec3& p) { return p.y() < 1e-9; }),
      rollers(mesh, "0 0 1", [](const Vec3& p) { return p.z() < 1e-9; }),
      stress, 2 * stress));
  EXPECT_NEAR((solved.at(n).x() - b) / (load * b * b * b * (1 - nu) / (4 * modulus)), 1, 2e-3);
  std::vector<Component*> all;
  solved.simulation.root().collect(all);
  for (const Component* each : all)
    if (const auto* expected = dynamic_cast<const Expectation*>(each))
      EXPECT_EQ(expected->failure().empty(), each->name() == "right") << expected->failure();
}

/// An eighth of a thick sphere of neo-Hookean rubber, radii 1 and 2, whose cavity is filled in as many steps as there are stretches. A cone
/// to the centre closes the cavity.
std::string thickSphere(int n, double k0, const std::vector<double>& stretches) {
  Mesh mesh;
  std::vector<Quad> inner;
  for (int patch = 0; patch < 3; ++patch) {
    const Mesh part = mapped(n, n, n, [&](const Vec3& u) -> Vec3 {
      Vec3 d = Vec3::Zero();
      d[patch] = 1, d[(patch + 1) % 3] = std::tan(pi / 4 * u.x()), d[(patch + 2) % 3] = std::tan(pi / 4 * u.y());
      return d.normalized() * std::pow(2, u.z());
    });
    std::vector<Index> at;
    for (const Vec3& p : part.position) {
      Index found = 0;
      while (std::size_t(found) < mesh.position.size() && (mesh.position[std::size_t(found)] - p).norm() > 1e-9) ++found;
      if (std::size_t(found) == mesh.position.size()) mesh.position.push_back(p);
      at.push_back(found);
    }
    for (Hexahedron cell : part.hexahedra) {
      for (Index& node : cell) node = at[std::size_t(node)];
      mesh.hexahedra.push_back(cell);
      if (mesh.position[std::size_t(cell[0])].norm() < 1 + 1e-9) inner.push_back({cell[0], cell[1], cell[2], cell[3]});
    }
  }
  const Index centre = Index(mesh.position.size());
  std::vector<std::array<Index, 3>> cone;
  const auto on_a_plane = [&](Index node) { return mesh.position[std::size_t(node)].minCoeff() < 1e-9; };
  for (const Quad& q : inner)
    for (int i = 0; i < 4; ++i) {
      const Index from = q[std::size_t(i)], to = q[std::size_t((i + 1) % 4)];
      const Vec3 lowest = mesh.position[std::size_t(from)].cwiseMax(mesh.position[std::size_t(to)]);
      if (on_a_plane(from) && on_a_plane(to) && lowest.minCoeff() < 1e-9) cone.push_back({to, from, centre});
    }
  mesh.position.push_back(Vec3::Zero());
  std::string planes;
  for (int axis = 0; axis < 3; ++axis)
    planes += rollers(mesh, fmt::format("{} {} {}", axis == 0, axis == 1, axis == 2), [axis](const Vec3& p) { return p[axis] < 1e-9; });
  std::string times = "0", volumes = "0";
  for (const double stretch : stretches)
    times += fmt::format(" {}", times.size() / 2 + 1), volumes += fmt::format(" {:.17g}", pi / 6 * (stretch * stretch * stretch - 1));
  return fmt::format(R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><EigenSimplicialLDLT/>{}
  <HexahedronHyperelasticityFEMForceField materialName="MooneyRivlin" c1="0.5" c2="0" k0="{}"/>{}
  <SurfacePressureConstraint name="cavity" quads="{}" triangles="{}" valueType="volumeGrowth" keyTimes="{}" value="{}"/></Node>)",
                     topology(mesh), k0, planes, text(inner), text(cone), times, volumes);
}

double pressureOf(Solved& solved) {
  return *std::get<double*>(findComponent(solved.simulation.root(), "/cavity")->data().find("pressure")->pointer());
}

/// The pressure rises to its limit, at a stretch of 1.8, and falls again. p = int 4 c1 (l - l^-5)/(l^3 - 1) dl from the outer to the inner
/// stretch, c1 = 1/2.
TEST(TextbookStatics, AThickSpherePastItsLimitPoint) {
  const std::vector<double> stretches{1.1, 1.2, 1.35, 1.5, 1.75, 2, 2.5, 3};
  Solved solved(thickSphere(3, 1e3, stretches));
  for (const double stretch : stretches) {
    if (stretch > 1.1) solved.step();
    const double expected = stretch == 1.5 ? 0.755433 : stretch == 2 ? 0.806927 : stretch == 3 ? 0.634507 : 0;
    if (expected > 0) EXPECT_NEAR(pressureOf(solved), expected, 0.02 * expected) << stretch;
  }
}

/// Filled at once, its cells would be turned inside out on the way: the volume grows in parts of the step.
TEST(TextbookStatics, AThickSphereThatIsFilledAtOnce) {
  for (const double k0 : {1e3, 1e5}) {
    Solved solved(thickSphere(2, k0, {2}));
    EXPECT_NEAR(pressureOf(solved), 0.806927, 0.04 * 0.806927) << k0;
  }
}

}  // namespace
}  // namespace stroma::test
