// SPDX-License-Identifier: LGPL-2.1-or-later
// Ogden's law with any number of terms: terms that repeat one, parameters by name and a cell, how many there may be.
#include <fmt/format.h>

#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string ogden(const std::string& values) { return "materialName=\"Ogden\" ParameterSet=\"" + values + "\""; }

/// Two tetrahedra without a common node, the second turned.
std::string twoCells(const std::string& attributes) {
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1  3 0 0 3 1 0 2 0 0 3 0 1\" "
         "tetrahedra=\"0 1 2 3 4 5 6 7\"/><MechanicalObject/><UniformMass totalMass=\"1\"/><" +
         tetrahedral + " materialName=\"Ogden\" " + attributes + "/></Node>";
}

TEST(Ogden, FiveTermsThatRepeatOneAreThatOne) {
  const std::string five = ogden("400 3.5 400 3.5 400 3.5 400 3.5 400 3.5 5000"), one = ogden("2000 3.5 5000");
  for (const std::string more : {"", " discretization=\"standard\"", " projectedTangent=\"true\""}) {
    FieldUnderTest a(lawScene(five + more), tetrahedral), b(lawScene(one + more), tetrahedral);
    a.deform(0.05), b.deform(0.05);
    EXPECT_LT(relativeDifference(a.force(), b.force()), 1e-13) << more;
    EXPECT_LT(relativeDifference(a.product(a.direction), b.product(a.direction)), 1e-13) << more;
    EXPECT_NEAR(a.field().energy(a.x), b.field().energy(b.x), 1e-13 * b.field().energy(b.x)) << more;
  }
}

TEST(Ogden, ByNameAndByPositionIsTheSame) {
  std::string named, positional;
  for (int k = 1; k <= 6; ++k) {
    named += fmt::format("mu{}=\"{}\" alpha{}=\"{}\" ", k, 100 * k, k, 0.7 * k);
    positional += fmt::format("{} {} ", 100 * k, 0.7 * k);
  }
  FieldUnderTest a(twoCells(named + "k0=\"5000\""), tetrahedral);
  FieldUnderTest b(twoCells("ParameterSet=\"" + positional + "5000\""), tetrahedral);
  a.deform(0.1), b.deform(0.1);
  EXPECT_EQ(relativeDifference(a.force(), b.force()), 0);
}

/// Each lane of a batch reads the terms of its own cell.
TEST(Ogden, ACellHasItsOwnTerms) {
  const std::string named =
      "mu1=\"500\" alpha1=\"3\" mu2=\"400\" alpha2=\"2\" mu3=\"300\" alpha3=\"-2\" k0=\"5000\" mu4=\"{}\" "
      "alpha4=\"{}\"";
  const auto forces = [&](const std::string& mu, const std::string& alpha) {
    FieldUnderTest t(twoCells(fmt::format(fmt::runtime(named), mu, alpha)), tetrahedral);
    t.deform(0.1);
    return t.force();
  };
  const Vector both = forces("200 900", "4 -3"), first = forces("200", "4"), second = forces("900", "-3");
  for (Index i = 0; i < 8; ++i) EXPECT_EQ(Vec3(both[i]), Vec3((i < 4 ? first : second)[i])) << i;
  EXPECT_GT(relativeDifference(first, second), 1e-3) << "nothing was tested";
}

TEST(Ogden, AnyOddNumberFromThreeIsTaken) {
  const auto problems = [](const std::string& attributes) { return problemsOf(twoCells(attributes)); };
  std::string values = "5000";
  for (int terms = 1; terms <= 12; ++terms) {
    values = fmt::format("{} {} {}", 100 * terms, 0.5 * terms, values);
    EXPECT_EQ(problems("ParameterSet=\"" + values + "\""), "") << terms;
    const std::string even = problems("ParameterSet=\"" + values + " 1\"");
    for (const std::string word : {fmt::format("has {} values", 2 * terms + 2).c_str(), "3, 5, 7 values and so on",
                                   "mu1 [Pa], alpha1 of each term, then k0 [Pa]"})
      EXPECT_NE(even.find(word), std::string::npos) << even;
  }
  EXPECT_NE(problems("ParameterSet=\"5000\"").find("has 1 values"), std::string::npos);
  EXPECT_NE(problems("ParameterSet=\"100 2 100 2 100 0 100 2 5000\"").find("alpha3 of Ogden is 0"), std::string::npos);
  const std::string gap = problems("mu1=\"1\" alpha1=\"2\" alpha4=\"2\" k0=\"1\"");
  EXPECT_NE(gap.find("Ogden needs mu2, alpha2, mu3, alpha3, mu4"), std::string::npos) << gap;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
