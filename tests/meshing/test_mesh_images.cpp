// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma mesh` on segmented images: the example leg in every format, and images that are no segmentation.
#include <cmath>
#include <set>

#include "tests/meshing/meshing_fixture.h"

namespace stroma::test {
namespace {

const std::string coarse = " --scale 0.001 --cell-size 0.03 --cell-size 2=0.025 --cell-size 3=0.02 --distance 0.004";

TEST_F(MeshCommand, TheLegIsWatertightOfGoodShapeAndHasTheVolumesOfItsVoxels) {
  if (!makeLeg("leg.mhd")) GTEST_SKIP() << "no Python with numpy";
  std::map<int, double> voxels;  // counted here, in the raw file
  for (const char c : bytes("leg.raw")) voxels[c] += 27e-9;
  for (const std::string& distance : {std::string("0.003"), std::string("0.002")}) {
    const auto json = report("leg.mhd -o leg.msh --scale 0.001 --cell-size 0.02 --distance " + distance);
    double angle = 0;
    const GmshFile file = readGmsh((folder_ / "leg.msh").string());
    const auto regions = regionsOf(file, angle);
    ASSERT_EQ(regions.size(), 3u);
    EXPECT_GT(angle, 8);
    EXPECT_NEAR(json["smallestDihedralAngle"].get<double>(), angle, 1e-3);
    for (const auto& [label, region] : regions) {
      EXPECT_NEAR(region.volume, voxels[label], 0.01 * voxels[label]) << "label " << label;
      EXPECT_GT(region.edges, 100);
      EXPECT_EQ(region.bad_edges, 0) << "label " << label;
      const auto& reported = json["regions"][label - 1];
      EXPECT_EQ(reported["label"], label);
      EXPECT_NEAR(reported["volume"].get<double>(), region.volume, 1e-6 * region.volume);
      EXPECT_TRUE(reported["watertight"].get<bool>());
      EXPECT_EQ(reported["parts"], 1);
    }
    EXPECT_EQ(file.mesh.report().inverted.size(), 0u);
  }
}

TEST_F(MeshCommand, EveryFormatAndEveryRunGivesTheSameMesh) {
  if (!makeLeg("leg.mhd")) GTEST_SKIP() << "no Python with numpy";
  ASSERT_EQ(stroma("mesh leg.mhd -o first.msh" + coarse).code, 0);
  for (const std::string image : {"leg.mhd", "leg.mha", "leg.nii", "leg.nii.gz", "leg.vti"}) {
    ASSERT_TRUE(makeLeg(image));
    const Finished finished = stroma("mesh " + image + " -o again.msh" + coarse);
    ASSERT_EQ(finished.code, 0) << finished.err;
    EXPECT_EQ(bytes("again.msh"), bytes("first.msh")) << image;
  }
}

TEST_F(MeshCommand, AUnitIsTheScaleThatMakesMetres) {
  if (!makeLeg("leg.mhd")) GTEST_SKIP() << "no Python with numpy";
  const std::string sizes = " --cell-size 0.03 --distance 0.004 -o ";
  ASSERT_EQ(stroma("mesh leg.mhd --scale 0.001" + sizes + "scale.msh").code, 0);
  ASSERT_EQ(stroma("mesh leg.mhd --unit mm" + sizes + "unit.msh").code, 0);
  EXPECT_EQ(bytes("unit.msh"), bytes("scale.msh"));
}

TEST_F(MeshCommand, TheReportCountsTheNodesOfTheFile) {
  if (!makeLeg("leg.mhd")) GTEST_SKIP() << "no Python with numpy";
  for (const std::string order : {"1", "2"}) {
    const auto json = report("leg.mhd --unit mm --cell-size 0.03 --distance 0.004 -o leg.msh --order " + order);
    const GmshFile file = readGmsh((folder_ / "leg.msh").string());
    std::map<int, std::set<Index>> nodes;
    const auto take = [&nodes](const auto& cells, const std::vector<int>& labels) {
      for (std::size_t c = 0; c < cells.size(); ++c) nodes[labels[c]].insert(cells[c].begin(), cells[c].end());
    };
    take(file.mesh.tetrahedra, file.groups.tetrahedra);
    take(file.mesh.quadratic_tetrahedra, file.groups.quadratic_tetrahedra);
    EXPECT_EQ(json["nodes"], file.mesh.position.size()) << "order " << order;
    ASSERT_EQ(nodes.size(), 3u);
    for (const auto& [label, own] : nodes) EXPECT_EQ(json["regions"][label - 1]["nodes"], own.size()) << "order " << order;
  }
}

/// A ball of `radius` voxels in a cube of `size`^3 as a MetaImage: axes turned about z by 90 degrees, spacing 1 2 3.
std::string turnedBall(int size, double radius) {
  std::string voxels;
  for (int z = 0; z < size; ++z)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double c = (size - 1) / 2.0, r2 = (x - c) * (x - c) + 4 * (y - c) * (y - c) + 9 * (z - c) * (z - c);
        voxels.push_back(r2 < radius * radius ? char(7) : char(0));
      }
  return fmt::format(
             "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 100 0 0\nElementSpacing = 1 2 3\nDimSize = {} {} {}\n"
             "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
             size, size, size) +
         voxels;
}

TEST_F(MeshCommand, SpacingAndAxesOfTheImageAreKept) {
  write("ball.mha", turnedBall(25, 10));
  const auto json = report("ball.mha -o ball.msh --cell-size 4 --name 7=ball");
  ASSERT_FALSE(json.is_null());
  const GmshFile file = readGmsh((folder_ / "ball.msh").string());
  const MeshReport mesh = file.mesh.report();
  // a ball of radius 10 about the middle voxel (12, 12, 12) = 12 (0 1 0) + 24 (-1 0 0) + 36 (0 0 1) + offset
  const Vec3 middle = (mesh.low + mesh.high) / 2;
  EXPECT_NEAR((middle - Vec3(76, 12, 36)).norm(), 0, 0.5);
  EXPECT_NEAR(mesh.volume, 4. / 3 * M_PI * 1000, 0.04 * 4. / 3 * M_PI * 1000);  // of voxels of 1 2 3
  EXPECT_EQ(file.group_names.at({3, 7}), "ball");
  EXPECT_EQ(file.group_names.at({2, 1}), "ball.outside");
}

TEST_F(MeshCommand, SeveralPartsOfALabelAreAllFound) {
  std::string voxels(40 * 20 * 20, '\0');
  const auto put = [&voxels](int x, int y, int z, int side, char label) {
    for (int k = 0; k < side * side * side; ++k)
      voxels[std::size_t((z + k / side / side) * 800 + (y + k / side % side) * 40 + x + k % side)] = label;
  };
  put(2, 2, 2, 14, 1), put(6, 6, 6, 5, 2), put(22, 4, 4, 4, 1), put(32, 10, 10, 4, 1), put(24, 14, 14, 3, 2);
  write("parts.mha",
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 40 20 20\nElementSpacing = 1 1 1\n"
        "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
            voxels);
  const auto json = report("parts.mha -o parts.msh --cell-size 5 --cell-size 2=2");
  ASSERT_FALSE(json.is_null());
  EXPECT_EQ(json["regions"][0]["parts"], 3);
  EXPECT_EQ(json["regions"][1]["parts"], 2);
  EXPECT_TRUE(json["regions"][1]["watertight"].get<bool>());
}

TEST_F(MeshCommand, RegionsThatMeetOnTheSurfaceAndAtTheBorderOfTheImageAreWatertight) {
  // a soft rod with a bone through it, both cut by the first and the last slice: three regions meet along circles
  constexpr int side = 24, length = 20;
  std::string voxels;
  std::map<int, double> count;
  for (int i = 0; i < side * side * length; ++i) {
    const double x = i % side - 11.5, y = i / side % side - 11.5, r = std::hypot(x, y);
    voxels.push_back(r < 4.2 ? '\2' : r < 10.6 ? '\1' : '\0');
    ++count[voxels.back()];
  }
  write("rod.mha", fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = {} {} {}\nElementSpacing = "
                               "1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
                               side, side, length) +
                       voxels);
  ASSERT_FALSE(report("rod.mha -o rod.msh --cell-size 4").is_null());
  double angle = 0;
  const auto regions = regionsOf(readGmsh((folder_ / "rod.msh").string()), angle);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_GT(angle, 8);
  for (const auto& [label, region] : regions) {
    EXPECT_NEAR(region.volume, count[label], 0.01 * count[label]);
    EXPECT_EQ(region.bad_edges, 0) << "label " << label;
  }
}

TEST_F(MeshCommand, ImagesThatAreNoSegmentationAreRefused) {
  const auto header = [](const char* type, const char* size) {
    return fmt::format(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementSpacing = 1 1 1\nDimSize = {}\n"
        "ElementType = {}\nElementDataFile = LOCAL\n",
        size, type);
  };
  std::string ramp, fractions;
  for (int i = 0; i < 1000; ++i) {
    const short value = short(i);
    ramp.append(reinterpret_cast<const char*>(&value), 2);
    const float half = float(i % 3) / 2;
    fractions.append(reinterpret_cast<const char*>(&half), 4);
  }
  write("grey.mha", header("MET_SHORT", "10 10 10") + ramp);
  write("half.mha", header("MET_FLOAT", "10 10 10") + fractions);
  write("empty.mha", header("MET_UCHAR", "10 10 10") + std::string(1000, '\0'));
  write("cut.mha", header("MET_UCHAR", "10 10 10") + std::string(100, '\1'));
  write("words.nii", "these are words");
  write("photo.png", "x");
  for (const auto& [arguments, sentence] :
       std::map<std::string, std::string>{{"grey.mha", "more than 256 different values"},
                                          {"half.mha", "0.5 is not a label"},
                                          {"empty.mha", "every voxel is 0"},
                                          {"cut.mha", "cannot be read"},
                                          {"words.nii", "is not a NIfTI file"},
                                          {"photo.png", "not known from its name"},
                                          {"none.nii", "there is no file"},
                                          {"half.mha --cell-size -1", "expected a number above 0"},
                                          {"half.mha --facet-angle 40", "expected at most 30"},
                                          {"half.mha --name soft", "expected LABEL=NAME"}})
    expectRefused(arguments, sentence);
  write("ball.mha", turnedBall(25, 10));
  EXPECT_NE(stroma("mesh ball.mha -o mesh.msh --cell-size 3=1").err.find("the input has no label 3 (it has 7)"),
            std::string::npos);
  EXPECT_NE(stroma("mesh ball.mha -o mesh.stl").err.find(".msh or .vtu"), std::string::npos);
}

TEST_F(MeshCommand, ARunOfASceneOpensNeitherCgalNorVtk) {
  write("falling.xml", falling_scene);
  const std::string line =
      "cd '" + folder_.string() + "' && LD_DEBUG=files '" STROMA_COMMAND "' run falling.xml -n 1 >.log 2>&1";
  ASSERT_EQ(std::system(line.c_str()), 0);
  const std::string log = bytes(".log");
  EXPECT_NE(log.find("mechanics.so"), std::string::npos);  // the log is one of opened files
  for (const char* file : {"meshing.so", "read_label_image", "libvtk", "libgmp"})
    EXPECT_EQ(log.find(file), std::string::npos) << file;
}

}  // namespace
}  // namespace stroma::test
