// SPDX-License-Identifier: LGPL-2.1-or-later
// A cone that keeps nodes, forces about an axis, and ellipsoids that move with a frame.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// The first force field of a scene, at any positions.
struct Load {
  Simulation simulation;
  System& system;
  ForceField& field;
  explicit Load(const std::string& text)
      : simulation(simulationFromText(text)), system(*simulation.systems().at(0)), field(*system.forceFields().at(0)) {}
  Vector forceAt(ConstRows x) {
    Vector v(system.allRows());
    return forceAt(x, v);
  }
  Vector forceAt(ConstRows x, ConstRows v) {
    Vector f(system.allRows());
    field.addForce(x, v, f);
    return f;
  }
};

std::string one(const std::string& position, const std::string& load, const std::string& state = "") {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MechanicalObject position="{}" {}/><UniformMass totalMass="2"/>{}</Node>)",
                     position, state, load);
}

// ---- cone ----

struct Place {
  Vec3 x, direction;  ///< of the force
  double distance;
};

/// A cone of 30 degrees and height 2 about y, its tip at (1, 0, 0): inside, beyond the side, the cap, the tip and the rim.
TEST(Cone, PushesByTheDistanceFromIt) {
  const double s = 0.5, c = std::sqrt(0.75);
  const Vec3 tip(1, 0, 0), generator(s, c, 0), outward(c, -s, 0);
  const Vec3 rim = tip + 2 * generator;
  const Place places[] = {{tip + Vec3(0.1, 1, 0), Vec3::Zero(), 0},
                          {tip + Vec3(0, 1.99, 0), Vec3::Zero(), 0},
                          {tip + generator + 0.3 * outward, -outward, 0.3},
                          {tip + 2.7 * Vec3(std::sin(0.2), std::cos(0.2), 0), -Vec3(std::sin(0.2), std::cos(0.2), 0), 0.7},
                          {tip + Vec3(0, -0.4, 0), Vec3(0, 1, 0), 0.4},
                          {tip - 0.5 * generator + 0.2 * outward, Vec3::Zero(), 0.0},
                          {rim + 0.3 * generator + 0.4 * outward, -(0.6 * generator + 0.8 * outward), 0.5}};
  Load t(one("0 0 0", "<ConicalForceField coneCenter='1 0 0' coneHeight='0 2 0' coneAngle='30' stiffness='10' damping='0'/>"));
  for (const Place& place : places) {
    Vector x(1);
    x[0] = place.x;
    Vec3 expected = 10 * place.distance * place.direction;
    if (place.distance == 0 && place.x.y() < 0) expected = -10 * (place.x - tip);  // before the tip, beside the axis
    EXPECT_LT((Vec3(t.forceAt(x)[0]) - expected).norm(), 1e-12) << place.x.transpose();
    EXPECT_NEAR(t.field.energy(x), expected.squaredNorm() / 20, 1e-12) << place.x.transpose();
  }
}

/// The tangent is the derivative in each part, and nothing jumps between two of them.
TEST(Cone, ItsTangentIsTheDerivative) {
  Load t(one("0 0 0", "<ConicalForceField coneHeight='1 2 -1' coneAngle='50' stiffness='10' damping='0'/>"));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-4, 4);
  int pushed = 0;
  for (int i = 0; i < 200; ++i) {
    Vector x(1), d(1), product(1), there(1), back(1);
    x[0] = Vec3(uniform(random), uniform(random), uniform(random));
    d[0] = Vec3(uniform(random), uniform(random), uniform(random));
    copy(x, there), axpy(1e-6, d, there), copy(x, back), axpy(-1e-6, d, back);
    const Vec3 difference = (Vec3(t.forceAt(there)[0]) - Vec3(t.forceAt(back)[0])) / 2e-6;
    t.forceAt(x);
    t.field.addStiffnessProduct(d, 1, product);
    EXPECT_LT((difference - Vec3(product[0])).norm(), 1e-5 * 10 * d[0].norm()) << x[0].transpose();
    pushed += norm(product) > 0;
  }
  EXPECT_GT(pushed, 150);
}

TEST(Cone, SaysWhatIsWrong) {
  expectContains(problemsOf(one("0 0 0", "<ConicalForceField coneHeight='0 0 0'/>")), "coneHeight has no direction");
  expectContains(problemsOf(one("0 0 0", "<ConicalForceField/>")), "coneHeight");
  expectContains(problemsOf(one("0 0 0", "<ConicalForceField coneHeight='0 1 0' coneAngle='120'/>")), "coneAngle");
}

// ---- torsion ----

TEST(Torsion, TheMomentGrowsWithTheSquareOfTheDistance) {
  Load t(one("1 0 0  1 3 5  2 2 -1", "<TorsionForceField indices='1 2' torque='4' axis='0 0 3' origin='1 1 7'/>"));
  const Vector f = t.forceAt(t.system.x);
  EXPECT_EQ(Vec3(f[0]), Vec3::Zero());
  EXPECT_LT((Vec3(f[1]) - Vec3(-8, 0, 0)).norm(), 1e-13);
  EXPECT_LT((Vec3(f[2]) - Vec3(-4, 4, 0)).norm(), 1e-13);
  double moment = 0;
  for (Index i = 0; i < 3; ++i) moment += (Vec3(t.system.x[i]) - Vec3(1, 1, 7)).cross(Vec3(f[i])).z();
  EXPECT_NEAR(moment, 4 * (4 + 2), 1e-12);
}

TEST(Torsion, AFrameGetsTheTorqueBesides) {
  Load t(one("2 0 0  0 0 0 1", "<TorsionForceField indices='0' torque='3' axis='0 1 0'/>", "template='Rigid3'"));
  const Vector f = t.forceAt(t.system.x);
  EXPECT_LT((Vec3(f[0]) - Vec3(0, 0, -6)).norm(), 1e-13);
  EXPECT_LT((Vec3(f[1]) - Vec3(0, 3, 0)).norm(), 1e-13);
}

/// Against springs k a node at distance r rests where both forces balance: (x - x0) k = tau u x x.
TEST(Torsion, BalancesWithSprings) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.1" gravity="0 0 0"><StaticSolver newton_iterations="200" relative_residual_tolerance_threshold="1e-12"/>
      <SparseLDLSolver/><MechanicalObject position="1 0 0"/><RestShapeSpringsForceField stiffness="100"/>
      <TorsionForceField indices="0" torque="20" axis="0 0 1"/></Node>)");
  for (int i = 0; i < 5; ++i) simulation.step();
  const double r = 0.2;  // (1 + i r) is what divides: x = 1/(1 - i r)
  const Vec3 x = simulation.states().at(0)->x()[0];
  EXPECT_NEAR(x.x(), 1 / (1 + r * r), 1e-8);
  EXPECT_NEAR(x.y(), r / (1 + r * r), 1e-8);
}

TEST(Torsion, SaysWhatIsWrong) {
  expectContains(problemsOf(one("0 0 0", "<TorsionForceField indices='0' torque='1' axis='0 0 0'/>")), "axis has no direction");
  expectContains(problemsOf(one("0 0 0", "<TorsionForceField indices='3' torque='1' axis='0 0 1'/>")), "indices");
}

// ---- a turned plate ----

std::string plate(const std::string& attributes) {
  return R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MeshTopology position="0 0 0  2 0 0  2 1 0  0 2 0  0 0 5" triangles="0 1 2  0 2 3  0 1 4"/><MechanicalObject/>
    <UniformMass totalMass="5"/><OscillatingTorsionPressureForceField axis="0 0 3" )" +
         attributes + "/></Node>";
}

/// Whatever the shape, the moment about the axis is M cos(2 pi f t), and a part that turned as a whole only gets that.
TEST(TurnedPlate, HasTheMomentOfItsTime) {
  Load t(plate("moment='3' frequency='2' phase='0.3' penalty='50' center='0.5 0.5 0' triangleList='0 1'"));
  const double moment = 3 * std::cos(2 * std::numbers::pi * 2 * 0.1 + 0.3);
  t.field.setTime(0.1);
  const Vec3 centre(0.5, 0.5, 0);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  for (const double noise : {0., 0.2}) {
    Vector x(5);
    for (Index i = 0; i < 5; ++i)
      x[i] = centre + turn * (Vec3(t.system.x[i]) - centre) + noise * Vec3(std::sin(i), std::cos(2 * i), std::sin(3 * i + 1));
    const Vector f = t.forceAt(x);
    double sum = 0;
    for (Index i = 0; i < 5; ++i) sum += (Vec3(x[i]) - centre).cross(Vec3(f[i])).z();
    EXPECT_NEAR(sum, moment, 1e-12) << noise;
    EXPECT_EQ(Vec3(f[4]), Vec3::Zero()) << "not of the part";
    if (noise > 0) continue;
    EXPECT_NEAR(t.field.energy(x), 0, 1e-25) << "it kept its shape";
    for (Index i = 0; i < 4; ++i) EXPECT_NEAR(f[i].dot(Vec3(x[i]) - centre), 0, 1e-13) << "across the radius alone";
  }
}

/// The shares of the corners of one triangle, by hand: distances 0, 2 and 2 from the axis through its first corner.
TEST(TurnedPlate, SharesTheMomentByTheDistance) {
  Load t(R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <MeshTopology position="0 0 0  2 0 0  0 2 0" triangles="0 1 2"/><MechanicalObject/><UniformMass totalMass="5"/>
    <OscillatingTorsionPressureForceField moment="8"/></Node>)");
  t.field.setTime(0);
  const Vector f = t.forceAt(t.system.x);
  EXPECT_LT(Vec3(f[0]).norm(), 1e-13);
  EXPECT_LT((Vec3(f[1]) - Vec3(0, 2, 0)).norm(), 1e-13);
  EXPECT_LT((Vec3(f[2]) - Vec3(-2, 0, 0)).norm(), 1e-13);
}

TEST(TurnedPlate, IsChosenByNumbersOrByPlanes) {
  const auto turned = [](const std::string& attributes) {
    Load t(plate("moment='1' " + attributes));
    t.field.setTime(0);
    const Vector f = t.forceAt(t.system.x);
    std::string nodes;
    for (Index i = 0; i < 5; ++i) nodes += f[i].norm() > 0 ? "1" : "0";
    return nodes;
  };
  EXPECT_EQ(turned("center='9 0 0'"), "11111");
  EXPECT_EQ(turned("center='9 0 0' triangleList='0'"), "11100");
  EXPECT_EQ(turned("center='9 0 0' dmin='-1' dmax='1'"), "11110");
  expectContains(problemsOf(plate("moment='1' dmin='7' dmax='8'")), "the part has no triangle");
  expectContains(problemsOf(plate("moment='1' triangleList='3'")), "triangleList names 3");
}

// ---- ellipsoids of a frame ----

std::string ellipsoids(const std::string& attributes, const std::string& points = "0.5 0.2 0  0.1 0.3 0.1") {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <Node name="rigid"><MechanicalObject name="dofs" template="Rigid3" position="0.1 0 0.2  0.1 0.2 0.3 0.9273618495495704"/>
    <UniformMass totalMass="1" inertia="0.1 0.1 0.1"/></Node>
    <Node name="soft"><MechanicalObject name="dofs" position="{}"/><UniformMass totalMass="1"/></Node>
    <InteractionEllipsoidForceField object1="@soft/dofs" object2="@rigid/dofs" {}/></Node>)",
                     points, attributes);
}

/// A sphere: the depth is that of the radius, whatever the turn of the frame; the reaction acts at the point.
TEST(EllipsoidOfAFrame, ASpherePushesAlongItsRadius) {
  Load t(ellipsoids("center='0.2 0 0' vradius='1 1 1' stiffness='50' damping='0'"));
  const Quaternion turn = orientationIn(t.system.x, 1);
  const Vec3 centre = Vec3(0.1, 0, 0.2) + turn * Vec3(0.2, 0, 0);
  const Vector f = t.forceAt(t.system.x);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (Index i = 2; i < 4; ++i) {
    const Vec3 y = Vec3(t.system.x[i]) - centre;
    EXPECT_LT((Vec3(f[i]) - 50 * (1 - y.norm()) * y.normalized()).norm(), 1e-12);
    force += f[i], torque += (Vec3(t.system.x[i]) - Vec3(0.1, 0, 0.2)).cross(Vec3(f[i]));
  }
  EXPECT_LT((Vec3(f[0]) + force).norm(), 1e-12);
  EXPECT_LT((Vec3(f[1]) + torque).norm(), 1e-12);
}

TEST(EllipsoidOfAFrame, KeepsInsideWithANegativeStiffnessAndFeelsNothingWhenToldSo) {
  Load t(ellipsoids("center='0 0 0' vradius='1 1 1' stiffness='-50' damping='0' object2_forces='false'", "0.1 2 0.2"));
  const Vector f = t.forceAt(t.system.x);
  EXPECT_LT((Vec3(f[2]) - Vec3(0, -50, 0)).norm(), 1e-12);
  EXPECT_EQ(Vec3(f[0]), Vec3::Zero());
  EXPECT_EQ(Vec3(f[1]), Vec3::Zero());
}

/// Energy, force and tangents against each other, with two ellipsoids and damping.
TEST(EllipsoidOfAFrame, ForceAndTangentsAreThoseOfTheEnergy) {
  for (const bool damped : {false, true}) {
    Load t(ellipsoids(fmt::format("center='0 0 0  0.4 0 0' vradius='1 0.6 0.8  0.5 0.9 0.5' stiffness='50' damping='{}'", damped ? 7 : 0),
                      "0.5 0.2 0.1  0.1 0.3 0.1  -0.4 0 0.3"));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const Index rows = t.system.allRows();
    Vector d(rows), v(rows);
    for (Index i = 0; i < rows; ++i) d[i] = Vec3(uniform(random), uniform(random), uniform(random));
    const double h = 1e-6;
    const auto moved = [&](double s) {
      Vector x(rows);
      copy(t.system.x, x);
      t.system.motion().advance(s, d, x);
      return x;
    };
    const Vector f = t.forceAt(t.system.x);
    EXPECT_NEAR((t.field.energy(moved(h)) - t.field.energy(moved(-h))) / (2 * h), -dot(f, d), 1e-6 * norm(f) * norm(d));
    const Vector plus = t.forceAt(moved(h)), minus = t.forceAt(moved(-h));
    t.forceAt(t.system.x);
    Vector product(rows);
    t.field.addStiffnessProduct(d, 1, product);
    for (Index i = 0; i < rows; ++i) {
      Vec3 exact = (plus[i] - minus[i]) / (2 * h);
      if (i == 1) exact -= 0.5 * Vec3(d[i]).cross(Vec3(f[i]));
      EXPECT_LT((exact - product[i]).norm(), 1e-5 * norm(product)) << i;
    }
    if (!damped) continue;
    Vector faster(rows), slower(rows), damping(rows);
    axpy(1, d, faster), axpy(-1, d, slower);
    const Vector fast = t.forceAt(t.system.x, faster), slow = t.forceAt(t.system.x, slower);
    t.forceAt(t.system.x, v);
    t.field.addDampingProduct(d, 1, damping);
    for (Index i = 0; i < rows; ++i) EXPECT_LT(((fast[i] - slow[i]) / 2 - damping[i]).norm(), 1e-12 * norm(damping)) << i;
    EXPECT_LT(dot(d, damping), 0);
  }
}

TEST(EllipsoidOfAFrame, SaysWhatIsWrong) {
  expectContains(problemsOf(ellipsoids("center='0 0 0' vradius='1 1 1  2 2 2'")), "center has 1 and vradius 2 vectors");
  expectContains(problemsOf(ellipsoids("center='0 0 0' vradius='1 0 1'")), "vradius is not positive");
  expectContains(problemsOf(ellipsoids("center='0 0 0' vradius='1 1 1' object2_dof_index='4'")), "object2_dof_index");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
