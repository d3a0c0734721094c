// SPDX-License-Identifier: LGPL-2.1-or-later
// The command over runs whose meshes change: what they record, and how they go on. References: the run that never stopped, and
// counts of cells by hand.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "framework/scene/value_lists.h"
#include "framework/simulation/state_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class ChangedRuns : public CommandTest {
 protected:
  /// A bar of 16 cells, which loses one before each of the steps 4, 7 and 10.
  void SetUp() override {
    CommandTest::SetUp();
    write("bar.xml",
          "<Node name=\"root\" dt=\"0.0078125\" gravity=\"0 -9.81 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"b\">"
          "<RegularGridTopology name=\"grid\" n=\"5 3 3\" min=\"0 0 0\" max=\"0.4 0.2 0.2\"/><MechanicalObject name=\"dofs\"/>"
          "<DiagonalMass massDensity=\"1000\"/><HexahedronFEMForceField method=\"svd\" youngModulus=\"50000\" poissonRatio=\"0.3\"/>"
          "<BoxROI name=\"end\" box=\"-1 -1 -1 0.001 1 1\"/><FixedProjectiveConstraint indices=\"@end.indices\"/>"
          "<CarvingRegion box=\"0.33 -9 -9 9 0.1 0.1\" velocity=\"-4.26666666666666666 0 0\" begin=\"0.0234375\"/>"
          "<Monitor name=\"root\" indices=\"10\" ExportPositions=\"true\"/><WriteState filename=\"all.state\"/>"
          "<VTKExporter filename=\"cells\" exportEveryNumberOfSteps=\"2\" cellsDataFields=\"\" XMLformat=\"false\"/></Node></Node>");
  }
  std::vector<std::string> filesIn(const std::string& folder, const std::string& start) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / folder))
      if (const std::string name = entry.path().filename().string(); name.starts_with(start)) names.push_back(name);
    std::sort(names.begin(), names.end());
    return names;
  }
  std::string contents() const {
    std::string text = readText(folder_ / "root_x.txt") + readText(folder_ / "all.state");
    for (const std::string& name : filesIn(".", "cells")) text += name + readText(folder_ / name);
    return text;
  }
};

TEST_F(ChangedRuns, GoOnFromACheckpointAfterAChange) {
  ASSERT_EQ(stroma("run bar.xml -n 12 --record whole --quiet").code, 0);
  const std::string whole = contents();
  const std::vector<std::string> meshes = filesIn("whole", "meshes.");
  EXPECT_EQ(meshes, (std::vector<std::string>{"meshes.0000000004.checkpoint", "meshes.0000000007.checkpoint",
                                              "meshes.0000000010.checkpoint"}));
  for (const int step : {2, 6, 8}) {
    const std::string folder = fmt::format("half{}", step);
    ASSERT_EQ(stroma(fmt::format("run bar.xml -n {} --record {} --quiet", step, folder)).code, 0);
    const Finished on = stroma(fmt::format("run bar.xml -n 12 --record {} --resume --threads 2 --quiet", folder));
    ASSERT_EQ(on.code, 0) << on.err;
    EXPECT_EQ(contents(), whole) << step;
    EXPECT_EQ(readText(folder_ / folder / "last.checkpoint"), readText(folder_ / "whole/last.checkpoint")) << step;
    const auto frames = [&](const std::string& of) { return readStateFile((folder_ / of / "b.dofs.state.gz").string()); };
    const std::vector<StateFrame> one = frames(folder), all = frames("whole");
    ASSERT_EQ(one.size(), all.size()) << step;
    for (std::size_t i = 0; i < all.size(); ++i)
      EXPECT_TRUE(one[i].time == all[i].time && one[i].x == all[i].x && one[i].v == all[i].v) << step << " " << i;
    EXPECT_EQ(filesIn(folder, "meshes."), meshes) << step;
    for (const std::string& name : meshes)
      EXPECT_EQ(readText(folder_ / folder / name), readText(folder_ / "whole" / name)) << step << name;
  }
  // a checkpoint of the instant after a change is one like others
  const Finished on = stroma("run bar.xml -n 12 --restart whole/meshes.0000000007.checkpoint --record on --quiet");
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_EQ(readText(folder_ / "on/last.checkpoint"), readText(folder_ / "whole/last.checkpoint"));
}

TEST_F(ChangedRuns, WhatIsWrittenHasTheCellsOfItsStep) {
  ASSERT_EQ(stroma("run bar.xml -n 12 --record out --quiet").code, 0);
  std::vector<int> cells;
  for (const std::string& name : filesIn(".", "cells")) {
    const std::string text = readText(folder_ / name);
    const auto at = text.find("\nCELL_TYPES ");
    if (at != std::string::npos) cells.push_back(std::atoi(text.c_str() + at + 12));
  }
  EXPECT_EQ(cells, (std::vector<int>{16, 15, 15, 14, 13, 13})) << "of the steps 2, 4, ..., 12";
  std::vector<std::size_t> points;
  for (const StateFrame& frame : readStateFile((folder_ / "out/b.dofs.state.gz").string())) points.push_back(frame.x.size());
  // along an edge of the bar each cell that goes has one point of its own
  EXPECT_EQ(points, (std::vector<std::size_t>{45, 45, 45, 45, 44, 44, 44, 43, 43, 43, 42, 42, 42}));
}

TEST_F(ChangedRuns, AnotherRunLeavesNoMeshesOfTheOneBefore) {
  ASSERT_EQ(stroma("run bar.xml -n 12 --record out --quiet").code, 0);
  ASSERT_EQ(stroma("run bar.xml -n 5 --record out --quiet").code, 0);
  EXPECT_EQ(filesIn("out", "meshes."), (std::vector<std::string>{"meshes.0000000004.checkpoint"}));
  ASSERT_EQ(stroma("run bar.xml -n 3 --record out --quiet").code, 0);
  EXPECT_TRUE(filesIn("out", "meshes.").empty());
}

TEST_F(ChangedRuns, ACheckpointIsOfTheSceneThatItBeganWith) {
  ASSERT_EQ(stroma("run bar.xml -n 5 --record out --quiet").code, 0);
  const Finished other = stroma("run bar.xml -n 8 --record out --resume --set '/b/grid.max=0.5 0.2 0.2' --quiet");
  EXPECT_EQ(other.code, 2) << other.out;
  EXPECT_NE(other.err.find("than when its mesh changed (expected the scene, and the values of --set"), std::string::npos) << other.err;
  EXPECT_EQ(stroma("run bar.xml -n 8 --record out --resume --quiet").code, 0) << "nothing was lost";
}

TEST_F(ChangedRuns, WhatEveryRunLeavesFollowsTheChanges) {
  const Finished run = stroma("run bar.xml -n 12");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("recorded in results/bar/last"), std::string::npos) << run.out;
  const std::string text = readText(folder_ / "results/bar/last/run.instants");
  const auto head = nlohmann::json::parse(text.substr(0, text.find('\n')));
  EXPECT_EQ(head.at("instants"), 13);
  std::vector<int> from, nodes;
  for (const auto& meshes : head.at("meshes")) from.push_back(meshes.at("from")), nodes.push_back(meshes.at("nodes").at(0));
  EXPECT_EQ(from, (std::vector<int>{4, 7, 10}));
  EXPECT_EQ(nodes, (std::vector<int>{44, 43, 42}));
  // it goes on from there
  ASSERT_EQ(stroma("run bar.xml -n 16 --no-record --quiet").code, 0);
  const std::string whole = contents();
  const Finished on = stroma("run bar.xml -n 16 --restart results/bar/last/last.checkpoint --no-record --quiet");
  EXPECT_EQ(on.code, 0) << on.err;
  EXPECT_EQ(contents(), whole);
  // counts that cannot be are told, and nothing counts up to them
  const std::string count = "\"instants\":13,";
  ASSERT_NE(text.find(count), std::string::npos);
  for (const auto& [other, told] : {std::pair{"-1", "damaged"}, std::pair{"99999999999", "cut short"}, std::pair{"12", "cut short"}}) {
    std::string damaged = text;
    write("results/bar/last/run.instants", damaged.replace(text.find(count), count.size(), "\"instants\":" + std::string(other) + ","));
    const Finished drawn = stroma("picture results/bar/last -o a.png");
    EXPECT_NE(drawn.code, 0) << other;
    EXPECT_NE(drawn.err.find(told), std::string::npos) << other << ": " << drawn.err;
  }
}

/// The last node takes the number of the first point that goes, 4.
TEST_F(ChangedRuns, AMeasuredQuantityFollowsItsNodes) {
  const std::string measured = "run bar.xml -n 12 --no-record --quiet --measure end --measure-value ";
  ASSERT_EQ(stroma("run bar.xml -n 12 --record out --quiet").code, 0);
  const std::vector<Vec3> last = readStateFile((folder_ / "out/b.dofs.state.gz").string()).back().x;
  Finished run = stroma(measured + "/b/dofs.position:44");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(ValueLists::fromBytes(readText(folder_ / "end")).get<Reals>("quantity"), (Reals{last[4][0], last[4][1], last[4][2]}));
  run = stroma(measured + "/b/dofs.position");
  ASSERT_EQ(run.code, 0) << run.err;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : last) mean += x / double(last.size());
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(ValueLists::fromBytes(readText(folder_ / "end")).get<Reals>("quantity").at(c), mean[Index(c)], 1e-14);
  run = stroma(measured + "/b/dofs.position:4");
  EXPECT_NE(run.code, 0);
  EXPECT_NE(run.err.find("all nodes of /b/dofs.position:4 have gone with their cells"), std::string::npos) << run.err;
  // numbers are those of the files, and a checkpoint of a changed mesh has others
  run = stroma(measured + "/b/dofs.position:44 --restart out/meshes.0000000007.checkpoint");
  EXPECT_NE(run.code, 0);
  EXPECT_NE(run.err.find("nodes have other numbers in the changed mesh of out/meshes.0000000007.checkpoint"), std::string::npos) << run.err;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
