// SPDX-License-Identifier: LGPL-2.1-or-later
// Loads of the condensed static solver: few or many, changing or not, inside or outside, and single precision.
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

/// Forces on `count` nodes from the top down that all change in time, each in its own way.
std::string changingLoads(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    const std::string node = std::to_string(139 - i), a = std::to_string(0.001 * (i % 7 - 3) + 0.0005);
    text += "<LinearForceField name=\"load" + node + "\" points=\"" + node + "\" times=\"0 0.2 0.5\" forces=\"0 0 0  " +
            a + " 0.002 0  0 " + a + " -0.001\"/>";
  }
  return text;
}

template <class T>
T valueOf(const Simulation& simulation, const char* name) {
  return *std::get<T*>(simulation.systems().front()->integrator().data().find(name)->pointer());
}

}  // namespace

TEST(SelectiveProducts, EqualTheFullProductForAnyNumberOfLoadedNodes) {
  for (const int count : {1, 3, 10}) {
    Block block{.loads = changingLoads(count), .gravity = "0 0 0"};
    block.solver = "<CondensedStaticSolver incremental=\"false\"/>";
    Simulation simulation = simulationFromText(block.text());
    // the full product, from K^-1 by columns: the answers to unit forces on one node after another
    Vector expected(140);
    System& system = *simulation.systems().front();
    for (int i = 0; i < 5; ++i) simulation.step();
    system.setTime(simulation.time());
    Vector load(140);
    system.computeForce(system.x, system.v, load);
    // at equilibrium the force is nothing on free nodes: the load is what the loads give alone
    Vector at_rest(140);
    for (Index i = 0; i < 140; ++i) at_rest[i] = system.states().front()->rest_position[i];
    system.computeForce(at_rest, system.v, load);
    int loaded = 0;
    for (Index node = 20; node < 140; ++node)
      for (int c = 0; c < 3; ++c) {
        if (std::abs(load[node][c]) < 1e-12) continue;  // round-off of the body at rest
        ++loaded;
        const std::string force = c == 0 ? "1 0 0" : c == 1 ? "0 1 0" : "0 0 1";
        Block unit{.solver = "<CondensedStaticSolver surfaceIndices=\"" + Block::nodes(20, 140) + "\"/>",
                   .loads = "<ConstantForceField indices=\"" + std::to_string(node) + "\" force=\"" + force + "\"/>",
                   .gravity = "0 0 0"};
        axpy(load[node][c], after(unit.text(), 1), expected);
      }
    EXPECT_EQ(valueOf<int>(simulation, "multipliedNodes"), count);
    EXPECT_LT(difference(displacement(simulation), expected), 1e-12) << count;
    EXPECT_GE(loaded, count);
  }
}

TEST(SelectiveProducts, LoadsOnEveryNodeAreTheWholeBodys) {
  Block block{.loads = changingLoads(120)};
  block.solver = "<CondensedStaticSolver/>";
  const Vector found = after(block.text(), 12);
  block.solver =
      "<StaticSolver newton_iterations=\"5\" relative_residual_tolerance_threshold=\"1e-12\"/><SparseLDLSolver/>";
  EXPECT_LT(difference(found, after(block.text(), 12)), 1e-10);
}

TEST(SelectiveProducts, OnlyChangesAreMultipliedWithoutDrift) {
  // ten constant loads, of which three change: through KeyTimes that stand still for the others
  std::string loads;
  for (int i = 0; i < 10; ++i) {
    const std::string node = std::to_string(139 - i), last = i < 3 ? "0 -0.003 0.001" : "0.001 0.002 0";
    loads += "<LinearForceField name=\"l" + node + "\" points=\"" + node +
             "\" times=\"0 100\" forces=\"0.001 0.002 0  " + last + "\"/>";
  }
  Block block{.loads = loads, .gravity = "0 0 0"};
  block.solver = "<CondensedStaticSolver/>";
  Simulation chained = simulationFromText(block.text());
  block.solver = "<CondensedStaticSolver incremental=\"false\"/>";
  Simulation anew = simulationFromText(block.text());
  int fewest = 10;
  for (int i = 0; i < 700; ++i) {
    chained.step();
    anew.step();
    if (i > 0) fewest = std::min(fewest, valueOf<int>(chained, "multipliedNodes"));
    EXPECT_EQ(valueOf<int>(anew, "multipliedNodes"), 10);
    if (i % 50 != 49) continue;
    ASSERT_LT(difference(displacement(chained), displacement(anew)), 1e-13) << i;
  }
  EXPECT_EQ(fewest, 3);
}

TEST(SelectiveProducts, LoadsInsideThatChangeReachTheSurface) {
  Block block{.loads = "<LinearForceField points=\"47 139\" times=\"0 1\" forces=\"0 0 0  0.3 0.1 -0.2\"/>"};
  // with few of them the nodes are kept; where kept nodes are named, the loads are reduced in each step
  block.solver = "<CondensedStaticSolver/>";
  const Vector kept = after(block.text(), 10);
  block.solver = "<CondensedStaticSolver surfaceIndices=\"139 100 60\"/>";
  const Vector found = after(block.text(), 10);
  EXPECT_LT(difference(kept, found), 1e-12);
  block.solver =
      "<StaticSolver newton_iterations=\"5\" relative_residual_tolerance_threshold=\"1e-12\"/><SparseLDLSolver/>";
  EXPECT_LT(difference(found, after(block.text(), 10)), 1e-10);
}

TEST(SelectiveProducts, SinglePrecisionIsWrongByItsRounding) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    Block block{.loads = "<ConstantForceField indices=\"139 138\" totalForce=\"0.05 0.02 -0.03\"/>"};
    block.solver = "<Condensed" + solver + "Solver/>";
    const Vector exact = after(block.text(), 3);
    block.solver = "<Condensed" + solver + "Solver precision=\"single\"/>";
    const double error = difference(after(block.text(), 3), exact);
    EXPECT_GT(error, 1e-12);
    EXPECT_LT(error, 2e-6);
  }
}

TEST(SelectiveProducts, PressureIsADeadLoadAtRest) {
  // to first order in p/E the follower is the dead load: the difference falls with p
  std::vector<double> errors;
  for (const std::string p : {"40", "4"}) {
    Block block{
        .loads = "<SurfacePressureForceField pressure=\"" + p + "\"/>", .cells = "hexahedra", .gravity = "0 0 0"};
    block.solver = "<CondensedStaticSolver/>";
    const Vector found = after(block.text(), 1);
    block.solver =
        "<StaticSolver newton_iterations=\"20\" relative_residual_tolerance_threshold=\"1e-9\"/><SparseLDLSolver/>";
    errors.push_back(difference(found, after(block.text(), 1)));
  }
  EXPECT_LT(errors[0], 0.02);
  EXPECT_NEAR(errors[0] / errors[1], 10, 1);
}
