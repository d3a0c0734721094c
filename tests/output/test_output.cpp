// SPDX-License-Identifier: LGPL-2.1-or-later
// WriteState, Monitor and EnergyMonitor on particles whose motion is known.
#include <cmath>
#include <fstream>
#include <sstream>

#include "framework/simulation/state_file.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

namespace fs = std::filesystem;

class Output : public WorkingFolderTest {
 protected:
  static std::string scene(const std::string& observers) {
    return R"(<Node name="root" dt="0.1" gravity="0 -10 0">
      <EulerExplicitSolver/>
      <MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0" velocity="0 0 0  0 3 0  1 0 0"/>
      <UniformMass totalMass="6"/>)" +
           observers + "</Node>";
  }
  static void run(const std::string& observers, int steps) {
    Simulation simulation = simulationFromText(scene(observers));
    simulation.begin();
    for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().diverged);
    simulation.end();
  }
};

std::vector<double> times(const std::vector<StateFrame>& frames) {
  std::vector<double> out;
  for (const StateFrame& frame : frames) out.push_back(std::round(1e6 * frame.time) / 1e6);
  return out;
}

/// The rows of numbers of a text file; lines that start with # are left out.
std::vector<std::vector<double>> columns(const std::string& file) {
  std::ifstream stream(file);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    rows.emplace_back(std::istream_iterator<double>(words), std::istream_iterator<double>());
  }
  return rows;
}

/// A spring of 100 N/m between a held node and one that is moved by 0.1 m per step: force and positions are of one instant.
TEST_F(Output, ForcesAreThoseOfTheEndOfTheStepWhateverTheIntegrator) {
  for (const std::string integrator :
       {"EulerImplicitSolver", "EulerImplicitSolver newtonIterations=\"10\"", "TrapezoidalRuleSolver", "NewmarkImplicitSolver",
        "BDFOdeSolver", "VariationalSymplecticSolver", "StaticSolver", "EulerExplicitSolver", "CentralDifferenceSolver",
        "RungeKutta4Solver"}) {
    {
      Simulation simulation = simulationFromText("<Node name=\"root\" gravity=\"0 0 0\" dt=\"0.1\"><" + integrator + R"(/>
        <SparseLDLSolver/><MechanicalObject position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>
        <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="100" damping="0"/>
        <FixedProjectiveConstraint indices="0"/>
        <LinearMovementProjectiveConstraint indices="1" keyTimes="0 1" movements="0 0 0  1 0 0"/>
        <Monitor name="pull" indices="0 1" ExportForces="true"/></Node>)");
      for (int i = 0; i < 3; ++i) ASSERT_FALSE(simulation.step().failed()) << integrator;
      simulation.end();
    }
    const auto f = columns("pull_f.txt");
    ASSERT_EQ(f.size(), 4u) << integrator;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(f[i].at(1), 10. * double(i), 1e-9) << integrator << ", at the held node at t = " << f[i].at(0);
      EXPECT_NEAR(f[i].at(4), -10. * double(i), 1e-9) << integrator;
    }
  }
}

TEST_F(Output, WriteStateWritesEveryStepFromTheStartToTheLast) {
  run(R"(<WriteState filename="a.state.gz" writeV="true" writeX0="true"/>)", 4);
  const auto frames = readStateFile("a.state.gz");
  EXPECT_EQ(times(frames), (std::vector<double>{0, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(frames[4].x0[2], Vec3(2, 0, 0));
  EXPECT_EQ(frames[0].v[1], Vec3(0, 3, 0));
  EXPECT_NEAR(frames[4].v[1].y(), 3 - 10 * 0.4, 1e-13);
  EXPECT_TRUE(frames[4].f.empty());
}

TEST_F(Output, WriteStateKeepsToItsTimesAndPeriod) {
  run(R"(<WriteState name="a" filename="a.state" period="0.2"/>
         <WriteState name="b" filename="b.state" time="0.1 0.25"/>
         <WriteState name="c" filename="c.state" time="0.1 0.3" period="0.4"/>)",
      9);
  EXPECT_EQ(times(readStateFile("a.state")), (std::vector<double>{0, 0.2, 0.4, 0.6, 0.8}));
  EXPECT_EQ(times(readStateFile("b.state")), (std::vector<double>{0.1, 0.3}));
  EXPECT_EQ(times(readStateFile("c.state")), (std::vector<double>{0.1, 0.3, 0.7}));
}

TEST_F(Output, WriteStateWritesSubsetsAndForces) {
  run(R"(<WriteState filename="a.state" DOFsX="2 0" writeV="true" DOFsV="1" writeF="true"/>)", 1);
  const auto frames = readStateFile("a.state");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].x, (std::vector<Vec3>{{2, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(frames[0].v, (std::vector<Vec3>{{0, 3, 0}}));
  for (const StateFrame& frame : frames)
    for (const Vec3& force : frame.f) EXPECT_NEAR((force - Vec3(0, -20, 0)).norm(), 0, 1e-13);
}

TEST_F(Output, WriteStateStartsAfreshAfterReset) {
  Simulation simulation = simulationFromText(scene(R"(<WriteState filename="a.state"/>)"));
  for (int i = 0; i < 3; ++i) simulation.step();
  simulation.reset();
  EXPECT_EQ(readStateFile("a.state").size(), 4u);
  simulation.step();
  simulation.end();
  EXPECT_EQ(readStateFile("a.state").size(), 2u);
}

TEST_F(Output, MonitorWritesColumns) {
  run(R"(<Monitor name="tip" indices="2 1" ExportPositions="true" ExportVelocities="true" ExportForces="true"/>)", 2);
  const auto x = columns("tip_x.txt"), v = columns("tip_v.txt"), f = columns("tip_f.txt");
  ASSERT_EQ(x.size(), 3u);
  EXPECT_EQ(x[0], (std::vector<double>{0, 2, 0, 0, 1, 0, 0}));
  EXPECT_NEAR(x[2][1], 2.2, 1e-14);
  ASSERT_EQ(v.size(), 3u);
  EXPECT_NEAR(v[2][5], 3 - 2, 1e-13);
  ASSERT_EQ(f.size(), 3u);
  for (const auto& row : f) EXPECT_NEAR(row[2], -20, 1e-13);
}

/// Seven columns of a frame in positions, six in velocities and forces; as many as a node has numbers.
TEST_F(Output, MonitorWritesFramesAndNumbers) {
  {
    Simulation simulation = simulationFromText(R"(<Node name="root" dt="0.1" gravity="0 -10 0" units="mm t s"><EulerExplicitSolver/>
      <Node name="b"><MechanicalObject name="dofs" template="Rigid3" position="9 9 9 0 0 0 1  1 2 3 0 0 0.6 -0.8"
      velocity="0 0 0 0 0 0  1 0 0 0 0 5"/>
      <UniformMass totalMass="4" inertia="0.2 0.2 0.2"/><ConstantForceField indices="1" forces="0 0 0 0.1 0.2 0.3"/>
      <Monitor name="b" indices="1" ExportPositions="true" ExportVelocities="true" ExportForces="true"/></Node>
      <Node name="n"><MechanicalObject name="dofs" template="Vec2" position="4 -3  7 8" velocity="1 2  0 0"/><UniformMass totalMass="2"/>
      <Monitor name="n" indices="1 0" ExportPositions="true" ExportVelocities="true"/></Node></Node>)");
    simulation.begin();
    simulation.step();
    simulation.end();
  }
  const auto x = columns("b_x.txt"), v = columns("b_v.txt"), f = columns("b_f.txt"), n = columns("n_x.txt"), rates = columns("n_v.txt");
  ASSERT_EQ(x.size(), 2u);
  ASSERT_EQ(x[1].size(), 8u);
  EXPECT_EQ(std::vector<double>(x[0].begin(), x[0].begin() + 4), (std::vector<double>{0, 1, 2, 3}));
  const double half = std::atan2(0.6, -0.8);
  for (std::size_t k = 0; k < 2; ++k) {  // w grows by 0.3/0.2 * 0.1
    EXPECT_NEAR(x[k][6], std::sin(half + (k ? 0.05 * 5.15 : 0)), 1e-3);
    EXPECT_NEAR(x[k][7], std::cos(half + (k ? 0.05 * 5.15 : 0)), 1e-3) << "the sign of the scene";
  }
  ASSERT_EQ(v[1].size(), 7u);
  EXPECT_EQ(v[0], (std::vector<double>{0, 1, 0, 0, 0, 0, 5}));
  EXPECT_NEAR(v[1][6], 5.15, 1e-12);
  ASSERT_EQ(f[1].size(), 7u);
  for (const auto& row : f)
    for (const auto& [column, force] : {std::pair(2, -20.), {4, 0.1}, {5, 0.2}, {6, 0.3}})
      EXPECT_NEAR(row[std::size_t(column)], force, 1e-12);
  EXPECT_EQ(n[0], (std::vector<double>{0, 7, 8, 4, -3}));
  EXPECT_EQ(rates[0], (std::vector<double>{0, 0, 0, 1, 2}));
  const auto head = [](const char* file) {
    std::ifstream stream(file);
    std::string text, line;
    while (std::getline(stream, line) && line.starts_with('#')) text += line + "\n";
    return text;
  };
  const std::string time = "# column 1: time [s]; then ";
  EXPECT_EQ(head("b_x.txt"), "# positions [mm] of /b/dofs\n" + time + "x y z and the quaternion x y z w of nodes 1\n");
  EXPECT_EQ(head("b_v.txt"), "# velocities [mm/s] of /b/dofs\n" + time + "x y z and the angular velocity about x y z [rad/s] of nodes 1\n");
  EXPECT_EQ(head("b_f.txt"), "# forces [N] of /b/dofs\n" + time + "x y z and the torque about x y z [N mm] of nodes 1\n");
  EXPECT_EQ(head("n_x.txt"), "# positions of /n/dofs\n" + time + "the numbers of nodes 1 0\n") << "angles or lengths";
}

/// What another component computes: of lists with a value for each node the chosen ones, of others all.
TEST_F(Output, MonitorWritesWhatOtherComponentsCompute) {
  const auto body = [](const std::string& attributes) {
    return R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><EulerImplicitSolver newtonIterations="30"/><SparseLDLSolver/>
      <RegularGridTopology n="3 3 3" min="0 0 0.009" max="1 1 1.009"/><MechanicalObject/><UniformMass totalMass="10"/>
      <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
      <BarrierContact name="contact" contactDistance="0.01" planes="0 0 1 0"/><Monitor name="m" indices="0 26" attributes=")" +
           attributes + "\"/></Node>";
  };
  Simulation simulation = simulationFromText(body("contact.pressures @/contact.wrenches near=contact.smallestGap"));
  simulation.begin();
  for (int i = 0; i < 3; ++i) simulation.step();
  simulation.end();
  const Component* contact = findComponent(simulation.root(), "/contact");
  const auto& pressures = *std::get<std::vector<double>*>(contact->data().find("pressures")->pointer());
  const auto& wrenches = *std::get<std::vector<Vec3>*>(contact->data().find("wrenches")->pointer());
  const auto p = columns("m_pressures.txt"), w = columns("m_wrenches.txt"), gap = columns("m_near.txt");
  ASSERT_EQ(p.size(), 3u) << "there is nothing before the first step";
  EXPECT_EQ(p[2], (std::vector<double>{simulation.time(), pressures[0], pressures[26]}));
  EXPECT_GT(pressures[0], 0);
  ASSERT_EQ(w.size(), 3u);
  EXPECT_EQ(w[2], (std::vector<double>{simulation.time(), wrenches[0].x(), wrenches[0].y(), wrenches[0].z(), wrenches[1].x(),
                                       wrenches[1].y(), wrenches[1].z()}));
  ASSERT_EQ(gap.size(), 4u);
  EXPECT_GT(gap[3][1], 0);
  expectContains(problemsOf(body("contact.pressure")), "did you mean 'pressures'");
  expectContains(problemsOf(body("contac.pressures")), "there is no component 'contac'");
  expectContains(problemsOf(body("contact.pressures contact.pressures")), "two files would be");
  expectContains(problemsOf(body("contact.planes pressures")), "names no attribute");
  expectContains(problemsOf(body("contact.mstate")), "numbers or vectors");
  EXPECT_EQ(problemsOf(body("/contact.pressures")), "");
  // attributes of a state are what it starts with
  expectContains(problemsOf(body("MechanicalObject.position")), "is a state, whose attributes are initial values");
  expectContains(problemsOf(body("v2=/MechanicalObject.velocity")), "ExportPositions, ExportVelocities or ExportForces");
}

TEST_F(Output, AMonitorOfAttributesAloneNeedsNoNodes) {
  const auto body = [](const std::string& monitor) {
    return R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><EulerImplicitSolver newtonIterations="30"/><SparseLDLSolver/>
      <RegularGridTopology n="2 2 2" min="0 0 0.009" max="1 1 1.009"/><MechanicalObject/><UniformMass totalMass="10"/>
      <HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
      <BarrierContact name="contact" contactDistance="0.01" planes="0 0 1 0"/><Monitor name="m" )" + monitor + "/></Node>";
  };
  Simulation simulation = simulationFromText(body("attributes='contact.pressures contact.smallestGap'"));
  simulation.begin();
  simulation.step();
  simulation.end();
  ASSERT_EQ(columns("m_pressures.txt").size(), 1u);
  EXPECT_EQ(columns("m_pressures.txt")[0].size(), 1u + 8u) << "of all nodes";
  EXPECT_EQ(columns("m_smallestGap.txt").back().size(), 2u);
  expectContains(problemsOf(body("ExportPositions='1'")), "indices lists no node");
  expectContains(problemsOf(body("indices='' attributes='contact.smallestGap'")), "indices lists no node");
}

/// A block that is drawn out by a tenth with held sides: (lambda + 2 mu) e along, lambda e across, in each of its cells.
TEST_F(Output, MonitorWritesFieldsOfCells) {
  const auto body = [](const std::string& monitor) {
    return R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
      <RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/>
      <MechanicalObject/><HexahedronFEMForceField name="fem" method="small" youngModulus="1000" poissonRatio="0.25"/>
      <PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 1 1"/><FixedProjectiveConstraint indices="0 3 6 9"/>
      <LinearMovementProjectiveConstraint indices="2 5 8 11" keyTimes="0 1" movements="0 0 0 0.2 0 0"/><Monitor name="m" )" +
           monitor + "/></Node>";
  };
  Simulation simulation = simulationFromText(body("cells='1' attributes='fem.stress all=fem.J'"));
  simulation.begin();
  simulation.step();
  simulation.end();
  const auto stress = columns("m_stress.txt"), all = columns("m_all.txt");
  ASSERT_EQ(stress.size(), 2u);
  ASSERT_EQ(stress[1].size(), 1u + 6u);
  const double expected[] = {120, 40, 40, 0, 0, 0};
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(stress[0][k + 1], 0, 1e-9);
    EXPECT_NEAR(stress[1][k + 1], expected[k], 1e-6) << k;
  }
  EXPECT_EQ(all[1].size(), 2u);
  EXPECT_NEAR(all[1][1], 1.1, 1e-9);
  EXPECT_EQ(problemsOf(body("attributes='fem.vonMises'")), "");
  expectContains(problemsOf(body("attributes='fem.stres'")), "did you mean 'stress'");
  expectContains(problemsOf(body("cells='2' attributes='fem.stress'")), "has no cell 2");
}

/// Particles tell no units; what the scene declares is written.
TEST_F(Output, MonitorNamesTheUnitsOfTheScene) {
  const auto headOf = [](const std::string& file) {
    std::ifstream stream(file);
    std::string quantity, columns;
    std::getline(stream, quantity), std::getline(stream, columns);
    return quantity + "\n" + columns;
  };
  const std::string monitor = R"(<Monitor name="tip" indices="2" ExportPositions="true" ExportForces="true"/>)";
  run(monitor, 1);
  EXPECT_EQ(headOf("tip_x.txt"), "# positions of /dofs\n# column 1: time; then x y z of nodes 2");
  std::string declared = scene(monitor);
  declared.replace(declared.find("dt="), 3, "units=\"mm kPa s\" dt=");
  Simulation simulation = simulationFromText(declared);
  simulation.begin();
  simulation.end();
  EXPECT_EQ(headOf("tip_x.txt"), "# positions [mm] of /dofs\n# column 1: time [s]; then x y z of nodes 2");
  EXPECT_EQ(headOf("tip_f.txt").substr(0, 13), "# forces [mN]");
}

TEST_F(Output, EnergyMonitorNamesTheUnitsOfTheScene) {
  const auto head = [](const std::string& units) {
    std::string text = scene(R"(<EnergyMonitor filename="energy.txt"/>)");
    Simulation simulation = simulationFromText(text.insert(text.find(" dt="), units));
    simulation.begin(), simulation.end();
    std::string line;
    std::ifstream file("energy.txt");
    return std::getline(file, line), line;
  };
  expectContains(head(""), "# time, energies: kinetic");
  expectContains(head(R"( units="mm t s")"), "# time [s], energies [mJ]:");
}

TEST_F(Output, EnergyMonitorWritesTheBalance) {
  run(R"(<EnergyMonitor filename="energy.txt" exportEveryNumberOfSteps="2"/>)", 5);
  const auto rows = columns("energy.txt");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_NEAR(rows[1][0], 0.2, 1e-15);
  // 2 kg each, 3 m/s and 1 m/s: 9 + 1 J; potential zero at height zero
  EXPECT_NEAR(rows[0][1], 10, 1e-13);
  EXPECT_EQ(rows[0][2], 0);
  EXPECT_NEAR(rows[0][3], 0, 1e-13);
  EXPECT_EQ(rows[0][5], 0);
  for (const auto& row : rows) {
    EXPECT_NEAR(row[4], row[1] + row[2] + row[3], 1e-12);
    EXPECT_NEAR(row[5], row[4] - rows[0][4], 1e-12);
  }
  // Euler's error in a constant field: half of m g^2 dt^2 per step and body, down or up with the order of the updates
  EXPECT_NEAR(std::abs(rows[2][5]), 0.5 * 6 * 100 * 0.01 * 4, 1e-10);
}

TEST_F(Output, MistakesAreNamed) {
  const std::pair<const char*, const char*> cases[] = {
      {R"(<WriteState/>)", "filename"},
      {R"(<WriteState filename="a" writeX="false"/>)", "nothing to write"},
      {R"(<WriteState filename="a" DOFsX="3"/>)", "indices in 0 ... 2"},
      {R"(<WriteState filename="a" time="1 0.5"/>)", "not ascending"},
      {R"(<WriteState filename="a" period="-1"/>)", "period"},
      {R"(<Monitor indices="-1" ExportForces="true"/>)", "indices in 0 ... 2"},
      {R"(<Monitor ExportForces="true"/>)", "indices"},
      {R"(<EnergyMonitor filename="e" exportEveryNumberOfSteps="0"/>)", "exportEveryNumberOfSteps"},
  };
  for (const auto& [observer, expected] : cases) expectContains(problemsOf(scene(observer)), expected);
  EXPECT_TRUE(fs::is_empty(folder_)) << "a scene that does not load writes nothing";
}

}  // namespace
}  // namespace stroma::test
