// SPDX-License-Identifier: LGPL-2.1-or-later
// Every tetrahedral method and variant, under every integrator, started from shapes and numbers that no tissue meets.
// What must hold: a step leaves finite positions and velocities; or it ends with a sentence that names the step, the
// component and the element, and the state is the one before the step, bit for bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

struct Variant {
  std::string method, update, tangent;
  std::string attributes() const {
    return fmt::format("method=\"{}\" updateStiffnessMatrix=\"{}\" updateVolume=\"{}\" tangent=\"{}\"", method,
                       update != "none", update == "BV", tangent);
  }
  std::string name() const { return method + "_" + update + "_" + tangent; }
};

/// The name of the test, which must not hold an address.
void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name(); }

std::vector<Variant> variants() {
  std::vector<Variant> out{{"small", "none", "warped"}, {"nodal", "none", "warped"}};
  for (const char* method : {"large", "polar", "svd"})
    for (const char* update : {"none", "B", "BV"})
      for (const char* tangent : {"warped", "exact"}) out.push_back({method, update, tangent});
  return out;
}

const std::vector<std::string> all_integrators{
    "<EulerImplicitSolver/><CGLinearSolver iterations='50' tolerance='1e-8'/>",
    "<EulerImplicitSolver/><SparseLDLSolver/>",
    "<EulerImplicitSolver newtonIterations='5' rayleighStiffness='0.01'/><SparseLDLSolver/>",
    "<EulerImplicitSolver newtonIterations='5' trapezoidalScheme='true'/><CGLinearSolver iterations='50' "
    "tolerance='1e-8'/>",
    "<StaticSolver newton_iterations='8'/><SparseLDLSolver/>",
    "<EulerExplicitSolver/>"};

/// What is wrong with the start or with the numbers.
struct Trouble {
  std::string name;
  std::function<void(Rows x, Rows v)> start = [](Rows, Rows) {};
  std::string young = "5000", poisson = "0.4";
  double dt = 0.01;
};

void each(Rows x, const std::function<Vec3(const Vec3&)>& map) {
  for (Index i = 0; i < x.count; ++i) x[i] = map(Vec3(x[i]));
}

std::vector<Trouble> troubles() {
  const auto shaped = [](const char* name, std::function<Vec3(const Vec3&)> map) {
    return Trouble{name, [map](Rows x, Rows) { each(x, map); }};
  };
  std::vector<Trouble> out;
  out.push_back(shaped("inverted", [](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); }));
  out.push_back(shaped("flat", [](const Vec3& p) { return Vec3(p.x(), p.y(), 0); }));
  out.push_back(shaped("line", [](const Vec3& p) { return Vec3(p.x(), 0, 0); }));
  out.push_back(shaped("point", [](const Vec3&) { return Vec3(0, 0, 0); }));
  out.push_back(shaped("huge", [](const Vec3& p) { return Vec3(1e8 * p); }));
  out.push_back({"scrambled", [](Rows x, Rows) {
                   std::mt19937 generator(3);
                   std::uniform_real_distribution<double> at(-1, 1);
                   each(x, [&](const Vec3&) { return Vec3(at(generator), at(generator), at(generator)); });
                 }});
  out.push_back({"one_node_through", [](Rows x, Rows) { x[x.count - 1] = Vec3(-0.3, -0.3, -0.3); }});
  out.push_back({"fast", [](Rows, Rows v) {
                   std::mt19937 generator(4);
                   std::uniform_real_distribution<double> at(-1e6, 1e6);
                   each(v, [&](const Vec3&) { return Vec3(at(generator), at(generator), at(generator)); });
                 }});
  out.push_back({.name = "long_step", .dt = 10});
  out.push_back({.name = "nearly_no_stiffness", .young = "1e-3"});
  out.push_back({.name = "very_stiff", .young = "1e12"});
  out.push_back({.name = "incompressible", .poisson = "0.4999"});
  out.push_back({.name = "auxetic", .poisson = "-0.9"});
  return out;
}

std::string scene(const Variant& variant, const std::string& integrator, const Trouble& trouble, bool gravity) {
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 {} 0">
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="0.2 0.2 0.2"/>
  <Node name="body">{}
    <TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets" cutting="five"/>
    <MechanicalObject name="dofs"/>
    <DiagonalMass massDensity="1000"/>
    <TetrahedronFEMForceField name="fem" youngModulus="{}" poissonRatio="{}" {}/>
    <FixedProjectiveConstraint indices="0 1 3 9"/>
  </Node></Node>)",
                     trouble.dt, gravity ? "-9.81" : "0", integrator, trouble.young, trouble.poisson,
                     variant.attributes());
}

bool isSymmetric(const Variant& variant) {
  const Simulation simulation = simulationFromText(scene(variant, all_integrators.back(), {.name = "rest"}, false));
  return simulation.systems().at(0)->forceFields().at(0)->traits().symmetric;
}

/// Conjugate gradients stand aside for a matrix that is not symmetric: the loader says so.
std::vector<std::string> integratorsFor(const Variant& variant) {
  const bool symmetric = isSymmetric(variant);
  std::vector<std::string> out;
  for (const std::string& integrator : all_integrators)
    if (symmetric || integrator.find("CGLinearSolver") == std::string::npos) out.push_back(integrator);
  return out;
}

bool isFinite(ConstRows rows) {
  for (Index i = 0; i < rows.count; ++i)
    if (!rows[i].allFinite()) return false;
  return true;
}

struct Tally {
  int runs = 0, stopped = 0;
  std::string last;  ///< the sentence of the last one that stopped
};

/// Runs up to ten steps and checks each.
void run(Simulation& simulation, const std::string& what, Tally& tally) {
  ++tally.runs;
  const State& state = *simulation.states().at(0);
  for (int step = 1; step <= 10; ++step) {
    const std::uint64_t before = simulation.stateHash();
    const StepReport report = simulation.step();
    ASSERT_TRUE(isFinite(state.x()) && isFinite(state.v())) << what << " step " << step;
    if (!report.diverged) continue;
    ++tally.stopped;
    tally.last = report.reason;
    EXPECT_EQ(simulation.stateHash(), before) << what << ": not rolled back";
    for (const std::string& word :
         {fmt::format("step {} ", step), std::string("/body/"), std::string("tetrahedron "), std::string("dt = ")})
      EXPECT_NE(report.reason.find(word), std::string::npos) << what << ": no \"" << word << "\" in: " << report.reason;
    return;
  }
}

class BadShapes : public testing::TestWithParam<Variant> {};

TEST_P(BadShapes, StayFiniteOrStopWithASentence) {
  for (const Trouble& trouble : troubles()) {
    Tally tally;
    for (const std::string& integrator : integratorsFor(GetParam())) {
      SCOPED_TRACE(trouble.name + " " + integrator);
      Simulation simulation = simulationFromText(scene(GetParam(), integrator, trouble, true));
      const State& state = *simulation.states().at(0);
      trouble.start(state.x(), state.v());
      run(simulation, GetParam().name() + " " + trouble.name + " " + integrator, tally);
      if (HasFatalFailure()) return;
    }
    if (tally.stopped > 0)
      fmt::print("{} {}: {} of {} integrators stopped: {}\n", GetParam().name(), trouble.name, tally.stopped,
                 tally.runs, tally.last);
  }
}

TEST_P(BadShapes, RestWithoutGravityIsKeptToRoundOff) {
  for (const std::string& integrator : integratorsFor(GetParam())) {
    SCOPED_TRACE(integrator);
    Simulation simulation = simulationFromText(scene(GetParam(), integrator, {.name = "rest"}, false));
    const State& state = *simulation.states().at(0);
    for (int step = 0; step < 10; ++step) ASSERT_FALSE(simulation.step().diverged);
    for (Index i = 0; i < state.size(); ++i)
      EXPECT_LT((state.x()[i] - state.rest_position[i]).norm(), 1e-14) << "node " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, BadShapes, testing::ValuesIn(variants()),
                         [](const auto& tested) { return tested.param.name(); });

TEST_P(BadShapes, ConjugateGradientsRefuseAnUnsymmetricTangent) {
  const std::string problems = problemsOf(scene(GetParam(), all_integrators[0], {.name = "rest"}, false));
  EXPECT_EQ(problems.empty(), isSymmetric(GetParam())) << problems;
  if (!problems.empty()) {
    EXPECT_NE(problems.find("symmetric"), std::string::npos) << problems;
  }
}

/// A body that bursts is refused long before a number is not finite, so that no NaN reaches a state.
TEST(Divergence, NamesStepComponentElementAndReason) {
  const Trouble trouble{.name = "explicit beyond its limit", .young = "1e12", .dt = 1};
  Simulation simulation =
      simulationFromText(scene({"polar", "none", "warped"}, "<EulerExplicitSolver name='explicit'/>", trouble, true));
  StepReport report;
  for (int step = 0; step < 200 && !report.diverged; ++step) report = simulation.step();
  ASSERT_TRUE(report.diverged);
  for (const char* word : {"step ", "/body/explicit", "has grown to", "/body/fem", "tetrahedron ", "nodes ", "J = "})
    EXPECT_NE(report.reason.find(word), std::string::npos) << report.reason;
  EXPECT_TRUE(isFinite(simulation.states()[0]->x()));
}

/// A million times its size at rest, and growing; a body whose nodes lie in one point at rest has no size to compare.
TEST(Divergence, ABodyThatHasBurstIsNamed) {
  Simulation simulation = simulationFromText(R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerExplicitSolver/>
    <Node name="point"><MechanicalObject position="1 1 1  1 1 1"/><UniformMass totalMass="1"/>
      <SpringForceField springsIndices1="0" springsIndices2="1" lengths="0" stiffness="1" damping="0"/></Node>
    <Node name="line"><MechanicalObject name="dofs" position="0 0 0  2 0 0"/><UniformMass totalMass="1"/>
      <SpringForceField name="spring" springsIndices1="0" springsIndices2="1" lengths="2" stiffness="1" damping="0"/>
    </Node></Node>)");
  System& system = *simulation.systems().at(0);
  Vector before(system.allRows());
  copy(system.x, before);
  const Index end = 3;
  system.x[end] = Vec3(-1.9e6, 0, 0);
  EXPECT_EQ(FaultWatch(system).firstFault(before), "") << "large, and not yet burst";
  ASSERT_EQ(grownBodies(system).size(), 1u);
  EXPECT_NE(grownBodies(system)[0].find("/line/dofs is 9.5e+05 times its size at rest"), std::string::npos)
      << grownBodies(system)[0];
  system.x[end] = Vec3(-2.2e6, 0, 0);
  EXPECT_NE(FaultWatch(system).firstFault(before).find(
                "/line/dofs has grown to 1.1e+06 times its size at rest; /line/spring"),
            std::string::npos)
      << FaultWatch(system).firstFault(before);
  EXPECT_EQ(FaultWatch(system).firstFault(system.x), "") << "no longer growing";
}

/// So is a sheet whose rest shape is not that of its state.
TEST(Divergence, OfASheetWithAnotherRestShapeIsNamed) {
  for (const char* sheet : {"TriangularFEMForceFieldOptim restScale='0.9'",
                            "TriangleFEMForceField initialPoints='0 0 0  0.9 0 0  0 0.9 0'"}) {
    Simulation simulation = simulationFromText(
        fmt::format("<Node name='root' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/>"
                    "<MeshTopology position='0 0 0  1 0 0  0 1 0' triangles='0 1 2'/><MechanicalObject/>"
                    "<UniformMass totalMass='1'/><{} youngModulus='10' poissonRatio='0.3' thickness='0.01'/></Node>",
                    sheet));
    System& system = *simulation.systems()[0];
    Vector before(system.allRows());
    copy(system.x, before);
    for (Index i = 0; i < system.allRows(); ++i) system.x[i] = 2e6 * Vec3(system.x[i]);
    EXPECT_NE(FaultWatch(system).firstFault(before).find("times its size at rest"), std::string::npos) << sheet;
  }
}

/// Two tetrahedra that share a state: apart by any distance they are whole, grown a hundred times they have burst.
TEST(Divergence, AHundredSizesAreABurstWhereElementsGrewAsMuch) {
  for (const char* method : {"polar", "nodal"}) {
    SCOPED_TRACE(method);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
      <MeshTopology position="0 0 0 1 0 0 0 1 0 0 0 1  2 0 0 3 0 0 2 1 0 2 0 1" tetrahedra="0 1 2 3 4 5 6 7"/>
      <MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
      <TetrahedronFEMForceField name="fem" method="{}" youngModulus="1000" poissonRatio="0.3"/></Node>)",
        method));
    System& system = *simulation.systems().at(0);
    Vector before(system.allRows());
    copy(system.x, before);
    for (Index i = 4; i < 8; ++i) system.x[i].x() += 1000;
    EXPECT_EQ(FaultWatch(system).firstFault(before), "") << "parted, and whole";
    for (Index i = 0; i < 8; ++i) system.x[i] = 90 * before[i];
    EXPECT_EQ(FaultWatch(system).firstFault(before), "") << "large, and not yet burst";
    for (Index i = 0; i < 8; ++i) system.x[i] = 110 * before[i];
    EXPECT_NE(FaultWatch(system).firstFault(before).find("/dofs has grown to 1.1e+02 times its size at rest; /fem"),
              std::string::npos)
        << FaultWatch(system).firstFault(before);
    for (Index i = 0; i < 8; ++i) system.x[i] = Vec3(before[i]) + Vec3(1e6, 0, 0);
    EXPECT_EQ(FaultWatch(system).firstFault(before), "") << "far away, and as large as at rest";
  }
}

}  // namespace
}  // namespace stroma::test
