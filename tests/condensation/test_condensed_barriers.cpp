// SPDX-License-Identifier: LGPL-2.1-or-later
// Barriers and penalties on condensed bodies, against the same bodies in EulerImplicitSolver, whose matrix has every node and the barriers'
// stiffness. In steps of 1e5 s the inertia is gone and it has the equations of CondensedStaticSolver.
#include <fmt/format.h>

#include <algorithm>

#include "framework/algebra/parallel.h"
#include "tests/condensation/bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string whole = "<EulerImplicitSolver newtonIterations=\"100\" newtonTolerance=\"1e-9\"/><SparseLDLSolver/>";

/// A sphere that is pressed some 3 mm into the side of the block and moved along it, in ten steps.
std::string sphere(double dt, double friction) {
  return fmt::format(
      "<BarrierContact name=\"contact\" spheres=\"0.105 0.033 0.09 0.024\" keyTimes=\"0 {} {}\" movements=\"0 0 0  "
      "-0.005 0 0  "
      "-0.005 0.002 0.003\" contactDistance=\"1e-3\" stiffness=\"2e5\" selfContact=\"false\" friction=\"{}\" "
      "frictionIterations=\"100\" "
      "slipVelocity=\"{}\"/>",
      5 * dt, 10 * dt, friction, 1e-4 / dt);
}

TEST(CondensedBarriers, ASpherePushesAsItDoesTheWholeBody) {
  for (const double dt : {0.002, 1e5}) {
    SCOPED_TRACE(dt);
    const Block block{.loads = sphere(dt, 0), .gravity = "0 0 0", .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 10, 1e-6) : expectWhole(condensed_statics, whole, block, 10, 1e-6);
  }
}

/// Friction is repeated until it changes by less than a thousandth, shares of the surface until forces change by a hundredth.
TEST(CondensedBarriers, FrictionIsThatOfTheWholeBody) {
  for (const double dt : {0.002, 1e5}) {
    SCOPED_TRACE(dt);
    const Block block{.loads = sphere(dt, 0.4), .gravity = "0 0 0", .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 10, 1e-3) : expectWhole(condensed_statics, whole, block, 10, 1e-3);
  }
}

/// Penalties find their contacts where a step starts: both have the same ones.
TEST(CondensedBarriers, PenaltiesPushAsTheyDoTheWholeBody) {
  for (const double dt : {0.002, 1e5})
    for (const double friction : {0.0, 0.4}) {
      SCOPED_TRACE(fmt::format("dt {}, friction {}", dt, friction));
      const std::string loads = fmt::format(
          "<PenaltyContact spheres=\"0.105 0.033 0.09 0.024\" keyTimes=\"0 {} {}\" movements=\"0 0 0  -0.005 0 0  -0.005 0.002 "
          "0.003\" contactDistance=\"1e-3\" stiffness=\"2e5\" selfContact=\"false\" friction=\"{}\" slipVelocity=\"{}\"/>",
          5 * dt, 10 * dt, friction, 1e-4 / dt);
      const Block block{.loads = loads, .gravity = "0 0 0", .dt = dt};
      dt < 1 ? expectWhole(condensed_in_time, whole, block, 10, 1e-7) : expectWhole(condensed_statics, whole, block, 10, 1e-7);
    }
}

/// Three nodes are pushed against a wall that collision models find, 3 mm before it.
TEST(CondensedBarriers, PenaltiesOfCollisionModelsToo) {
  for (const double dt : {0.002, 1e5}) {
    SCOPED_TRACE(dt);
    const Block block{
        .loads = "<ConstantForceField indices=\"134 129 124\" forces=\"0.06 0.01 0  0.06 0.01 0  0.06 0.01 0\"/>"
                 "<PointCollisionModel contactStiffness=\"100\"/><Node name=\"wall\"><MeshTopology position=\"0.0845 -0.1 -0.1  "
                 "0.0845 0.2 -0.1  0.0845 0.2 0.3  0.0845 -0.1 0.3\" triangles=\"0 2 1  0 3 2\"/><MechanicalObject/>"
                 "<FixedProjectiveConstraint fixAll=\"true\"/><TriangleCollisionModel contactStiffness=\"100\"/></Node>"
                 "<CollisionPipeline/><MinProximityIntersection alarmDistance=\"0.006\" contactDistance=\"0.003\"/>"
                 "<CollisionResponse response=\"PenalityContactForceField\"/>",
        .gravity = "0 0 0",
        .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 30, 1e-9) : expectWhole(condensed_statics, whole, block, 30, 1e-9);
  }
}

const std::string dragged =
    "<LinearMovementProjectiveConstraint indices=\"136\" keyTimes=\"0 {0} {1}\" movements=\"0 0 0  0.002 0.001 -0.001  "
    "0 0 0\"/>"
    "<FixedPlaneProjectiveConstraint indices=\"60 61\" direction=\"0 1 0\"/>";

TEST(CondensedBarriers, NodesThatAreDraggedAreInTheCompliance) {
  for (const double dt : {0.002, 1e5}) {
    SCOPED_TRACE(dt);
    const Block block{
        .loads = fmt::format(fmt::runtime(dragged), 5 * dt, 20 * dt) + sphere(dt, 0), .gravity = "0 0 0", .dt = dt};
    dt < 1 ? expectWhole(condensed_in_time, whole, block, 8, 1e-4) : expectWhole(condensed_statics, whole, block, 8, 1e-4);
  }
}

/// A sphere on either side, each with a contact of its own, or both of one contact with a plane above that comes down.
TEST(CondensedBarriers, SeveralPushAtOnce) {
  for (const double dt : {0.002, 1e5}) {
    const std::string apart =
        sphere(dt, 0) +
        fmt::format("<BarrierContact name=\"second\" spheres=\"-0.025 0.03 0.1 0.024\" keyTimes=\"0 {}\" movements=\"0 0 0  "
                    "0.004 -0.002 0.001\" contactDistance=\"1e-3\" stiffness=\"2e5\" selfContact=\"false\"/>",
                    5 * dt);
    const std::string together = fmt::format(
        "<BarrierContact spheres=\"0.105 0.033 0.09 0.024  -0.025 0.03 0.1 0.024\" planes=\"0 0 -1 -0.1408\" keyTimes=\"0 {}\" "
        "movements=\"0 0 0  -0.001 0.001 -0.004\" contactDistance=\"1e-3\" stiffness=\"2e5\" selfContact=\"false\"/>",
        10 * dt);
    for (const std::string& loads : {apart, together}) {
      SCOPED_TRACE(fmt::format("dt {}, {}", dt, loads));
      const Block block{.loads = loads, .gravity = "0 0 0", .dt = dt};
      dt < 1 ? expectWhole(condensed_in_time, whole, block, 10, 1e-6) : expectWhole(condensed_statics, whole, block, 10, 1e-4);
    }
  }
}

/// Of nodes that are moved beside a sphere: the force that the whole body has there.
TEST(CondensedBarriers, WhatIsMovedFeelsTheForceOfTheWholeBody) {
  for (const double dt : {0.002, 1e5}) {
    Block block{.solver = whole,
                .loads = fmt::format(fmt::runtime(dragged), 5 * dt, 20 * dt) + sphere(dt, 0),
                .gravity = "0 0 0",
                .dt = dt};
    Simulation expected = simulationFromText(block.text());
    expected.systems().front()->requestForce();
    for (int i = 0; i < 8; ++i) expected.step();
    const Vec3 force = -Vec3(expected.systems().front()->f[136]);
    ASSERT_GT(force.norm(), 0.01);
    const std::string* end = dt < 1 ? std::end(condensed_in_time) : std::end(condensed_statics);
    for (const std::string* solver = dt < 1 ? condensed_in_time : condensed_statics; solver != end; ++solver) {
      SCOPED_TRACE(*solver);
      block.solver = *solver;
      Simulation simulation = simulationFromText(block.text());
      for (int i = 0; i < 8; ++i) simulation.step();
      const Data* output = simulation.systems().front()->integrator().data().find("dragForces");
      const auto& found = *std::get<std::vector<Vec3>*>(output->pointer());
      ASSERT_FALSE(found.empty());
      EXPECT_LT((found.front() - force).norm(), 1e-3 * force.norm());
    }
  }
}

std::string grid(const char* name, const char* n, const char* low, const char* high, const std::string& more) {
  return fmt::format(
      "<Node name=\"{0}\"><Node name=\"source\"><RegularGridTopology name=\"grid\" n=\"{1}\" min=\"{2}\" "
      "max=\"{3}\"/></Node>"
      "<TetrahedronSetTopologyContainer name=\"mesh\"/><Hexa2TetraTopologicalMapping input=\"@source/grid\" "
      "output=\"@mesh\"/>"
      "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"0.5\"/><TetrahedronFEMForceField method=\"small\" "
      "youngModulus=\"5000\" "
      "poissonRatio=\"0.35\"/>{4}</Node>",
      name, n, low, high, more);
}

/// A free block falls on one that is held: momentum, and the same as the whole bodies.
std::string twoBlocks(const std::string& solver, bool is_held) {
  return "<Node name=\"root\" dt=\"0.002\" gravity=\"0 0 0\">" + solver +
         grid("a", "4 3 4", "0.015 0.013 0.0605", "0.065 0.048 0.11",
              "<BoxROI name=\"all\" box=\"-1 -1 -1 1 1 1\"/><ConstantForceField indices=\"@all.indices\" "
              "totalForce=\"0.4 0.1 -1\"/>") +
         grid("b", "5 5 4", "0 0 0", "0.08 0.06 0.06",
              is_held ? "<BoxROI name=\"held\" box=\"-1 -1 -1 1 1 0.001\"/><FixedProjectiveConstraint "
                        "indices=\"@held.indices\"/>"
                      : "<BoxROI name=\"all\" box=\"-1 -1 -1 1 1 1\"/><ConstantForceField indices=\"@all.indices\" "
                        "totalForce=\"-0.4 "
                        "-0.1 1\"/>") +
         "<BarrierContact mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"1e-3\" "
         "stiffness=\"1e5\"/></Node>";
}

TEST(CondensedBarriers, TwoBodiesMeetAsTheWholeOnes) {
  const Vector expected = after(twoBlocks(whole, true), 40);
  EXPECT_LT(difference(after(twoBlocks("<CondensedDynamicSolver/>", true), 40), expected), 1e-4);
}

/// What pushes one body pushes the other back: the sum of momenta stays zero.
TEST(CondensedBarriers, FreeBodiesKeepTheirMomentum) {
  Simulation simulation = simulationFromText(twoBlocks("<CondensedDynamicSolver/>", false));
  double largest_part = 0;
  for (int i = 0; i < 60; ++i) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(!report.diverged && report.newton_converged) << report.reason;
    const System& system = *simulation.systems().front();
    Vec3 sum = Vec3::Zero();
    for (const Mass* mass : system.masses()) {
      Vec3 part = Vec3::Zero();
      for (Index k = 0; k < mass->state().size(); ++k) part += mass->lumped()[std::size_t(k)] * mass->state().v()[k];
      sum += part, largest_part = std::max(largest_part, part.norm());
    }
    ASSERT_LT(sum.norm(), 1e-9 * largest_part) << i;
  }
  EXPECT_GT(largest_part, 1e-3);
}

TEST(CondensedBarriers, ARunGoesOnBitForBitFromACheckpoint) {
  for (const std::string& solver : {condensed_in_time[0], condensed_statics[0]}) {
    SCOPED_TRACE(solver);
    const Block block{.solver = solver, .loads = sphere(0.002, 0.4), .gravity = "0 0 0", .dt = 0.002};
    Simulation run = simulationFromText(block.text()), restored = simulationFromText(block.text());
    for (int i = 0; i < 6; ++i) run.step();
    restored.restore(run.checkpoint());
    for (int i = 6; i < 10; ++i) run.step(), restored.step();
    EXPECT_EQ(difference(displacement(restored), displacement(run)), 0);
  }
}

/// A sphere that is drawn along the side: other nodes are pushed when the run begins again.
std::string drawnAlong(const std::string& solver) {
  const std::string loads =
      "<BarrierContact spheres=\"0.105 0.033 0.05 0.024\" keyTimes=\"0 0.02 0.08\" movements=\"0 0 0  -0.004 0 0  -0.004 0.002 "
      "0.06\" contactDistance=\"1e-3\" stiffness=\"2e5\" selfContact=\"false\" friction=\"0.4\" slipVelocity=\"0.05\"/>";
  return Block{.solver = solver, .loads = loads, .gravity = "0 0 0", .dt = 0.002}.text();
}

TEST(CondensedBarriers, AResetBeginsBitForBitAsTheFirstTime) {
  for (const std::string& solver : {condensed_in_time[0], condensed_in_time[1], condensed_statics[0]}) {
    SCOPED_TRACE(solver);
    Simulation simulation = simulationFromText(drawnAlong(solver));
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 40; ++i) simulation.step(), hashes.push_back(simulation.stateHash());
    EXPECT_NE(hashes.front(), hashes.back());
    simulation.reset();
    for (int i = 0; i < 40; ++i) {
      simulation.step();
      ASSERT_EQ(simulation.stateHash(), hashes[std::size_t(i)]) << "step " << i;
    }
  }
}

TEST(CondensedBarriers, TwoThreadsHaveTheBitsOfOne) {
  for (const std::string& solver : {condensed_in_time[0], condensed_in_time[1], condensed_statics[0]}) {
    SCOPED_TRACE(solver);
    std::uint64_t hashes[2];
    for (const int count : {1, 2}) {
      setThreads(count);
      Simulation simulation = simulationFromText(drawnAlong(solver));
      for (int i = 0; i < 30; ++i) simulation.step();
      hashes[count - 1] = simulation.stateHash();
      setThreads(1);
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

/// Nodes of a surface that meets something are kept, whichever are named.
TEST(CondensedBarriers, ASurfaceThatMeetsSomethingIsKept) {
  Block block{.solver = "<CondensedStaticSolver/>", .loads = sphere(1, 0), .gravity = "0 0 0", .dt = 1};
  const Vector expected = after(block.text(), 10);
  block.solver = "<CondensedStaticSolver surfaceIndices=\"67 72\"/>";
  EXPECT_LT(difference(after(block.text(), 10), expected), 1e-9);
}

TEST(CondensedBarriers, ForcesOfConstraintBesideThemAreRefused) {
  const Block block{.solver = "<CondensedStaticSolver/>",
                    .loads =
                        "<BarrierContact spheres=\"0.2 0 0 0.01\" selfContact=\"false\"/><FixedLagrangianConstraint "
                        "indices=\"139\"/>"};
  const std::string problems = problemsOf(block.text());
  EXPECT_NE(problems.find("either, not both"), std::string::npos) << problems;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
