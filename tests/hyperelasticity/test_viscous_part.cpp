// SPDX-License-Identifier: LGPL-2.1-or-later
// viscousPart="deviatoric": the change of shape relaxes as the series says and the volume does not, at points and with
// the mean dilatation; derivatives; laws without such a part.
#include <set>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "tests/hyperelasticity/viscous_bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string deviatoric = prony + " viscousPart=\"deviatoric\"";
const std::string mean = " dilatation=\"mean\"";
/// Laws of J^-2/3 C beside a function of J.
const std::set<std::string> uncoupled{
    "MooneyRivlin", "VerondaWestman", "ArrudaBoyce", "Ogden 1",         "Ogden 2",
    "Ogden 3",      "Ogden 5",        "Yeoh",        "FungOrthotropic", "TransverselyIsotropicMooneyRivlin"};

/// Under a shape that is held, the stress is that of the volume, k0 ln J / J in all directions, and G(t)/G_0 of the rest.
TEST(ViscousPart, TheShapeRelaxesAndTheVolumeStays) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  const double j = f.determinant(), k0 = 5000, h = 0.01;
  const Mat3 volume = k0 * std::log(j) * f.inverse().transpose();
  for (const LawCase& law : lawCases()) {
    if (!uncoupled.count(law.name)) continue;
    for (const auto& [cube, more] : {std::pair(false, std::string()), {true, ""}, {true, mean}}) {
      SCOPED_TRACE(law.name + (cube ? " hexahedra" : "") + more);
      Driven body(law.attributes + deviatoric + update("exponential") + more, cube);
      Driven elastic(law.attributes + more, cube);
      const Mat3 whole = elastic.step(0, f);
      EXPECT_GT((whole - volume).norm(), 0.05 * whole.norm()) << "nothing relaxes";
      body.startAt(f);
      for (int n = 1; n <= 60; ++n) {
        const Mat3 expected = volume + modulus(n * h) / g0 * (whole - volume);
        ASSERT_LT((body.step(n * h, f) - expected).norm(), 1e-10 * whole.norm()) << n;
      }
    }
  }
}

/// A pressure alone does not relax; with viscousPart="all" it does.
TEST(ViscousPart, ADilationIsElastic) {
  const std::string law = "materialName=\"MooneyRivlin\" ParameterSet=\"300 200 5000\"";
  const Mat3 f = 1.1 * Mat3::Identity();
  for (const std::string& word : updates) {
    Driven shape(law + deviatoric + update(word), true), all(law + prony + update(word), true);
    shape.startAt(f), all.startAt(f);
    const double pressure = 5000 * std::log(1.331) / 1.1;
    for (int n = 1; n <= 50; ++n) {
      EXPECT_NEAR(shape.step(0.02 * n, f)(0, 0), pressure, 1e-9 * pressure);
      EXPECT_LT(all.step(0.02 * n, f)(0, 0), 0.95 * pressure) << n;
    }
  }
}

TEST(ViscousPart, TangentIsTheForcesDerivative) {
  for (const LawCase& law : lawCases()) {
    if (!uncoupled.count(law.name)) continue;
    for (const std::string more : {"", " projectedTangent=\"true\"", "mean"})
      for (const bool cubes : {false, true}) {
        const bool averaged = more == "mean";
        if (averaged && !cubes) continue;
        SCOPED_TRACE(law.name + more + (cubes ? " hexahedra" : ""));
        const std::string attributes = law.attributes + deviatoric + update("exponential") + (averaged ? mean : more);
        FieldUnderTest t(cubes ? block(attributes) : lawScene(attributes), typeOf(cubes));
        giveHistory(t);
        const Vector f = t.force();
        expectConsistentDerivatives(t, f);
      }
  }
}

TEST(ViscousPart, LawsWithoutSuchAPartAreRefused) {
  for (const LawCase& law : lawCases()) {
    const std::string problems = problemsOf(oneCell(law.attributes + deviatoric));
    if (uncoupled.count(law.name))
      EXPECT_EQ(problems, "") << law.name;
    else
      expectContains(problems, "has no such part beside that of the volume");
  }
  const std::string all = "materialName=\"MooneyRivlin\" ParameterSet=\"300 200 5000\"" + mean + prony;
  expectContains(problemsOf(oneCell(all, true)), "viscousPart=\"deviatoric\"");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
