// SPDX-License-Identifier: LGPL-2.1-or-later
// Expectations of a scene: met, not met, never compared; closed forms, bounds, energies, iterations, volumes and attributes.
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class Expectations : public CommandTest {
 protected:
  /// Two points that fall freely; symplectic Euler: y = -5 t (t + dt).
  Finished run(const std::string& expectations, int steps = 20, const std::string& options = "") {
    write("scene.xml", R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/>
      <MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass name="mass" totalMass="2"/>)" + expectations + "</Node>");
    return stroma("run scene.xml --no-record -n " + std::to_string(steps) + " " + options);
  }
  void meets(const std::string& expectation, int steps = 20) {
    const Finished done = run(expectation, steps);
    EXPECT_EQ(done.code, 0) << expectation << "\n" << done.err;
    EXPECT_NE(done.err.find("1 result is as expected"), std::string::npos) << expectation << "\n" << done.err;
  }
  void misses(const std::string& expectation, const std::string& sentence, int steps = 20) {
    const Finished done = run(expectation, steps);
    EXPECT_EQ(done.code, 1) << expectation << "\n" << done.err;
    EXPECT_NE(done.err.find(sentence), std::string::npos) << expectation << "\n" << done.err;
  }
  void refuses(const std::string& expectation, const std::string& sentence) {
    const Finished done = run(expectation);
    EXPECT_EQ(done.code, 2) << expectation << "\n" << done.err;
    EXPECT_NE(done.err.find(sentence), std::string::npos) << expectation << "\n" << done.err;
  }
};

TEST_F(Expectations, ClosedFormsAreMetAtTimesAndAtTheEnd) {
  meets(R"xml(<Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.01)" tolerance="1e-12"/>)xml");
  meets(R"xml(<Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.01)" at="0 0.05 0.2" tolerance="1e-12"/>)xml");
  meets(R"xml(<Expect of="/dofs.velocity" axis="norm" is="10*t" when="always" tolerance="1e-12"/>)xml");
  meets(R"xml(<Expect of="/dofs.position" axis="x" is="x"/>)xml");
  meets(R"xml(<Expect of="/dofs.position" nodes="1" axis="x" is="1"/>)xml");
  meets(R"xml(<Expect of="total_energy" is="-t" when="always" tolerance="1e-9"/>)xml");
}

TEST_F(Expectations, WhatIsNotMetHasTheNumbers) {
  misses(R"xml(<Expect name="fall" of="/dofs.displacement" nodes="1" axis="y" is="-5*t^2"/>)xml",
         "/fall: /dofs.displacement node 1 y is -0.21 at t = 0.2, expected -0.2 (off by 0.01");
  misses(R"xml(<Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.011)" tolerance="1e-4"/>)xml", "off by 0.001");
  meets(R"xml(<Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.011)" tolerance="1e-2"/>)xml");
  misses(R"xml(<Expect of="/dofs.displacement" axis="y" above="-0.2"/>)xml", "expected above -0.2");
  misses(R"xml(<Expect of="/dofs.displacement" axis="norm" below="0.1" when="always"/>)xml", "expected below 0.1");
}

TEST_F(Expectations, APlaceThatAListDoesNotHaveIsAFailure) {
  misses(R"xml(<Expect of="/mass.totalMass" nodes="0 7" above="0"/>)xml", "/mass.totalMass[7], of a list of 1, is nan");
}

TEST_F(Expectations, NumbersOfCellsAreThoseOfTheStart) {
  const auto body = [this](const char* expect, const char* begin) {
    write("cut.xml", std::string(R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver/><SparseLDLSolver/>
    <RegularGridTopology n="4 2 2" min="0 0 0" max="3 1 1"/><MechanicalObject name="dofs"/><DiagonalMass massDensity="1"/>
    <HexahedronFEMForceField name="fem" youngModulus="1e5" poissonRatio="0.3"/><BoxROI name="end" box="2.9 -1 -1 3.1 2 2"/>
    <FixedProjectiveConstraint indices="@end.indices"/><CarvingRegion box="0.1 -9 -9 0.9 9 9" end="1" begin=")") +
                             begin + "\"/>" + expect + "</Node>");
    return stroma("run cut.xml --no-record -n 4");
  };
  const char* const of_cell = R"(<Expect of="/fem.vonMises" nodes="1" above="-1" when="always"/>)";
  EXPECT_EQ(body(of_cell, "0.9").code, 0);
  EXPECT_EQ(body(R"(<Expect of="/fem.vonMises" above="-1" when="always"/>)", "0.02").code, 0);
  const Finished cut = body(of_cell, "0.02");
  EXPECT_EQ(cut.code, 1) << cut.err;
  EXPECT_NE(cut.err.find("/fem.vonMises had 3 numbers where the scene starts and has 2"), std::string::npos) << cut.err;
  const Finished axis = body(R"(<Expect of="/fem.stress" axis="norm" above="-1"/>)", "0.9");
  EXPECT_EQ(axis.code, 2);
  EXPECT_NE(axis.err.find("`axis` chooses of vectors"), std::string::npos) << axis.err;
}

TEST_F(Expectations, ATimeThatIsNotReachedIsAFailure) {
  misses(R"xml(<Expect of="/dofs.displacement" axis="x" is="0" at="0.1 0.5"/>)xml",
         "was not compared at t = 0.5: the run ended at 0.2");
}

TEST_F(Expectations, EnergiesIterationsAndAttributes) {
  meets(R"xml(<Expect of="kinetic_energy" is="2*(10*t)^2/2" tolerance="1e-12"/>)xml");
  meets(R"xml(<Expect of="energy_drift" below="1.01" when="always"/>)xml");
  misses(R"xml(<Expect of="energy_drift" below="1e-3" when="always"/>)xml", "energy_drift is");
  meets(R"xml(<Expect of="linear_iterations" is="0"/>)xml");
  meets(R"xml(<Expect of="/mass.totalMass" is="2"/>)xml");
  misses(R"xml(<Expect of="/mass.totalMass" is="3"/>)xml", "/mass.totalMass is 2");
}

TEST_F(Expectations, VolumesAndIterationsOfABody) {
  write("body.xml", R"(<Node name="root" dt="0.01" gravity="0 -10 0">
    <EulerImplicitSolver/><CGLinearSolver iterations="50" tolerance="1e-9"/>
    <RegularGridTopology n="3 3 3" min="0 0 0" max="1 2 3"/><MechanicalObject name="dofs" scale3d="1.1 1 1"/>
    <DiagonalMass massDensity="1"/>
    <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/><FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
    <Expect of="/dofs.volume" is="6.6" at="0" tolerance="1e-12"/>
    <Expect of="linear_iterations" above="0.5" below="51"/></Node>)");
  const Finished done = stroma("run body.xml --no-record -n 3");
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.err.find("2 results are as expected"), std::string::npos) << done.err;
}

TEST_F(Expectations, AnOpenOrderIsRefused) {
  refuses(R"xml(<Expect of="/dofs.displacement"/>)xml", "nothing is expected");
  refuses(R"xml(<Expect of="/dofs.displacment" is="0"/>)xml", "displacment");
  refuses(R"xml(<Expect of="/dof.displacement" is="0"/>)xml", "/dofs");
  refuses(R"xml(<Expect of="energy_drfit" below="1"/>)xml", "energy_drift");
  refuses(R"xml(<Expect of="/dofs.displacement" is="1 +"/>)xml", "cannot be read");
  refuses(R"xml(<Expect of="/dofs.displacement" nodes="7" is="0"/>)xml", "there is no node 7");
}

TEST_F(Expectations, TheyAreInTheJson) {
  const Finished done = run(R"xml(<Expect of="/mass.totalMass" is="3"/>)xml", 1, "--json - --quiet");
  EXPECT_EQ(done.code, 1);
  EXPECT_NE(done.out.find("\"not_as_expected\""), std::string::npos) << done.out;
}

TEST_F(Expectations, ARunThatGoesOnComparesWhatIsLeft) {
  const std::string expectation =
      R"xml(<Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.01)" at="0.1 0.2" tolerance="1e-12"/>)xml";
  write("scene.xml", R"(<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/>
    <MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>)" + expectation + "</Node>");
  EXPECT_EQ(stroma("run scene.xml -n 15 --record out").code, 1) << "0.2 s is not reached";
  EXPECT_EQ(stroma("run scene.xml -n 20 --record out --resume").code, 0);
}

/// A frame that spins by 5 rad/s about z while it drifts, and a point.
TEST_F(Expectations, FramesNumbersAndMomentum) {
  const auto scene = [this](const std::string& expectation) {
    write("frames.xml", R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerExplicitSolver/>
      <Node name="b"><MechanicalObject name="dofs" template="Rigid3" position="1 2 0  0 0 0 1" velocity="3 0 0  0 0 5"/>
      <UniformMass totalMass="2" inertia="0.1 0.2 0.4"/><Node name="tip"><MechanicalObject name="dofs"
      position="0 0.5 0"/><RigidMapping/></Node></Node>
      <Node name="p"><MechanicalObject name="dofs" position="0 1 0" velocity="0 0 7"/><UniformMass totalMass="0.5"/></Node>
      )" + expectation + "</Node>");
    return stroma("run frames.xml --no-record -n 100");
  };
  const auto meets = [&](const std::string& words) {
    const Finished done = scene("<Expect " + words + " tolerance=\"1e-9\" absolute=\"1e-12\" when=\"always\"/>");
    EXPECT_EQ(done.code, 0) << words << "\n" << done.err;
    EXPECT_NE(done.err.find("1 result is as expected"), std::string::npos) << words << "\n" << done.err;
  };
  const auto misses = [&](const std::string& words, const std::string& sentence, int code = 1) {
    const Finished done = scene("<Expect " + words + "/>");
    EXPECT_EQ(done.code, code) << words << "\n" << done.err;
    EXPECT_NE(done.err.find(sentence), std::string::npos) << words << "\n" << done.err;
  };
  meets(R"xml(of="/b/dofs.orientation" axis="z" is="5*t-2*pi*rint(5*t/(2*pi))")xml");
  meets(R"xml(of="/b/dofs.orientation" axis="norm" is="abs(5*t-2*pi*rint(5*t/(2*pi)))")xml");
  misses(R"xml(of="/b/dofs.orientation" axis="z" is="4.95*t" at="0.4" tolerance="1e-3")xml",
         "/b/dofs.orientation node 0 z is 2 at t = 0.4, expected 1.98");
  meets(R"xml(of="/b/dofs.angularVelocity" axis="z" is="5")xml");
  misses(R"xml(of="/b/dofs.angularVelocity" is="0")xml", "angularVelocity node 0 z is 5 at");
  meets(R"xml(of="/b/dofs.position" axis="x" is="1+3*t")xml");
  // 2 kg at (1 + 3t, 2, 0) with 3 m/s along x, 0.4 kg m^2 about z; 0.5 kg at (0, 1, 7t) with 7 m/s along z
  meets(R"xml(of="linear_momentum" axis="x" is="6")xml");
  meets(R"xml(of="linear_momentum" axis="z" is="3.5")xml");
  meets(R"xml(of="angular_momentum" axis="z" is="2-12")xml");
  meets(R"xml(of="angular_momentum" axis="x" is="3.5")xml");
  misses(R"xml(of="angular_momentum" axis="norm" is="10")xml", "angular_momentum norm is 10.59");
  meets(R"xml(of="/p/dofs.velocity" axis="z" is="7")xml");
  misses(R"xml(of="/p/dofs.orientation" is="0")xml", "the nodes of /p/dofs have no orientation", 2);
  misses(R"xml(of="/b/dofs.orientatoin" is="0")xml", "orientatoin", 2);
}

/// Every number of a node, not its first alone.
TEST_F(Expectations, NumbersOfNodes) {
  const auto run = [this](const std::string& expectation) {
    write("numbers.xml", R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerExplicitSolver/>
      <MechanicalObject name="dofs" template="Vec6" position="1 2 3 4 5 6" velocity="0 0 0 0 0 2"/><UniformMass totalMass="1"/>)" +
                             expectation + "</Node>");
    return stroma("run numbers.xml --no-record -n 100");
  };
  for (const char* good : {R"xml(of="/dofs.position" axis="y" is="2")xml",
                           R"xml(of="/dofs.displacement" above="-1e-9" below="2.000001")xml",
                           R"xml(of="/dofs.velocity" axis="norm" is="2")xml", R"xml(of="/dofs.displacement" axis="norm" is="2*t")xml"}) {
    const Finished done = run(std::string("<Expect ") + good + "/>");
    EXPECT_EQ(done.code, 0) << good << "\n" << done.err;
  }
  const Finished last = run(R"xml(<Expect of="/dofs.displacement" below="1"/>)xml");
  EXPECT_EQ(last.code, 1) << last.err;
  EXPECT_NE(last.err.find("/dofs.displacement node 0 number 5 is 2 at t = 1"), std::string::npos) << last.err;
  const Finished mass = run(R"xml(<Expect of="linear_momentum" is="0"/>)xml");
  EXPECT_EQ(mass.code, 2);
  EXPECT_NE(mass.err.find("is a mass on numbers"), std::string::npos) << mass.err;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
