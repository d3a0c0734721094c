// SPDX-License-Identifier: LGPL-2.1-or-later
// Stiffnesses that nobody gave: a warning states the number that is used.
#include <set>

#include "framework/mechanics/force_field.h"
#include "framework/scene/modules.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Only some scenes ask for these, which are told of in another way, see below; a required attribute stands for others.
const std::set<std::string> of_some_scenes = {
    "BeamHookeLawForceField.lengthY",
    "BeamHookeLawForceField.lengthZ",
    "BeamHookeLawForceField.radius",
    "HexahedronPorousForceField.biotModulus",   // limitModulus, a required one
    "TetrahedronPorousForceField.biotModulus",  // likewise
    "RegularGridSpringForceField.cubesStiffness",
    "RegularGridSpringForceField.linesStiffness",
    "RegularGridSpringForceField.quadsStiffness",
    "RestShapeSpringsForceField.angularStiffness",
    "SpringForceField.stiffness",
};

bool hasNumber(const std::string& text) { return text.find_first_of("123456789") != std::string::npos; }

TEST(GivenStiffness, EveryNumberThatAForceFieldHasByDefaultIsToldOf) {
  Factory factory;
  Modules modules(factory);
  int told = 0;
  for (const auto& entry : modules.index()) {
    const std::string type(entry.type);
    ASSERT_TRUE(modules.provide(type)) << type;
    const auto component = factory.make(type);
    if (!dynamic_cast<ForceField*>(component.get())) continue;
    for (const Data& data : component->data().all()) {
      const std::string& unit = data.unitText();
      if (!(unit == "N/m" || unit == "N m" || unit == "Pa") || !hasNumber(data.defaultText()) || data.isRequired()) continue;
      const std::string name = type + "." + data.name();
      EXPECT_NE(data.isPhysical(), of_some_scenes.contains(name)) << name << " is " << data.defaultText() << " " << unit;
      told += data.isPhysical();
    }
  }
  EXPECT_GT(told, 20);
}

std::string problemsWith(const std::string& field, const std::string& state = "position='0 0 0  1 0 0'") {
  return sceneFromText("<Node name='root' gravity='0 0 0'><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject name='dofs' " +
                       state + "/><UniformMass totalMass='1'/>" + field + "</Node>")
      .diagnostics.text();
}

TEST(GivenStiffness, SpringsAndPlanes) {
  const std::string pair = "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='1'";
  const std::string spring = "stiffness is not given: the default 100 N/m is used";
  expectContains(problemsWith(pair + "/>"), spring);
  EXPECT_EQ(problemsWith(pair + " stiffness='100'/>").find("not given: the default"), std::string::npos);
  EXPECT_EQ(problemsWith("<SpringForceField spring='0 1 100 0 1'/>").find("not given: the default"), std::string::npos);
  expectContains(problemsWith("<RestShapeSpringsForceField points='1'/>"), spring);
  EXPECT_EQ(problemsWith("<RestShapeSpringsForceField points='1' stiffness='3'/>").find("not given: the default"),
            std::string::npos);
  expectContains(
      problemsWith("<RestShapeSpringsForceField points='0' stiffness='3'/>", "template='Rigid3' position='0 0 0 0 0 0 1'"),
      "angularStiffness is not given: the default 100 N m is used");
  expectContains(problemsWith("<PlaneForceField normal='0 1 0' d='-1'/>"), "stiffness is not given: the default 500 N/m is used");
}

TEST(GivenStiffness, GridsHaveOneForEachKindOfCell) {
  const auto grid = [](const std::string& n, const std::string& attributes) {
    return problemsWith("<RegularGridSpringForceField " + attributes + "/>",
                        "/><RegularGridTopology n='" + n + "' min='0 0 0' max='1 1 1'");
  };
  const std::string words = "Stiffness is not given: the default 100 N/m is used";
  for (const char* kind : {"lines", "quads", "cubes"}) expectContains(grid("2 2 2", ""), kind + words);
  EXPECT_EQ(grid("2 2 2", "stiffness='3'").find(words), std::string::npos);
  EXPECT_EQ(grid("2 2 2", "linesStiffness='3' quadsStiffness='2' cubesStiffness='1'").find(words), std::string::npos);
  EXPECT_EQ(grid("3 3 1", "linesStiffness='3' quadsStiffness='2'").find(words), std::string::npos) << "it has no cubes";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
