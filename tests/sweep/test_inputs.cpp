// SPDX-License-Identifier: LGPL-2.1-or-later
// Files that runs of a sweep read, which of them make which runs again, and what is left of a scene in a measured run.
#include <fmt/format.h>

#include <map>

#include "tests/support/shell.h"

namespace stroma::test {
namespace {

class SweepInputs : public CommandTest {
 protected:
  /// The files that say that a run is whole, and when they were written.
  std::map<std::string, std::filesystem::file_time_type> wholeRuns() const {
    std::map<std::string, std::filesystem::file_time_type> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "out" / "runs"))
      if (entry.path().string().ends_with(".outcome.json")) found[entry.path().string()] = entry.last_write_time();
    return found;
  }
  void sweep(const std::string& meshes) {
    const Finished run = stroma("sweep body.xml --vary /loader.filename=" + meshes +
                                " --vary /fem.method=small,large --no-times -n 1 -q -o out");
    EXPECT_EQ(run.code, 0) << run.err;
  }
};

/// One tetrahedron of this height, or two.
std::string meshFile(double height, bool two = false) {
  return fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 {}\n5 0 0 -1\n$EndNodes\n"
                     "$Elements\n{}\n1 4 2 1 1 1 2 3 4\n{}$EndElements\n",
                     height, two ? 2 : 1, two ? "2 4 2 1 1 1 3 2 5\n" : "");
}

TEST_F(SweepInputs, AMeshAddedLaterMakesItsOwnRunsAlone) {
  write("a.msh", meshFile(1)), write("b.msh", meshFile(1, true)), write("c.msh", meshFile(2, true));
  write("body.xml", R"(<Node name="root" gravity="0 0 -1" dt="0.1"><EulerImplicitSolver/><SparseLDLSolver/>
    <MeshGmshLoader name="loader" filename="a.msh"/><TetrahedronSetTopologyContainer name="mesh" src="@loader"/><MechanicalObject/>
    <UniformMass totalMass="1"/><FixedProjectiveConstraint indices="0 1 2"/>
    <TetrahedronFEMForceField name="fem" method="small" youngModulus="100" poissonRatio="0.3"/></Node>)");
  sweep("a.msh,b.msh");
  const auto first = wholeRuns();
  ASSERT_EQ(first.size(), 4u);
  sweep("a.msh,b.msh,c.msh");
  const auto second = wholeRuns();
  EXPECT_EQ(second.size(), 6u) << "those of the third mesh";
  for (const auto& [file, time] : first) {
    ASSERT_TRUE(second.contains(file)) << file;
    EXPECT_EQ(second.at(file), time) << "made again: " << file;
  }
  // a mesh that has changed makes its own runs again
  write("b.msh", meshFile(3, true));
  sweep("a.msh,b.msh,c.msh");
  EXPECT_EQ(wholeRuns().size(), 8u);
}

/// A run that a sweep measures writes nothing, and ends where it would by itself.
TEST_F(SweepInputs, AStepThatIsRefusedIsRefusedInMeasuredRunsToo) {
  const std::string scene = STROMA_SOURCE_DIR "/tests/stress/scenes/incision.xml";
  for (const std::string measured : {"", " --measure end.values"}) {
    const Finished run = stroma("run " + scene + " -n 10 --no-record --set /slab/knife.hexahedraToRemove=99" + measured);
    EXPECT_EQ(run.code, 3) << measured;
    EXPECT_NE(run.err.find("/slab/knife: there is no hexahedron 99"), std::string::npos) << run.err;
  }
}

}  // namespace
}  // namespace stroma::test
