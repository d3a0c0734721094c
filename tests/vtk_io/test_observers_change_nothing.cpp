// SPDX-License-Identifier: LGPL-2.1-or-later
// Every observer of the factory, with all that it can be asked for, beside every integrator: the bits of the run are those
// of one that nobody watches.
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

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
