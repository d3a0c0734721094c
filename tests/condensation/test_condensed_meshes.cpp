// SPDX-License-Identifier: LGPL-2.1-or-later
// Condensed against whole bodies on meshes of organs: the example organ, a liver, a leg of two materials.
#include <fstream>
#include <iterator>

#include "framework/mesh/topology.h"
#include "tests/condensation/bodies.h"

using namespace stroma;
using namespace stroma::test;

namespace {

// one exact solve of a linear body; what is left is round-off
const std::string newton =
    "<StaticSolver newton_iterations=\"4\" relative_residual_tolerance_threshold=\"1e-9\"/><SparseLDLSolver/>";

void replace(std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

/// A mesh of tetrahedra, held between two heights, pulled at a node, under a weight. SOLVER and MASS are left open.
std::string organ(const std::string& file, double low, double high, int pulled) {
  return "<Node name=\"root\" dt=\"0.02\" gravity=\"0 -1 0\">SOLVER<MeshGmshLoader name=\"loader\" filename=\"" + file +
         "\"/><TetrahedronSetTopologyContainer name=\"mesh\" src=\"@loader\"/><MechanicalObject name=\"dofs\"/>MASS"
         "<TetrahedronFEMForceField name=\"fem\" method=\"small\" youngModulus=\"5000\" poissonRatio=\"0.4\"/>"
         "<BoxROI name=\"held\" box=\"-99 " +
         std::to_string(low) + " -99 99 " + std::to_string(high) +
         " 99\" position=\"@dofs.rest_position\"/><FixedProjectiveConstraint indices=\"@held.indices\"/>"
         "<ConstantForceField indices=\"" +
         std::to_string(pulled) + "\" totalForce=\"0.1 0.2 0.3\"/></Node>";
}

/// The example scene of the leg, without its exporter.
std::string leg() {
  const std::string scenes = std::string(STROMA_SOURCE_DIR) + "/scenes/";
  std::ifstream file(scenes + "examples/leg.xml");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  replace(text, "<CondensedStaticSolver name=\"solver\"/>", "SOLVER");
  replace(text, "<DiagonalMass name=\"mass\" massDensity=\"1060\"/>", "MASS");
  replace(text, "../meshes/", scenes + "meshes/");
  const auto start = text.find("<VTKExporter"), end = text.find("/>", start);
  text.erase(start, end + 2 - start);
  return text;
}

/// Empty where the liver of the shared data is not here.
std::string bodyOf(const std::string& name) {
  const std::string organ_file = std::string(STROMA_SOURCE_DIR) + "/scenes/meshes/organ_600.msh";
  const std::string liver_file = std::string(STROMA_SHARED_DATA) + "/meshes/liver.msh";
  if (name == "organ") return organ(organ_file, 0.03, 99, 5);
  if (name == "leg") return leg();
  return std::filesystem::exists(liver_file) ? organ(liver_file, -99, 1, 60) : "";
}

std::string with(std::string text, const std::string& solver, const std::string& mass) {
  replace(text, "SOLVER", solver);
  replace(text, "MASS", mass);
  return text;
}

int interiorOf(const Simulation& simulation) {
  return *std::get<int*>(simulation.systems().front()->integrator().data().find("interiorNodes")->pointer());
}

class CondensedMeshes : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (text.empty()) GTEST_SKIP() << "the liver of the shared data is not here";
  }
  const std::string name = GetParam(), text = bodyOf(name);
};

}  // namespace

TEST_P(CondensedMeshes, StaticBodiesAreTheWholeOnes) {
  const std::string mass = "<DiagonalMass massDensity=\"1\"/>";
  const Vector expected = after(with(text, newton, mass), 3);
  EXPECT_GT(norm(expected), 1e-6) << name;
  EXPECT_LT(difference(after(with(text, "<CondensedStaticSolver/>", mass), 3), expected), 1e-10) << name;
  EXPECT_GT(interiorOf(simulationFromText(with(text, "<CondensedStaticSolver/>", mass))), 10) << name;
}

TEST_P(CondensedMeshes, DynamicBodiesAreTheWholeOnes) {
  const std::string mass = "<DiagonalMass massDensity=\"1060\"/>";
  const Vector expected = after(with(text, "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\"/>", mass), 10);
  EXPECT_GT(norm(expected), 1e-6) << name;
  EXPECT_LT(difference(after(with(text, "<CondensedDynamicSolver/>", mass), 10), expected), 1e-10) << name;
}

TEST_P(CondensedMeshes, DynamicBodiesWithoutMassInsideAreTheWholeOnes) {
  // masses on the boundary alone, and elsewhere nothing to speak of
  Simulation probe = simulationFromText(with(text, "<CondensedStaticSolver/>", "<DiagonalMass massDensity=\"1\"/>"));
  const State& state = *probe.states().front();
  std::vector<char> outside(std::size_t(state.size()), 0);
  for (const Triangle& face : state.find<Topology>(true)->mesh().boundaryTriangles())
    for (const Index node : face) outside[node] = 1;
  // what a constraint moves is kept, wherever it lies
  for (const NodeProjector& held : probe.systems().front()->constraints().projectors()) outside[held.row] = 1;
  std::string masses;
  for (const char is_outside : outside) masses += is_outside ? "0.003 " : "1e-25 ";
  const std::string mass = "<DiagonalMass vertexMass=\"" + masses + "\"/>";
  const Vector expected = after(with(text, "<CondensedDynamicSolver condensed=\"false\" solve=\"factor\"/>", mass), 10);
  EXPECT_GT(norm(expected), 1e-6) << name;
  EXPECT_LT(difference(after(with(text, "<CondensedDynamicSolver interiorMass=\"neglected\"/>", mass), 10), expected),
            1e-10)
      << name;
}

INSTANTIATE_TEST_SUITE_P(All, CondensedMeshes, testing::Values("organ", "leg", "liver"),
                         [](const auto& tested) { return std::string(tested.param); });
