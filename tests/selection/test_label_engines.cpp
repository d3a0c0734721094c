// SPDX-License-Identifier: LGPL-2.1-or-later
// Labels of nodes and cells, groups with moduli, and points joined, projected and shared out.
#include <gtest/gtest.h>

#include "tests/selection/engine_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Wholes = std::vector<int>;

TEST(LabelEngines, ListsInBrackets) {
  EXPECT_EQ(made<std::string>(engine("<MergeROIs name='e' nbROIs='3' indices1='4 7' indices3='2'/>"), "roiIndices"), "[4,7] [] [2]");
  EXPECT_EQ(made<Wholes>(engine("<SelectLabelROI name='e' labels='[1 2],[3] [-4] [] [2]' selectLabels='2 -4'/>"), "indices"),
            (Wholes{0, 2, 4}));
  EXPECT_EQ(made<Wholes>(engine("<SelectConnectedLabelsROI name='e' nbLabels='3' labels1='[1] [1] []' labels2='[2] [3] [2]' "
                                "labels3='[] [2] [1]' connectLabels='2 1'/>"),
                         "indices"),
            (Wholes{0, 1, 2}));
  for (const char* wrong : {"1 2", "[1", "[1] 2", "[a]", "[[1]]"})
    expectContains(problemsOf("<Node name='root'><SelectLabelROI labels='" + std::string(wrong) + "'/></Node>"), "in brackets");
  expectContains(problemsOf("<Node name='root'><SelectConnectedLabelsROI nbLabels='2' labels1='[1]' labels2='[1] [2]'/></Node>"),
                 "labels2 has 2 lists, and labels1 has 1");
  expectContains(problemsOf("<Node name='root'><SelectConnectedLabelsROI labels1='[1]' labels2='[1]' connectLabels='1 2 3'/></Node>"),
                 "connectLabels has 3 numbers");
}

TEST(LabelEngines, ModuliOfGroups) {
  const auto moduli = [](const std::string& attributes) {
    return made<std::vector<double>>(engine("<GroupFilterYoungModulus name='e' " + attributes + "/>"), "youngModulus");
  };
  EXPECT_EQ(moduli("groups='5 3 5' mapGroupModulus='3 20; 5 10;' defaultYoungModulus='7'"), (std::vector<double>{10, 20, 10}));
  EXPECT_EQ(moduli("groups='5 3 5' mapGroupModulus='3 20;' defaultYoungModulus='7'"), (std::vector<double>{7, 20, 7}));
  EXPECT_EQ(moduli("groups='5 3 5 4' groupModulus='1 2'"), (std::vector<double>{1, 2, 1, 10000}));
  const auto said = [](const std::string& attributes) {
    return engine("<GroupFilterYoungModulus name='e' " + attributes + "/>").diagnostics.text();
  };
  expectContains(said("groups='5 3' mapGroupModulus='3 20;'"), "groups without a modulus, as 5, have 10000 Pa");
  EXPECT_EQ(said("groups='5 3' mapGroupModulus='3 20; 5 10000;'").find("without a modulus"), std::string::npos);
  expectContains(said("groups='5 3' groupModulus='1 2 3'"), "3 values for 2 groups");
  expectContains(said("elementsGroup='5 3' groupModulus='1 2'"), "with groups alone");
  for (const char* wrong : {"3;", "3 -1;", "a 1;", "3 20"})
    expectContains(
        problemsOf("<Node name='root'><GroupFilterYoungModulus groups='3' mapGroupModulus='" + std::string(wrong) + "'/></Node>"),
        "semicolon");
}

/// In the order of the points: the first takes the nearest one that is near enough, again from where it is then.
TEST(SplittingEngines, PointsNearEachOtherAreOne) {
  const auto points = made<std::vector<Vec3>>(
      engine("<JoinPoints name='e' points='0 0 0  0.3 0 0  0.5 0 0  2 0 0  0.9 0 0' distance='0.45'/>"), "mergedPoints");
  ASSERT_EQ(points.size(), 3u);  // 0 and 0.3 at 0.15, with 0.5 at 0.8/3; 0.9 is farther from there
  EXPECT_NEAR(points[0].x(), 0.8 / 3, 1e-15);
  EXPECT_EQ(points[1].x(), 2);
  EXPECT_EQ(points[2].x(), 0.9);
  for (const char* point : {"0 0 0", "1 0 1e-17"})  // the second by round-off
    expectContains(problemsOf(fmt::format("<Node name='root'><ProjectiveTransformEngine input_position='{}' "
                                          "proj_mat='1 0 0 0 0 1 0 0 0 0 1 0'/></Node>", point)),
                   "it has no picture");
}

/// Of two lists with the same node the first has it.
TEST(SplittingEngines, NodesAreSharedOut) {
  const Scene scene = engine("<MeshSplittingEngine name='e' position='0 0 0  1 0 0  2 0 0  3 0 0' edges='0 1  2 3' nbInputs='2' "
                             "indices1='3' edgeIndices2='1'/>");
  EXPECT_EQ(made<Wholes>(scene, "indexPairs"), (Wholes{2, 0, 2, 1, 1, 0, 0, 0}));
  EXPECT_EQ(made<std::vector<Vec3>>(scene, "position2"), (std::vector<Vec3>{{2, 0, 0}}));
  expectContains(problemsOf("<Node name='root'><MeshSplittingEngine position='0 0 0' nbInputs='1' quadIndices1='0'/></Node>"),
                 "quadIndices1 names 0, and there are 0");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
