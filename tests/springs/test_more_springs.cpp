// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs by polynomials, of triangles, and between orientations, against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string nodes(const std::string& positions, const std::string& field, const std::string& state = "") {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MechanicalObject name="dofs" position="{}" {}/><UniformMass totalMass="4"/>{}</Node>)",
                     positions, state, field);
}

/// Forces and the energy where a scene starts.
struct Start {
  Simulation simulation;
  System& system;
  ForceField& field;
  explicit Start(const std::string& text)
      : simulation(simulationFromText(text)), system(*simulation.systems().at(0)), field(*system.forceFields().at(0)) {}
  Vector force() { return forceAt(system.x); }
  Vector forceAt(ConstRows x) {
    Vector f(system.allRows()), v(system.allRows());
    field.addForce(x, v, f);
    return f;
  }
  double energy() { return field.energy(system.x); }
};

// ---- polynomials ----

/// P(e) = 200 e + 500 e^2 with e = 0.1 and, beyond its length, of the second spring e = -0.2.
TEST(PolynomialSprings, PullByTheirPolynomial) {
  const std::string springs =
      "<PolynomialSpringsForceField firstObjectPoints='0 1' secondObjectPoints='1 2' polynomialDegree='2 1' "
      "polynomialStiffness='200 500  300' computeZeroLength='0' zeroLength='1 1' {}/>";
  Start slack(nodes("0 0 0  1.1 0 0  1.1 0.8 0", fmt::format(fmt::runtime(springs), "")));
  const Vector f = slack.force();
  EXPECT_NEAR(f[0].x(), 200 * 0.1 + 500 * 0.01, 1e-12);
  EXPECT_NEAR(f[1].x(), -25, 1e-12);
  EXPECT_EQ(Vec3(f[2]), Vec3::Zero()) << "it is too short, and does not push";
  EXPECT_NEAR(slack.energy(), 200 * 0.01 / 2 + 500 * 0.001 / 3, 1e-12);
  Start pushing(nodes("0 0 0  1.1 0 0  1.1 0.8 0", fmt::format(fmt::runtime(springs), "compressible='true'")));
  EXPECT_NEAR(pushing.force()[2].y(), 300 * 0.2, 1e-12);
  EXPECT_NEAR(pushing.energy(), 200 * 0.01 / 2 + 500 * 0.001 / 3 + 300 * 0.04 / 2, 1e-12);
}

TEST(PolynomialSprings, TheirLengthIsThatOfTheStart) {
  Start t(nodes("0 0 0  0 2 0", "<PolynomialSpringsForceField firstObjectPoints='0' secondObjectPoints='1' polynomialStiffness='40'/>"));
  EXPECT_LT(norm(t.force()), 1e-13);
  Vector x(2);
  x[0] = Vec3(0, 0, 0), x[1] = Vec3(0, 0, 3);
  EXPECT_NEAR(t.forceAt(x)[0].z(), 40 * 0.5, 1e-12) << "half longer";
}

/// A mass on one spring swings with w = sqrt(P'(0) / (L m)) for small amplitudes.
TEST(PolynomialSprings, AMassSwingsWithItsPeriod) {
  const double h = 1e-3, w = std::sqrt(100 / (0.5 * 2));
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject position="0 0 0  0.500001 0 0"/>
      <UniformMass vertexMass="2"/><FixedProjectiveConstraint indices="0"/><PolynomialSpringsForceField firstObjectPoints="0"
      secondObjectPoints="1" polynomialStiffness="100 7000" polynomialDegree="2" computeZeroLength="0" zeroLength="0.5"
      compressible="true"/></Node>)",
      h));
  const double w_step = 2 / h * std::asin(w * h / 2);
  for (int i = 0; i < 500; ++i) simulation.step();
  const double t = simulation.time();
  // symplectic Euler: x_n = a cos(w' n h) - a tan(w' h / 2) sin(w' n h)
  const double exact = 1e-6 * (std::cos(w_step * t) - std::tan(w_step * h / 2) * std::sin(w_step * t));
  EXPECT_NEAR(simulation.states().at(0)->x()[1].x() - 0.5, exact, 1e-9);
}

/// |f| = P(l/L) l / sqrt(l^2 + exp(shift - scale l^2)), and its energy by the trapezoidal rule of many points.
TEST(PolynomialRestShapeSprings, PullByTheirFormula) {
  Start t(nodes("0 0 0  1 0 0",
                "<PolynomialRestShapeSpringsForceField points='1' polynomialStiffness='30 -4 5' polynomialDegree='3' "
                "initialLength='0.7' smoothShift='-2' smoothScale='3'/>"));
  const auto pull = [](double l) {
    const double e = l / 0.7, p = 30 * e - 4 * e * e + 5 * e * e * e;
    return p * l / std::sqrt(l * l + std::exp(-2 - 3 * l * l));
  };
  Vector x(2);
  copy(t.system.x, x);
  const Vec3 d(0.3, -0.4, 1.2);
  x[1] = Vec3(1, 0, 0) + d;
  const Vector f = t.forceAt(x);
  EXPECT_LT((Vec3(f[1]) + pull(1.3) * d / 1.3).norm(), 1e-12);
  EXPECT_EQ(Vec3(f[0]), Vec3::Zero());
  double work = 0;
  const int pieces = 20000;
  for (int i = 0; i < pieces; ++i) work += 1.3 / pieces * pull(1.3 * (i + 0.5) / pieces);
  EXPECT_NEAR(t.field.energy(x), work, 1e-7 * work);
  EXPECT_EQ(norm(t.force()), 0) << "no corner at the target";
}

TEST(PolynomialSprings, SayWhatIsWrong) {
  const auto told = [](const std::string& attributes) {
    return problemsOf(nodes("0 0 0  1 0 0", "<PolynomialSpringsForceField " + attributes + "/>"));
  };
  const std::string ends = "firstObjectPoints='0' secondObjectPoints='1' ";
  expectContains(told(ends + "polynomialStiffness='1 2 3'"), "has 3 coefficients, and polynomialDegree asks for 1");
  expectContains(told(ends + "polynomialDegree='0'"), "numbers from 1 on");
  expectContains(told(ends + "computeZeroLength='0'"), "there is no length at rest");
  expectContains(told("firstObjectPoints='0' secondObjectPoints='0'"), "joins node 0 to itself");
  expectContains(told("firstObjectPoints='0 1' secondObjectPoints='1'"), "as many of each");
  expectContains(told("firstObjectPoints='0' secondObjectPoints='7'"), "secondObjectPoints");
}

// ---- triangles ----

/// The corners of one triangle under a homogeneous strain have the forces of the plane stress: f_a = -A sigma g_a.
TEST(TriangularSprings, AreAMembraneForSmallStrains) {
  const double young = 700, poisson = 0.3, thickness = 0.1, size = 1e-6;
  Mat3 strain = Mat3::Zero();
  strain.topLeftCorner<2, 2>() << 0.7, 0.4, 0.4, -0.2;
  const double lambda = young * thickness * poisson / (1 - poisson * poisson), mu = young * thickness / (2 * (1 + poisson));
  Mat3 plane = Mat3::Identity();
  plane(2, 2) = 0;
  const Mat3 stress = lambda * strain.trace() * plane + 2 * mu * strain;
  const Vec3 rest[] = {{0, 0, 0}, {1.1, 0.1, 0}, {0.3, 0.9, 0}};
  const double area = (rest[1] - rest[0]).cross(rest[2] - rest[0]).z() / 2;
  for (const char* type : {"TriangularQuadraticSpringsForceField", "TriangularBiquadraticSpringsForceField",
                           "TriangularTensorMassForceField"}) {
    Start t(nodes("0 0 0  1.1 0.1 0  0.3 0.9 0",
                  fmt::format("<MeshTopology position='0 0 0  1.1 0.1 0  0.3 0.9 0' triangles='0 1 2'/><{} youngModulus='{}' "
                              "poissonRatio='{}' thickness='{}'/>",
                              type, young, poisson, thickness)));
    Vector x(3);
    for (Index a = 0; a < 3; ++a) x[a] = rest[a] + size * strain * rest[a];
    const Vector f = t.forceAt(x);
    for (Index a = 0; a < 3; ++a) {
      const Vec3 gradient = Vec3::UnitZ().cross(rest[(a + 2) % 3] - rest[(a + 1) % 3]) / (2 * area);
      EXPECT_LT((Vec3(f[a]) + area * size * stress * gradient).norm(), 1e-5 * size * stress.norm()) << type << " " << a;
    }
    const double energy = area * size * size * (lambda / 2 * strain.trace() * strain.trace() + mu * strain.squaredNorm());
    EXPECT_NEAR(t.field.energy(x), energy, 1e-4 * energy) << type;
  }
}

/// The biquadratic ones at any strain: E = A (lambda/2 tr(E)^2 + mu E:E) with Green's strain of the plane.
TEST(TriangularSprings, BiquadraticOnesAreStVenantsMembrane) {
  Start t(nodes("0 0 0  1 0 0  0 1 0",
                "<MeshTopology position='0 0 0  1 0 0  0 1 0' triangles='0 1 2'/><TriangularBiquadraticSpringsForceField "
                "youngModulus='100' poissonRatio='0.25' compressible='false'/>"));
  Vector x(3);
  x[0] = Vec3(0.1, 0.2, 0.3), x[1] = x[0] + Vec3(0.9, 0.4, -0.3), x[2] = x[0] + Vec3(-0.2, 1.3, 0.6);
  Eigen::Matrix<double, 3, 2> deformation;
  deformation << Vec3(x[1] - x[0]), Vec3(x[2] - x[0]);
  const Eigen::Matrix2d green = 0.5 * (deformation.transpose() * deformation - Eigen::Matrix2d::Identity());
  const double lambda = 100 * 0.25 / (1 - 0.0625), mu = 100 / 2.5;
  EXPECT_NEAR(t.field.energy(x), 0.5 * (lambda / 2 * green.trace() * green.trace() + mu * green.squaredNorm()), 1e-11);
}

/// With compressible a triangle of half its area has 3/4 (lambda + 2 mu) A / 16 more.
TEST(TriangularSprings, ALostAreaIsHeldOpen) {
  double energy[2];
  for (const bool resists : {false, true}) {
    Start t(nodes("0 0 0  1 0 0  0 1 0",
                  fmt::format("<MeshTopology position='0 0 0  1 0 0  0 1 0' triangles='0 1 2'/>"
                              "<TriangularBiquadraticSpringsForceField youngModulus='90' poissonRatio='0' compressible='{}'/>",
                              resists)));
    Vector x(3);
    x[0] = Vec3(0, 0, 0), x[1] = Vec3(1, 0, 0), x[2] = Vec3(0, 0.5, 0);
    energy[resists] = t.field.energy(x);
  }
  EXPECT_NEAR(energy[1] - energy[0], 0.75 * 90 * 0.5 / 16, 1e-12);
}

/// Without angular springs each side is a spring: three equal sides of length 1 have k = L^2 (c^2 (lambda + 2 mu) + mu)/(4 A).
TEST(TriangularSprings, AloneTheSidesAreSprings) {
  const double height = std::sqrt(0.75), area = height / 2, cotangent = 0.5 / height;
  Start t(nodes(fmt::format("0 0 0  1 0 0  0.5 {:.17g} 0", height),
                fmt::format("<MeshTopology position='0 0 0  1 0 0  0.5 {:.17g} 0' triangles='0 1 2'/>"
                            "<TriangularQuadraticSpringsForceField youngModulus='10' poissonRatio='0.2' useAngularSprings='false'/>",
                            height)));
  const double wave = 10 / (1 - 0.04), mu = 10 / 2.4, k = (cotangent * cotangent * wave + mu) / (4 * area);
  Vector x(3);
  copy(t.system.x, x);
  x[2] += Vec3(0, 0, 1);  // both of its sides are as long as they can be made by this
  const double length = std::sqrt(2.);
  EXPECT_NEAR(t.forceAt(x)[2].z(), -2 * k * (length - 1) / length, 1e-12);
}

/// Across its plane a triangle of the tensor mass is under the tension lambda + 2 mu: E = T A/2 |grad w|^2.
TEST(TriangularTensorMass, IsTautAcross) {
  Start t(nodes("0 0 0  1 0 0  0 1 0",
                "<MeshTopology position='0 0 0  1 0 0  0 1 0' triangles='0 1 2'/>"
                "<TriangularTensorMassForceField youngModulus='40' poissonRatio='0.5' thickness='0.3'/>"));
  Vector x(3);
  copy(t.system.x, x);
  x[1] += Vec3(0, 0, 0.2), x[2] += Vec3(0, 0, -0.1);
  const double tension = 40 * 0.3 / 0.75;
  EXPECT_NEAR(t.field.energy(x), tension * 0.5 / 2 * (0.04 + 0.01), 1e-13);
  EXPECT_NEAR(t.forceAt(x)[1].z(), -tension * 0.5 * 0.2, 1e-13);
}

/// Strains of a plate of rectangles in its plane, and shear across it by k G t; whichever way it lies.
TEST(QuadBending, IsAMembraneWithShearAcross) {
  const double young = 70, poisson = 0.3, thickness = 0.1, a = 2, b = 1;
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3 rest[] = {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0}};
  std::string places;
  for (const Vec3& p : rest) {
    const Vec3 q = turn * p;
    places += fmt::format("{:.17g} {:.17g} {:.17g}  ", q[0], q[1], q[2]);
  }
  Start t(nodes(places, fmt::format("<MeshTopology position='{}' quads='0 1 2 3'/><QuadBendingFEMForceField youngModulus='{}' "
                                    "poissonRatio='{}' thickness='{}'/>",
                                    places, young, poisson, thickness)));
  Mat3 gradient = Mat3::Zero();  // of displacements
  gradient.topLeftCorner<2, 2>() << 0.07, 0.04, 0.02, -0.02;
  gradient(2, 0) = 0.05, gradient(2, 1) = -0.03;
  Vector x(4);
  for (Index i = 0; i < 4; ++i) x[i] = turn * (rest[i] + gradient * rest[i]);
  const double e = young * thickness / (1 - poisson * poisson), shear = 0.06, across = 5. / 6 * young * thickness / (2 * (1 + poisson));
  const double plane = e * (0.07 * 0.07 + 0.02 * 0.02 - 2 * poisson * 0.07 * 0.02 + (1 - poisson) / 2 * shear * shear) / 2;
  EXPECT_NEAR(t.field.energy(x), a * b * (plane + across * (0.05 * 0.05 + 0.03 * 0.03) / 2), 1e-14);
  const Vector f = t.forceAt(x);
  const Vec3 pull = turn.transpose() * (Vec3(f[1]) + Vec3(f[2]));  // on the side x = a
  EXPECT_NEAR(pull[0], -b * e * (0.07 - poisson * 0.02), 1e-13);
  EXPECT_NEAR(pull[2], -b * across * 0.05, 1e-13);
  expectContains(problemsOf("<Node name='root'><EulerImplicitSolver/><CGLinearSolver/><MeshTopology position='0 0 0  1 0 0  1.2 1 0  "
                            "0 1 0' quads='0 1 2 3'/><MechanicalObject/><UniformMass totalMass='1'/><QuadBendingFEMForceField/></Node>"),
                 "quad 0 is no rectangle");
}

// ---- orientations ----

const std::string three_frames = "0 0 0  0.1 0.2 0.3 0.9273618495495704   1 0 0  0 0 0.6 0.8   2 0 0  0.28 0 0 0.96";

/// A frame of inertia I that a spring k holds to a fixed one turns with w = sqrt(k / I).
TEST(AngularSprings, AFrameTurnsBackWithItsPeriod) {
  const double h = 1e-3, k = 50, inertia = 0.2, w = std::sqrt(k / inertia), start = 0.3;
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject template="Rigid3"
      position="0 0 0  0 0 0 1   1 0 0  {:.17g} 0 0 {:.17g}"/><UniformMass totalMass="2" inertia="0.2 0.2 0.2"/>
      <FixedProjectiveConstraint indices="0"/><AngularSpringForceField indices="0 1" angularStiffness="50"/></Node>)",
      h, std::sin(start / 2), std::cos(start / 2)));
  for (int i = 0; i < 200; ++i) simulation.step();
  const double w_step = 2 / h * std::asin(w * h / 2), t = simulation.time();
  const double exact = start * (std::cos(w_step * t) - std::tan(w_step * h / 2) * std::sin(w_step * t));
  const State& state = *simulation.states().at(0);
  const Vec3 turn = rotationVector(orientationIn(state.x(), 3));
  EXPECT_NEAR(turn.x(), exact, 1e-9);
  EXPECT_LT(turn.tail<2>().norm(), 1e-12);
}

TEST(AngularSprings, TorquesBalanceUnlessTheyAreOneSided) {
  for (const bool one_sided : {false, true}) {
    Start t(nodes(three_frames,
                  fmt::format("<AngularSpringForceField indices='0 1 2' angularStiffness='7 20 30' oneSided='{}'/>", one_sided),
                  "template='Rigid3'"));
    const Vector f = t.force();
    const auto q = [&](Index frame) { return orientationIn(t.system.x, 2 * frame + 1); };
    const Vec3 first = rotationVector(q(1) * q(0).conjugate()), second = rotationVector(q(2) * q(1).conjugate());
    const Vec3 back = one_sided ? Vec3(Vec3::Zero()) : Vec3(30 * second);
    EXPECT_LT((Vec3(f[3]) - (back - 20 * first)).norm(), 1e-12);
    EXPECT_LT((Vec3(f[5]) + 30 * second).norm(), 1e-12);
    EXPECT_LT((Vec3(f[1]) - (one_sided ? Vec3(Vec3::Zero()) : Vec3(20 * first))).norm(), 1e-12);
    EXPECT_EQ(Vec3(f[0]), Vec3::Zero());
  }
}

/// Energy, force and tangent against each other: the tangent is the symmetric part, without half of the torque's own turn.
TEST(AngularSprings, ForceAndTangentAreThoseOfTheEnergy) {
  Start t(nodes(three_frames, "<AngularSpringForceField indices='0 1 2' angularStiffness='20'/>", "template='Rigid3'"));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vector d(6);
  for (Index i = 0; i < 6; ++i) d[i] = Vec3(uniform(random), uniform(random), uniform(random));
  const double h = 1e-5;
  const auto moved = [&](double s) {
    Vector x(6);
    copy(t.system.x, x);
    t.system.motion().advance(s, d, x);
    return x;
  };
  const Vector f = t.force();
  EXPECT_NEAR((t.field.energy(moved(h)) - t.field.energy(moved(-h))) / (2 * h), -dot(f, d), 1e-7 * norm(f));
  const Vector plus = t.forceAt(moved(h)), minus = t.forceAt(moved(-h));
  t.force();
  Vector product(6);
  t.field.addStiffnessProduct(d, 1, product);
  for (Index i = 0; i < 6; ++i) {
    Vec3 exact = (plus[i] - minus[i]) / (2 * h);
    if (i % 2 == 1) exact -= 0.5 * Vec3(d[i]).cross(Vec3(f[i]));
    EXPECT_LT((exact - product[i]).norm(), 1e-7 * norm(product)) << i;
  }
}

TEST(AngularSprings, ActBetweenTheirLimitsOnly) {
  const auto torque = [](const std::string& limit) {
    Start t(nodes("0 0 0  0 0 0 1   1 0 0  0 0 0.6 0.8", "<AngularSpringForceField indices='0 1' " + limit + "/>", "template='Rigid3'"));
    return t.force()[3].norm();
  };
  const double angle = 2 * std::asin(0.6);
  EXPECT_NEAR(torque(""), 100 * angle, 1e-10);
  EXPECT_NEAR(torque("limit='0.5 2'"), 100 * angle, 1e-10);
  EXPECT_EQ(torque("limit='1.5 2'"), 0);
  EXPECT_EQ(torque("limit='0 1'"), 0);
}

TEST(AngularSprings, SayWhatIsWrong) {
  const auto told = [](const std::string& attributes, const std::string& state) {
    return problemsOf(nodes(state.empty() ? "0 0 0  1 0 0" : three_frames, "<AngularSpringForceField " + attributes + "/>", state));
  };
  expectContains(told("indices='0 1'", ""), "have no orientation");
  expectContains(told("indices='0'", "template='Rigid3'"), "there is no spring");
  expectContains(told("indices='0 1' angularStiffness='1 2 3'", "template='Rigid3'"), "angularStiffness has 3 values");
  expectContains(told("indices='0 1' angularStiffness='1 2 3' oneSided='true'", "template='Rigid3'"), "angularStiffness has 3 values");
  expectContains(told("indices='0 1' limit='2 1'", "template='Rigid3'"), "leave no angle");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
