// SPDX-License-Identifier: LGPL-2.1-or-later
// Chains of beams as the plug-in BeamAdapter describes them: forces, inertia and weight against closed forms.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "framework/mechanics/mass.h"
#include "tests/beams/frame_field.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr double young = 1e9, radius = 0.02, density = 800, length = 2;
const double area = std::numbers::pi * radius * radius, bending = young * std::numbers::pi * std::pow(radius, 4) / 4;

std::string chain(int beams, const std::string& integrator, const std::string& more, const std::string& gravity = "0 0 0",
                  const std::string& attributes = "") {
  std::string position, edges;
  for (int i = 0; i <= beams; ++i) position += fmt::format("{} 0 0  0 0 0 1  ", length * i / beams);
  for (int i = 0; i < beams; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  return fmt::format(R"(<Node name="root" gravity="{}">{}<SparseLDLSolver/><MeshTopology edges="{}"/>
    <MechanicalObject name="dofs" template="Rigid3" position="{}"/>
    <BeamInterpolation name="beams" defaultYoungModulus="{}" defaultPoissonRatio="0.3" radius="{}" {}/>
    <AdaptiveBeamForceFieldAndMass name="field" interpolation="@beams" massDensity="{}"/>
    <FixedProjectiveConstraint indices="0"/>{}</Node>)",
                     gravity, integrator, edges, position, young, radius, attributes, density, more);
}

TEST(BeamChains, ACantileverBendsByAForceAndByItsWeight) {
  for (const int beams : {1, 3}) {
    const double force = 1e-3;
    Simulation pulled = simulationFromText(
        chain(beams, "<StaticSolver/>", fmt::format("<ConstantForceField indices=\"{}\" forces=\"0 {} 0 0 0 0\"/>", beams, force)));
    ASSERT_TRUE(pulled.step().newton_converged);
    const double exact = force * std::pow(length, 3) / (3 * bending);
    EXPECT_NEAR(pulled.systems()[0]->x[2 * beams].y(), exact, 1e-4 * exact);
    Simulation heavy = simulationFromText(chain(beams, "<StaticSolver/>", "", "0 0 -0.001"));
    ASSERT_TRUE(heavy.step().newton_converged);
    const double sag = 0.001 * density * area * std::pow(length, 4) / (8 * bending);
    EXPECT_NEAR(-heavy.systems()[0]->x[2 * beams].z(), sag, 1e-4 * sag) << "exact at nodes";
  }
}

TEST(BeamChains, AnEndMomentRollsABeamUp) {
  for (const int beams : {4, 10}) {
    Simulation simulation = simulationFromText(
        chain(beams, "<StaticSolver/>",
              fmt::format("<ConstantForceField indices=\"{}\" forces=\"0 0 0 0 0 {:.17g}\"/><PartialFixedProjectiveConstraint "
                          "indices=\"1-{}\" fixedDirections=\"0 0 1 1 1 0\"/>",
                          beams, 2 * std::numbers::pi * bending / length, beams)));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_LT(simulation.systems()[0]->x[2 * beams].norm(), 1e-8 * length) << beams;
  }
}

TEST(BeamChains, ARectangleIsStifferAcrossItsLongSide) {
  for (const int side : {1, 2}) {
    Simulation simulation = simulationFromText(
        chain(2, "<StaticSolver/>",
              fmt::format("<ConstantForceField indices=\"2\" forces=\"0 {} {} 0 0 0\"/>", side == 1 ? 1e-3 : 0, side == 2 ? 1e-3 : 0),
              "0 0 0", "crossSectionShape=\"rectangular\" lengthY=\"0.03\" lengthZ=\"0.01\""));
    ASSERT_TRUE(simulation.step().newton_converged);
    const double moment = side == 1 ? 0.01 * std::pow(0.03, 3) / 12 : 0.03 * std::pow(0.01, 3) / 12;
    const double exact = 1e-3 * std::pow(length, 3) / (3 * young * moment);
    EXPECT_NEAR(simulation.systems()[0]->x[4][side], exact, 1e-3 * exact);
  }
}

/// The stiffness and the mass of a chain's free rows, for small motion.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> matricesOf(System& system) {
  Vector f(system.allRows()), v(system.allRows()), unit(system.allRows()), out(system.allRows());
  system.computeForce(system.x, v, f);
  const Index rows = system.allRows() - 2;
  Eigen::MatrixXd k(3 * rows, 3 * rows), m(3 * rows, 3 * rows);
  for (Index c = 0; c < 3 * rows; ++c) {
    clear(unit), unit[2 + c / 3][c % 3] = 1;
    for (Eigen::MatrixXd* each : {&k, &m}) {
      clear(out);
      if (each == &k) for (ForceField* field : system.forceFields()) field->addStiffnessProduct(unit, -1, out);
      else system.addMassProduct(unit, 1, out);
      for (Index r = 0; r < 3 * rows; ++r) (*each)(r, c) = out[2 + r / 3][r % 3];
    }
  }
  return {k, m};
}

TEST(BeamChains, FrequenciesAreThoseOfACantilever) {
  Simulation simulation = simulationFromText(chain(8, "<EulerImplicitSolver/>", ""));
  const auto [k, m] = matricesOf(*simulation.systems()[0]);
  EXPECT_LT((m - m.transpose()).norm(), 1e-14 * m.norm());
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, m, Eigen::EigenvaluesOnly);
  const double unit = std::sqrt(bending / (density * area * std::pow(length, 4)));
  // each twice, in both planes; the inertia of the turning sections takes less than the tolerance
  const double exact[] = {1.87510407, 4.69409113, 7.85475744};
  for (int i = 0; i < 3; ++i)
    for (int plane : {0, 1})
      EXPECT_NEAR(std::sqrt(modes.eigenvalues()[2 * i + plane]) / (unit * exact[i] * exact[i]), 1, 3e-3) << i;
}

const std::string bent = R"(<Node name="root" gravity="{}"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology edges="0 1  1 2"/>
    <MechanicalObject template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9   1 0.2 0  0 0 0 1   2 0 0.3  -0.2 0 0.1 0.9"/>
    <BeamInterpolation name="beams" straight="false" defaultYoungModulus="2e4 3e4" defaultPoissonRatio="0.3"
      crossSectionShape="rectangular" lengthY="0.2" lengthZ="0.1"/>
    <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000"/></Node>)";

TEST(BeamChains, ForceIsTheSlopeOfTheEnergyAndStiffnessThatOfTheForce) {
  FrameField t(fmt::format(fmt::runtime(bent), "1 -9 2"));
  for (const double size : {0.01, 0.3, 0.7}) {
    SCOPED_TRACE(size);
    t.expectSlopes(t.movedBy(1, randomRows(6, 3, size), t.system.x), randomRows(6, 4, 1));
  }
}

TEST(BeamChains, ABentShapeIsAtRestWhereverItIsAndFallsAsAWhole) {
  FrameField still(fmt::format(fmt::runtime(bent), "0 0 0"));
  Vector x(6);
  copy(still.system.x, x);
  for (Index i = 0; i < 6; i += 2) {
    x[i] = turnedBy(Vec3(0.5, -2, 1)) * Vec3(x[i]) + Vec3(1, 2, 3);
    Motion::turnBy(Vec3(0.5, -2, 1), x.rows().data + std::size_t(i + 1) * row_doubles);
  }
  EXPECT_LT(norm(still.forceAt(x)), 1e-9);
  // momentum of a motion along is mass times velocity, and the weight is mass times gravity
  FrameField heavy(fmt::format(fmt::runtime(bent), "1 -9 2"));
  const Vector f = heavy.forceAt(x);
  Vector along(6), momentum(6);
  for (Index i = 0; i < 6; i += 2) along[i] = Vec3(1, -9, 2);
  heavy.system.addMassProduct(along, 1, momentum);
  const double mass = heavy.system.masses()[0]->totalMass();
  const double chords = std::sqrt(1.04) + std::sqrt(1.13);  // and the curves are longer
  EXPECT_GT(mass, 1000 * 0.02 * chords);
  EXPECT_LT(mass, 1000 * 0.02 * 1.05 * chords);
  Vec3 force = Vec3::Zero(), carried = Vec3::Zero();
  for (Index i = 0; i < 6; i += 2) force += f[i], carried += momentum[i];
  EXPECT_LT((force - mass * Vec3(1, -9, 2)).norm(), 1e-9 * force.norm());
  EXPECT_LT((carried - mass * Vec3(1, -9, 2)).norm(), 1e-12 * force.norm());
}

/// A load P at the length a of a cantilever bends its end by P a^2 (3 L - a)/(6 E I), and the place itself, where no node
/// is, as the cubic curve says that has the deflections w and slopes t of the ends: w s^2 (3 - 2 s) + t L s^2 (s - 1).
TEST(BeamChains, ALoadBetweenNodesBendsAsOneOnTheBeam) {
  for (const int beams : {1, 2}) {
    const double force = 1e-3, at = 0.8;
    Simulation simulation = simulationFromText(chain(
        beams, "<StaticSolver/>",
        fmt::format("<Node name=\"on\"><MechanicalObject name=\"points\" position=\"{} 0 0  {} 0 0.02\"/><AdaptiveBeamMapping "
                    "interpolation=\"@../beams\"/><ConstantForceField indices=\"0\" forces=\"0 {} 0\"/></Node>",
                    at, length, force)));
    ASSERT_TRUE(simulation.step().newton_converged);
    const double exact = force * at * at * (3 * length - at) / (6 * bending);
    const Vec3 tip = simulation.systems()[0]->x[2 * beams];
    EXPECT_NEAR(tip.y(), exact, 1e-4 * exact) << beams;
    const State& points = *simulation.states()[1];
    EXPECT_NEAR(points.x()[1].y(), tip.y(), 1e-12);
    EXPECT_NEAR(points.x()[1].z(), 0.02, 1e-6);
    const double end = length / beams, s = at / end;  // of the first beam
    const double way = force * at * at * (3 * end - at) / (6 * bending), slope = force * at * at / (2 * bending);
    const double cubic = way * s * s * (3 - 2 * s) + slope * end * s * s * (s - 1);
    EXPECT_NEAR(points.x()[0].y(), cubic, 1e-4 * cubic);
  }
}

/// A thin rod whose inertia is not that of a body: what reads tensors finds the lumped ones.
TEST(BeamChains, WhatReadsTensorsFindsTheLumpedOnes) {
  Simulation simulation = simulationFromText(chain(4, "<EulerImplicitSolver/>", ""));
  const Mass& mass = *simulation.systems()[0]->masses()[0];
  EXPECT_NEAR(mass.totalMass(), density * area * length, 1e-12);
  ASSERT_TRUE(mass.turns());
  for (const TurningInertia& one : mass.turningInertias())
    EXPECT_EQ(Mat3(one.inertia), Mat3(mass.lumped()[std::size_t(one.row)] * Mat3::Identity())) << one.row;
}

/// What beams are made of may change in a run.
TEST(BeamChains, TheMassIsThatOfThePresentAttributes) {
  Simulation simulation = simulationFromText(chain(4, "<EulerImplicitSolver/>", ""));
  const Mass& mass = *simulation.systems()[0]->masses()[0];
  simulation.setAttribute("/field", "massDensity", "1600");
  EXPECT_NEAR(mass.totalMass(), 2 * density * area * length, 1e-12);
  simulation.setAttribute("/beams", "radius", "0.04");
  EXPECT_NEAR(mass.totalMass(), 8 * density * area * length, 1e-12);
  simulation.step();
  EXPECT_NEAR(mass.totalMass(), 8 * density * area * length, 1e-12);
  for (const TurningInertia& one : mass.turningInertias())
    EXPECT_EQ(Mat3(one.inertia), Mat3(mass.lumped()[std::size_t(one.row)] * Mat3::Identity())) << one.row;
  System& system = *simulation.systems()[0];
  Vector rigid(system.allRows()), momentum(system.allRows());
  for (Index row = 0; row < system.allRows(); row += 2) rigid[row] = Vec3::UnitX();
  system.addMassProduct(rigid, 1, momentum);
  double sum = 0;
  for (Index row = 0; row < system.allRows(); row += 2) sum += momentum[row].x();
  EXPECT_NEAR(sum, 8 * density * area * length, 1e-12) << "and so is M";
}

TEST(BeamChains, TheDensityIsThatOfTheRodThatIsNamed) {
  const std::string scene = R"(<Node name="root"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology edges="0 1  1 2" name="line"/>
    <WireRestShape name="shape" length="2" straightLength="1" spireDiameter="9" spireHeight="0" radius="1" radiusExtremity="1"
      youngModulus="1" youngModulusExtremity="1" massDensity="4000" massDensityExtremity="100"/>
    <MechanicalObject template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1"/>
    <BeamInterpolation name="beams" topology="@line" defaultYoungModulus="1e9" radius="0.02"/>
    <AdaptiveBeamForceFieldAndMass interpolation="@beams" {}/></Node>)";
  const auto massOf = [&](const std::string& attributes) {
    Simulation simulation = simulationFromText(fmt::format(fmt::runtime(scene), attributes));
    return simulation.systems()[0]->masses()[0]->totalMass();
  };
  EXPECT_NEAR(massOf("massDensity=\"7\""), 7 * area * 2, 1e-12);
  EXPECT_NEAR(massOf("instrumentParameters=\"@shape\""), 4100 * area, 1e-10);
}

/// A fast spin that is turned: with the forces by which M turns momenta and energy stay, and without them angular momentum does not.
TEST(BeamChains, AngularMomentumStaysWhereASpinIsTurned) {
  for (const bool turns : {true, false}) {
    constexpr double spin = 100, turn = 1, time = 0.1, r = 0.02, l = 0.5;
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" gravity="0 0 0" dt="1e-4"><RungeKutta4Solver/><SparseLDLSolver/><MeshTopology edges="0 1  1 2  2 3  3 4"/>
    <MechanicalObject template="Rigid3" position="0 0 0 0 0 0 1  0.125 0 0 0 0 0 1  0.25 0 0 0 0 0 1  0.375 0 0 0 0 0 1  0.5 0 0 0 0 0 1"
      velocity="0 -0.25 0 {0} 0 1  0 -0.125 0 {0} 0 1  0 0 0 {0} 0 1  0 0.125 0 {0} 0 1  0 0.25 0 {0} 0 1"/>
    <BeamInterpolation name="beams" defaultYoungModulus="1e6" defaultPoissonRatio="0.3" radius="{1}"/>
    <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000" turningForces="{2}"/></Node>)", spin, r, turns));
    System& system = *simulation.systems()[0];
    const auto momentum = [&] {
      Vector p(system.allRows()), v(system.allRows()), f(system.allRows());
      system.computeForce(system.x, v, f);
      system.addMassProduct(system.v, 1, p);
      Vec3 sum = Vec3::Zero();
      for (Index row = 0; row < system.allRows(); row += 2) sum += Vec3(system.x[row]).cross(Vec3(p[row])) + Vec3(p[row + 1]);
      return sum;
    };
    const auto energy = [&] { return system.kineticEnergy() + system.elasticEnergy(system.x); };
    const double at_first = energy();
    const Vec3 start = momentum();
    const double mass = 1000 * std::numbers::pi * r * r * l, about = mass * r * r / 2 * spin;
    EXPECT_NEAR(start.x(), about, 1e-9);
    EXPECT_NEAR(start.z(), mass * (l * l / 12 + r * r / 4) * turn, 1e-9);
    while (simulation.time() < time - 1e-9) ASSERT_FALSE(simulation.step().diverged);
    const double drift = (momentum() - start).norm();
    EXPECT_NEAR(drift / start.norm(), turns ? 0 : 0.16, turns ? 1e-5 : 0.01);
    if (turns) EXPECT_NEAR(energy(), at_first, 1e-6 * at_first);
  }
}

/// A quarter of a circle, whose ends turn differently: M turns as the middle axes do, which the mean of the ends' turnings is not.
TEST(BeamChains, EnergyStaysWhereAMuchBentBeamTurns) {
  for (const double bend : {0.8, -0.8}) {
    const double c = std::cos(bend / 2), s = std::sin(bend / 2);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" gravity="0 0 0" dt="2e-5"><RungeKutta4Solver/><SparseLDLSolver/><MeshTopology edges="0 1"/>
    <MechanicalObject template="Rigid3" position="0 0 0 0 0 {} {}  0.4 0 0 0 0 {} {}" velocity="0 -1 0 40 0 5  0 1 0.5 10 20 5"/>
    <BeamInterpolation name="beams" defaultYoungModulus="1e4" defaultPoissonRatio="0.3" radius="0.05"/>
    <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000"/></Node>)", -s, c, s, c));
    System& system = *simulation.systems()[0];
    const auto energy = [&] {
      Vector v(system.allRows()), f(system.allRows());
      system.computeForce(system.x, v, f);
      return system.kineticEnergy() + system.elasticEnergy(system.x);
    };
    const double start = energy();
    while (simulation.time() < 0.05 - 1e-9) ASSERT_FALSE(simulation.step().diverged);
    EXPECT_NEAR(energy() / start, 1, 1e-7);
  }
}

TEST(BeamChains, SayWhatIsWrong) {
  const auto problems = [](const std::string& beams, const std::string& field) {
    return problemsOf(R"(<Node name="root"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology edges="0 1"/>
        <MechanicalObject template="Rigid3"
      position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><BeamInterpolation name="beams" )" +
                      beams + "/><AdaptiveBeamForceFieldAndMass massDensity=\"1\" " + field + "/></Node>");
  };
  EXPECT_EQ(problems("defaultYoungModulus=\"1e5\"", ""), "");
  expectContains(problems("defaultYoungModulus=\"1 2 3\"", ""), "defaultYoungModulus has 3 numbers for 1 beams");
  expectContains(problems("edgeList=\"4\"", ""), "edgeList names edge 4");
  expectContains(problems("innerRadius=\"2\"", ""), "the inner radius is 2 and the radius 1");
  expectContains(problems("crossSectionShape=\"elliptic\"", ""), "elliptic");
  expectContains(problems("DOF0TransformNode0=\"0 0 0 0 0 0 1\"", ""), "dofsAndBeamsAligned");
  expectContains(problems("dofsAndBeamsAligned=\"false\" DOF0TransformNode0=\"1 0 0 0 0 0 1\"", ""), "not supported");
  expectContains(problems("", "shearStressComputation=\"false\""), "not supported");
  expectContains(problems("", "interpolation=\"@nowhere\""), "nowhere");
}

/// A rod on three nodes in a line, held at its handle: at rest it is what its shape says.
std::string wire(const std::string& shape, double middle, double end) {
  return fmt::format(R"(<Node name="root" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>{}<MeshTopology name="line" edges="0 1  1 2"/>
    <MechanicalObject template="Rigid3" position="0 0 0 0 0 0 1  {} 0 0 0 0 0 1  {} 0 0 0 0 0 1"/>
    <WireBeamInterpolation name="wire" WireRestShape="@shape" topology="@line"/>
    <AdaptiveBeamForceFieldAndMass interpolation="@wire" massDensity="1000"/><FixedProjectiveConstraint indices="0"/></Node>)",
                     shape, middle, end);
}

TEST(BeamChains, AWireComesToTheShapeThatItHasAtRest) {
  const std::string hook = "length=\"0.35\" straightLength=\"0.3\" spireDiameter=\"0.05\" radius=\"0.001\" radiusExtremity=\"0.0005\" ";
  for (const double height : {0., 0.01}) {
    Simulation simulation = simulationFromText(
        wire(fmt::format("<WireRestShape name=\"shape\" {} spireHeight=\"{}\" "
                         "youngModulus=\"1e9\" youngModulusExtremity=\"1e8\"/>", hook, height),
             0.3, 0.35));
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    const double round = std::numbers::pi * 0.05, turn = 2 * std::numbers::pi * 0.05 / std::hypot(round, height);
    const Vec3 tip(0.3 + 0.025 * std::sin(turn), height * turn / (2 * std::numbers::pi), 0.025 * (std::cos(turn) - 1));
    EXPECT_LT((Vec3(simulation.systems()[0]->x[4]) - tip).norm(), 1e-9) << height;
    EXPECT_LT((Vec3(simulation.systems()[0]->x[2]) - Vec3(0.3, 0, 0)).norm(), 1e-9);
    // each stretch has its own stuff: 1e9 r^4 against 1e8 (r/2)^4
    Vector f(6), v(6), x(6);
    System& system = *simulation.systems()[0];
    copy(system.x, x);
    x[0] += Vec3(1e-5, 0, 0);
    system.computeForce(x, v, f);
    const double axial = 1e9 * std::numbers::pi * 1e-6 / 0.3;
    EXPECT_NEAR(f[0].x(), -1e-5 * axial, 1e-3 * 1e-5 * axial);
  }
}

TEST(BeamChains, AShortStraightPartLeavesTheHelixAsItIs) {
  Simulation simulation = simulationFromText(
      wire("<WireRestShape name=\"shape\" length=\"0.35\" straightLength=\"0.0001\" spireDiameter=\"0.5\" spireHeight=\"0\" "
           "radius=\"0.001\" radiusExtremity=\"0.001\" youngModulus=\"1e9\" youngModulusExtremity=\"1e9\"/>",
           0.15, 0.35));
  ASSERT_TRUE(simulation.step().newton_converged);
  EXPECT_LT((Vec3(simulation.systems()[0]->x[4]) - Vec3(0.25 * std::sin(1.4), 0, 0.25 * (std::cos(1.4) - 1))).norm(), 1e-9);
}

TEST(BeamChains, SectionsInARowMakeARod) {
  Simulation simulation = simulationFromText(wire(R"(<RodStraightSection name="handle" length="0.3" radius="0.001" youngModulus="1e9"/>
    <RodSpireSection name="tip" length="0.05" radius="0.001" youngModulus="1e8" spireDiameter="0.05" spireHeight="0"/>
    <WireRestShape name="shape" wireMaterials="@handle @tip"/>)",
                                                  0.3, 0.35));
  ASSERT_TRUE(simulation.step().newton_converged);
  EXPECT_LT((Vec3(simulation.systems()[0]->x[4]) - Vec3(0.3 + 0.025 * std::sin(2.), 0, 0.025 * (std::cos(2.) - 1))).norm(), 1e-9);
}

TEST(BeamChains, WiresSayWhatIsWrong) {
  const auto problems = [](const std::string& shape, double end = 0.35) {
    return problemsOf(wire("<WireRestShape name=\"shape\" length=\"0.35\" youngModulus=\"1e9\" " + shape + "/>", 0.3, end));
  };
  EXPECT_EQ(problems("straightLength=\"0.3\" spireDiameter=\"0.1\""), "");
  expectContains(problems("straightLength=\"0.4\""), "straightLength is 0.4 and length 0.35");
  expectContains(problems("straightLength=\"0.3\" spireDiameter=\"0.01\""), "turns by");
  expectContains(problems("keyPoints=\"0 0.2\""), "keyPoints end at 0.2");
  expectContains(problems("straightLength=\"0.3\" keyPoints=\"0 0.2 0.35\""), "the end of the straight part");
  expectContains(problems("procedural=\"false\""), "not supported");
  expectContains(problems("wireMaterials=\"@wire\""), "wireMaterials");
  for (const char* dropped : {"innerRadius", "innerRadiusExtremity", "massDensityExtremity"})
    expectContains(problemsOf(wire(fmt::format("<RodStraightSection name=\"handle\" length=\"0.35\" radius=\"0.001\" youngModulus=\"1e9\"/>"
                                               "<WireRestShape name=\"shape\" wireMaterials=\"@handle\" {}=\"0.0001\"/>", dropped),
                                   0.3, 0.35)),
                   fmt::format("{} and wireMaterials are both given", dropped));
  expectContains(problems("straightLength=\"0.3\" spireDiameter=\"0.1\"", 0.5), "longer than the rod");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
