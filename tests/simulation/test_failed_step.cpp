// SPDX-License-Identifier: LGPL-2.1-or-later
// A step of several systems of which one fails: the others go on as if it had not been tried.
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace {

/// Gives up at its first try of step 4.
class Stumbling final : public Integrator {
 public:
  void declare(DataTable&) override {}
  void compile(System&) override {}
  StepReport step(System& system, const StepContext& context) override {
    system.beginStep(context);
    StepReport report;
    report.diverged = stumbles && context.index == 4;
    if (report.diverged) stumbles = false;
    return report;
  }
  void reset() override { ++resets; }
  std::string describe() const override { return "stumbles once"; }
  bool stumbles = true;
  int resets = 0;
};

const bool registered = (factory().add<Stumbling>("TestStumbling", "test"), true);

TEST(FailedStep, LeavesTheMemoryOfIntegratorsWhoseStepWasGood) {
  for (const std::string integrator : {"BDFOdeSolver order='2'", "NewmarkImplicitSolver", "CentralDifferenceSolver",
                                       "VariationalSymplecticSolver", "StaticSolver", "EulerImplicitSolver"}) {
    SCOPED_TRACE(integrator);
    const std::string scene = R"(<Node name="root" dt="0.001" gravity="0 -10 0">
      <Node name="good"><)" + integrator +
                              R"(/><SparseLDLSolver/>
        <MechanicalObject name="dofs" position="0 0 0  1 0 0  1 1 0  0 0 1"/><UniformMass totalMass="3"/>
        <MeshTopology position="@dofs.position" tetrahedra="0 1 2 3"/>
        <TetrahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method="large"/>
        <FixedProjectiveConstraint indices="0 1 3"/></Node>
      <Node name="bad"><TestStumbling name="mover"/><MechanicalObject position="0 0 0"/><UniformMass/></Node></Node>)";
    Simulation tried = simulationFromText(scene), never = simulationFromText(scene);
    auto& sure_footed = dynamic_cast<Stumbling&>(never.systems()[1]->integrator());
    sure_footed.stumbles = false;
    for (int step = 1; step <= 3; ++step) ASSERT_FALSE(tried.step().diverged);
    EXPECT_TRUE(tried.step().diverged);
    EXPECT_EQ(dynamic_cast<Stumbling&>(tried.systems()[1]->integrator()).resets, 1);
    for (int step = 4; step <= 8; ++step) ASSERT_FALSE(tried.step().diverged);
    for (int step = 1; step <= 8; ++step) never.step();
    EXPECT_EQ(tried.stateHash(), never.stateHash());
  }
}

}  // namespace
}  // namespace stroma::test
