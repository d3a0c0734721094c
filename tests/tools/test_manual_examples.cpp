// SPDX-License-Identifier: LGPL-2.1-or-later
// Every component's manual page has an example, and every example runs.
#include <algorithm>
#include <map>
#include <vector>

#include "framework/scene/modules.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace {

using ManualExamples = CommandTest;

/// The scene below the line `Example:`, or empty.
std::string exampleOf(const std::string& page) {
  const std::string mark = "\nExample:\n";
  const auto at = page.find(mark);
  if (at == std::string::npos) return {};
  const auto end = page.find("</Node>\n", page.rfind("</Node>"));
  return end == std::string::npos ? "" : page.substr(at + mark.size(), end + 8 - at - mark.size());
}

/// What the examples read: one tetrahedron, or its surface, in each format, and a recording.
void writeFiles(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "block.msh") << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                                         "4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n";
  std::ofstream(folder / "block.vtk") << "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                         "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n"
                                         "CELL_TYPES 1\n10\n";
  std::ofstream(folder / "block.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::ofstream(folder / "fall.state") << "T= 0\n  X= 0 0 0 1 0 0\nT= 0.02\n  X= 0 -0.002 0 1 0.038 0\n";
  std::ofstream(folder / "block.stl") << "solid block\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\n"
                                         "vertex 1 0 0\nendloop\nendfacet\nendsolid block\n";
}

TEST_F(ManualExamples, EveryComponentHasOneAndItRuns) {
  Factory factory;
  const Modules modules(factory);
  ASSERT_FALSE(modules.index().empty());
  std::map<std::string, std::vector<std::string>> types_of;  // several names of one component share a page
  for (const auto& entry : modules.index()) {
    const std::string example = exampleOf(modules.manual(entry.type));
    EXPECT_FALSE(example.empty()) << entry.type << " has no example in its manual page";
    if (!example.empty()) types_of[example].push_back(entry.type);
  }
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  writeFiles(folder_ / "meshes");
  for (const auto& [example, types] : types_of) {
    EXPECT_TRUE(std::ranges::any_of(types, [&](const auto& type) { return example.find("<" + type) != example.npos; }))
        << types[0] << " does not occur in its example";
    write("example.xml", example);
    const Finished run = stroma("run example.xml -n 3 --quiet");
    EXPECT_EQ(run.code, 0) << types[0] << ":\n" << run.err << example;
  }
}

}  // namespace
}  // namespace stroma::test
