// SPDX-License-Identifier: LGPL-2.1-or-later
// Units through the whole way of a scene: numbers, loaders, overrides, edits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "framework/mechanics/state.h"
#include "tests/checks/units_fixture.h"
#include "tools/scene_writer/changed_scene.h"
#include "tools/units/units.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class UnitsInScenes : public UnitsFixture {};

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
    const auto with = [&, type = type, file = file](const std::string& more) {
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
  EXPECT_NE(told.find("gravity is not given: the earth's is used along -y, 9810 mm/s^2"), std::string::npos) << told;
  EXPECT_NEAR(gravityOf("units=\"cm g ms\"").y(), -9.81e-4, 1e-18);
  EXPECT_EQ(gravityOf("units=\"mm g ms\"", &told), Vec3(0, -9.81e-3, 0));
  EXPECT_NE(told.find("along -y, 0.00981 mm/ms^2"), std::string::npos) << told;
  EXPECT_EQ(gravityOf("units=\"mm kPa s\" gravity=\"0 0 -10\"", &told), Vec3(0, 0, -10));
  EXPECT_EQ(told.find("gravity"), std::string::npos) << told;
  for (const char* si : {"", "units=\"m kg s\""}) {
    EXPECT_EQ(gravityOf(si, &told), Vec3(0, -9.81, 0)) << si;
    EXPECT_EQ(told.find("gravity"), std::string::npos) << told;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
