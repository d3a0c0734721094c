// SPDX-License-Identifier: LGPL-2.1-or-later
// What a scene may ask of a law together: moduli that agree, tangents that differ, names of SOFA's plugin; the manual's
// table of laws; what a report says of an element without volume.
#include <fmt/format.h>

#include <fstream>
#include <limits>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string oneCell(const std::string& attributes, const std::string& position = "0 0 0 1 0 0 0 1 0 0 0 1") {
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<TetrahedronSetTopologyContainer position=\"" +
         position + "\" tetrahedra=\"0 1 2 3\"/><MechanicalObject/><UniformMass totalMass=\"1\"/><" + tetrahedral +
         " " + attributes + "/></Node>";
}
void expectRefused(const std::string& attributes, const std::vector<std::string>& words) {
  const std::string problems = problemsOf(oneCell(attributes));
  for (const std::string& word : words)
    EXPECT_NE(problems.find(word), std::string::npos) << attributes << ": " << problems;
}
std::string withHooke(const std::string& law, const std::string& more) {
  return "materialName=\"" + law + "\" youngModulus=\"10000\" poissonRatio=\"0.25\" " + more;
}

// E = 10000, nu = 0.25: mu = lambda = 4000, K = 6666.67
TEST(HyperelasticAttributes, ModuliThatContradictEachOtherAreRefused) {
  const std::string fibres = " k1=\"5000\" k2=\"2\" AnisotropyDirections=\"1 0 0\"";
  const std::vector<std::pair<std::string, std::string>> refused{{"NeoHookean", "mu=\"10\""},
                                                                 {"NeoHookean", "mu=\"4008\""},
                                                                 {"NeoHookean", "lambda=\"4500\""},
                                                                 {"StVenantKirchhoff", "mu=\"10\""},
                                                                 {"StableNeoHookean", "lambda=\"1\""},
                                                                 {"MooneyRivlin", "c1=\"10\" c2=\"5\""},
                                                                 {"MooneyRivlin", "c1=\"1500\" k0=\"9000\""},
                                                                 {"VerondaWestman", "c1=\"10\" c2=\"5\""},
                                                                 {"VerondaWestman", "c2=\"5\" k0=\"1000\""},
                                                                 {"ArrudaBoyce", "mu=\"4000\""},
                                                                 {"ArrudaBoyce", "k0=\"4000\""},
                                                                 {"Ogden", "mu1=\"4000\" alpha1=\"3\""},
                                                                 {"Yeoh", "c1=\"1000\" c2=\"5\""},
                                                                 {"Yeoh", "c2=\"5\" k0=\"4000\""},
                                                                 {"Hencky", "lambda=\"4500\""},
                                                                 {"OgdenUnconstrained", "m1=\"3\" cp=\"6666\""},
                                                                 {"TransverselyIsotropic", "mu=\"10\"" + fibres},
                                                                 {"TransverselyIsotropic", "lambda=\"10\"" + fibres}};
  for (const auto& [law, more] : refused)
    expectRefused(withHooke(law, more), {"a shear modulus of 4000 Pa and a bulk modulus of 6666.67 Pa", "of " + law});
  const std::vector<std::pair<std::string, std::string>> accepted{{"NeoHookean", "mu=\"4000\""},
                                                                  {"NeoHookean", "lambda=\"4001\""},
                                                                  {"MooneyRivlin", "c1=\"1500\" c2=\"500\""},
                                                                  {"MooneyRivlin", "c1=\"1500\" k0=\"6667\""},
                                                                  {"VerondaWestman", "c1=\"2000\" c2=\"2\""},
                                                                  {"ArrudaBoyce", "mu=\"3686.2\""},  // 4000/1.085137
                                                                  {"Ogden", "mu1=\"8000\" alpha1=\"3\""},
                                                                  {"Yeoh", "c1=\"2000\" c2=\"-5\" c3=\"1\""},
                                                                  {"Hencky", "mu=\"4000\""},
                                                                  {"OgdenUnconstrained", "m1=\"3\" cp=\"4000\""},
                                                                  {"TransverselyIsotropic", fibres},
                                                                  {"TransverselyIsotropic", "mu=\"4000\"" + fibres}};
  for (const auto& [law, more] : accepted) EXPECT_EQ(problemsOf(oneCell(withHooke(law, more))), "") << law << more;
  for (const std::string given : {"c1", "c2"})
    expectRefused(withHooke("MooneyRivlin", given + "=\"2500\""),
                  {given + " = 2500 of MooneyRivlin is above mu/2 = 2000", "would be negative"});
}

TEST(HyperelasticAttributes, ParametersWithoutMeaningTogetherAreRefused) {
  const auto law = [](const std::string& name, const std::string& values) {
    return "materialName=\"" + name + "\" AnisotropyDirections=\"1 0 0  0 1 0\" ParameterSet=\"" + values + "\"";
  };
  expectRefused(law("FungOrthotropic", "5000 3000 2000 1000 700 900 1.3 0.35 0.1 2000 5000"),
                {"v12 = 1.3, v23 = 0.35 and v31 = 0.1", "not positive definite"});
  const auto ligament = [](const std::string& values) {
    return "materialName=\"TransverselyIsotropicMooneyRivlin\" AnisotropyDirections=\"1 0 0\" ParameterSet=\"" +
           values + "\"";
  };
  expectRefused(ligament("300 200 150 12 2500 0.9 5000"), {"lam_max = 0.9", "below 1"});
  expectRefused(ligament("300 200 150 800 2500 1.1 5000"), {"c4 = 800 and lam_max = 1.1"});
  expectRefused(ligament("300 -300 150 12 2500 1.1 5000"), {"c1 + c2", "not above 0"});
  expectRefused("materialName=\"OgdenUnconstrained\" ParameterSet=\"1500 0 100\"", {"m1 of OgdenUnconstrained is 0"});
  expectRefused("materialName=\"OgdenUnconstrained\" ParameterSet=\"1500 3 -600\"", {"no bulk modulus cp + 2/3 mu"});
  expectRefused("materialName=\"Yeoh\" ParameterSet=\"1 2 3 4 5 6 7 5000\"", {"ParameterSet of Yeoh has 8 values"});
  expectRefused("materialName=\"Yeoh\" ParameterSet=\"-1 5000\"", {"c1 of Yeoh is -1"});
}

/// A name that several laws have, with another meaning and unit in each.
/// c2 is a pressure or a pure number, as the law has it.
TEST(HyperelasticAttributes, ALawDecidesTheUnitOfAParameter) {
  const auto energyWith = [](const std::string& parameters) {
    Simulation s = simulationFromText(oneCell(parameters));
    s.systems()[0]->x[1] = Vec3(1.3, 0.1, 0);
    return s.systems()[0]->potentialEnergy(s.systems()[0]->x);
  };
  const std::string moduli = " c1=\"3 kPa\" k0=\"1 MPa\" c2=", mooney = "materialName=\"MooneyRivlin\"" + moduli;
  const std::string veronda = "materialName=\"VerondaWestman\"" + moduli;
  EXPECT_EQ(energyWith(mooney + "\"2 kPa\""), energyWith(mooney + "\"2000\""));
  EXPECT_EQ(energyWith(mooney + "\"1/2 kPa\""), energyWith(mooney + "\"500\""));
  EXPECT_EQ(energyWith(veronda + "\"1/2\""), energyWith(veronda + "\"0.5\""));
  expectRefused(veronda + "\"2 kPa\"", {"c2 of VerondaWestman is a pure number", "numbers without unit"});
  expectRefused(mooney + "\"2 mm\"", {"'mm' is the unit of a length", "a pressure"});
}

TEST(HyperelasticAttributes, AParameterSaysWhatItMeansToEachLaw) {
  FieldUnderTest t(oneCell("materialName=\"NeoHookean\" ParameterSet=\"1000 4000\""), tetrahedral);
  const std::string help = t.field().data().find("c4")->helpText();
  EXPECT_NE(help.find("[Pa] (OgdenUnconstrained"), std::string::npos) << help;
  EXPECT_NE(help.find("exponent of fibres that straighten [-] (TransverselyIsotropicMooneyRivlin)"), std::string::npos)
      << help;
  EXPECT_EQ(t.field().data().find("c3")->unitText(), "Pa");
  EXPECT_EQ(t.field().data().find("c4")->unitText(), "Pa or -");
}

TEST(HyperelasticAttributes, RegularisationNeedsALawWithJ) {
  for (const LawCase& law : lawCases()) {
    const std::string attributes = law.attributes + " matrixRegularization=\"true\"";
    if (law.name == "StVenantKirchhoff")
      expectRefused(attributes, {"matrixRegularization acts on d2W/dJ2", "has no J", "projectedTangent"});
    else
      EXPECT_EQ(problemsOf(oneCell(attributes)), "") << law.name;
  }
}

TEST(HyperelasticAttributes, NamesOfThePluginAreExplained) {
  const std::string law = "materialName=\"NeoHookean\" ParameterSet=\"1000 4000\" ";
  EXPECT_EQ(problemsOf(oneCell(law + "considerInversion=\"false\"")), "");
  expectRefused(law + "considerInversion=\"true\"", {"considerInversion", "StableNeoHookean"});
  expectRefused(law + "ParameterFile=\"some.param\"", {"some.param", "ParameterSet"});
  expectRefused("materialName=\"NeoHookeanIsotropic\" ParameterSet=\"1000 4000\"",
                {"no law 'NeoHookeanIsotropic'", "MooneyRivlin, c1 = mu/2"});
}

/// A line for each law, with its parameters in the order of ParameterSet; the next is its energy.
TEST(HyperelasticAttributes, TheManualHasATableOfLaws) {
  std::ifstream page(STROMA_SOURCE_DIR "/components/hyperelasticity/tetrahedron_hyperelasticity_fem_force_field.cpp");
  ASSERT_TRUE(page);
  std::vector<std::string> lines;
  for (std::string line; std::getline(page, line);) lines.push_back(line);
  for (const hyperelastic::HyperelasticLaw& law : hyperelastic::hyperelasticLaws()) {
    std::string names;
    for (const auto& p : law.parameters) names += (names.empty() ? "" : " ") + p.name;
    std::string line = fmt::format("//   {:34}{}", law.name, names);
    if (law.with_terms) line += ", or ";
    const auto row = std::find_if(lines.begin(), lines.end(), [&](const auto& l) { return l.rfind(line, 0) == 0; });
    ASSERT_NE(row, lines.end()) << line;
    EXPECT_EQ(row[1].rfind("//                          ", 0), 0u) << row[1];
  }
}

/// A report names an element without volume as long as that is why the last force was not finite.
TEST(HyperelasticAttributes, AFaultIsForgotten) {
  FieldUnderTest t(oneCell("materialName=\"NeoHookean\" ParameterSet=\"1000 4000\""), tetrahedral);
  const auto blamed = [&](ConstRows x) { return t.field().worstElement(x).find("had J = ") != std::string::npos; };
  const auto turnOver = [&] {
    t.rest();
    t.x[3] = Vec3(0, 0, -0.5);
    t.force();
  };
  turnOver();
  EXPECT_TRUE(blamed(t.x));
  t.rest();
  t.force();
  EXPECT_FALSE(blamed(t.x)) << "a trial that was given up";

  // what another component made NaN
  const double nan = std::numeric_limits<double>::quiet_NaN();
  turnOver();
  t.rest();
  Vector f(t.x.count());
  f[0] = Vec3(nan, nan, nan);
  t.field().addForce(t.x, t.v_zero, f);
  EXPECT_FALSE(blamed(t.x));
  Vector bad(t.x.count());
  copy(t.x, bad);
  bad[0] = Vec3(nan, nan, nan);
  t.forceAt(bad);
  EXPECT_FALSE(blamed(bad));

  // positions that a flat element made NaN
  turnOver();
  t.forceAt(bad);
  EXPECT_TRUE(blamed(bad));
}

/// At rest and turned the tangent is that of fibres that are stretched by a little, whatever the round-off of
/// positions: crimped ones, and ones that are straight from the start.
class FibresAtRest : public testing::TestWithParam<std::string> {};
TEST_P(FibresAtRest, HaveOneTangent) {
  const std::string law = GetParam() + " AnisotropyDirections=\"1 2 1\"";
  FieldUnderTest t(lawScene(law), tetrahedral);
  const Vec3 fibre = Vec3(1, 2, 1).normalized();
  const Vector direction = t.product(t.direction);
  const auto tangentAt = [&](const Mat3& f) {
    t.rest();
    Vector turned(t.x.count()), back(t.x.count());
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]), turned[i] = f * Vec3(t.direction[i]);
    const Vector product = t.product(turned);
    for (Index i = 0; i < t.x.count(); ++i) back[i] = f.inverse() * Vec3(product[i]);
    return back;
  };
  const Vector stretched = tangentAt(Mat3::Identity() + 1e-7 * fibre * fibre.transpose());
  const Vector pressed = tangentAt(Mat3::Identity() - 1e-7 * fibre * fibre.transpose());
  EXPECT_GT(relativeDifference(stretched, pressed), 0.01) << "fibres resist stretch alone";
  EXPECT_LT(relativeDifference(direction, stretched), 1e-5);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 10; ++k) {
    const Vec3 axis(uniform(random), uniform(random), uniform(random));
    const Mat3 turn = Eigen::AngleAxisd(3 * uniform(random), axis.normalized()).toRotationMatrix();
    EXPECT_LT(relativeDifference(tangentAt(turn), stretched), 1e-5);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Laws, FibresAtRest,
    testing::Values("materialName=\"TransverselyIsotropic\" ParameterSet=\"1000 4000 3000 1.5\"",
                    "materialName=\"TransverselyIsotropicMooneyRivlin\" ParameterSet=\"300 200 150 12 2500 1.06 5000\"",
                    "materialName=\"TransverselyIsotropicMooneyRivlin\" ParameterSet=\"300 200 150 12 2500 1 5000\""));

TEST(HyperelasticAttributes, ParametersOfAnotherOrderOrAnotherBookAreWarnedOf) {
  const auto said = [](const std::string& law) {
    return simulationFromText(oneCell("materialName=\"" + law)).scene().diagnostics.text();
  };
  // c1 + c2 = 1.00001e9: G = 2.00002e9, K = 1e5: nu = (3 K - 2 G)/(2 (3 K + G)) = -0.9998
  expectContains(said("MooneyRivlin\" ParameterSet=\"1e9 1e4 1e5\""), "a Poisson's ratio of -1");
  EXPECT_EQ(said("MooneyRivlin\" ParameterSet=\"1e4 1e5 1e9\"").find("a Poisson's ratio of"), std::string::npos);
  EXPECT_EQ(said("NeoHookean\" ParameterSet=\"1000 0\"").find("a Poisson's ratio of"), std::string::npos) << "nu = 0";
  const std::string negative = said("Ogden\" ParameterSet=\"1.2e4 2.5 -2e3 -3 1e5\"");
  expectContains(negative, "mu2 = -2000 of Ogden is negative");
  expectContains(negative, "The energy here has mu2/alpha2^2");
  EXPECT_EQ(said("Ogden\" ParameterSet=\"1.2e4 2.5 2e3 -3 1e5\"").find("negative"), std::string::npos);
  expectRefused("materialName=\"Ogden\" ParameterSet=\"1e5 2 -3e5 -2 1e7\"", {"the products mu_k alpha_k"});
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
