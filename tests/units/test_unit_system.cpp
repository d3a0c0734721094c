// SPDX-License-Identifier: LGPL-2.1-or-later
// In which units the numbers of a scene are, and what a unit of SI is called there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "framework/scene/modules.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

/// A bar of tissue of 120 x 40 x 30 mm, 10 kPa and the density of water, in the numbers of a system.
std::string bar(const std::string& units, double millimetre, double kilopascal, double water, double earth) {
  return fmt::format(
      R"(<Node name="root" {} dt="0.01" gravity="0 {} 0"><Node name="bar"><EulerImplicitSolver/><SparseLDLSolver/>
  <RegularGridTopology n="5 3 3" min="0 0 0" max="{} {} {}"/><MechanicalObject name="dofs"/>
  <DiagonalMass massDensity="{}"/><HexahedronFEMForceField youngModulus="{}" poissonRatio="0.3"/></Node></Node>)",
      units, -9810 * earth, 120 * millimetre, 40 * millimetre, 30 * millimetre, water, 10 * kilopascal);
}

UnitSystem unitsIn(const std::string& xml) {
  Factory factory;
  Modules modules(factory);
  return unitsOf(loadSceneText(xml, "bar.xml", {}, factory, modules));
}

TEST(UnitSystem, IsFoundWhereTheNumbersAreThoseOfThings) {
  EXPECT_EQ(unitsIn(bar("", 1e-3, 1e3, 1000, 1e-3)).name, "m, kg, s");
  EXPECT_EQ(unitsIn(bar("", 1, 1, 1e-6, 1)).name, "mm, kg, s");
  EXPECT_EQ(unitsIn(bar("", 1, 1e-3, 1e-9, 1)).name, "mm, t, s");
  EXPECT_EQ(unitsIn(bar("", 1, 1e12, 1e-6, 1)).name, "") << "harder than anything: no system fits";
}

/// The body of many scenes of SOFA: 6 wide, a mass of 1, Young's modulus 3000, gravity 9.81. It would be foam in centimetres where
/// nearly nothing has weight, and so would one without gravity; nobody named such units.
TEST(UnitSystem, NumbersOfNoSystemHaveNoUnits) {
  const auto block = [](const char* gravity, const char* mass, const char* modulus) {
    return fmt::format(
        R"(<Node name="root" gravity="0 {} 0"><EulerImplicitSolver/><SparseLDLSolver/><RegularGridTopology n="5 3 3" min="0 0 0"
  max="6 3 3"/><MechanicalObject/><UniformMass totalMass="{}"/><HexahedronFEMForceField youngModulus="{}" poissonRatio="0.3"/></Node>)",
        gravity, mass, modulus);
  };
  EXPECT_EQ(unitsIn(block("-9.81", "1", "3000")).name, "");
  EXPECT_EQ(unitsIn(block("0", "54", "3000")).name, "");
  EXPECT_EQ(unitsIn(block("-981", "54", "30000")).name, "cm, g, s");
}

/// Without a mass size and stiffness alone speak: 8 mm and 500 kPa could be 8 m and 500 Pa, if nothing had weight.
TEST(UnitSystem, ABodyWithoutAMassIsNotTakenForOneThatItsWeightWouldCrush) {
  const auto sample = [](const char* size, const char* modulus) {
    return fmt::format(
        R"(<Node name="root" gravity="0 0 0"><StaticSolver/><RegularGridTopology n="3 3 3" min="0 0 0" max="{}"/>
  <MechanicalObject/><HexahedronFEMForceField youngModulus="{}" poissonRatio="0.3"/></Node>)",
        size, modulus);
  };
  EXPECT_EQ(unitsIn(sample("8 8 8", "500")).name, "") << "kPa, MPa or Pa: nobody knows";
  EXPECT_EQ(unitsIn(sample("0.08 0.08 0.08", "5000")).name, "m, kg, s");
}

TEST(UnitSystem, IsWhatTheSceneDeclares) {
  EXPECT_EQ(unitsIn(bar("units=\"mm t s\"", 1, 1e-3, 1e-9, 1)).name, "mm, t, s");
  EXPECT_EQ(unitsIn(bar("units=\"mm kPa s\"", 1, 1, 1e-6, 1)).name, "mm, kg, s");
  EXPECT_EQ(unitsIn(bar("units=\"mm, MPa, s\"", 1, 1e-3, 1e-9, 1)).name, "mm, t, s");
  EXPECT_EQ(unitsIn(bar("units=\"mm N s\"", 1, 1e-3, 1e-9, 1)).name, "mm, t, s");
}

TEST(UnitSystem, IsRefusedWhereItIsNone) {
  for (const char* wrong : {"mm", "mm t", "mm cm s", "mm kpa s", "mm t s s", "mm K s"})
    EXPECT_THROW(unitsIn(bar(std::string("units=\"") + wrong + "\"", 1, 1, 1e-6, 1)), SceneError) << wrong;
  std::string mixed = bar("units=\"mm kPa s\"", 1, 1, 1e-6, 1);
  mixed.replace(mixed.find("dt=\"0.01\""), 9, "dt=\"10 ms\"");
  EXPECT_THROW(unitsIn(mixed), SceneError) << "a value with a unit is SI among numbers that are not";
}

TEST(UnitSystem, NamesUnitsOfSIInIt) {
  const UnitSystem si = readUnitSystem("m kg s"), mm_kg = readUnitSystem("mm kPa s"), mm_t = readUnitSystem("mm t s"),
                   cm = readUnitSystem("cm g s");
  EXPECT_EQ(si.unit("N s/m"), "N s/m");
  for (const auto& [unit, in_mm_kg, in_mm_t] : std::vector<std::array<const char*, 3>>{{"m", "mm", "mm"},
                                                                                       {"Pa", "kPa", "MPa"},
                                                                                       {"N", "mN", "N"},
                                                                                       {"J", "uJ", "mJ"},
                                                                                       {"m/s^2", "mm/s^2", "mm/s^2"},
                                                                                       {"kg/m^3", "kg/mm^3", "t/mm^3"},
                                                                                       {"N/m", "mN/mm", "N/mm"},
                                                                                       {"s", "s", "s"},
                                                                                       {"-", "", ""}}) {
    EXPECT_EQ(mm_kg.unit(unit), in_mm_kg) << unit;
    EXPECT_EQ(mm_t.unit(unit), in_mm_t) << unit;
  }
  EXPECT_EQ(cm.unit("N"), "dyn");
  EXPECT_EQ(cm.unit("Pa"), "g/(cm s^2)");
  EXPECT_EQ(UnitSystem().unit("Pa"), "") << "unknown";
  EXPECT_EQ(mm_kg.inBrackets("Pa"), " [kPa]");
}

TEST(UnitSystem, NamesUnitsOfSentencesInIt) {
  const UnitSystem mm = readUnitSystem("mm kPa s");
  EXPECT_EQ(mm.sentence("attached nodes lie up to 0.3 m apart, 2 moved"),
            "attached nodes lie up to 0.3 mm apart, 2 moved");
  EXPECT_EQ(mm.sentence("pull with (0 0 -1) N, together 1 N, and a torque of 2e+03 N m: 5 Pa/s"),
            "pull with (0 0 -1) mN, together 1 mN, and a torque of 2e+03 mN mm: 5 kPa/s");
  EXPECT_EQ(mm.sentence("3 nodes, 4 Newton iterations, step 5 makes 6 more"),
            "3 nodes, 4 Newton iterations, step 5 makes 6 more");
  EXPECT_EQ(readUnitSystem("m kg s").sentence("0.3 m"), "0.3 m");
  EXPECT_TRUE(readUnitSystem("SI").isSI());
  // numbers of a scene whose units nobody knows have none
  EXPECT_EQ(UnitSystem().sentence("pull with (0 0 -1) N, together 1 N m: dt = 0.3 s is 4 kg/m^3 off"),
            "pull with (0 0 -1), together 1: dt = 0.3 is 4 off");
  EXPECT_EQ(UnitSystem().sentence("3 nodes, step 5 makes 6 more"), "3 nodes, step 5 makes 6 more");
}

}  // namespace
}  // namespace stroma
