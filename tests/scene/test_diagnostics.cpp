// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/diagnostics.h"

#include <gtest/gtest.h>

namespace stroma {
namespace STROMA_TEST_FILE {

TEST(Nearest, FindsTheNameMeant) {
  const std::vector<std::string> names = {"MechanicalObject", "MeshTopology", "TetrahedronFEMForceField", "UniformMass",
                                          "CGLinearSolver"};
  EXPECT_EQ(nearest("MechanicalObjct", names), "MechanicalObject");
  EXPECT_EQ(nearest("mechanicalobject", names), "MechanicalObject");
  EXPECT_EQ(nearest("UnifromMass", names), "UniformMass");
  EXPECT_EQ(nearest("TetrahedronFEM", names), "TetrahedronFEMForceField");
  EXPECT_EQ(nearest("Sphere", names), "");
  EXPECT_EQ(nearest("index", {"box", "indices", "strict"}), "indices");
  EXPECT_EQ(nearest("", names), "");
  EXPECT_EQ(nearest("x", {}), "");
}

TEST(Nearest, AHugeWordCostsNothing) { EXPECT_EQ(nearest(std::string(50'000'000, 'a'), {"abc", "abcd"}), ""); }

TEST(Problem, ReadsAsOneLine) {
  const Problem problem{Severity::error,        {"a.scn", 3, 7}, "/liver/fem.method", "'lrge' is not a word for it",
                        "one of: small, large", "large"};
  EXPECT_EQ(problem.text(),
            "a.scn:3:7: error: /liver/fem.method: 'lrge' is not a word for it (expected one of: small, large; did you "
            "mean 'large'?)");
  EXPECT_EQ((Problem{Severity::note, {}, {}, "so it is", {}, {}}.text()), "note: so it is");
}

TEST(Diagnostics, CountsAllAndKeepsABoundedNumber) {
  Diagnostics diagnostics;
  diagnostics.warning({}, {}, "a warning");
  EXPECT_FALSE(diagnostics.hasErrors());
  for (int i = 0; i < 100000; ++i) diagnostics.error({}, {}, "an error");
  EXPECT_EQ(diagnostics.errorCount(), 100000);
  EXPECT_LE(diagnostics.problems().size(), 1001u);
  EXPECT_NE(diagnostics.text().find("there are more errors"), std::string::npos);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
