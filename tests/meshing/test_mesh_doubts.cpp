// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma mesh` refuses before it starts and warns of afterwards: sizes, idle options, names, small and lost
// parts.
#include "tests/meshing/meshing_fixture.h"

namespace stroma::test {
namespace {

/// An image of voxels of size 1, empty but for boxes of labels.
class Blocks {
 public:
  explicit Blocks(int side) : side_(side), voxels_(std::size_t(side) * std::size_t(side) * std::size_t(side), '\0') {}
  Blocks& put(std::array<int, 3> low, std::array<int, 3> size, char label) {
    for (int z = low[2]; z < low[2] + size[2]; ++z)
      for (int y = low[1]; y < low[1] + size[1]; ++y)
        for (int x = low[0]; x < low[0] + size[0]; ++x) voxels_[std::size_t((z * side_ + y) * side_ + x)] = label;
    return *this;
  }
  std::string text() const {
    return fmt::format(
               "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = {0} {0} {0}\nElementSpacing = 1 1 "
               "1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
               side_) +
           voxels_;
  }

 private:
  int side_;
  std::string voxels_;
};

const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

TEST_F(MeshCommand, SizesThatNoMachineMeshesAreRefusedAtOnce) {
  write("tet.obj", tetrahedron), write("cube.mha", Blocks(20).put({4, 4, 4}, {12, 12, 12}, 1).text());
  for (const std::string line : {"tet.obj --cell-size 1e-4", "cube.mha --cell-size 0.012", "tet.obj --facet-size 1e-4",
                                 "cube.mha --cell-size 3 --most-cells 100"}) {
    const Finished finished = stroma("mesh -o n.msh " + line);
    EXPECT_EQ(finished.code, 2) << line;
    EXPECT_NE(finished.err.find("cells are to be expected"), std::string::npos) << finished.err;
    EXPECT_NE(finished.err.find("--scale"), std::string::npos) << finished.err;
    EXPECT_FALSE(exists("n.msh"));
  }
  const auto json = report("cube.mha -o n.msh --cell-size 1.5");
  ASSERT_FALSE(json.is_null());
  const double expected = json["expectedTetrahedra"], found = json["tetrahedra"];
  EXPECT_LT(std::max(expected / found, found / expected), 3);
  const Finished told = stroma("mesh cube.mha -o n.msh --cell-size 1 --progress 0.01");
  EXPECT_EQ(told.code, 0);
  EXPECT_NE(told.err.find("cells expected"), std::string::npos) << told.err;
}

TEST_F(MeshCommand, OptionsWithoutEffectAndNamesThatMeanTwoThingsAreRefused) {
  write("tet.obj", tetrahedron);
  write("two.mha", Blocks(12).put({2, 2, 2}, {8, 8, 4}, 1).put({2, 2, 6}, {8, 8, 4}, 2).text());
  for (const auto& [line, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"two.mha -o n.msh --feature-angle 20", "--feature-angle has no effect here"},
           {"tet.obj -o n.msh --free-volume", "--free-volume has no effect here"},
           {"tet.obj -o n.msh --feature-angle 1000", "at most 180"},
           {"tet.obj -o n.vtu --msh22", "--msh22 has no effect here"},
           {"tet.obj -o n.msh --unit kg", "--unit kg: expected a length, such as m, cm, mm"},
           {"tet.obj -o n.msh --unit mm --scale 2", "--unit and --scale: expected one of them"},
           {"two.mha -o n.vtu --name 1=a", "--name has no effect here"},
           {"two.mha -o n.msh --cell-size 2 --cell-size 3", "another one before it"},
           {"two.mha -o n.msh --name 1=a --name 2=a", "would have one name"},
           {"two.mha -o n.msh --name 1=a --name 1=b", "label 1 has a name"},
           {"two.mha -o n.msh --name 1=label_2", "would have one name"},
           {"two.mha -o n.msh --name 1=outside", "the exterior of the body"},
           {"two.mha", "-o MESH"},
           {"two.mha -o n.msh --distance 30", "the longest side of the body is 8"},
           {"two.mha -o n.msh --distance '1 mm'", "without a unit"},
           {"two.mha -o n.msh --unit mm --distance '1 mn'", "--distance mn: expected a length"},
           {"two.mha -o n.msh --name 1=a.b", "'.'"}}) {
    const Finished finished = stroma("mesh " + line);
    EXPECT_EQ(finished.code, 2) << line;
    EXPECT_NE(finished.err.find(sentence), std::string::npos) << line << ": " << finished.err;
  }
  const auto in_millimetres = report("two.mha -o n.msh --unit mm --cell-size '2 mm' --distance 0.3mm");
  const auto in_metres = report("two.mha -o n.msh --unit mm --cell-size 0.002 --distance 0.0003");
  ASSERT_FALSE(in_millimetres.is_null() || in_metres.is_null());
  EXPECT_EQ(in_millimetres["tetrahedra"], in_metres["tetrahedra"]);
  EXPECT_EQ(in_millimetres["distance"], in_metres["distance"]);
}

TEST_F(MeshCommand, SmallPartsKeepTheVolumeOfTheirVoxelsWithCellsSmallerThanVoxels) {
  for (const int thick : {1, 2, 3}) {
    write("p.mha", Blocks(16).put({4, 4, 4}, {7, 7, 7}, 1).put({6, 6, 6}, {thick, thick, thick}, 2).text());
    const auto json = report("p.mha -o p.msh --cell-size 3 --cell-size 2=0.4 --distance 0.03");
    ASSERT_FALSE(json.is_null());
    const double volume = json["regions"][1]["volume"], voxels = thick * thick * thick;
    EXPECT_NEAR(volume, voxels, (thick == 1 ? 0.08 : 0.04) * voxels) << thick;
    write("sheet.mha", Blocks(12).put({3, 3, 3}, {6, 6, thick}, 1).text());
    // not 0.5: there CGAL's perturbation of the sheet takes very long, which is a defect that no test shows
    const auto sheet = report("sheet.mha -o p.msh --cell-size 0.45 --distance 0.05");
    ASSERT_FALSE(sheet.is_null());
    EXPECT_NEAR(sheet["regions"][0]["volume"].get<double>(), 36. * thick, 0.02 * 36 * thick) << thick;
  }
}

TEST_F(MeshCommand, SingleVoxelsAreMeshedAndBranchingSurfacesAreWarnedOf) {
  write("speck.mha", Blocks(40).put({5, 5, 5}, {30, 30, 30}, 1).put({2, 2, 2}, {1, 1, 1}, 1).text());
  const Finished speck = stroma("mesh speck.mha -o n.msh --cell-size 6 --distance 1 --json");
  ASSERT_EQ(speck.code, 0) << speck.err;
  EXPECT_EQ(nlohmann::json::parse(speck.out)["regions"][0]["parts"], 2) << speck.err;
  write("edge.mha", Blocks(16).put({2, 2, 2}, {6, 6, 12}, 1).put({8, 8, 2}, {6, 6, 12}, 1).text());
  const Finished edge = stroma("mesh edge.mha -o n.msh --cell-size 4 --json");
  ASSERT_EQ(edge.code, 0) << edge.err;
  const auto region = nlohmann::json::parse(edge.out)["regions"][0];
  EXPECT_TRUE(region["watertight"].get<bool>());
  EXPECT_FALSE(region["manifold"].get<bool>());
  EXPECT_NE(edge.err.find("closed but branches"), std::string::npos) << edge.err;
}

TEST_F(MeshCommand, TheVolumeOfASurfaceDoesNotDependOnHowItIsTurned) {
  write("two.obj", tetrahedron + "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 5 6 7\nf 5 8 6\nf 6 8 7\nf 5 7 8\n");
  const auto json = report("two.obj -o n.msh --cell-size 0.4");
  ASSERT_FALSE(json.is_null());
  EXPECT_NEAR(json["regions"][0]["inputVolume"].get<double>(), 1. / 3, 1e-12);
  EXPECT_NEAR(json["regions"][0]["volume"].get<double>(), 1. / 3, 1e-6);
}

}  // namespace
}  // namespace stroma::test
