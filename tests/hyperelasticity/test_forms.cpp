// SPDX-License-Identifier: LGPL-2.1-or-later
// The forms of a law against each other: mjed and the textbook's discretisation agree to round-off.
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(HyperelasticForms, MjedIsTheStandardDiscretisation) {
  for (const LawCase& law : lawCases())
    for (double noise : {0.02, 0.05}) {
      SCOPED_TRACE(law.name);
      FieldUnderTest mjed(lawScene(law.attributes), tetrahedral);
      FieldUnderTest standard(lawScene(law.attributes, "StandardTetrahedralFEMForceField"),
                              "StandardTetrahedralFEMForceField");
      mjed.deform(noise), standard.deform(noise);
      const Vector f = mjed.force();
      ASSERT_TRUE(std::isfinite(dot(f, f)));
      ASSERT_GT(dot(f, f), 0);
      const double force = relativeDifference(f, standard.force());
      const double tangent = relativeDifference(mjed.product(mjed.direction), standard.product(mjed.direction));
      EXPECT_LT(force, 1e-12);
      EXPECT_LT(tangent, 1e-12);
      std::printf("%-20s noise %.2f: force %.1e tangent %.1e\n", law.name.c_str(), noise, force, tangent);
      const BlockMatrix a = mjed.matrix(), b = standard.matrix();
      double worst = 0, largest = 0;
      for (std::size_t i = 0; i < a.values().size(); ++i) {
        worst = std::max(worst, std::abs(a.values()[i] - b.values()[i]));
        largest = std::max(largest, std::abs(a.values()[i]));
      }
      EXPECT_LT(worst, 1e-12 * largest);
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
