// SPDX-License-Identifier: LGPL-2.1-or-later
// What takes no part in a motion is said: bodies of which all is held, cells without a law.
#include "tools/checks/idle_parts.h"

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string told(const std::string& text) {
  Simulation simulation = simulationFromText(text);
  warnOfIdleParts(simulation, simulation.diagnostics());
  return simulation.scene().diagnostics.text();
}

std::string heldAt(const std::string& constraint) {
  return R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
    <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>)" +
         constraint + "</Node>";
}

TEST(IdleParts, ABodyOfWhichEveryNodeIsHeldIsSaid) {
  const std::string sentence = "/dofs: every node is fixed by constraints";
  expectContains(told(heldAt("<FixedProjectiveConstraint indices='0-7'/>")), sentence);
  expectContains(told(heldAt("<FixedProjectiveConstraint fixAll='true'/>")), sentence);
  for (const char* free :
       {"", "<FixedProjectiveConstraint indices='0-6'/>",
        "<PartialFixedProjectiveConstraint indices='0-7' fixedDirections='1 1 0'/>",
        "<LinearMovementProjectiveConstraint indices='0-7' keyTimes='0 1' movements='0 0 0 1 0 0'/>",
        "<FixedProjectiveConstraint name='held_by_the_scene_FixedProjectiveConstraint' fixAll='true'/>"})
    EXPECT_EQ(told(heldAt(free)).find(sentence), std::string::npos) << free;
  EXPECT_EQ(told(R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject name="dofs"
    position="0 0 0"/><UniformMass totalMass="1"/><FixedProjectiveConstraint indices="0"/></Node>)").find(sentence), std::string::npos)
      << "a post, which nobody holds by mistake";
}

TEST(IdleParts, WhatContradictsOrDoublesIsSaid) {
  const std::string fixed = "<FixedProjectiveConstraint name='fixed' indices='0-3'/>";
  const std::string moved =
      "<LinearMovementProjectiveConstraint name='moved' indices='2 3 4' keyTimes='0 1' movements='0 0 0 1 0 0'/>";
  expectContains(told(heldAt(fixed + moved)), "/moved: 2 of its nodes are also fixed by /fixed: they move");
  EXPECT_EQ(told(heldAt("<FixedProjectiveConstraint indices='0 1'/>" + moved)).find(": they move"), std::string::npos);
  const std::string later = "<ParabolicProjectiveConstraint indices='2 3' P1='0 0 0' P2='0.4 0.3 0' P3='1 0 0' BeginTime='1' EndTime='2'/>";
  EXPECT_EQ(told(heldAt("<FixedProjectiveConstraint indices='0-3' endTime='1'/>" + later)).find(": they move"), std::string::npos)
      << "held until then";
  expectContains(told(heldAt(fixed + "<ConstantForceField name='load' indices='0 3' forces='1 0 0'/>")),
                 "/load: every node that it acts on is fixed or moved");
  EXPECT_EQ(told(heldAt(fixed + "<ConstantForceField indices='3 4' forces='1 0 0'/>")).find("is fixed or moved"),
            std::string::npos);
  expectContains(told(heldAt("<HexahedronFEMForceField name='again' youngModulus='1000' poissonRatio='0.3'/>")),
                 "/again: it connects the same nodes as /HexahedronFEMForceField: their stiffnesses add up");
  EXPECT_EQ(told(heldAt("")).find("add up"), std::string::npos);
}

/// What is held and what moves count by directions, and through attachments.
TEST(IdleParts, MotionsAlongHeldDirectionsAreSaid) {
  const std::string words = ": they move";
  const auto moved = [](const std::string& type, const std::string& more) {
    return "<" + type + " name='moved' indices='2 3' keyTimes='0 1' " + more + "/>";
  };
  const std::string plane = "<FixedPlaneProjectiveConstraint name='plane' indices='3 4' direction='0 0 1'/>";
  const std::string along = "<DirectionProjectiveConstraint name='along' indices='2 3' direction='1 0 0'/>";
  const std::string partly = "<PartialFixedProjectiveConstraint name='partly' indices='2 3' fixedDirections='0 0 1'/>";
  const std::string up = moved("PartialLinearMovementProjectiveConstraint", "movedDirections='0 0 1' movements='0 0 0 0 0 0.01'");
  expectContains(told(heldAt(plane + up)), "/moved: 1 of its nodes are also fixed by /plane: they move");
  expectContains(told(heldAt(along + up)), "/moved: 2 of its nodes are also fixed by /along: they move");
  expectContains(told(heldAt(partly + up)), "/moved: 2 of its nodes are also fixed by /partly: they move");
  const std::string fixed = "<FixedProjectiveConstraint name='fixed' indices='3'/>";
  expectContains(told(heldAt(fixed + up)), "/moved: 1 of its nodes are also fixed by /fixed: they move");
  expectContains(told(heldAt(plane + moved("LinearVelocityProjectiveConstraint", "velocities='0 0 0 1 0 1'"))), words);
  expectContains(told(heldAt(plane + "<OscillatorProjectiveConstraint indices='3' translation='0 0 1' pulsation='1'/>")), words);
  const std::string tied = "<AttachProjectiveConstraint object1='@dofs' object2='@dofs' indices1='3' indices2='0' twoWay='true'/>";
  expectContains(told(heldAt("<FixedProjectiveConstraint name='fixed' indices='0'/>" + tied + up)), "fixed by /fixed" + words);
  for (const std::string& apart :
       {moved("PartialLinearMovementProjectiveConstraint", "movedDirections='1 1 0' movements='0 0 0 1 1 1'"),
        moved("LinearMovementProjectiveConstraint", "movements='0 0 0 1 1 0'")})
    EXPECT_EQ(told(heldAt(plane + apart)).find(words), std::string::npos) << apart;
}

/// Node 3 is at 1 1 0 and node 0 at the origin, node 2 at 0 1 0.
TEST(IdleParts, WhatAnAttachmentBringsAwayFromItsPlaceIsSaid) {
  const std::string words = "/part: 1 of its nodes are attached to nodes that are fixed at another position";
  const auto attached = [](const std::string& part, const std::string& to) {
    return told(heldAt("<FixedProjectiveConstraint name='fixed' indices='0 2'/>"
                       "<PartialFixedProjectiveConstraint name='part' indices='3' fixedDirections='" + part + "'/>"
                       "<AttachProjectiveConstraint object1='@dofs' object2='@dofs' indices1='3' indices2='" + to + "' twoWay='true'/>"));
  };
  expectContains(attached("0 1 0", "0"), words);
  expectContains(attached("1 0 0", "2"), words);
  for (const std::string& told_nothing : {attached("0 0 1", "0"), attached("0 1 0", "2"), attached("0 1 0", "1")})
    EXPECT_EQ(told_nothing.find("fixed at another position"), std::string::npos) << told_nothing;
}

TEST(IdleParts, AGravityThatFindsNoMassInStaticsIsSaid) {
  const auto scene = [](const std::string& gravity, const std::string& mass) {
    return "<Node name='root' " + gravity + R"(><StaticSolver/><SparseLDLSolver/>
      <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>)" +
           mass + R"(<HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>
      <FixedProjectiveConstraint indices="0 1 2"/></Node>)";
  };
  const std::string sentence = "/dofs: it has no mass: the gravity (0 -9.81 0) of / has no effect on it";
  expectContains(told(scene("gravity='0 -9.81 0'", "")), sentence);
  EXPECT_EQ(told(scene("gravity='0 -9.81 0'", "<UniformMass totalMass='1'/>")).find("has no effect on it"), std::string::npos);
  EXPECT_EQ(told(scene("gravity='0 0 0'", "")).find("has no effect on it"), std::string::npos);
  EXPECT_EQ(told(scene("", "")).find("has no effect on it"), std::string::npos) << "nobody asked for it";
}

/// A hexahedron, and a pyramid of two tetrahedra on its upper face.
std::string mixed(const std::string& fields) {
  return R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
    <MeshTopology name="mesh" position="0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2"
      hexahedra="0 1 2 3 4 5 6 7" tetrahedra="4 5 6 8 4 6 7 8"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>)" +
         fields + "</Node>";
}

TEST(IdleParts, CellsWithoutALawInAMixedMeshAreSaid) {
  const std::string tetrahedra = "<TetrahedronFEMForceField youngModulus='1000' poissonRatio='0.3'/>",
                    hexahedra = "<HexahedronFEMForceField youngModulus='1000' poissonRatio='0.3'/>";
  expectContains(told(mixed(tetrahedra)), "/mesh: 1 of 1 hexahedra have no material");
  expectContains(told(mixed(hexahedra)), "/mesh: 2 of 2 tetrahedra have no material");
  EXPECT_EQ(told(mixed(tetrahedra + hexahedra)).find("no material"), std::string::npos);
}

TEST(IdleParts, AWeightThatNobodyWroteAndAFallForEverAreNoted) {
  const auto scene = [](const std::string& gravity, const std::string& more) {
    return "<Node name='root' " + gravity + R"(><EulerImplicitSolver/><CGLinearSolver/>
      <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
      <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>)" +
           more + "</Node>";
  };
  const std::string held = "<FixedProjectiveConstraint indices='0'/>", floor = "<PlaneForceField normal='0 1 0' d='-1'/>";
  const std::string weight = "/dofs: gravity is not given: the default (0 -9.81 0) m/s^2 is used";
  const std::string fall = "/dofs: nothing fixes or supports it";
  expectContains(told(scene("", held)), weight);
  expectContains(told(scene("gravity='0 0 -1'", "")), fall);
  for (const std::string& text : {scene("gravity='0 -9.81 0'", held), scene("gravity='0 -9.81 0'", floor), scene("gravity='0 0 0'", "")}) {
    EXPECT_EQ(told(text).find(weight), std::string::npos) << text;
    EXPECT_EQ(told(text).find(fall), std::string::npos) << text;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
