// SPDX-License-Identifier: LGPL-2.1-or-later
// Membranes of triangles: homogeneous strains, momentum, derivatives, the inflated sphere, bad input.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

const std::string patch =
    "position='0 0 0  1 0 .1  2 0 0  0 1 .2  1 1 .3  2 1 0' triangles='0 1 4  0 4 3  1 2 5  5 4 1'";

std::string scene(const std::string& mesh, const std::string& attributes, const std::string& more = "") {
  return fmt::format(R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/><MeshTopology {}/>
    <MechanicalObject/><UniformMass totalMass="1"/><TriangularFEMForceField {}/>{}</Node>)",
                     mesh, attributes, more);
}
FieldUnderTest membrane(const std::string& mesh, const std::string& attributes) {
  return FieldUnderTest(scene(mesh, attributes), "TriangularFEMForceField");
}

/// A plane patch under a homogeneous strain, turned in space. Energy, with the stresses of plane stress or strain
/// written out.
TEST(Membrane, HomogeneousStrain) {
  const std::string flat = "position='0 0 2  2 0 2  2 3 2  0 3 2' triangles='0 1 2  3 0 2'";
  const double e = 3000, nu = 0.3, h = 0.01, xx = 0.02, yy = -0.01;
  for (const std::string method : {"large", "small"})
    for (bool plane_strain : {false, true}) {
      FieldUnderTest t = membrane(flat, fmt::format("youngModulus='{}' poissonRatio='{}' thickness='{}' method='{}' "
                                                    "planeStrain='{}'",
                                                    e, nu, h, method, plane_strain));
      const Mat3 turn = method == "large" ? Mat3(Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized())) : Mat3::Identity();
      for (Index i = 0; i < 4; ++i) {
        const Vec3 p = t.x[i];
        t.x[i] = turn * Vec3((1 + xx) * p.x(), (1 + yy) * p.y(), 7);
      }
      const double a = plane_strain ? e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) : e / (1 - nu * nu);
      const double b = plane_strain ? e * nu / ((1 + nu) * (1 - 2 * nu)) : e * nu / (1 - nu * nu);
      const double sx = a * xx + b * yy, sy = b * xx + a * yy;
      EXPECT_NEAR(t.field().energy(t.x), 6 * h * (sx * xx + sy * yy) / 2, 1e-12);
      // the resultant on the edge x = 2, of length 3
      const Vector f = t.force();
      EXPECT_LT((turn.transpose() * Vec3(f[1] + f[2]) - Vec3(-3 * h * sx, 0, 0)).norm(), 1e-12);
    }
}

/// A plane patch stretched along its fibres or across them, and sheared between: stresses of a plane orthotropic sheet.
TEST(Membrane, FibresAreStifferThanWhatLiesAcross) {
  const double along = 3000, across = 500, nu = 0.4, nu_across = nu * across / along, h = 0.01, angle = 0.7;
  const Vec3 fibre(std::cos(angle), std::sin(angle), 0), other(-std::sin(angle), std::cos(angle), 0);
  for (const std::string method : {"small", "large"}) {
    FieldUnderTest t(
        fmt::format("<Node name='root' gravity='0 0 0'><EulerImplicitSolver/><CGLinearSolver/><MeshTopology position='0 0 2  2 0 2  "
                    "2 3 2  0 3 2' triangles='0 1 2  3 0 2'/><MechanicalObject/><UniformMass totalMass='1'/>"
                    "<TriangularAnisotropicFEMForceField youngModulus='{}' transverseYoungModulus='{}' poissonRatio='{}' thickness='{}' "
                    "fiberAngle='{:.17g}' method='{}'/></Node>",
                    along, across, nu, h, angle * 180 / std::numbers::pi, method),
        "TriangularAnisotropicFEMForceField");
    const double a = 1e-6, b = 2e-6, shear = 3e-6;  // so small that large is linear
    for (Index i = 0; i < 4; ++i) {
      const Vec3 rest = t.x[i];
      const double p = rest.dot(fibre), q = rest.dot(other);
      t.x[i] = rest + (a * p + shear / 2 * q) * fibre + (b * q + shear / 2 * p) * other;
    }
    const double part = 1 - nu * nu_across, s1 = (along * a + nu * across * b) / part, s2 = (nu * across * a + across * b) / part;
    const double s12 = along / (2 * (1 + nu)) * shear;
    EXPECT_NEAR(t.field().energy(t.x), 6 * h * (s1 * a + s2 * b + s12 * shear) / 2, 1e-5 * 6 * h * s1 * a);
    const Vec3 x(1, 0, 0);
    const Vec3 traction = s1 * fibre.dot(x) * fibre + s2 * other.dot(x) * other + s12 * (other.dot(x) * fibre + fibre.dot(x) * other);
    const Vector f = t.force();
    EXPECT_LT((f[1] + f[2] + 3 * h * traction).norm(), 1e-5 * h * s1);
    t.deform(0.3);
    Vector strained = t.force(), above(4), below(4);
    copy(t.x, above), copy(t.x, below);
    axpy(1e-5, t.direction, above), axpy(-1e-5, t.direction, below);
    const double slope = (t.field().energy(above) - t.field().energy(below)) / 2e-5;
    EXPECT_NEAR(-slope, dot(strained, t.direction), 1e-6 * std::abs(slope));
    EXPECT_LT(momentumOf(t.x, strained).force, 1e-13);
    if (method == "large") {
      EXPECT_LT(momentumOf(t.x, strained).torque, 1e-13);
    }
  }
}

TEST(Membrane, FibresThatLieAcrossOrAreTooSoftAreRefused) {
  const auto refusal = [](const std::string& attributes) {
    return problemsOf(fmt::format("<Node name='root'><EulerImplicitSolver/><CGLinearSolver/><MeshTopology position='0 0 0  1 0 0  1 0 1' "
                                 "triangles='0 1 2'/><MechanicalObject/><UniformMass totalMass='1'/>"
                                 "<TriangularAnisotropicFEMForceField {}/></Node>",
                                 attributes));
  };
  expectContains(refusal("fiberAngle='90'"), "lie across it");
  expectContains(refusal("youngModulus='100' transverseYoungModulus='1000' poissonRatio='0.4'"), "too large");
  expectContains(refusal("fiberCenter='0 0 1  1 0 0'"), "one point");
}

TEST(Membrane, KeepsMomentumAndAngularMomentum) {
  FieldUnderTest t = membrane(patch, "youngModulus='3000' poissonRatio='0.3' thickness='0.1'");
  for (unsigned seed : {1u, 2u, 3u}) {
    t.deform(0.3, seed);
    const Momentum momentum = momentumOf(t.x, t.force());
    EXPECT_LT(momentum.force, 1e-14);
    EXPECT_LT(momentum.torque, 1e-13);
  }
}

/// Force against energy for every variant; the exact tangent against forces, at large strains; the warped one where
/// nothing is strained.
TEST(Membrane, Derivatives) {
  for (const std::string variant : {"method='small'", "method='large'", "method='large' tangent='exact'"}) {
    SCOPED_TRACE(variant);
    FieldUnderTest t = membrane(patch, "youngModulus='3' poissonRatio='0.3' thickness='0.1' " + variant);
    t.deform(0.3);
    Vector f = t.force(), a(6), b(6);
    copy(t.x, a), copy(t.x, b);
    axpy(1e-5, t.direction, a), axpy(-1e-5, t.direction, b);
    EXPECT_NEAR((t.field().energy(b) - t.field().energy(a)) / 2e-5, dot(f, t.direction), 1e-8);
    if (variant == "method='large'") t.moveRigidly();
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6)), 1e-7);
    const BlockMatrix k = t.matrix();
    Vector product(6);
    k.multiply(t.direction, product);
    EXPECT_LT(relativeDifference(product, t.product(t.direction)), 1e-13);
  }
}

/// The warped tangent takes no energy out, however the membrane is stretched or crushed.
TEST(Membrane, WarpedTangentIsDefinite) {
  FieldUnderTest t = membrane(patch, "youngModulus='3' poissonRatio='0.3' thickness='0.1'");
  for (unsigned seed = 1; seed < 50; ++seed) {
    t.deform(0.5, seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (Index i = 0; i < 6; ++i) t.direction[i] = Vec3(uniform(random), uniform(random), uniform(random));
    const Vector product = t.product(t.direction);
    EXPECT_LE(dot(t.direction, product), 1e-12 * std::sqrt(dot(product, product)));
  }
}

/// A sphere of radius 1: an octahedron cut `levels` times, its nodes with a zero coordinate listed by axis.
struct Sphere {
  std::vector<Vec3> nodes{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Triangle> triangles{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                                  {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};

  explicit Sphere(int levels) {
    for (int level = 0; level < levels; ++level) {
      std::map<Edge, Index> middle;
      const auto half = [&](Index a, Index b) {
        const auto [at, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)}, Index(nodes.size()));
        if (fresh) nodes.push_back((nodes[a] + nodes[b]).normalized());
        return at->second;
      };
      std::vector<Triangle> finer;
      for (const auto& [a, b, c] : triangles) {
        const Index ab = half(a, b), bc = half(b, c), ca = half(c, a);
        for (const Triangle& t : {Triangle{a, ab, ca}, Triangle{b, bc, ab}, Triangle{c, ca, bc}, Triangle{ab, bc, ca}})
          finer.push_back(t);
      }
      triangles = finer;
    }
  }
  std::string mesh() const {
    std::ostringstream out;
    out.precision(17);
    out << "position='";
    for (const Vec3& p : nodes) out << p.transpose() << "  ";
    out << "' triangles='";
    for (const Triangle& t : triangles) out << t[0] << " " << t[1] << " " << t[2] << "  ";
    out << "'";
    return out.str();
  }
  std::string symmetryPlanes() const {
    std::string out;
    for (int axis = 0; axis < 3; ++axis) {
      std::string list;
      for (std::size_t i = 0; i < nodes.size(); ++i)
        if (std::abs(nodes[i][axis]) < 1e-12) list += std::to_string(i) + " ";
      out += fmt::format("<PartialFixedProjectiveConstraint indices='{}' fixedDirections='{} {} {}'/>", list, axis == 0,
                         axis == 1, axis == 2);
    }
    return out;
  }
};

/// Mean radius of the inflated sphere, by Newton's method with exact tangents.
double inflatedRadius(int levels, double young, double nu, double h, const std::string& pressure) {
  const Sphere sphere(levels);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" gravity="0 0 0"><StaticSolver newton_iterations="60"
      relative_residual_tolerance_threshold="1e-9"/><SparseLDLSolver/><MeshTopology {}/><MechanicalObject/>
      <UniformMass totalMass="1"/>
      <TriangularFEMForceField youngModulus="{}" poissonRatio="{}" thickness="{}" tangent="exact"/>{}
      <SurfacePressureForceField {}/></Node>)",
      sphere.mesh(), young, nu, h, sphere.symmetryPlanes(), pressure));
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
  const System& system = *simulation.systems().at(0);
  double sum = 0;
  for (std::size_t i = 0; i < sphere.nodes.size(); ++i) sum += system.x[Index(i)].norm();
  return sum / double(sphere.nodes.size());
}

/// Stress p R / 2 h. With the stretch s, sigma = E (s - 1) / (1 - nu) and a constant thickness: p = 2 h sigma / (R
/// s^2). The faceted sphere differs in second order of the edge.
TEST(Membrane, InflatedSphere) {
  const double e = 1000, nu = 0.3, h = 0.01, stretch = 1.1, sigma = e * (stretch - 1) / (1 - nu);
  const std::string load = fmt::format("pressure='{:.17g}'", 2 * h * sigma / (stretch * stretch));
  const double coarse = std::abs(inflatedRadius(2, e, nu, h, load) - stretch) / (stretch - 1);
  const double fine = std::abs(inflatedRadius(3, e, nu, h, load) - stretch) / (stretch - 1);
  RecordProperty("relative error of the growth, 128 triangles", std::to_string(coarse));
  RecordProperty("relative error of the growth, 512 triangles", std::to_string(fine));
  EXPECT_LT(fine, 0.05);
  EXPECT_LT(fine, 0.4 * coarse);
  // a gas: the same stretch when its pressure at rest is s^3 times higher
  const std::string gas = fmt::format("volumeConservationMode='1' pressure='{:.17g}'",
                                      2 * h * sigma / (stretch * stretch) * std::pow(stretch, 3));
  EXPECT_LT(std::abs(inflatedRadius(3, e, nu, h, gas) - stretch) / (stretch - 1), 0.05);
}

/// The same sphere in implicit steps a hundred times longer than the waves of its surface allow: the tension is in the
/// warped tangent.
TEST(Membrane, LongStepsOfAnInflatedSphere) {
  const Sphere sphere(2);
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.5" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology {}/>
      <MechanicalObject/><UniformMass totalMass="0.001"/><TriangularFEMForceField youngModulus="1000"
      poissonRatio="0.3" thickness="0.01"/>{}<SurfacePressureForceField pressure="2.36"/></Node>)",
      sphere.mesh(), sphere.symmetryPlanes()));
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems().at(0);
  double sum = 0, speed = 0;
  for (std::size_t i = 0; i < sphere.nodes.size(); ++i)
    sum += system.x[Index(i)].norm(), speed = std::max(speed, system.v[Index(i)].norm());
  EXPECT_NEAR(sum / double(sphere.nodes.size()), 1.1, 0.01);
  EXPECT_LT(speed, 1e-6);
}

TEST(Membrane, SaysWhatIsWrong) {
  const auto expectProblem = [](const std::string& mesh, const std::string& attributes, const std::string& words) {
    const std::string problems = problemsOf(scene(mesh, attributes));
    EXPECT_NE(problems.find(words), std::string::npos) << words << " is not in:\n" << problems;
  };
  EXPECT_EQ(problemsOf(scene(patch, "poissonRatio='0.5'")), "");
  expectProblem("position='0 0 0 1 0 0 0 1 0'", "", "has no triangles");
  expectProblem("position='0 0 0 1 0 0 2 0 0' triangles='0 1 2'", "", "is a line at rest");
  expectProblem(patch, "youngModulus='1 2'", "youngModulus has 2 values for 4 triangles");
  expectProblem(patch, "poissonRatio='0.5' planeStrain='1'", "planeStrain");
  expectProblem(patch, "thickness='0'", "thickness");
  expectProblem(patch, "method='qr'", "method");
}

}  // namespace
}  // namespace stroma::test
