// SPDX-License-Identifier: LGPL-2.1-or-later
// ValuesFromLabels: the table, its errors, and a bar of two materials in series against its closed form.
#include <gtest/gtest.h>

#include "framework/mechanics/state.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

std::string engine(const std::string& attributes) {
  return "<Node name=\"root\"><ValuesFromLabels name=\"engine\" " + attributes + "/></Node>";
}

std::vector<double> valuesOf(const std::string& attributes) {
  const Scene scene = sceneFromText(engine(attributes));
  return *std::get<std::vector<double>*>(findComponent(*scene.root, "/engine")->data().find("values")->pointer());
}

void expectError(const std::string& attributes, const std::string& part) {
  try {
    sceneFromText(engine(attributes));
    ADD_FAILURE() << attributes << " is accepted";
  } catch (const SceneError& error) {
    EXPECT_NE(error.diagnostics().text().find(part), std::string::npos) << error.diagnostics().text();
  }
}

TEST(ValuesFromLabels, GiveEachCellTheValueOfItsLabel) {
  EXPECT_EQ(valuesOf("labels=\"2 1 1 7\" table=\"1 10  7 0.5  2 20\""), (std::vector<double>{20, 10, 10, 0.5}));
  EXPECT_EQ(valuesOf("labels=\"2 1 9\" table=\"2 20\" defaultValue=\"-1\""), (std::vector<double>{20, -1, -1}));
}

TEST(ValuesFromLabels, SeveralValuesALabel) {
  EXPECT_EQ(valuesOf("labels=\"2 1 2\" width=\"3\" table=\"1 1 0 0  2 0.5 0 2\""),
            (std::vector<double>{0.5, 0, 2, 1, 0, 0, 0.5, 0, 2}));
  EXPECT_EQ(valuesOf("labels=\"2 9\" width=\"2\" table=\"2 3 4\" defaultValue=\"-1\""),
            (std::vector<double>{3, 4, -1, -1}));
  expectError("labels=\"2 1\" width=\"3\" table=\"1 10  2 20 3\"", "a label and its 3 values");
  expectError("labels=\"1\" width=\"2\" table=\"1.5 10 20\"", "1.5 in table is not a label");
}

TEST(ValuesFromLabels, ErrorsNameTheLabel) {
  expectError("labels=\"2 1 5 5\" table=\"1 10  2 20\"", "no value for label 5 (2 cells)");
  expectError("labels=\"2 1\" table=\"1 10  2\"", "table has 3 numbers");
  expectError("labels=\"2 1\" table=\"1.5 10  2 20\"", "1.5 in table is not a label");
  expectError("labels=\"2 1\" table=\"1 10  2 20  1 5\"", "the label 1 twice");
  expectError("labels=\"\" table=\"1 10\"", "labels");
  const Scene scene = sceneFromText(engine("labels=\"1 1\" table=\"1 10  4 20\""));
  EXPECT_NE(scene.diagnostics.text().find("no cell has the label 4"), std::string::npos) << scene.diagnostics.text();
}

TEST(ValuesFromLabels, TwoMaterialsInSeriesStretchAsTheirSum) {
  // without lateral contraction u = F / A (l_1 / E_1 + l_2 / E_2): 8 N on 4 m^2, 1 m of 1000 Pa and 2 m of 5000 Pa
  Simulation simulation = simulationFromText(R"(<Node name="root" gravity="0 0 0">
    <StaticSolver/><SparseLDLSolver/>
    <RegularGridTopology name="grid" n="2 2 4" min="0 0 0" max="2 2 3"/>
    <MechanicalObject name="dofs"/>
    <ValuesFromLabels name="stiffness" labels="4 7 7" table="7 5000  4 1000"/>
    <HexahedronFEMForceField method="small" youngModulus="@stiffness.values" poissonRatio="0"/>
    <BoxROI name="low" box="-1 -1 -0.1 3 3 0.1"/><BoxROI name="high" box="-1 -1 2.9 3 3 3.1"/>
    <FixedProjectiveConstraint indices="@low.indices"/>
    <ConstantForceField indices="@high.indices" totalForce="0 0 8"/></Node>)");
  simulation.step();
  const auto* state = dynamic_cast<State*>(findComponent(*simulation.scene().root, "/dofs"));
  ASSERT_NE(state, nullptr);
  for (Index n = 0; n < 4; ++n) {
    EXPECT_NEAR(state->x()[4 + n].z() - 1, 2. / 1000, 1e-12);
    EXPECT_NEAR(state->x()[12 + n].z() - 3, 2 * (1. / 1000 + 2. / 5000), 1e-12);
  }
}

}  // namespace
}  // namespace stroma::test
