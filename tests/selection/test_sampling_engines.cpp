// SPDX-License-Identifier: LGPL-2.1-or-later
// Points chosen on a mesh or in it, values along a direction, frames on a surface, and affine matrices one after another.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/selection/engine_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Eleven points on a line: the ends, then what is farthest from both; and the middles of the thirds, once they are moved.
TEST(SamplingEngines, NodesFarFromEachOther) {
  std::string line, edges;
  for (int i = 0; i <= 10; ++i) line += fmt::format("{} 0 0  ", i);
  for (int i = 0; i < 10; ++i) edges += fmt::format("{} {}  ", i, i + 1);
  const auto chosen = [&](const std::string& attributes) {
    return made<std::vector<int>>(engine("<MeshSampler name='e' position='" + line + "' " + attributes + "/>"), "outputIndices");
  };
  EXPECT_EQ(chosen("number='3' maxIter='0'"), (std::vector<int>{0, 10, 5}));
  EXPECT_EQ(chosen("number='2' maxIter='0' fixedPosition='5.2 0 0'"), (std::vector<int>{0, 10}));
  EXPECT_EQ(chosen("number='1' maxIter='9'"), std::vector<int>{5});
  EXPECT_EQ(chosen("number='3' maxIter='0' edges='" + edges + "'"), (std::vector<int>{0, 10, 5}));
  // along a horseshoe the ends are far from each other, in a straight line they are near
  const std::string shoe = "position='0 0 0  4 0 0  8 0 0  8 1 0  4 1 0  0 1 0' maxIter='0' number='2' ";
  EXPECT_EQ(made<std::vector<int>>(engine("<MeshSampler name='e' " + shoe + "/>"), "outputIndices"), (std::vector<int>{0, 3}));
  EXPECT_EQ(made<std::vector<int>>(engine("<MeshSampler name='e' edges='0 1  1 2  2 3  3 4  4 5' " + shoe + "/>"), "outputIndices"),
            (std::vector<int>{0, 5}));
  expectContains(problemsOf("<Node name='root'><MeshSampler position='0 0 0' number='2'/></Node>"),
                 "there are 1 nodes, and 2 are to be chosen");
  expectContains(problemsOf("<Node name='root'><MeshSampler position='0 0 0' edges='0 1'/></Node>"), "names node 1");
}

/// No node twice, and none where a fixed one is.
TEST(SamplingEngines, NoNodeIsChosenTwice) {
  const std::string three = "<MeshSampler name='e' position='0 0 0  2 0 0  1 0 0' fixedPosition='0 0 0' number='{}'/>";
  const auto chosen = [](const Scene& scene) { return made<std::vector<int>>(scene, "outputIndices"); };
  const Scene too_many = engine(fmt::format(fmt::runtime(three), 3)), both = engine(fmt::format(fmt::runtime(three), 2));
  EXPECT_EQ(chosen(too_many), (std::vector<int>{1, 2}));
  expectContains(too_many.diagnostics.text(), "2 of 3 nodes were found");
  EXPECT_EQ(chosen(both), (std::vector<int>{1, 2}));
  EXPECT_EQ(both.diagnostics.text().find("were found"), std::string::npos);
  EXPECT_EQ(chosen(engine("<MeshSampler name='e' position='1 0 0  1 0 0' number='2'/>")), std::vector<int>{0});
  expectContains(problemsOf("<Node name='root'><MeshSampler position='1 0 0' fixedPosition='0 0 0' number='1'/></Node>"),
                 "all nodes lie where a fixed point is");
}

/// In the tetrahedron of the unit vectors x + y + z < 1.
TEST(SamplingEngines, PointsLieInTheSurfaceAndApart) {
  const std::string scene = "<RandomPointDistributionInSurface name='e' vertices='0 0 0  1 0 0  0 1 0  0 0 1' "
                            "triangles='0 2 1  0 1 3  1 2 3  2 0 3' numberOfInPoints='40' minDistanceBetweenPoints='0.05' {}/>";
  const auto points = [&](const std::string& more) {
    return made<std::vector<Vec3>>(engine(fmt::format(fmt::runtime(scene), more)), "inPoints");
  };
  const std::vector<Vec3> inside = points("");
  ASSERT_EQ(inside.size(), 40u);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    EXPECT_GT(inside[i].minCoeff(), 0);
    EXPECT_LT(inside[i].sum(), 1);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GE((inside[i] - inside[k]).norm(), 0.05);
  }
  EXPECT_EQ(points(""), inside);
  EXPECT_NE(points("randomSeed='1'"), inside);
  for (const Vec3& p : made<std::vector<Vec3>>(engine(fmt::format(fmt::runtime(scene), "")), "outPoints")) EXPECT_GE(p.sum(), 1);
  expectContains(engine("<RandomPointDistributionInSurface name='e' vertices='0 0 0  1 0 0  0 1 0  0 0 1' "
                        "triangles='0 2 1  0 1 3  1 2 3  2 0 3' numberOfInPoints='9' minDistanceBetweenPoints='5'/>").diagnostics.text(),
                 "1 of 9 points were found");
  expectContains(problemsOf("<Node name='root'><RandomPointDistributionInSurface vertices='0 0 0'/></Node>"), "there is no surface");
}

TEST(SamplingEngines, ValuesChangeAlongADirection) {
  const Scene scene = engine("<ValuesFromPositions name='e' position='0 0 0  2 0 0  0 4 0  0 0 8' edges='0 1' triangles='0 1 2' "
                             "tetrahedra='0 1 2 3' direction='0 0 3' inputValues='10 18'/>");
  EXPECT_EQ(made<std::vector<double>>(scene, "values"), (std::vector<double>{10, 10, 10, 18}));
  EXPECT_EQ(made<std::vector<double>>(scene, "edgeValues"), std::vector<double>{10});
  EXPECT_EQ(made<std::vector<double>>(scene, "triangleValues"), std::vector<double>{10});
  EXPECT_EQ(made<std::vector<double>>(scene, "tetrahedronValues"), std::vector<double>{12});
  const Scene three = engine("<ValuesFromPositions name='e' position='0 0 0  2 0 0  0 4 0  0 0 8' direction='0 0 3' inputValues='10 14 20' "
                             "tetrahedra='0 1 2 3'/>");
  EXPECT_EQ(made<std::vector<double>>(three, "values"), (std::vector<double>{10, 10, 10, 20}));
  EXPECT_EQ(made<std::vector<double>>(three, "tetrahedronValues"), std::vector<double>{12});
  const auto told = [](const std::string& text) { return problemsOf("<Node name='root'><ValuesFromPositions " + text + "/></Node>"); };
  expectContains(told("position='0 0 0  0 1 0'"), "inputValues has no value");
  expectContains(told("inputValues='1 2' direction='0 0 0'"), "direction is zero");
  expectContains(told("inputValues='1 2' direction='0 0 1' position='0 0 0  0 1 0'"), "lie in one plane");
}

/// z is the normal, and the frame is right-handed.
TEST(SamplingEngines, FramesStandOnTheNodes) {
  for (const Vec3& normal : {Vec3(0, 0, 2), Vec3(1, 0, 0), Vec3(-1, 0.1, 0), Vec3(0.3, -0.9, 0.2)}) {
    const Scene scene = engine(fmt::format("<Vertex2Frame name='e' position='1 2 3' normals='{} {} {}' invertNormals='true'/>",
                                           normal.x(), normal.y(), normal.z()));
    const auto frame = made<std::vector<double>>(scene, "frames");
    ASSERT_EQ(frame.size(), 7u);
    const Mat3 axes = Eigen::Quaterniond(frame[6], frame[3], frame[4], frame[5]).toRotationMatrix();
    EXPECT_LT((axes.col(2) + normal.normalized()).norm(), 1e-14);
    const Vec3 across = Vec3::UnitY();
    EXPECT_NEAR(axes.col(0).dot(across), 0, 1e-14);
    EXPECT_GT(axes.col(1).dot(across), 0);
  }
  const auto told = [](const std::string& text) { return problemsOf("<Node name='root'><Vertex2Frame " + text + "/></Node>"); };
  expectContains(told("position='1 2 3'"), "1 nodes and 0 normals");
  expectContains(told("position='1 2 3' normals='0 0 0'"), "the normal of node 0 is zero");
  expectContains(told("position='1 2 3' useNormals='false'"), "there is one node");
  expectContains(told("position='1 2 3  1 2 3' useNormals='false'"), "nodes 0 and 1 are in one place");
}

/// A point goes through the later matrix first: (1, 0, 0) doubled, turned to y, lifted by z.
TEST(SamplingEngines, MatricesActOneAfterAnother) {
  const std::string chain = "<TranslateTransformMatrixEngine name='a' translation='0 0 5'/>"
                            "<RotateTransformMatrixEngine name='b' inT='@a.outT' rotation='0 0 90'/>"
                            "<ScaleTransformMatrixEngine name='c' inT='@b.outT' scale='2 3 4'/>"
                            "<InvertTransformMatrixEngine name='d' inT='@c.outT'/>";
  const auto moved = [&](const char* matrix, const char* point) {
    const Scene scene = engine(
        fmt::format("<TransformPosition name='e' method='affine' matrix='@{}.outT' input_position='{}'/>", matrix, point),
        chain);
    return made<std::vector<Vec3>>(scene, "output_position").at(0);
  };
  EXPECT_LT((moved("c", "1 0 0") - Vec3(0, 2, 5)).norm(), 1e-15);
  EXPECT_LT((moved("c", "0 1 1") - Vec3(-3, 0, 9)).norm(), 1e-15);
  EXPECT_LT((moved("d", "-3 0 9") - Vec3(0, 1, 1)).norm(), 1e-15);
  // a millimetre in nanometres, and more: a far place flattens nothing
  const Scene far = engine("<InvertTransformMatrixEngine name='e' inT='@b.outT'/>",
                           "<TranslateTransformMatrixEngine name='a' translation='0 0 5e9'/>"
                           "<RotateTransformMatrixEngine name='b' inT='@a.outT' rotation='0 0 90'/>");
  const auto back = made<std::array<double, 16>>(far, "outT");
  EXPECT_EQ(back[11], -5e9);
  expectContains(problemsOf("<Node name='root'><ScaleTransformMatrixEngine name='flat' scale='1 0 1'/>"
                            "<InvertTransformMatrixEngine inT='@flat.outT'/></Node>"),
                 "inT has no inverse");
  expectContains(problemsOf("<Node name='root'><TranslateTransformMatrixEngine name='a' translation='0 0 1e308'/>"
                            "<TranslateTransformMatrixEngine name='b' inT='@a.outT' translation='0 0 1e308'/>"
                            "<InvertTransformMatrixEngine inT='@b.outT'/></Node>"),
                 "inT has a number that is not finite");
}

/// Not farther than maxRandomDisplacement along each axis, other numbers for another seed.
TEST(SamplingEngines, RandomDisplacementsAreBounded) {
  const auto moved = [](const std::string& more) {
    return made<std::vector<Vec3>>(engine("<TransformPosition name='e' method='random' input_position='1 2 3  4 5 6' " + more + "/>"),
                                   "output_position");
  };
  const std::vector<Vec3> once = moved("maxRandomDisplacement='0.25' fixedIndices='1'");
  EXPECT_LE((once[0] - Vec3(1, 2, 3)).cwiseAbs().maxCoeff(), 0.25);
  EXPECT_GT((once[0] - Vec3(1, 2, 3)).norm(), 0);
  EXPECT_EQ(once[1], Vec3(4, 5, 6));
  EXPECT_EQ(moved("maxRandomDisplacement='0.25' fixedIndices='1'"), once);
  EXPECT_NE(moved("maxRandomDisplacement='0.25' seedValue='7'")[0], once[0]);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
