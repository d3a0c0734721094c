// SPDX-License-Identifier: LGPL-2.1-or-later
// A step that fails is taken back: x, v and what integrators and linear solvers remember are as if it had not been tried.
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Gives up at its first try of step 4.
class Stumbling final : public Integrator {
 public:
  void declare(DataTable&) override {}
  void compile(System&) override {}
  StepReport step(System& system, const StepContext& context) override {
    StepReport report;
    report.diverged = stumbles && context.index == 4;
    if (report.diverged) stumbles = false;
    return report;
  }
  std::string describe() const override { return "stumbles once"; }
  bool stumbles = true;
};

/// Its force is no number while it fails.
class Faulty final : public ForceField {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows, ConstRows, Rows f) override {
    if (fails) f[state().firstRow() + 2].x() = std::numeric_limits<double>::quiet_NaN();
  }
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}
  bool fails = false;
};

const bool registered =
    (factory().add<Stumbling>("TestStumbling", "test"), factory().add<Faulty>("TestFaulty", "test"), true);

const std::string integrators[] = {"BDFOdeSolver order='2'",      "NewmarkImplicitSolver", "CentralDifferenceSolver",
                                   "VariationalSymplecticSolver", "StaticSolver",          "EulerImplicitSolver"};

/// A tetrahedron in a node of its own.
std::string body(const std::string& name, const std::string& integrator, const std::string& more = {},
                 const std::string& solver = "<SparseLDLSolver/>") {
  return "<Node name='" + name + "'><" + integrator + "/>" + solver +
         R"(<MechanicalObject name="dofs" position="0 0 0  1 0 0  1 1 0  0 0 1"/><UniformMass totalMass="3"/>
        <MeshTopology position="@dofs.position" tetrahedra="0 1 2 3"/>
        <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="large"/>
        <FixedProjectiveConstraint indices="0 1 3"/>)" +
         more + "</Node>";
}
const std::string bad_body =
    "<Node name='bad'><TestStumbling name='mover'/><MechanicalObject position='0 0 0'/><UniformMass/></Node>";
std::string sceneOf(const std::string& bodies) {
  return "<Node name='root' dt='0.001' gravity='0 -10 0'>" + bodies + "</Node>";
}

TEST(FailedStep, LeavesTheMemoryOfIntegratorsWhoseStepWasGood) {
  for (const std::string& integrator : integrators) {
    SCOPED_TRACE(integrator);
    const std::string scene = sceneOf(body("good", integrator) + bad_body);
    Simulation tried = simulationFromText(scene), never = simulationFromText(scene);
    auto& sure_footed = dynamic_cast<Stumbling&>(never.systems()[1]->integrator());
    sure_footed.stumbles = false;
    for (int step = 1; step <= 3; ++step) ASSERT_FALSE(tried.step().diverged);
    EXPECT_TRUE(tried.step().diverged);
    for (int step = 4; step <= 8; ++step) ASSERT_FALSE(tried.step().diverged);
    for (int step = 1; step <= 8; ++step) never.step();
    EXPECT_EQ(tried.stateHash(), never.stateHash());
  }
}

TEST(FailedStep, LeavesTheMemoryOfTheIntegratorThatFailed) {
  for (const std::string& integrator : integrators)
    for (const int last_good : {0, 3}) {
      SCOPED_TRACE(integrator + " after step " + std::to_string(last_good));
      const std::string scene = sceneOf(body("body", integrator, "<TestFaulty name='fault'/>"));
      Simulation tried = simulationFromText(scene), never = simulationFromText(scene);
      for (int step = 1; step <= last_good; ++step) ASSERT_FALSE(tried.step().diverged);
      auto& fault = dynamic_cast<Faulty&>(*findComponent(tried.root(), "/body/fault"));
      fault.fails = true;
      EXPECT_TRUE(tried.step().diverged);
      fault.fails = false;
      for (int step = last_good + 1; step <= 8; ++step) ASSERT_FALSE(tried.step().diverged);
      for (int step = 1; step <= 8; ++step) never.step();
      EXPECT_EQ(tried.stateHash(), never.stateHash());
    }
}

/// A warm start, and the factors of a former matrix turned with the body.
TEST(FailedStep, LeavesTheMemoryOfTheLinearSolver) {
  for (const char* solver : {"<CGLinearSolver warmStart='true' tolerance='1e-10'/>",
                             "<PCGLinearSolver preconditioner='warped'/><SparseLDLSolver/>"}) {
    SCOPED_TRACE(solver);
    const std::string scene = sceneOf(body("good", "EulerImplicitSolver", {}, solver) + bad_body);
    Simulation tried = simulationFromText(scene), never = simulationFromText(scene);
    dynamic_cast<Stumbling&>(never.systems()[1]->integrator()).stumbles = false;
    for (int step = 1; step <= 9; ++step) tried.step();
    for (int step = 1; step <= 8; ++step) never.step();
    ASSERT_EQ(tried.steps(), 8);
    EXPECT_EQ(tried.stateHash(), never.stateHash());
  }
}

/// The factors of its matrix are products that no double holds.
TEST(FailedStep, NoNumberOfItsCheckpointIsInfinite) {
  const std::string text = "<Node name='root' dt='1e10'>" +
                           body("a", "EulerImplicitSolver rayleighStiffness='1e308'", {}, "<CGLinearSolver/>") +
                           "</Node>";
  Simulation simulation = simulationFromText(text);
  EXPECT_TRUE(simulation.step().diverged);
  const Archive checkpoint = simulation.checkpoint();
  for (const auto& [name, entry] : checkpoint.entries()) {
    if (entry.kind != Archive::Kind::real) continue;
    std::vector<double> values(entry.bytes.size() / sizeof(double));
    std::memcpy(values.data(), entry.bytes.data(), entry.bytes.size());
    for (const double value : values) EXPECT_TRUE(std::isfinite(value)) << name;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
