// SPDX-License-Identifier: LGPL-2.1-or-later
// What the condensed solvers refuse, warn of and leave undone.
#include <fmt/format.h>

#include <functional>

#include "tests/condensation/bodies.h"
#include "tests/support/ground_spring.h"
#include "tools/checks/result_doubts.h"

using namespace stroma;
using namespace stroma::test;

namespace {

void expectRefused(const Block& block, const std::vector<std::string>& words) {
  const std::string problems = problemsOf(block.text());
  for (const std::string& word : words)
    EXPECT_NE(problems.find(word), std::string::npos) << word << " in: " << problems;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  return text;
}

}  // namespace

/// The factor of a cube of n^3 nodes takes about n^5 numbers in the order of the mesh, and n^4 in a good one. Here 21
/// and 12 MB with what else there is.
TEST(CondensedOrder, IsLookedForThatTakesLittleMemory) {
  const std::string problems = problemsOf(
      R"(<Node name="root" dt="0.01"><RegularGridTopology name="grid" n="12 12 12" min="0 0 0" max="1 1 1"/>
           <Node><CondensedDynamicSolver condensed="false" solve="factor" memoryLimit="0.016"/>
           <TetrahedronSetTopologyContainer name="cells"/>
           <Hexa2TetraTopologicalMapping input="@../grid" output="@cells"/><MechanicalObject/><UniformMass totalMass="1"/>
           <TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3" method="small"/>
           <BoxROI name="low" box="-1 -1 -0.1 2 2 0.01"/><FixedProjectiveConstraint indices="@low.indices"/></Node></Node>)");
  EXPECT_EQ(problems, "");
}

TEST(CondensedRefusals, ForcesThatAreNotLinear) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    const Block block{.solver = "<Condensed" + solver + "Solver/>"};
    const std::string problems = problemsOf(replaced(block.text(), "method=\"small\"", "method=\"large\""));
    EXPECT_NE(problems.find("/body/fem is not linear"), std::string::npos) << problems;
    EXPECT_NE(problems.find("method=\"small\""), std::string::npos) << problems;
  }
}

TEST(CondensedRefusals, BodiesThatAreNotHeld) {
  const Block block{.solver = "<CondensedStaticSolver/>"};
  const std::string text = block.text(),
                    floor = "<FixedProjectiveConstraint name=\"floor\" indices=\"" + Block::nodes(0, 20) + "\"/>";
  const std::string problems = problemsOf(replaced(text, floor, ""));
  EXPECT_NE(problems.find("singular"), std::string::npos) << problems;
  EXPECT_NE(problems.find("FixedProjectiveConstraint"), std::string::npos) << problems;
  // with inertia the same body may fall: from rest u_n = g dt^2 n (n + 1) / 2 by the scheme. All its nodes as one where
  // all have their mass; where kept nodes carry that of others, nearly so
  for (const auto& [attributes, tolerance] : {std::pair("condensed=\"false\"", 1e-9), std::pair("", 0.02)}) {
    const std::string solver = std::string("<CondensedDynamicSolver ") + attributes + "/>";
    const Vector u = after(replaced(Block{.solver = solver, .dt = 0.01}.text(), floor, ""), 10);
    const double fall = -9.81 * 1e-4 * 55;
    for (const Index node : {0, 47, 139}) EXPECT_NEAR(u[node][1] / fall, 1, tolerance) << attributes;
  }
}

TEST(CondensedRefusals, MoreMemoryThanAllowed) {
  for (const std::string solver : {"Static", "Dynamic"})
    expectRefused(Block{.solver = "<Condensed" + solver + "Solver memoryLimit=\"0.0005\"/>"},
                  {"0.0005 GB are allowed by memoryLimit", "90 kept nodes over 30", "precision=\"single\""});
}

TEST(CondensedRefusals, WhatOneMatrixDoesNotHave) {
  expectRefused(Block{.solver = "<CondensedDynamicSolver/>",
                      .loads = "<DiagonalVelocityDampingForceField dampingCoefficient=\"0.1 0.1 0.1\"/>"},
                {"depends on velocity"});
  expectRefused(Block{.solver = "<CondensedDynamicSolver/>",
                      .loads = "<UniformVelocityDampingForceField dampingCoefficient=\"0.5\" explicitDamping=\"true\"/>"},
                {"depends on velocity"});
  expectRefused(Block{.solver = "<CondensedDynamicSolver/>", .more = "<VolumeConstraint/>"}, {"corrects positions"});
  expectRefused(Block{.solver = "<CondensedStaticSolver/>",
                      .more = "<AttachProjectiveConstraint indices1=\"50\" indices2=\"51\" twoWay=\"true\"/>"},
                {"makes nodes one", "an integrator that makes its matrix in steps"});
  expectRefused(Block{.solver = "<CondensedStaticSolver/>",
                      .more = "<LinearRelationProjectiveConstraint indices=\"50 51\" coefficients=\"1 1\"/>"},
                {"linear relations"});
  expectRefused(Block{.solver = "<CondensedStaticSolver/>",
                      .more = "<AttachProjectiveConstraint indices1=\"50\" indices2=\"51\" twoWay=\"false\"/>"},
                {"follow others"});
  expectRefused(Block{.solver = "<CondensedStaticSolver surfaceIndices=\"700\"/>"}, {"surfaceIndices", "700"});
  expectRefused(Block{.solver = "<CondensedStaticSolver surfaceIndices=\"70\" condensed=\"false\"/>"},
                {"surfaceIndices"});
}

TEST(CondensedRefusals, AttributesThatContradictEachOther) {
  expectRefused(Block{.solver = "<CondensedDynamicSolver solve=\"factor\"/>"}, {"solve", "condensed=\"false\""});
  expectRefused(Block{.solver = "<CondensedDynamicSolver condensed=\"false\" interiorMass=\"neglected\"/>"},
                {"interiorMass", "keeps every node"});
  expectRefused(Block{.solver = "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\" precision=\"single\"/>"},
                {"precision", "double precision"});
}

TEST(CondensedNotes, AMatrixOfMassesIsSaidToBeLumped) {
  const auto said = [](const std::string& mass) {
    Block block{.solver = "<CondensedDynamicSolver/>"};
    block.mass = mass;
    testing::internal::CaptureStderr();
    simulationFromText(block.text());
    return testing::internal::GetCapturedStderr();
  };
  const std::string density = "massDensity=\"1000\"/>";
  EXPECT_NE(said("<MeshMatrixMass " + density).find("lumped to its sums"), std::string::npos);
  EXPECT_EQ(said("<DiagonalMass " + density).find("lumped"), std::string::npos);
}

TEST(CondensedRange, DisplacementsWithoutMeaningAreAFailure) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    const Block block{.solver = "<Condensed" + solver + "Solver/>",
                      .loads = "<ConstantForceField indices=\"139\" totalForce=\"1e308 0 0\"/>"};
    Simulation simulation = simulationFromText(block.text());
    const StepReport report = simulation.step();
    EXPECT_TRUE(report.diverged) << solver;
    EXPECT_NE(report.reason.find("range of numbers"), std::string::npos) << report.reason;
  }
}

TEST(CondensedStability, StiffnessThatPushesIsWarnedOf) {
  const auto said = [](const std::string& stiffness) {
    const std::string text =
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CondensedDynamicSolver/>"
        "<MechanicalObject position=\"0 0 0  1 0 0\"/><UniformMass totalMass=\"1\"/>"
        "<TestGroundSpring stiffness=\"" +
        stiffness + "\"/></Node>";
    testing::internal::CaptureStderr();
    simulationFromText(text);
    return testing::internal::GetCapturedStderr();
  };
  factory().add<GroundSpring>("TestGroundSpring", "springs to the rest shape");
  EXPECT_EQ(said("50").find("pushes"), std::string::npos);
  // 1/(1 - sqrt(50/0.5) 0.01) = 1.111
  EXPECT_NE(said("-50").find("grows by a factor of 1.11"), std::string::npos) << said("-50");
}

TEST(CondensedRange, IsDoubtedWhenItIsLeft) {
  Block block{.solver = "<CondensedStaticSolver/>", .gravity = "0 0 0"};
  // shear u_x = g z of the whole block: every wall across x turns by g
  const auto doubts = [&](double shear, const std::string& more) {
    block.solver = "<CondensedStaticSolver " + more + "/>";
    std::string movements = "0 0 0 " + std::to_string(shear * 0.14) + " 0 0 " + std::to_string(shear * 0.14) + " 0 0";
    block.loads = "<LinearMovementProjectiveConstraint indices=\"" + Block::nodes(120, 140) +
                  "\" keyTimes=\"0 0.02 9\" outside=\"hold\" movements=\"" + movements + "\"/>";
    Simulation simulation = simulationFromText(block.text());
    simulation.step();
    std::string text;
    for (const std::string& sentence : doubtsOf(simulation)) text += sentence;
    return text;
  };
  EXPECT_EQ(doubts(0.02, ""), "");
  EXPECT_NE(doubts(0.3, "").find("has turned by"), std::string::npos);
  EXPECT_NE(doubts(0.3, "rotationBound=\"10\"").find("has a strain of"), std::string::npos);
  EXPECT_EQ(doubts(0.3, "rotationBound=\"10\" strainBound=\"10\""), "");
}

namespace {

std::string doubtsAfter(const Block& block, int steps) {
  Simulation simulation = simulationFromText(block.text());
  simulation.computeOnDemand(true);
  for (int i = 0; i < steps; ++i) simulation.step();
  std::string text;
  for (const std::string& sentence : doubtsOf(simulation)) text += sentence;
  return text;
}

/// One node of the surface is dragged by 10 mm, to x = 10 mm at `peak` s, and to where it was at `end` s.
std::string dragTo(double peak, double end) {
  return "<LinearMovementProjectiveConstraint indices=\"137\" keyTimes=\"0 " + std::to_string(peak) + " " +
         std::to_string(end) + "\" outside=\"hold\" movements=\"0 0 0 0.01 0 0 0 0 0\"/>";
}

}  // namespace

TEST(CondensedRange, IsDoubtedAtTheEndOfARamp) {
  for (const std::string solver : {"Static", "Dynamic"})
    for (const std::string more : {"", " surfaceIndices=\"137 98\""})
      for (const int steps : {2, 10, 37}) {
        const double end = 0.02 * steps;
        Block block{
            .solver = "<Condensed" + solver + "Solver" + more + "/>", .loads = dragTo(end, 99), .gravity = "0 0 0"};
        const std::string text = doubtsAfter(block, steps);
        EXPECT_NE(text.find("has turned by"), std::string::npos) << solver << more << steps;
        EXPECT_NE(text.find(fmt::format("at t = {:.6g} s", end)), std::string::npos) << text;
      }
}

TEST(CondensedRange, IsDoubtedAfterAPeakThatIsOver) {
  const Block block{.solver = "<CondensedStaticSolver/>", .loads = dragTo(0.2, 0.4), .gravity = "0 0 0"};
  const std::string text = doubtsAfter(block, 25);
  EXPECT_NE(text.find("has turned by"), std::string::npos);
  EXPECT_NE(text.find("at t = 0.2 s"), std::string::npos) << text;
}

TEST(CondensedRange, IsCountedFromTheShapeAtRest) {
  // twice as high at the start as at rest
  Block block{.solver = "<CondensedStaticSolver/>", .gravity = "0 0 0"};
  const auto stretched = [&](double factor) {
    std::string x = "position=\"", rest = "rest_position=\"";
    for (int k = 0; k < 7; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 5; ++i) {
          const std::string flat = fmt::format("{} {} ", 0.02 * i, 0.02 * j);
          x += flat + fmt::format("{} ", factor * 0.14 / 6 * k), rest += flat + fmt::format("{} ", 0.14 / 6 * k);
        }
    return "<MechanicalObject name=\"dofs\" " + x + "\" " + rest + "\"/>";
  };
  const std::string object = "<MechanicalObject name=\"dofs\"/>";
  const auto doubts = [&](double factor, const std::string& loads) {
    block.loads = loads;
    Simulation simulation = simulationFromText(replaced(block.text(), object, stretched(factor)));
    simulation.step();
    std::string text;
    for (const std::string& sentence : doubtsOf(simulation)) text += sentence;
    return text;
  };
  EXPECT_EQ(doubts(1.5, ""), "");  // one step to the rest shape, where the strain is zero
  const std::string stays = "<FixedProjectiveConstraint indices=\"" + Block::nodes(120, 140) + "\"/>";
  EXPECT_NE(doubts(1.5, stays).find("has a strain of 0.5"), std::string::npos) << doubts(1.5, stays);
}

TEST(CondensedRange, ExplainSaysWhenNothingIsWatched) {
  const auto plan = [](const std::string& text) {
    return simulationFromText(text).systems().front()->integrator().describe();
  };
  EXPECT_NE(plan("<Node name=\"root\"><CondensedStaticSolver/><MechanicalObject position=\"0 0 0\"/>"
                 "<RestShapeSpringsForceField points=\"0\" stiffness=\"200\"/></Node>")
                .find("the range of linear elasticity is not checked"),
            std::string::npos);
  EXPECT_NE(
      plan(Block{.solver = "<CondensedStaticSolver surfaceIndices=\"64 139\"/>"}.text()).find("after the last step"),
      std::string::npos);
  EXPECT_EQ(plan(Block{.solver = "<CondensedStaticSolver/>"}.text()).find("linear elasticity"), std::string::npos);
}

TEST(CondensedInterior, IsComputedWhenSomebodyReadsIt) {
  const Block block{.solver = "<CondensedStaticSolver/>",
                    .loads = "<ConstantForceField indices=\"139\" force=\"0.1 0 0\"/>"};
  Simulation simulation = simulationFromText(block.text());
  const System& system = *simulation.systems().front();
  const Vec3 rest = system.x[47], rest_outside = system.x[100];
  simulation.computeOnDemand(true);
  simulation.step();
  EXPECT_EQ(Vec3(system.x[47]), rest);
  EXPECT_GT((system.x[100] - rest_outside).norm(), 1e-5);
  simulation.complete();
  EXPECT_GT((system.x[47] - rest).norm(), 1e-5);
  // and without asking for demand it always is
  Simulation careful = simulationFromText(block.text());
  careful.step();
  EXPECT_EQ(Vec3(careful.systems().front()->x[47]), Vec3(system.x[47]));
}

TEST(CondensedInterior, NodesThatAnObserverWatchesAreKept) {
  const Block block{.solver = "<CondensedStaticSolver/>",
                    .more = "<Monitor name=\"unwritten\" indices=\"47 48\" ExportPositions=\"true\"/>"};
  Simulation simulation = simulationFromText(block.text());
  simulation.dropObservers();
  simulation.computeOnDemand(true);
  const System& system = *simulation.systems().front();
  const Vec3 rest = system.x[47];
  simulation.step();
  EXPECT_GT((system.x[47] - rest).norm(), 1e-6);
}

TEST(CondensedInterior, TheWholeForceIsThereForWhoAsks) {
  Block block{.solver = "<CondensedStaticSolver/>", .loads = "<ConstantForceField indices=\"139\" force=\"0.1 0 0\"/>"};
  Scene scene = sceneFromText(block.text());
  std::vector<State*> states;
  scene.root->collect(states);
  states.front()->requestForce();
  Simulation simulation(std::move(scene));
  simulation.computeOnDemand(true);
  simulation.step();
  const ConstRows f = states.front()->f();
  double free = 0, held = 0;
  for (Index i = 0; i < 140; ++i) (i < 20 ? held : free) += f[i].norm();
  EXPECT_GT(held, 1);
  EXPECT_LT(free, 1e-9 * held);
}

TEST(CondensedReset, RepeatsItselfBitForBit) {
  for (const std::string solver : {"Static", "Dynamic"}) {
    Block block{
        .solver = "<Condensed" + solver + "Solver/>",
        .loads =
            "<LinearForceField points=\"139 47 100\" times=\"0 1\" forces=\"0 0 0  0.3 0.1 -0.2\"/>"
            "<LinearMovementProjectiveConstraint indices=\"134\" keyTimes=\"0 0.1\" movements=\"0 0 0 0.001 0 0\"/>"};
    Simulation simulation = simulationFromText(block.text());
    for (int i = 0; i < 9; ++i) simulation.step();
    const std::uint64_t hash = simulation.stateHash();
    simulation.reset();
    for (int i = 0; i < 9; ++i) simulation.step();
    EXPECT_EQ(simulation.stateHash(), hash);
  }
}
