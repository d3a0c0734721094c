// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers that fit no system of units are doubted when a scene is loaded, and others are not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/checks/units_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class UnitDoubts : public UnitsFixture {};

struct Body {
  const char* gravity;
  const char* max;  ///< of a box from 0
  const char* mass;
  const char* young;
};

std::string bodyScene(const Body& body) {
  return fmt::format(
      R"(<Node name="root" {}>
  {}<CGLinearSolver/>
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="{}"/>
  <MechanicalObject/>
  {}
  <HexahedronFEMForceField name="fem" youngModulus="{}" poissonRatio="0.45"/>
</Node>)",
      body.gravity,
      *body.mass ? "<EulerImplicitSolver/>" : "<StaticSolver/><FixedProjectiveConstraint indices='0 1 2 3 4 5 6 7 8'/>",
      body.max, body.mass, body.young);
}

/// Without what is said of a gravity that finds no mass.
std::vector<Problem> doubtsOfUnits(std::vector<Problem> warnings) {
  std::erase_if(warnings, [](const Problem& each) { return each.message.find("has no effect on it") != std::string::npos; });
  return warnings;
}

TEST_F(UnitDoubts, ConsistentOnesRaiseNoDoubt) {
  const char* const g = "gravity='0 -9.81 0'";
  const Body bodies[] = {
      {g, "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>", "10000"},   // m kg s
      {g, "0.1 0.08 0.06", "<UniformMass totalMass='0.5'/>", "500"},         // brain
      {"", "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>", "10000"},  // gravity by default
      {g, "1 0.05 0.05", "<DiagonalMass massDensity='7850'/>", "2.1e11"},    // steel
      {g, "2e-4 1e-4 1e-4", "<DiagonalMass massDensity='1000'/>", "100"},    // cells
      {"gravity='0 -0.0981 0'", "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>",
       "10000"},                                                                            // a hundredth: a small load
      {"gravity='0 0 -50'", "100 80 60", "<DiagonalMass massDensity='1.06e-6'/>", "10"},    // and in mm kg s
      {"gravity='0 0 -9810'", "100 80 60", "<DiagonalMass massDensity='1.06e-6'/>", "10"},  // mm kg s, kPa
      {"gravity='0 0 -9810'", "100 80 60", "<DiagonalMass massDensity='1.06e-9'/>", "0.01"},     // mm t s, MPa
      {"gravity='0 0 -9810'", "100 80 60", "<UniformMass totalMass='5e-4'/>", "0.01"},           // the same by its mass
      {"gravity='0 0 -9810'", "100 80 60", "<DiagonalMass massDensity='1.06e-3'/>", "10000"},    // mm g s, Pa
      {"gravity='0 -981 0'", "10 8 6", "<DiagonalMass massDensity='1.06'/>", "1e5"},             // cm g s, dyn/cm^2
      {"gravity='0 -9.81e-3 0'", "100 80 60", "<DiagonalMass massDensity='1.06e-3'/>", "0.01"},  // mm g ms
      {"gravity='0 0 0'", "100 80 60", "<DiagonalMass massDensity='1.06e-6'/>", "10"},
      {"gravity='0 0 0'", "1 1 1", "<DiagonalMass massDensity='1'/>", "1"},  // without dimensions
      {g, "1 1 1", "<UniformMass totalMass='1'/>", "1"},
      {"gravity='0 0 0'", "10 1 1", "<DiagonalMass massDensity='1'/>", "1000"},
      {g, "10 1 1", "<DiagonalMass massDensity='1000'/>", "1e6"},  // the cantilever of textbooks
      {g, "10 1 1", "<DiagonalMass massDensity='7850'/>", "210e9"},
      {g, "60 5 5", "<DiagonalMass massDensity='7850'/>", "210e9"},
      {g, "10 1 1", "", "210e9"},                          // no mass
      {"gravity='0 -9810 0'", "100 80 60", "", "210000"},  // mm, N, MPa
      {"gravity='0 -9.81 0 m/s^2'", "100 80 60 mm", "<DiagonalMass massDensity='1.06 g/cm^3'/>", "10 kPa"},
  };
  for (const Body& body : bodies) {
    const auto warnings = doubtsOfUnits(problemsOf(bodyScene(body)));
    EXPECT_TRUE(warnings.empty()) << bodyScene(body) << warnings[0].text();
  }
}

TEST_F(UnitDoubts, NumbersThatFitNoSystemAreDoubted) {
  struct Case {
    Body body;
    int line;
    std::vector<std::string> parts;
  };
  const char* const g = "gravity='0 -9.81 0'";
  const char* const tissue = "<DiagonalMass name='mass' massDensity='1060'/>";
  const Case cases[] = {
      // a mesh in millimetres
      {{g, "80 60 50", tissue, "10000"},
       3,
       {"size 111.8 m", "density 1060 kg/m^3", "size is outside 10 um to 100 m", "\"mm\" after the lengths of /grid"}},
      {{g, "80 60 50", "<UniformMass totalMass='0.25'/>", "10000"}, 3, {"\"mm\" after the lengths of /grid"}},
      {{"", "80 60 50", tissue, "10000"}, 3, {"\"mm\" after the lengths of /grid"}},
      // kilopascals
      {{g, "0.1 0.08 0.06", tissue, "10"},
       6,
       {"youngModulus=\"10 kPa\" on /fem", "times youngModulus: the body is too heavy for its stiffness"}},
      // the density of millimetres
      {{g, "0.1 0.08 0.06", "<DiagonalMass name='mass' massDensity='1.06e-6'/>", "10000"},
       5,
       {"massDensity=\"1.06e-06 kg/mm^3\" on /mass", "density is outside 10 kg/m^3 to 25000 kg/m^3"}},
      // grams
      {{g, "0.1 0.08 0.06", "<UniformMass name='mass' totalMass='500'/>", "10000"},
       5,
       {"totalMass=\"500 g\" on /mass", "density is outside"}},
      // millimetres, kilopascals and tonnes, with the gravity of metres
      {{"", "100 80 60", "<DiagonalMass name='mass' massDensity='1.06e-9'/>", "10"},
       3,
       {"read in mm, t, s:", "youngModulus 10 MPa", "gravity is outside", "write gravity=\"0 -9810 0\" on / (",
        "if mm, t, s are meant, else with units", "\"mm\" after the lengths of /grid", "youngModulus=\"10 kPa\"",
        "massDensity=\"1.06e-09 t/mm^3\""}},
      // the digits of metres
      {{g, "100 80 60", "<DiagonalMass name='mass' massDensity='1.06e-6'/>", "10"}, 3, {"gravity is outside"}},
      // gravity in millimetres
      {{"gravity='0 0 -9810'", "0.1 0.08 0.06", tissue, "10000"}, 1, {"gravity=\"0 0 -9810 mm/s^2\""}},
      // units here and none there: what has none is SI
      {{"gravity='0 -9.81 0'", "80 60 50", "<DiagonalMass massDensity='1.06 g/cm^3'/>", "10 kPa"},
       3,
       {"\"mm\" after the lengths of /grid"}},
      // large for what it bears, with and without a mass
      {{g, "70 30 20", tissue, "5000"}, 3, {"too heavy for its stiffness", "\"mm\" after the lengths of /grid"}},
      {{g, "70 30 20", "", "5000"},
       3,
       {"do size, stiffness and gravity fit", "for tissue on earth", "\"mm\" after the lengths of /grid"}},
      {{g, "80 60 50", "", "10 kPa"}, 3, {"size is outside 10 um to 100 m", "\"mm\" after the lengths of /grid"}},
      // a density of 1 does not switch the doubt off
      {{g, "0.1 0.08 0.06", "<DiagonalMass name='mass' massDensity='1'/>", "10000"},
       5,
       {"density is outside", "massDensity=\"1 g/cm^3\" on /mass"}},
      {{"gravity='0 0 0'", "0.1 0.08 0.06", "<DiagonalMass name='mass' massDensity='1'/>", "10 kPa"},
       5,
       {"density is outside", "massDensity=\"1 g/cm^3\" on /mass"}},
  };
  for (const Case& each : cases) {
    const auto warnings = doubtsOfUnits(problemsOf(bodyScene(each.body)));
    ASSERT_EQ(warnings.size(), 1u) << bodyScene(each.body);
    EXPECT_EQ(warnings[0].where.line, each.line) << warnings[0].text();
    for (const std::string& part : each.parts)
      EXPECT_NE(warnings[0].text().find(part), std::string::npos) << part << " is not in: " << warnings[0].text();
  }
}

TEST_F(UnitDoubts, WhatHasAUnitIsNotAdvisedAgainst) {
  const char* const g = "gravity='0 -9.81 0'";
  const char* const tissue = "<DiagonalMass name='mass' massDensity='1060'/>";
  // all in range, and heavy: nothing says which of them is wrong
  for (const char* young : {"10 Pa", "40 Pa"}) {
    const auto warnings = problemsOf(bodyScene({g, "0.5 0.08 0.06", tissue, young}));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].message.find("the body is too heavy for its stiffness"), std::string::npos)
        << warnings[0].text();
    EXPECT_EQ(warnings[0].suggestion, "");
  }
  const auto tiny = problemsOf(bodyScene({g, "0.1 0.08 0.06", tissue, "10 mPa"}));
  ASSERT_EQ(tiny.size(), 1u);
  EXPECT_NE(tiny[0].message.find("youngModulus is outside 10 Pa to 1000 GPa"), std::string::npos) << tiny[0].text();
  EXPECT_EQ(tiny[0].suggestion, "");
  write("scene.xml", bodyScene({g, "0.1 0.08 0.06", tissue, "10000"}));
  const Finished set = stroma("check scene.xml --set \"/fem.youngModulus=10 Pa\"");
  EXPECT_NE(set.err.find("too heavy for its stiffness"), std::string::npos) << set.err;
  EXPECT_EQ(set.err.find("after the lengths"), std::string::npos) << set.err;
}

/// A scene in mm, t, s with two bodies, the second with other numbers.
std::string twoBodies(const std::string& second) {
  const auto node = [](const std::string& name, const std::string& mass) {
    return fmt::format(
        "<Node name='{}'>\n<RegularGridTopology n='3 3 3' min='0 0 0' max='100 80 60'/>\n"
        "<MechanicalObject/>\n{}\n<HexahedronFEMForceField youngModulus='0.01' poissonRatio='0.45'/>\n"
        "</Node>\n",
        name, mass);
  };
  return "<Node gravity='0 -9810 0'>\n<EulerImplicitSolver/><CGLinearSolver/>\n" +
         node("good", "<DiagonalMass massDensity='1.06e-9'/>") + node("wrong", second) + "</Node>";
}

/// Declared units are those of all numbers: values with a unit, which would be refused, are not advised, but the units that fit.
TEST_F(UnitDoubts, TheSystemThatFitsIsAdvisedInPlaceOfADeclaredOne) {
  const std::string tonnes = bodyScene({"units='mm t s'", "100 80 60", "<DiagonalMass massDensity='1.06e-9'/>", "0.01"});
  EXPECT_TRUE(doubtsOfUnits(problemsOf(tonnes)).empty());
  for (const char* units : {"mm kg s", "cm g s"}) {
    std::string scene = tonnes;
    scene.replace(scene.find("mm t s"), 6, units);
    const auto doubts = doubtsOfUnits(problemsOf(scene));
    ASSERT_EQ(doubts.size(), 1u) << units;
    EXPECT_EQ(doubts[0].message.find("in no consistent system"), std::string::npos) << doubts[0].message;
    EXPECT_NE(doubts[0].suggestion.find("units=\"mm t s\""), std::string::npos) << doubts[0].suggestion;
    EXPECT_EQ(doubts[0].suggestion.find("MPa"), std::string::npos) << doubts[0].suggestion;
  }
}

TEST_F(UnitDoubts, TheBodyThatIsOffIsBlamed) {
  EXPECT_TRUE(problemsOf(twoBodies("<DiagonalMass massDensity='1.06e-9'/>")).empty());
  const auto warnings = problemsOf(twoBodies("<DiagonalMass name='mass' massDensity='1060'/>"));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].path, "/wrong/mass.massDensity") << warnings[0].text();
  EXPECT_EQ(warnings[0].where.line, 12);
  const std::string text = warnings[0].text();
  for (const char* part : {"read in mm, t, s: size 141.4 mm, youngModulus 10 kPa", "density is outside",
                           "write massDensity=\"1.06e-09\" on /wrong/mass", "if mm, t, s are meant"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
  EXPECT_EQ(text.find("too heavy"), std::string::npos) << text;
  EXPECT_EQ(text.find("with units"), std::string::npos) << "the other body is right: " << text;
}

TEST_F(UnitDoubts, TheStiffestFieldBearsTheWeight) {
  const std::string soft = "<HexahedronFEMForceField name='soft' youngModulus='15' poissonRatio='0.45'/>";
  const std::string mass = "<DiagonalMass massDensity='1060'/>";
  const auto warnings = [this](const std::string& in_node) {
    return problemsOf(bodyScene({"gravity='0 -9.81 0'", "0.1 0.08 0.06", in_node.c_str(), "1e6"}));
  };
  EXPECT_TRUE(warnings(mass + soft).empty());
  EXPECT_EQ(problemsOf(bodyScene({"gravity='0 -9.81 0'", "0.5 0.08 0.06", mass.c_str(), "15"})).size(), 1u)
      << "alone it does not";
}

/// Of a law with several moduli the one whose value is printed is named.
TEST_F(UnitDoubts, TheModulusThatIsToldIsTheStiffest) {
  const auto problems = problemsOf(R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology n="3 3 3" min="0 0 0" max="0.02 0.02 0.02"/><MechanicalObject/><UniformMass totalMass="1"/>
  <HexahedronHyperelasticityFEMForceField materialName="MooneyRivlin" c1="2e4" c2="1e4" k0="2e8"/>
  <FixedProjectiveConstraint indices="0 1 2 3"/></Node>)");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].message.find("k0 200 MPa"), std::string::npos) << problems[0].message;
}

TEST_F(UnitDoubts, ALoaderOfAnotherMeshIsNotNamed) {
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  const auto warnings = problemsOf(R"(<Node name="root" gravity="0 -9.81 0">
  <EulerImplicitSolver/><CGLinearSolver/>
  <MeshGmshLoader name="other" filename="scenes/meshes/organ_600.msh"/>
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="80 60 50"/>
  <HexahedronSetTopologyContainer name="cells" position="@grid.position" hexahedra="@grid.hexahedra"/>
  <MechanicalObject/>
  <DiagonalMass massDensity="1060"/>
  <HexahedronFEMForceField youngModulus="10000" poissonRatio="0.45"/>
</Node>)");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].text().find("\"mm\" after the lengths of /grid"), std::string::npos) << warnings[0].text();
  EXPECT_EQ(warnings[0].path, "/grid");
}

TEST_F(UnitDoubts, TheColumnOfATransformationStaysInMetres) {
  write("m.obj", "v 0 0 0\nv 12.5 0 0\nv 0 30 0\nf 1 2 3\n");
  const auto warned = [this](const std::string& more) {
    const auto warnings = problemsOf(meshScene("<MeshOBJLoader name='mesh' filename='m.obj' " + more + "/>"));
    return std::count_if(warnings.begin(), warnings.end(), [](const Problem& each) {
      return each.message.find("the last column of transformation is in metres") != std::string::npos;
    });
  };
  EXPECT_EQ(warned("unit='mm' transformation='1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1'"), 1);
  EXPECT_EQ(warned("unit='mm' transformation='0 -1 0 0  1 0 0 0  0 0 1 0  0 0 0 1'"), 0);
  EXPECT_EQ(warned("unit='m' transformation='1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1'"), 0);
  EXPECT_EQ(warned("transformation='1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1'"), 0);
}

TEST_F(UnitDoubts, ALoaderIsNamedForItsUnit) {
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  const auto scene = [](const char* loader) {
    return fmt::format(R"(<Node name="root" gravity="0 -9.81 0">
  <Node name="organ">
    <EulerImplicitSolver/><CGLinearSolver/>
    <MeshGmshLoader name="loader" filename="scenes/meshes/organ_600.msh" {}/>
    <TetrahedronSetTopologyContainer src="@loader"/><MechanicalObject/><DiagonalMass massDensity="1060"/>
    <TetrahedronFEMForceField youngModulus="10000" poissonRatio="0.45"/>
  </Node>
</Node>)",
                       loader);
  };
  write("scene.xml", scene("scale='1000'"));
  const Finished checked = stroma("check scene.xml");
  EXPECT_EQ(checked.code, 0);
  EXPECT_NE(checked.err.find("scene.xml:4:5: warning: /organ/loader: in no consistent system"), std::string::npos)
      << checked.err;
  EXPECT_NE(checked.err.find("unit=\"mm\" on /organ/loader (scene.xml:4:5)"), std::string::npos) << checked.err;
  const Finished run = stroma("run scene.xml -n 1");
  EXPECT_NE(run.err.find("in no consistent system"), std::string::npos) << run.err;
  write("scene.xml", scene("scale='1000' unit='mm'"));
  EXPECT_EQ(stroma("check scene.xml").err.find("consistent system"), std::string::npos);
}

TEST_F(UnitDoubts, NoSceneOfTheProjectIsDoubted) {
  long scenes = 0;
  for (const char* folder : {"examples", "validation", "benchmarks"})
    for (const auto& entry : std::filesystem::directory_iterator(std::string(STROMA_SOURCE_DIR "/scenes/") + folder)) {
      if (entry.path().extension() != ".xml") continue;
      Session session;
      try {
        session.load(entry.path().string());
      } catch (const SceneError& error) {  // needs what this test has not
        continue;
      }
      ++scenes;
      const std::string told = session.simulation().scene().diagnostics.text();
      EXPECT_EQ(told.find("consistent system"), std::string::npos) << told;
    }
  EXPECT_GT(scenes, 45);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
