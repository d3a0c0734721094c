// SPDX-License-Identifier: LGPL-2.1-or-later
// Units through the whole way of a scene: every attribute of every component, loaders, overrides, edits, doubts at load.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "framework/mechanics/state.h"
#include "tests/support/shell.h"
#include "tools/scene_writer/changed_scene.h"
#include "tools/session/session.h"
#include "tools/units/units.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

bool holdsReals(const Data& data) {
  const DataPointer& at = data.pointer();
  return std::holds_alternative<double*>(at) || std::holds_alternative<Vec3*>(at) ||
         std::holds_alternative<std::vector<double>*>(at) || std::holds_alternative<std::vector<Vec3>*>(at);
}

template <class Visit>
void forEachAttribute(Visit&& visit) {
  Factory factory;
  Modules modules(factory);
  int count = 0;
  for (const auto& entry : modules.index()) {
    ASSERT_TRUE(modules.provide(entry.type)) << entry.type;
    const auto component = factory.make(entry.type);
    for (Data& data : component->data().all()) visit(entry.type, data), ++count;
  }
  EXPECT_GT(count, 1000);
}

TEST(UnitsOfAttributes, EachDeclaredTextIsAUnit) {
  std::set<std::string> texts;
  forEachAttribute([&texts](const std::string& type, const Data& data) {
    if (data.unitText().empty() || data.unitText() == "N or N s") return;
    texts.insert(data.unitText());
    ASSERT_TRUE(findUnit(data.unitText())) << type << "." << data.name() << " [" << data.unitText() << "]";
    const Dimension dimension = readUnit(data.unitText()).dimension;
    if (dimension == Dimension{}) return;
    EXPECT_NE(describe(dimension).find("such as"), std::string::npos)
        << type << "." << data.name() << " [" << data.unitText() << "] has no words in units.cpp";
  });
  EXPECT_GT(texts.size(), 15u);
}

/// Numbers of several kinds in one list, or of a kind that another attribute decides.
const std::set<std::string> of_no_one_unit = {"ParameterSet", "c2",     "c4",           "oscillators",   "spring",
                                              "table",        "values", "defaultValue", "transformation", "planes"};

TEST(UnitsOfAttributes, EachAttributeOfRealsSaysItsUnit) {
  forEachAttribute([](const std::string& type, const Data& data) {
    if (holdsReals(data))
      EXPECT_EQ(data.unitText().empty(), of_no_one_unit.count(data.name()) == 1) << type << "." << data.name();
  });
}

/// A unit of the dimension that is a thousandth of the declared one.
std::string thousandth(const std::string& unit) {
  return unit.starts_with("1/") ? "mm" + unit.substr(1) + "/m" : "mm " + unit + "/m";
}

TEST(UnitsOfAttributes, EachIsReadInAnotherUnitOfItsDimension) {
  long read = 0;
  forEachAttribute([&read](const std::string& type, Data& data) {
    if (data.unitText().empty() || data.isOutput() || !holdsReals(data)) return;
    if (data.unitText() == "N or N s") return;
    const Dimension dimension = readUnit(data.unitText()).dimension;
    if (dimension == Dimension{}) return;
    const std::string numbers = std::holds_alternative<double*>(data.pointer()) ? "4000" : "4000 4000 4000";
    const auto problem = data.parse(numbers + " " + thousandth(data.unitText()), DataOrigin::written);
    ASSERT_FALSE(problem) << type << "." << data.name() << ": " << problem->text();
    EXPECT_EQ(data.print(), numbers == "4000" ? "4" : "4 4 4") << type << "." << data.name();
    const auto wrong = data.parse(numbers + " m^7", DataOrigin::written);
    ASSERT_TRUE(wrong) << type << "." << data.name();
    EXPECT_EQ(wrong->expected, describe(dimension)) << type << "." << data.name();
    ++read;
  });
  EXPECT_GT(read, 200);
}

class UnitsInScenes : public CommandTest {
 protected:
  std::uint64_t hashOf(const std::string& xml, const std::vector<Override>& overrides = {}) {
    Session session;
    Simulation& simulation = session.loadText(xml, (folder_ / "scene.xml").string(), overrides);
    session.run({.steps = 5});
    EXPECT_EQ(simulation.steps(), 5);
    return simulation.stateHash();
  }
  /// Warnings of a scene at load.
  std::vector<Problem> problemsOf(const std::string& xml, Severity severity = Severity::warning) {
    Session session;
    Simulation& simulation = session.loadText(xml, (folder_ / "scene.xml").string());
    std::vector<Problem> found;
    for (const Problem& problem : simulation.scene().diagnostics.problems())
      if (problem.severity == severity) found.push_back(problem);
    return found;
  }
  std::string errorOf(const std::string& xml) {
    try {
      Session session;
      session.loadText(xml, (folder_ / "scene.xml").string());
    } catch (const SceneError& error) {
      return error.what();
    }
    return {};
  }
};

const char* const plain = R"(<Node name="root" dt="0.02" gravity="0 -9.81 0">
  <EulerImplicitSolver rayleighStiffness="0.005"/><SparseLDLSolver/>
  <RegularGridTopology n="4 3 3" min="0 0 0" max="0.12 0.04 0.03"/>
  <MechanicalObject name="dofs" rotation="0 0 10"/>
  <DiagonalMass name="mass" massDensity="1060"/>
  <HexahedronFEMForceField name="fem" youngModulus="10500" poissonRatio="0.45"/>
  <BoxROI name="held" box="-1 -1 -1 0.001 1 1"/>
  <FixedProjectiveConstraint indices="@held.indices"/>
  <BoxROI name="end" box="0.1 -1 -1 1 1 1"/>
  <ConstantForceField name="pull" indices="@end.indices" totalForce="0.15 0 0"/>
</Node>)";

const char* const in_units = R"(<Node name="root" dt="1/50 s" gravity="0 -9810 0 mm/s^2">
  <EulerImplicitSolver rayleighStiffness="5 ms"/><SparseLDLSolver/>
  <RegularGridTopology n="4 3 3" min="0 0 0" max="12 4 3 cm"/>
  <MechanicalObject name="dofs" rotation="0 0 10 deg"/>
  <DiagonalMass name="mass" massDensity="1.06 g/cm^3"/>
  <HexahedronFEMForceField name="fem" youngModulus="10.5 kPa" poissonRatio="45 %"/>
  <BoxROI name="held" box="-1000 -1000 -1000 1 1000 1000 mm"/>
  <FixedProjectiveConstraint indices="@held.indices"/>
  <BoxROI name="end" box="10 cm -1 m -1 m 1 m 1 m 1 m"/>
  <ConstantForceField name="pull" indices="@end.indices" totalForce="150 0 0 mN"/>
</Node>)";

TEST_F(UnitsInScenes, ASceneInUnitsHasTheBitsOfItsTwinInSI) {
  const std::uint64_t expected = hashOf(plain);
  EXPECT_EQ(hashOf(in_units), expected);
  EXPECT_NE(hashOf(plain, {Override::parse("/fem.youngModulus=11 kPa")}), expected) << "the comparison sees a change";
  EXPECT_EQ(
      hashOf(plain, {Override::parse("/fem.youngModulus=10.5 kPa"), Override::parse("dt=20 ms"),
                     Override::parse("gravity=-9.81 m/s^2"), Override::parse("/mass.massDensity=1.06e-9 t/mm^3")}),
      expected);
}

TEST_F(UnitsInScenes, EditsOfARunTakeThemAndTheTextKeepsThem) {
  const std::string file = write("scene.xml", plain);
  Session session;
  Simulation& simulation = session.load(file);
  simulation.setAttribute("/fem", "youngModulus", "12 kPa");
  simulation.setAttribute("/", "dt", "10 ms");
  const Diagnostics told = simulation.setAttribute("/", "gravity", "-3720 mm/s^2");
  ASSERT_EQ(told.problems().size(), 1u);
  EXPECT_NE(told.text().find("along y: 0 -3.72 0 m/s^2"), std::string::npos) << told.text();
  EXPECT_EQ(simulation.dt(), 0.01);
  EXPECT_EQ(simulation.root().gravity(), Vec3(0, -3.72, 0));
  EXPECT_EQ(findComponent(simulation.root(), "/fem")->data().find("youngModulus")->print(), "12000");
  const std::string text = changedScene(simulation).texts.at(file);
  for (const char* part : {"youngModulus=\"12 kPa\"", "dt=\"10 ms\"", "gravity=\"-3720 mm/s^2\""})
    EXPECT_NE(text.find(part), std::string::npos) << part << text;
  session.run({.steps = 3});
  Session again;
  Simulation& reread = again.loadText(text, file);
  again.run({.steps = 3});
  EXPECT_EQ(reread.stateHash(), simulation.stateHash());
  try {
    simulation.setAttribute("/fem", "youngModulus", "12 mm");
    FAIL() << "accepted";
  } catch (const ComponentError& error) {
    EXPECT_NE(std::string(error.what()).find("'mm' is the unit of a length"), std::string::npos) << error.what();
    EXPECT_EQ(error.expected, "a pressure, such as Pa, kPa, MPa, mmHg");
  }
}

std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const auto at = text.find(part);
  EXPECT_NE(at, text.npos) << part;
  return at == text.npos ? text : text.replace(at, part.size(), by);
}

TEST_F(UnitsInScenes, AWrongUnitIsAnErrorAtItsPlace) {
  write("scene.xml", replaced(in_units, "10.5 kPa", "10.5 kpa"));
  const Finished unknown = stroma("check scene.xml");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("scene.xml:6:"), std::string::npos) << unknown.err;
  EXPECT_NE(
      unknown.err.find("'kpa' is not a unit (expected a pressure, such as Pa, kPa, MPa, mmHg; did you mean 'kPa'?)"),
      std::string::npos)
      << unknown.err;
  EXPECT_NE(errorOf(replaced(in_units, "45 %", "45 kPa")).find("expected a number without unit"), std::string::npos);
  EXPECT_NE(errorOf(replaced(in_units, "1/50 s", "50 Hz")).find("'Hz' is the unit of a rate (expected a time"),
            std::string::npos);
  EXPECT_NE(errorOf(replaced(in_units, "0 -9810 0 mm/s^2", "0 -9.81 0 N")).find("expected an acceleration"),
            std::string::npos);
  EXPECT_NE(errorOf(replaced(in_units, "1/50 s", "0 ms")).find("a value > 0 s"), std::string::npos);
  EXPECT_NE(errorOf(replaced(in_units, "10.5 kPa", "-10.5 kPa")).find("-10500 is outside the range"),
            std::string::npos);
}

TEST_F(UnitsInScenes, OneNumberOfGravityIsNoted) {
  auto notes = problemsOf(replaced(plain, "0 -9.81 0", "-9.81 m/s^2"), Severity::note);
  std::erase_if(notes, [](const Problem& note) { return note.path != "/.gravity"; });
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].message, "gravity is one number and acts along y: 0 -9.81 0 m/s^2");
  EXPECT_EQ(notes[0].where.line, 1);
  EXPECT_EQ(hashOf(replaced(plain, "0 -9.81 0", "-9.81")), hashOf(plain));
}

// ---- loaders ----

std::string meshScene(const std::string& loader) {
  return "<Node name='root'>" + loader +
         "<MechanicalObject name='dofs' src='@mesh'/><MeshTopology name='topology' src='@mesh'/></Node>";
}

TEST_F(UnitsInScenes, EveryLoaderMakesMetresOfItsUnit) {
  const std::string obj = "v 0 0 0\nv 12.5 0 0\nv 0 30 0\nf 1 2 3\n";
  write("m.obj", obj);
  write("m.stl",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 12.5 0 0\nvertex 0 30 0\nendloop\n"
        "endfacet\nendsolid s\n");
  write("m.vtk",
        "# vtk DataFile Version 3.0\nm\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 12.5 0 0 0 30 0\n"
        "POLYGONS 1 4\n3 0 1 2\n");
  write("m.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 12.5 0 0\n3 0 30 0\n$EndNodes\n$Elements\n1\n"
        "1 2 2 1 1 1 2 3\n$EndElements\n");
  const auto farthest = [this](const std::string& loader) {
    Session session;
    const std::string scene =
        loader.starts_with("<MeshTopology") ? "<Node>" + loader + "<MechanicalObject/></Node>" : meshScene(loader);
    Simulation& simulation = session.loadText(scene, (folder_ / "scene.xml").string());
    std::vector<State*> states;
    simulation.root().collect(states);
    Vec3 high = Vec3::Zero();
    for (const Vec3& p : states.at(0)->rest_position) high = high.cwiseMax(p);
    return high;
  };
  const std::pair<const char*, const char*> loaders[] = {
      {"MeshOBJLoader", "m.obj"}, {"MeshSTLLoader", "m.stl"}, {"MeshVTKLoader", "m.vtk"}, {"MeshGmshLoader", "m.msh"}};
  for (const auto& [type, file] : loaders) {
    const auto with = [&](const std::string& more) {
      return farthest(fmt::format("<{} name='mesh' filename='{}' {}/>", type, file, more));
    };
    EXPECT_EQ(with(""), Vec3(12.5, 30, 0)) << type;
    EXPECT_EQ(with("unit='mm'"), Vec3(0.0125, 0.03, 0)) << type;
    EXPECT_EQ(with("unit='cm' scale3d='2 1 1'"), Vec3(0.25, 0.3, 0)) << type;
    EXPECT_EQ(with("unit='mm' translation='1 0 0'"), Vec3(1.0125, 0.03, 0)) << type;
    EXPECT_EQ(with("unit='mm' translation='1000 0 0 mm'"), Vec3(1.0125, 0.03, 0)) << type;
  }
  EXPECT_EQ(farthest("<MeshTopology name='mesh' filename='m.msh' unit='mm'/>"), Vec3(0.0125, 0.03, 0));
  const std::string wrong = errorOf(meshScene("<MeshOBJLoader name='mesh' filename='m.obj' unit='kg'/>"));
  EXPECT_NE(wrong.find("'kg' is no unit of length (expected a length, such as m, cm, mm)"), std::string::npos) << wrong;
  const std::string unknown = errorOf(meshScene("<MeshOBJLoader name='mesh' filename='m.obj' unit='millimeter'/>"));
  EXPECT_NE(unknown.find("did you mean 'mm'?"), std::string::npos) << unknown;
  const std::string none = errorOf(meshScene("<MeshTopology name='mesh' position='0 0 0' unit='mm'/>"));
  EXPECT_NE(none.find("unit is that of a file"), std::string::npos) << none;
}

// ---- doubts ----

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

TEST_F(UnitsInScenes, ConsistentOnesRaiseNoDoubt) {
  const char* const g = "gravity='0 -9.81 0'";
  const Body bodies[] = {
      {g, "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>", "10000"},   // m kg s
      {g, "0.1 0.08 0.06", "<UniformMass totalMass='0.5'/>", "500"},         // brain
      {"", "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>", "10000"},  // gravity by default
      {g, "1 0.05 0.05", "<DiagonalMass massDensity='7850'/>", "2.1e11"},    // steel
      {g, "2e-4 1e-4 1e-4", "<DiagonalMass massDensity='1000'/>", "100"},    // cells
      {"gravity='0 -0.0981 0'", "0.1 0.08 0.06", "<DiagonalMass massDensity='1060'/>",
       "10000"},                                                                            // a hundredth: a small load
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
    const auto warnings = problemsOf(bodyScene(body));
    EXPECT_TRUE(warnings.empty()) << bodyScene(body) << warnings[0].text();
  }
}

TEST_F(UnitsInScenes, NumbersThatFitNoSystemAreDoubted) {
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
    const auto warnings = problemsOf(bodyScene(each.body));
    ASSERT_EQ(warnings.size(), 1u) << bodyScene(each.body);
    EXPECT_EQ(warnings[0].where.line, each.line) << warnings[0].text();
    for (const std::string& part : each.parts)
      EXPECT_NE(warnings[0].text().find(part), std::string::npos) << part << " is not in: " << warnings[0].text();
  }
}

TEST_F(UnitsInScenes, WhatHasAUnitIsNotAdvisedAgainst) {
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

TEST_F(UnitsInScenes, TheBodyThatIsOffIsBlamed) {
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

TEST_F(UnitsInScenes, TheStiffestFieldBearsTheWeight) {
  const std::string soft = "<HexahedronFEMForceField name='soft' youngModulus='15' poissonRatio='0.45'/>";
  const std::string mass = "<DiagonalMass massDensity='1060'/>";
  const auto warnings = [this](const std::string& in_node) {
    return problemsOf(bodyScene({"gravity='0 -9.81 0'", "0.1 0.08 0.06", in_node.c_str(), "1e6"}));
  };
  EXPECT_TRUE(warnings(mass + soft).empty());
  EXPECT_EQ(problemsOf(bodyScene({"gravity='0 -9.81 0'", "0.5 0.08 0.06", mass.c_str(), "15"})).size(), 1u)
      << "alone it does not";
}

TEST_F(UnitsInScenes, ALoaderOfAnotherMeshIsNotNamed) {
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

TEST_F(UnitsInScenes, TheColumnOfATransformationStaysInMetres) {
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

TEST_F(UnitsInScenes, ALoaderIsNamedForItsUnit) {
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

/// What acts where no gravity is written is the earth's, in the units that the scene declares.
TEST_F(UnitsInScenes, GravityThatIsNotWrittenIsTheEarths) {
  const auto gravityOf = [this](const std::string& attributes, std::string* told = nullptr) {
    Session session;
    const Simulation& simulation = session.loadText(
        "<Node name=\"root\" " + attributes + "><Node name=\"below\"/></Node>", (folder_ / "scene.xml").string());
    if (told) *told = simulation.scene().diagnostics.text();
    return Vec3(simulation.root().children()[0]->gravity());
  };
  std::string told;
  EXPECT_EQ(gravityOf("units=\"mm kPa s\"", &told), Vec3(0, -9810, 0));
  EXPECT_NE(told.find("no gravity is written: the earth's acts along -y, 9810 mm/s^2"), std::string::npos) << told;
  EXPECT_NEAR(gravityOf("units=\"cm g ms\"").y(), -9.81e-4, 1e-18);
  EXPECT_EQ(gravityOf("units=\"mm kPa s\" gravity=\"0 0 -10\"", &told), Vec3(0, 0, -10));
  EXPECT_EQ(told.find("gravity"), std::string::npos) << told;
  for (const char* si : {"", "units=\"m kg s\""}) {
    EXPECT_EQ(gravityOf(si, &told), Vec3(0, -9.81, 0)) << si;
    EXPECT_EQ(told.find("gravity"), std::string::npos) << told;
  }
}

TEST_F(UnitsInScenes, NoSceneOfTheProjectIsDoubted) {
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
