// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames made of their parts and taken apart, sums, lengths, means, and surfaces moved along their normals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/selection/engine_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(FrameEngines, FramesAreAsManyAsBothListsHave) {
  const Scene scene = engine("<QuatToRigidEngine name='e' positions='1 2 3  4 5 6  7 8 9' orientations='0 0 0 1  0 0 0.6 0.8'/>");
  const std::vector<double> expected = {1, 2, 3, 0, 0, 0, 1, 4, 5, 6, 0, 0, 0.6, 0.8};
  EXPECT_EQ(made<std::vector<double>>(scene, "rigids"), expected);
  expectContains(problemsOf("<Node name='root'><QuatToRigidEngine positions='0 0 0' orientations='0 0 1'/></Node>"),
                 "four numbers for each orientation");
}

/// q = q_z q_y q_x of the angles.
TEST(FrameEngines, FramesComeApartAgain) {
  const Vec3 angles(20, -35, 110);
  const Vec3 half = angles * 3.14159265358979323846 / 360;
  const Eigen::Quaterniond q(Eigen::AngleAxisd(2 * half.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(2 * half.y(), Vec3::UnitY()) *
                             Eigen::AngleAxisd(2 * half.x(), Vec3::UnitX()));
  const Scene scene =
      engine(fmt::format("<RigidToQuatEngine name='e' rigids='1 2 3 {:.17g} {:.17g} {:.17g} {:.17g}'/>", q.x(), q.y(), q.z(), q.w()));
  EXPECT_EQ(made<std::vector<Vec3>>(scene, "positions").at(0), Vec3(1, 2, 3));
  EXPECT_EQ(made<std::vector<double>>(scene, "orientations").at(3), q.w());
  EXPECT_LT((made<std::vector<Vec3>>(scene, "orientationsEuler").at(0) - 2 * half).norm(), 1e-12);
}

TEST(FrameEngines, SumsLengthsAndMeans) {
  const Scene sum = engine("<SumEngine name='e' input='1 2 3  10 20 30'/>");
  EXPECT_EQ(made<std::vector<double>>(sum, "output"), (std::vector<double>{11, 22, 33}));
  EXPECT_EQ(made<std::vector<int>>(engine("<SumEngine name='e' template='int' input='1 2 3'/>"), "output"), std::vector<int>{6});
  const std::vector<double> expected[] = {{4, 12}, {7, 17}, {5, 13}};
  for (int kind = 0; kind < 3; ++kind)
    EXPECT_EQ(made<std::vector<double>>(engine(fmt::format("<NormEngine name='e' input='3 -4 0  0 12 5' normType='{}'/>", kind)), "output"),
              expected[kind]);
  const std::string mean = "<AverageCoord name='e' vertices='0 0 0  1 0 0  0 3 0' indices='{}'/>";
  EXPECT_EQ(made<std::vector<Vec3>>(engine(fmt::format(fmt::runtime(mean), "1 2")), "average").at(0), Vec3(0.5, 1.5, 0));
  EXPECT_LT((made<std::vector<Vec3>>(engine("<AverageCoord name='e' vertices='0 0 0  1 0 0  0 3 0'/>"), "average").at(0) -
             Vec3(1 / 3., 1, 0)).norm(), 1e-15);
  expectContains(problemsOf("<Node name='root'>" + fmt::format(fmt::runtime(mean), "3") + "</Node>"), "indices names 3");
}

/// The corners of a cube of quads move along its diagonals.
TEST(FrameEngines, ASurfaceMovesOutwards) {
  const Scene scene = engine("<DilateEngine name='e' input_position='@cube.position' quads='@cube.quads' distance='0.3'/>",
                             "<CubeTopology name='cube' nx='2' ny='2' nz='2' min='-1 -1 -1' max='1 1 1'/>");
  const auto moved = made<std::vector<Vec3>>(scene, "output_position"), start = made<std::vector<Vec3>>(scene, "input_position");
  ASSERT_EQ(moved.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_LT((moved[i] - (1 + 0.3 / std::sqrt(3)) * start[i]).norm(), 1e-14);
  const Scene inwards = engine("<NormalsFromPoints name='e' position='@cube.position' quads='@cube.quads' invertNormals='true'/>",
                               "<CubeTopology name='cube' nx='2' ny='2' nz='2' min='-1 -1 -1' max='1 1 1'/>");
  const auto normals = made<std::vector<Vec3>>(inwards, "normals");
  for (std::size_t i = 0; i < 8; ++i) EXPECT_LT((normals[i] + start[i] / std::sqrt(3)).norm(), 1e-15);
  expectContains(problemsOf("<Node name='root'><DilateEngine input_position='0 0 0  1 0 0'/></Node>"), "there is no surface");
  expectContains(problemsOf("<Node name='root'><TransformPosition method='translation' input_position='0 0 0  1 0 0' "
                            "fixedIndices='1 2'/></Node>"),
                 "fixedIndices names point 2 of 2");
  expectContains(engine("<DilateEngine name='e' input_position='0 0 0  1 0 0  0 1 0  5 5 5' triangles='0 1 2'/>").diagnostics.text(),
                 "1 of 4 nodes lie on no cell");
}

/// Three frames have as many numbers as seven points, which are others.
TEST(FrameEngines, TakeNoFrameApart) {
  const std::string frames = "<MechanicalObject name='f' template='Rigid3' position='0 0 0 0 0 0 1  10 0 0 0 0 0 1  20 0 0 0 0 0 1'/>";
  const auto told = [&frames](const std::string& text) { return problemsOf("<Node name='root'>" + frames + text + "</Node>"); };
  const std::string expected = "the value of position (list of 7 reals) does not fit ";
  expectContains(told("<AverageCoord vertices='@f.position'/>"), expected + "vertices");
  expectContains(told("<SumEngine template='Vec3' input='@f.position'/>"), expected + "input");
  expectContains(told("<MeshTopology position='@f.position'/>"), expected + "position");
  const Scene scene =
      engine("<RigidToQuatEngine name='parts' rigids='@f.position'/><AverageCoord name='e' vertices='@parts.positions'/>", frames);
  EXPECT_EQ(made<std::vector<Vec3>>(scene, "average").at(0), Vec3(10, 0, 0));
  const Scene sum = engine("<SumEngine name='e' template='Rigid3' input='@f.position'/>", frames);
  EXPECT_EQ(made<std::vector<double>>(sum, "output"), (std::vector<double>{30, 0, 0, 0, 0, 0, 3}));
}

TEST(FrameEngines, RegionsHaveTheirValues) {
  const Scene scene =
      engine("<ROIValueMapper name='e' nbROIs='2' indices1='1 3' value1='5' indices2='3 4' value2='7' defaultValue='2'/>");
  EXPECT_EQ(made<std::vector<double>>(scene, "outputValues"), (std::vector<double>{2, 5, 2, 7, 7}));
  expectContains(problemsOf("<Node name='root'><ROIValueMapper nbROIs='1' indices1='-1'/></Node>"), "indices1 names -1");
  expectContains(problemsOf("<Node name='root'><ROIValueMapper indices1='0 2' value1='5'/></Node>"), "indices1 is given, and nbROIs is 0");
  expectContains(problemsOf("<Node name='root'><ROIValueMapper nbROIs='2' value3='5'/></Node>"), "nbROIs=\"3\"");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
