// SPDX-License-Identifier: LGPL-2.1-or-later
// The unit of every attribute of every component: it is one, it is said, and values are read in others of its dimension.
#include <gtest/gtest.h>

#include <set>

#include "framework/scene/component.h"
#include "framework/scene/modules.h"
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
    const std::string type(entry.type);
    ASSERT_TRUE(modules.provide(type)) << type;
    const auto component = factory.make(type);
    for (Data& data : component->data().all()) visit(type, data), ++count;
  }
  EXPECT_GT(count, 1000);
}

TEST(UnitsOfAttributes, EachDeclaredTextIsAUnit) {
  std::set<std::string> texts;
  forEachAttribute([&texts](const std::string& type, const Data& data) {
    if (data.unitText().empty() || data.unitText().find(" or ") != std::string::npos) return;
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
const std::set<std::string> of_no_one_unit = {"ParameterSet", "oscillators",   "spring",
                                              "PolynomialRestShapeSpringsForceField.smoothShift",
                                              "PolynomialRestShapeSpringsForceField.smoothScale",
                                              "table",        "values", "defaultValue", "transformation", "planes", "proj_mat",
                                              // a file does not say what its numbers are
                                              "tetrahedraValues", "hexahedraValues", "prismsValues", "pyramidsValues",
                                              "quadraticTetrahedraValues",
                                              // lists of engines have the unit of what is linked to them
                                              "in", "out", "global", "inputValues", "value", "outputValues", "input", "output",
                                              "substractor", "indices", "input1", "input2", "input3", "input4", "input5", "input6",
                                              "input7", "input8", "value1", "value2", "value3", "value4", "value5", "value6",
                                              "value7", "value8", "rigidMass", "absolute",
                                              // a force and a torque, a product of two that a response may scale, a length or a number
                                              "wrenches", "pairWrenches", "contactStiffness", "StopperLagrangianConstraint.min",
                                              "StopperLagrangianConstraint.max",
                                              // places and quaternions
                                              "beams", "DOF0TransformNode0", "DOF1TransformNode1", "startingPos"};

TEST(UnitsOfAttributes, EachAttributeOfRealsSaysItsUnit) {
  forEachAttribute([](const std::string& type, const Data& data) {
    if (holdsReals(data)) {
      EXPECT_EQ(data.unitText().empty(),
                of_no_one_unit.count(data.name()) + of_no_one_unit.count(type + "." + data.name()) == 1)
          << type << "." << data.name();
    }
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
    if (data.unitText().find(" or ") != std::string::npos) return;
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

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
