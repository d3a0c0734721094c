// SPDX-License-Identifier: LGPL-2.1-or-later
// Pressures and stresses on surfaces: balance and work on closed surfaces, derivatives, time, closed forms, bad input.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "framework/mesh/cell_kind.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string cube_positions = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1";
const std::string cube_quads = "0 3 2 1  4 5 6 7  0 1 5 4  1 2 6 5  2 3 7 6  3 0 4 7";
const std::string cube_triangles = "0 3 2  0 2 1  4 5 6  4 6 7  0 1 5  0 5 4  1 2 6  1 6 5  2 3 7  2 7 6  3 0 4  3 4 7";
/// An open patch with one inner node (4) of a 3 x 3 grid that is not flat.
const std::string patch_positions = "0 0 0  1 0 .1  2 0 0  0 1 .2  1 1 .3  2 1 0  0 2 0  1 2 -.1  2 2 .2";
const std::string patch_quads = "0 1 4 3  1 2 5 4  3 4 7 6  4 5 8 7";
const std::string patch_triangles = "0 1 4  0 4 3  1 2 5  1 5 4  3 4 7  3 7 6  4 5 8  4 8 7";

std::string scene(const std::string& positions, const std::string& cells, const std::string& load,
                  const std::string& solver = "<SparseLDLSolver/>") {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/>{}
    <MeshTopology position="{}" {}/><MechanicalObject/><UniformMass totalMass="1"/><{}/></Node>)",
                     solver, positions, cells, load);
}
std::string quads(const std::string& list) { return "quads='" + list + "'"; }
std::string triangles(const std::string& list) { return "triangles='" + list + "'"; }
FieldUnderTest pressureOn(const std::string& positions, const std::string& cells, const std::string& attributes) {
  return FieldUnderTest(scene(positions, cells, "SurfacePressureForceField " + attributes),
                        "SurfacePressureForceField");
}
Vec3 sumOf(ConstRows f) {
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < f.count; ++i) sum += f[i];
  return sum;
}

/// The trilinear hexahedron has bilinear faces, and its volume has a formula of its own.
TEST(SurfacePressure, DoesPdVOnABodyOfQuads) {
  FieldUnderTest t = pressureOn(cube_positions, quads(cube_quads), "pressure='7'");
  for (unsigned seed : {1u, 2u, 3u}) {
    t.deform(0.2, seed);
    std::array<Vec3, 8> corners;
    for (int i = 0; i < 8; ++i) corners[i] = t.x[i];
    EXPECT_NEAR(t.field().energy(t.x), -7 * cell_kinds::hexahedron.size(corners.data()), 1e-13);
  }
}

/// Of the 3 x 3 or 4 x 4 blocks that a face has, and not of the 6 x 6 of the largest one.
TEST(SurfacePressure, ProductsCostWhatTheBlocksOfItsFacesDo) {
  const auto costOf = [](const std::string& cells) {
    FieldUnderTest t = pressureOn(cube_positions, cells, "pressure='7'");
    return t.field().cost();
  };
  const ForceField::Cost three = costOf(triangles(cube_triangles)), four = costOf(quads(cube_quads));
  EXPECT_GT(three.product, 0);
  EXPECT_DOUBLE_EQ(three.product / (12 * 9), four.product / (6 * 16));
  EXPECT_DOUBLE_EQ(three.assembly / (12 * 9), four.assembly / (6 * 16));
  EXPECT_LT(three.product, 12 * 9 * 4) << "some nanoseconds a block";
}

TEST(SurfacePressure, ClosedSurfacesFeelNoForceAndNoTorque) {
  const std::string stress =
      "cauchyStress='3 1 -2 0.5 7 4' useConstantForce='false' triangleList='0 1 2 3 4 5 6 7 8 9 "
      "10 11'";
  for (const auto& [cells, load] :
       {std::pair(quads(cube_quads), std::string("SurfacePressureForceField pressure='7'")),
        {triangles(cube_triangles), "SurfacePressureForceField pressure='-7' volumeConservationMode='1'"},
        {triangles(cube_triangles), "TrianglePressureForceField " + stress}}) {
    FieldUnderTest t(scene(cube_positions, cells, load), load.substr(0, load.find(' ')));
    t.deform(0.1);
    const Momentum momentum = momentumOf(t.x, t.force());
    EXPECT_LT(momentum.force, 1e-14);
    EXPECT_LT(momentum.torque, 1e-14);
  }
}

/// p times the projected area of a patch whose rim is the unit square's, whatever its inside.
TEST(SurfacePressure, ResultantIsThePressureTimesTheProjectedArea) {
  for (const std::string& cells : {quads(patch_quads), triangles(patch_triangles)}) {
    FieldUnderTest t = pressureOn(patch_positions, cells, "pressure='3'");
    for (Index i = 0; i < 9; ++i)
      if (i != 4) t.x[i].z() = 0;
    t.x[4] += Vec3(0.2, -0.1, 0.4);
    EXPECT_LT((sumOf(t.force()) - Vec3(0, 0, 12)).norm(), 1e-13);
  }
}

/// Force and tangents of every variant against differences: exact, or the symmetric part of the exact one.
TEST(SurfacePressure, TangentsOfOpenSurfaces) {
  const std::string stress =
      "TrianglePressureForceField cauchyStress='3 1 -2 0.5 7 4' useConstantForce='false' triangleList='0 2 5'";
  for (const auto& [cells, load] :
       {std::pair(quads(patch_quads), std::string("SurfacePressureForceField pressure='7'")),
        {triangles(patch_triangles), "SurfacePressureForceField pressure='7'"},
        {quads(patch_quads), "SurfacePressureForceField pressure='7' mainDirection='0.6 0 0.8'"},
        {triangles(patch_triangles), stress}}) {
    SCOPED_TRACE(load);
    const std::string type = load.substr(0, load.find(' '));
    FieldUnderTest exact(scene(patch_positions, cells, load + " tangent='exact'"), type);
    FieldUnderTest symmetric(scene(patch_positions, cells, load), type);
    EXPECT_TRUE(exact.field().traits().exact_tangent);
    EXPECT_FALSE(exact.field().traits().symmetric);
    EXPECT_FALSE(symmetric.field().traits().exact_tangent);
    EXPECT_TRUE(symmetric.field().traits().symmetric);
    exact.deform(0.1), symmetric.deform(0.1);
    EXPECT_LT(relativeDifference(exact.product(exact.direction), exact.differenceOfForces(1e-6)), 1e-9);
    const BlockMatrix k = exact.matrix(), s = symmetric.matrix();
    Vector product(9);
    s.multiply(exact.direction, product);
    EXPECT_LT(relativeDifference(product, symmetric.product(exact.direction)), 1e-14);
    for (Index i = 0; i < 9; ++i)
      for (Index j = 0; j < 9; ++j) {
        const Index ij = k.slot(i, j), ji = k.slot(j, i);
        if (ij < 0) continue;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(s.values()[std::size_t(9 * ij + 3 * r + c)],
                        (k.values()[std::size_t(9 * ij + 3 * r + c)] + k.values()[std::size_t(9 * ji + 3 * c + r)]) / 2,
                        1e-13);
      }
  }
}

/// With a rim that does not move, the symmetric part is the derivative.
TEST(SurfacePressure, HeldRimMakesTheTangentSymmetric) {
  for (const std::string& cells : {quads(patch_quads), triangles(patch_triangles)}) {
    FieldUnderTest t = pressureOn(patch_positions, cells, "pressure='7'");
    t.deform(0.1);
    for (Index i = 0; i < 9; ++i)
      if (i != 4) t.direction[i].setZero();
    const Vector product = t.product(t.direction), difference = t.differenceOfForces(1e-6);
    EXPECT_LT((product[4] - difference[4]).norm(), 1e-8);
    FieldUnderTest free = pressureOn(patch_positions, cells, "pressure='7'");
    free.deform(0.1);
    EXPECT_GT(relativeDifference(free.product(free.direction), free.differenceOfForces(1e-6)), 0.05);
  }
}

TEST(SurfacePressure, GasHasAPotential) {
  for (double size : {1., 0.6, 0.05}) {  // at 0.05^3 of the volume the pressure is limited
    FieldUnderTest t = pressureOn(cube_positions, quads(cube_quads), "pressure='5' volumeConservationMode='1'");
    t.deform(0.05);
    for (Index i = 0; i < 8; ++i) t.x[i] *= size;
    Vector f = t.force(), a(8), b(8);
    copy(t.x, a), copy(t.x, b);
    const double step = 1e-5 * size;
    axpy(step, t.direction, a), axpy(-step, t.direction, b);
    EXPECT_NEAR(-(t.field().energy(a) - t.field().energy(b)) / (2 * step), dot(f, t.direction),
                1e-7 * std::sqrt(dot(f, f)));
    std::array<Vec3, 8> corners;
    for (int i = 0; i < 8; ++i) corners[i] = t.x[i];
    double work = 0;  // f.x = 3 p V on a closed surface
    for (Index i = 0; i < 8; ++i) work += f[i].dot(t.x[i]);
    const double volume = cell_kinds::hexahedron.size(corners.data());
    EXPECT_NEAR(work, 3 * 5 * std::min(1., 1000 * volume), 1e-12);
  }
}

TEST(SurfacePressure, FollowsTime) {
  const auto at = [](const std::string& attributes, double time) {
    FieldUnderTest t = pressureOn(patch_positions, quads(patch_quads), attributes);
    EXPECT_TRUE(t.field().traits().time_dependent);
    t.field().setTime(time);
    for (Index i = 0; i < 9; ++i) t.x[i].z() = 0;
    return sumOf(t.force()).z() / 4;
  };
  const std::string pulse = "pulseMode='1' pressure='6' pressureLowerBound='2' pressureSpeed='3'";
  for (const auto& [t, p] : {std::pair(0., 0.), {1., 3.}, {2., 6.}, {2.5, 4.5}, {10 / 3., 2.}, {11 / 3., 3.}, {5., 5.}})
    EXPECT_NEAR(at(pulse, t), p, 1e-13) << t;
  EXPECT_NEAR(at("pulseMode='1' pressure='-6' pressureSpeed='3'", 3), -3, 1e-13);
  const std::string keys = "keyTimes='1 2 4' keyPressures='5 -1 3'";
  for (const auto& [t, p] : {std::pair(0., 5.), {1.5, 2.}, {3., 1.}, {9., 3.}}) EXPECT_NEAR(at(keys, t), p, 1e-14) << t;
}

TEST(SurfacePressure, LoadsOnlyWhatIsChosen) {
  const auto total = [](const std::string& attributes) {
    FieldUnderTest t = pressureOn(cube_positions, quads(cube_quads), "pressure='2' " + attributes);
    return sumOf(t.force());
  };
  EXPECT_LT((total("quadIndices='1'") - Vec3(0, 0, 2)).norm(), 1e-15);
  EXPECT_LT((total("quadIndices='1 3'") - Vec3(2, 0, 2)).norm(), 1e-15);
  EXPECT_LT((total("min='-1 -1 0.5' max='2 2 2'") - Vec3(0, 0, 2)).norm(), 1e-15);
  EXPECT_LT((total("min='2 2 2' max='-1 -1 0.5'") - Vec3(0, 0, 2)).norm(), 1e-15);
  EXPECT_LT((total("quadIndices='1 3' mainDirection='0.6 0 -0.8'") - Vec3(1.2, 0, 1.6)).norm(), 1e-15);
  FieldUnderTest none(
      scene(cube_positions, quads(cube_quads), "SurfacePressureForceField pressure='2' useTangentStiffness='0'"),
      "SurfacePressureForceField");
  EXPECT_FALSE(none.field().traits().has_stiffness);
}

/// A dead load knows neither the current area nor the current normal.
TEST(TrianglePressure, DeadLoad) {
  FieldUnderTest t(scene(patch_positions, triangles("1 2 8  1 8 6"),
                         "TrianglePressureForceField pressure='1 2 3' "
                         "triangleList='0 1'"),
                   "TrianglePressureForceField");
  const Vec3 a = t.x[1], b = t.x[2], c = t.x[8], d = t.x[6];  // none at the origin
  const double area = ((b - a).cross(c - a).norm() + (c - a).cross(d - a).norm()) / 2;
  t.deform(0.2);
  Vector f = t.force();
  EXPECT_LT((sumOf(f) - area * Vec3(1, 2, 3)).norm(), 1e-14);
  const double before = t.field().energy(t.x);
  axpy(2, t.direction, t.x);
  EXPECT_NEAR(before - t.field().energy(t.x), 2 * dot(f, t.direction), 1e-13);
  EXPECT_FALSE(t.field().traits().has_stiffness);
}

// ---- closed forms of loaded bodies ----

/// A block 4 x 1 x 1 of elements with the given load, for the static solver.
std::string block(const std::string& field, const std::string& held, const std::string& load) {
  return fmt::format(
      R"(<Node name="root" gravity="0 0 0"><RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="4 1 1"/>
      <Node name="body"><StaticSolver newton_iterations="30"/><SparseLDLSolver/>
      <TetrahedronSetTopologyContainer name="tets"/><Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
      <MechanicalObject/><UniformMass totalMass="1"/>{}
      <BoxROI name="x" box="-1 -1 -1 .01 2 2"/><BoxROI name="y" box="-1 -1 -1 9 .01 2"/>
      <BoxROI name="z" box="-1 -1 -1 9 2 .01"/>{}{}</Node></Node>)",
      field, held, load);
}
void expectEquilibrium(Simulation& simulation) {
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
}
const std::string symmetry_planes =
    R"(<PartialFixedProjectiveConstraint indices="@x.indices" fixedDirections="1 0 0"/>
       <PartialFixedProjectiveConstraint indices="@y.indices" fixedDirections="0 1 0"/>
       <PartialFixedProjectiveConstraint indices="@z.indices" fixedDirections="0 0 1"/>)";

/// Volumetric strain -p/K of a body under pressure from all sides, K = E / (3 (1 - 2 nu)); the strain is homogeneous,
/// so the elements are exact; follower and linear loads differ by the strain itself.
TEST(SurfacePressure, HydrostaticPressure) {
  const double e = 3000, nu = 0.3, p = 0.01, strain = p * (1 - 2 * nu) / e;
  Simulation simulation =
      simulationFromText(block(fmt::format(R"(<TetrahedronFEMForceField method="small" youngModulus="{}"
      poissonRatio="{}"/>)",
                                           e, nu),
                               symmetry_planes, fmt::format(R"(<SurfacePressureForceField pressure="{}"/>)", -p)));
  expectEquilibrium(simulation);
  const System& system = *simulation.systems().at(0);
  const std::vector<Vec3>& rest = system.states()[0]->rest_position;
  for (std::size_t i = 0; i < rest.size(); ++i)
    EXPECT_LT((system.x[Index(i)] - (1 - strain) * rest[i]).norm(), 1e-5 * 4 * strain);
}

/// A bar pulled at its end: elongation p L / E with nu = 0.
TEST(SurfacePressure, BarIsPulledLikeFOverA) {
  const double e = 3000, p = 300;
  const std::string field = fmt::format(R"(<TetrahedronFEMForceField method="small" youngModulus="{}"
      poissonRatio="0"/>)",
                                        e);
  Simulation follower = simulationFromText(
      block(field, symmetry_planes,
            fmt::format(R"(<SurfacePressureForceField pressure="{}" min="3.99 -1 -1" max="5 2 2"/>)", p)));
  expectEquilibrium(follower);
  const System& system = *follower.systems().at(0);
  const std::vector<Vec3>& rest = system.states()[0]->rest_position;
  for (std::size_t i = 0; i < rest.size(); ++i)  // the end does not turn, nor does its area change
    EXPECT_NEAR(system.x[Index(i)].x(), rest[i].x() * (1 + p / e), 1e-8);
}

/// A cantilever under a follower pressure on its top: with the exact tangent Newton's method squares its residual.
TEST(SurfacePressure, ExactTangentIsQuadratic) {
  const auto iterations = [](const std::string& tangent) {
    Simulation simulation = simulationFromText(
        R"(<Node name="root" gravity="0 0 0"><RegularGridTopology name="grid" n="9 3 3" min="0 0 0" max="4 1 1"/>
        <StaticSolver newton_iterations="60" relative_residual_tolerance_threshold="1e-10"/><SparseLDLSolver/>
        <MechanicalObject/><UniformMass totalMass="1"/><BoxROI name="x" box="-1 -1 -1 .01 2 2"/>
        <HexahedronFEMForceField method="green" youngModulus="3000" poissonRatio="0.3" tangent="exact"/>
        <FixedProjectiveConstraint indices="@x.indices"/>
        <SurfacePressureForceField pressure="-8" min="-1 -1 0.99" max="5 2 2" )" +
        tangent + "/></Node>");
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged || report.unsolved) << report.reason;
    ::testing::Test::RecordProperty("iterations " + tangent, report.newton_iterations);
    return report.newton_iterations;
  };
  const int exact = iterations("tangent='exact'"), symmetric = iterations(""),
            none = iterations("useTangentStiffness='0'");
  EXPECT_LE(exact, 8);
  EXPECT_LT(exact, symmetric);
  EXPECT_LE(symmetric, none);
}

/// A pressure that rolls the bar up: with the symmetric part a solve fails, and goes on with the exact tangent unless the scene names one.
TEST(SurfacePressure, ASolveThatFailsGoesOnWithTheExactTangent) {
  const auto run = [](const std::string& tangent) {
    Simulation simulation = simulationFromText(
        R"(<Node name="root" gravity="0 0 0"><RegularGridTopology name="grid" n="17 5 5" min="0 0 0" max="4 1 1"/><StaticSolver
  newton_iterations="40" smallest_part="1"/><SparseLDLSolver/><MechanicalObject/><UniformMass totalMass="1"/><BoxROI name="x"
  box="-1 -1 -1 .01 2 2"/><HexahedronFEMForceField method="svd" youngModulus="3000" poissonRatio="0.3" tangent="exact"/>
  <FixedProjectiveConstraint indices="@x.indices"/><SurfacePressureForceField min="-1 -1 0.99" max="5 2 2" pressure="60" )" +
        tangent + "/></Node>");
    const StepReport report = simulation.step();
    const System& system = *simulation.systems()[0];
    EXPECT_EQ(report.unsolved, tangent == "tangent='symmetric'") << report.reason;
    return Vec3(system.x[system.allRows() - 1]);
  };
  const Vec3 open = run(""), exact = run("tangent='exact'");
  EXPECT_LT((open - exact).norm(), 1e-6);
  EXPECT_GT((open - Vec3(4, 1, 1)).norm(), 2);
  run("tangent='symmetric'");
}

TEST(SurfacePressure, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes, const std::string& cells = quads(patch_quads)) {
    return problemsOf(scene(patch_positions, cells, "SurfacePressureForceField " + attributes));
  };
  EXPECT_EQ(problems("pressure='1'"), "");
  expectContains(problems("pressure='1'", ""), "no face of the mesh is loaded");
  expectContains(problems("pressure='1' quadIndices='4'"), "indices in 0 ... 3");
  expectContains(problems("pressure='1' triangleIndices='0'"), "lists 0 triangles");
  expectContains(problems("pressure='1' quadIndices=''"), "lists no face");
  expectContains(problems("pressure='1' quadIndices='0' min='0 0 0'"), "min, max is given too");
  expectContains(problems("pressure='1' min='8 8 8' max='9 9 9'"), "no face of the mesh is loaded");
  expectContains(problems("pressure='1' min='-1e9 -1e9 0.4' max='1e9 1e9 0.5'"), "no face of the mesh is loaded");
  expectContains(problems("pressure='1' min='-1 -1 -1'"), "min is given without max");
  expectContains(problems("pressure='1' max='1 1 1'"), "max is given without min");
  expectContains(problems("pressure='1' min='1 1 1' max='1 1 1'"), "min and max are the same point 1 1 1");
  expectContains(problems("pressure='1' mainDirection='0 0 2'"), "mainDirection has the length 2");
  EXPECT_EQ(problems("pressure='1' mainDirection='0.577 0.577 0.577'"), "");
  expectContains(problems("pressure='1' pressureSpeed='4'"), "no meaning without pulseMode");
  expectContains(problems("pressure='1' pulseMode='1' pressureSpeed='0'"), "pressureSpeed is zero");
  expectContains(problems("pressure='1' volumeConservationMode='1'"), "open at the edge of nodes 0 1");
  expectContains(problems("keyTimes='0 1'"), "not given together");
  expectContains(problems("keyTimes='0 1' keyPressures='1 2 3'"), "3 values for 2 keyTimes");
  expectContains(problems("keyTimes='0 1' keyPressures='1 2' pressure='3'"), "one of them");
  expectContains(problems("pressures='1'"), "pressure");
  const std::string closed =
      scene(cube_positions, quads(cube_quads),
            "SurfacePressureForceField pressure='1' volumeConservationMode='1' defaultVolume='-2'");
  expectContains(problemsOf(closed), "defaultVolume is -2");
  expectContains(problemsOf(scene(cube_positions, quads(cube_quads),
                                  "SurfacePressureForceField pressure='1' triangleIndices='0'")),
                 "lists 0 triangles");
  // conjugate gradients and an unsymmetric tangent
  expectContains(problemsOf(scene(patch_positions, quads(patch_quads),
                                  "SurfacePressureForceField pressure='1' tangent='exact'", "<CGLinearSolver/>")),
                 "not symmetric");
  EXPECT_EQ(problemsOf(scene(patch_positions, quads(patch_quads), "SurfacePressureForceField pressure='1'",
                             "<CGLinearSolver/>")),
            "");
  EXPECT_EQ(problemsOf(scene(cube_positions, quads(cube_quads),
                             "SurfacePressureForceField pressure='1' tangent='exact'", "<CGLinearSolver/>")),
            "");
}

TEST(TrianglePressure, SaysWhatIsWrong) {
  const auto problems = [](const std::string& attributes) {
    return problemsOf(scene(patch_positions, triangles(patch_triangles), "TrianglePressureForceField " + attributes));
  };
  EXPECT_EQ(problems("pressure='1 0 0' triangleList='0'"), "");
  expectContains(problems("pressure='1 0 0'"), "triangleList");
  expectContains(problems("pressure='1 0 0' triangleList=''"), "lists no triangle");
  expectContains(problems("pressure='1 0 0' triangleList='8'"), "indices in 0 ... 7");
  expectContains(problems("pressure='1' triangleList='0'"), "pressure");
  expectContains(problems("triangleList='0'"), "which is not given");
  expectContains(problems("triangleList='0' useConstantForce='0' pressure='1 0 0'"), "pressure has no meaning");
  expectContains(problems("triangleList='0' useConstantForce='0' cauchyStress='1 2 3'"), "3 values");
  expectContains(problems("triangleList='0' pressure='1 0 0' cauchyStress='1 2 3 4 5 6'"),
                 "cauchyStress has no meaning");
}

/// Two tetrahedra with all of their faces listed, as mesh loaders list them: the one between them bears no pressure.
TEST(SurfacePressure, FacesBetweenTwoCellsAreNotLoaded) {
  const std::string positions = "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1", cells = "tetrahedra='0 1 2 3  1 2 3 4' ",
                    inner = "1 2 3", outer = "0 2 1  0 1 3  0 3 2  1 2 4  2 3 4  1 4 3";
  FieldUnderTest skin = pressureOn(positions, cells + triangles(outer), "pressure='2'"),
                 all = pressureOn(positions, cells + triangles(inner + " " + outer), "pressure='2'"),
                 none = pressureOn(positions, cells, "pressure='2'"),
                 listed =
                     pressureOn(positions, cells + triangles(inner + " " + outer), "pressure='2' triangleIndices='0'");
  const Vector f = skin.force(), of_all = all.force(), of_none = none.force();
  for (Index i = 0; i < 5; ++i) {
    EXPECT_NEAR((of_all[i] - f[i]).norm(), 0, 1e-14) << i;
    EXPECT_NEAR((of_none[i] - f[i]).norm(), 0, 1e-14) << i;
  }
  EXPECT_GT(sumOf(listed.force()).norm(), 1);
}

TEST(SurfacePressure, AMeshWithoutFacesSaysWhatListsThem) {
  const std::string told = problemsOf(scene("0 0 0  1 0 0  0 1 0  0 0 1", "tetrahedra='0 1 2 3'",
                                            "SurfacePressureForceField pressure='1' triangleIndices='0'"));
  expectContains(told, "createSubelements=\"true\" on the mesh loader");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
