// SPDX-License-Identifier: LGPL-2.1-or-later
// Every observer of the factory, with all that it can be asked for, beside every integrator, and all of them together beside
// contact, mappings that bend, forces of constraint and factors: the bits of the run are those of one that nobody watches.
#include <filesystem>
#include <map>

#include "tests/support/folder_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// What each observer is asked for: everything, forces too. One that is not here fails the test.
const std::map<std::string, std::string> asked_for = {
    {"CarvingRegion", "sphere='99 99 99 1'"},
    {"CollisionPipeline", ""},
    {"Expect", "of='/dofs.displacement' axis='norm' below='9' when='always'"},
    {"EnergyMonitor", "filename='energies.txt'"},
    {"MeshExporter", "filename='mesh' format='vtk' exportEveryNumberOfSteps='1'"},
    {"OBJExporter", "filename='skin' exportEveryNumberOfSteps='1'"},
    {"STLExporter", "filename='skin' exportEveryNumberOfSteps='1'"},
    {"Monitor", "indices='3 7' ExportPositions='1' ExportVelocities='1' ExportForces='1' fileName='watched'"},
    {"TopologicalChangeProcessor", "useDataInputs='1' timeToRemove='9' hexahedraToRemove='0'"},
    {"VTKExporter",
     "filename='body' exportEveryNumberOfSteps='1' pointsDataFields='displacement velocity force' "
     "cellsDataFields='vonMises J'"},
    {"WriteState", "filename='all.state' period='0.01' writeX='1' writeX0='1' writeV='1' writeF='1'"},
};

struct Method {
  const char *integrator, *field;
};
const Method methods[] = {
    {"EulerImplicitSolver", "svd"},
    {"EulerImplicitSolver rayleighStiffness='0.01' rayleighMass='0.1'", "large"},
    {"EulerImplicitSolver newtonIterations='5'", "svd"},
    {"EulerImplicitSolver trapezoidalScheme='true'", "small"},
    {"EulerImplicitSolver firstOrder='true'", "svd"},
    {"NewmarkImplicitSolver", "svd"},
    {"BDFOdeSolver order='2'", "svd"},
    {"TrapezoidalRuleSolver", "svd"},
    {"VariationalSymplecticSolver", "svd"},
    {"EulerExplicitSolver", "svd"},
    {"RungeKutta4Solver", "svd"},
    {"CentralDifferenceSolver", "svd"},
    {"StaticSolver", "svd"},
    {"CondensedStaticSolver", "small"},
    {"CondensedDynamicSolver", "small"},
};

std::string scene(const Method& method, const std::string& observers) {
  return fmt::format(R"(<Node name="root" dt="0.0005" gravity="0 -10 0"><{}/><CGLinearSolver/>
    <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
    <MechanicalObject name="dofs" position="@grid.position"/><UniformMass totalMass="2"/>
    <HexahedronFEMForceField youngModulus="4000" poissonRatio="0.4" method="{}"/>
    <ConstantForceField indices="11" totalForce="0 0 1"/>
    <FixedProjectiveConstraint indices="0 4 8 12"/>{}</Node>)",
                     method.integrator, method.field, observers);
}

/// Where forces come from elsewhere than the body's elements, or a solver keeps something from step to step.
std::string bodyWith(const std::string& parts, const std::string& solver, const std::string& observers) {
  return fmt::format(R"(<Node name="root" dt="0.005" gravity="0 -10 0"><EulerImplicitSolver newtonIterations="4"/>{}
    <RegularGridTopology name="grid" n="4 3 3" min="0 0 0" max="0.3 0.2 0.2"/>
    <MechanicalObject name="dofs" position="@grid.position"/><UniformMass totalMass="2"/>
    <HexahedronFEMForceField youngModulus="4000" poissonRatio="0.4" method="svd"/>
    <FixedProjectiveConstraint indices="0 4 8 12"/>{}{}</Node>)",
                     solver, parts, observers);
}
const std::pair<const char*, const char*> other_bodies[] = {
    {"<BarrierContact contactDistance='0.02' stiffness='1e4' friction='0.3' planes='0 1 0 -0.005'/>", "<CGLinearSolver/>"},
    {"<PenaltyContact contactDistance='0.02' stiffness='1e3' planes='0 1 0 -0.005'/>", "<CGLinearSolver/>"},
    {"<ConstraintContact contactDistance='0.004' planes='0 1 0 -0.005'/>", "<SparseLDLSolver/>"},
    {"<BilateralLagrangianConstraint first_point='11' second_point='35'/>", "<SparseLDLSolver/>"},
    {"<Node name='tool'><MechanicalObject template='Rigid3' position='0.3 0.1 0.1 0 0 0 1'/><UniformMass totalMass='1'/>"
     "<Node name='tip'><MechanicalObject name='at' position='0 0.1 0  0 0 0.1'/><RigidMapping/>"
     "<ConstantForceField indices='1' forces='1 0 0'/></Node></Node>"
     "<SpringForceField object1='@dofs' object2='@tool/tip/at' springsIndices1='11 23' springsIndices2='0 1' "
     "lengths='0.1 0.1' stiffness='100'/>",
     "<CGLinearSolver/>"},
    {"<Node name='skin'><MechanicalObject name='at' position='0.25 0.05 0.05  0.27 0.15 0.15'/><BarycentricMapping/>"
     "<ConstantForceField indices='1' forces='1 0 0'/></Node>",
     ""},
};

class Observers : public WorkingFolderTest {
 protected:
  static std::vector<std::uint64_t> hashes(const std::string& text) {
    std::vector<std::uint64_t> found;
    Simulation simulation = simulationFromText(text);
    simulation.computeOnDemand(true);  // as the command does: an observer then asks for what it reads
    simulation.begin();
    for (int i = 0; i < 5; ++i) {
      EXPECT_FALSE(simulation.step().diverged);
      found.push_back(simulation.stateHash());
    }
    simulation.end();
    return found;
  }
};

TEST_F(Observers, ChangeNoBitOfTheRun) {
  modules().openAll();
  for (const Method& method : methods) {
    const auto alone = hashes(scene(method, ""));
    int watched = 0;
    for (const ComponentEntry* entry : factory().entries()) {
      if (!dynamic_cast<Observer*>(factory().make(entry->type).get())) continue;
      const auto asked = asked_for.find(entry->type);
      ASSERT_TRUE(asked != asked_for.end()) << entry->type << " is an observer: say what it can be asked for";
      ++watched;
      EXPECT_EQ(hashes(scene(method, "<" + entry->type + " " + asked->second + "/>")), alone)
          << entry->type << " beside " << method.integrator;
    }
    EXPECT_EQ(watched, int(asked_for.size()));
  }
}

TEST_F(Observers, ChangeNoBitTogetherWhereBodiesTouchOrAreTied) {
  modules().openAll();
  std::string all;
  for (const auto& [type, asked] : asked_for) all += fmt::format("<{} {}/>", type, asked);
  for (const auto& [parts, solver] : other_bodies) {
    SCOPED_TRACE(parts);
    EXPECT_EQ(hashes(bodyWith(parts, solver, all)), hashes(bodyWith(parts, solver, "")));
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
