// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma mesh` as a user runs it, and a check of what it wrote that shares no code with what wrote it.
#pragma once
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "components/topology/gmsh_reader.h"
#include "tests/support/shell.h"

namespace stroma::test {

class MeshCommand : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    if (!std::filesystem::exists(STROMA_BINARY_DIR "/lib/stroma/meshing.so"))
      GTEST_SKIP() << "built without CGAL: there is no mesh generator";
  }
  /// The example leg in the format of the name; false when there is no Python with numpy.
  bool makeLeg(const std::string& file, const std::string& voxel = "3") const {
    const std::string line = "/usr/bin/python3 '" STROMA_SOURCE_DIR "/scenes/meshes/make_leg.py' --voxel " + voxel +
                             " --out '" + (folder_ / file).string() + "' >'" + (folder_ / ".leg").string() + "' 2>&1";
    return std::system(line.c_str()) == 0;
  }
  nlohmann::json report(const std::string& arguments) const {
    const Finished finished = stroma("mesh " + arguments + " --json");
    EXPECT_EQ(finished.code, 0) << finished.err;
    return finished.code == 0 ? nlohmann::json::parse(finished.out) : nlohmann::json();
  }
  /// The command refuses the input with this sentence, and writes no mesh.
  void expectRefused(const std::string& arguments, const std::string& sentence) const {
    const Finished finished = stroma("mesh " + arguments + " -o mesh.msh");
    EXPECT_EQ(finished.code, 2) << arguments;
    EXPECT_NE(finished.err.find(sentence), std::string::npos) << arguments << ": " << finished.err;
    EXPECT_FALSE(exists("mesh.msh")) << arguments;
  }
  std::string bytes(const std::string& file) const { return readText(folder_ / file); }
};

/// What is found of one label.
struct Region {
  double volume = 0;
  long edges = 0, bad_edges = 0;  ///< edges of its boundary; those without exactly two triangles
};

/// Volumes, boundaries and the smallest dihedral angle, from the cells alone. Quadratic maps: for small meshes.
inline std::map<int, Region> regionsOf(const GmshFile& file, double& smallest_angle) {
  const Mesh& mesh = file.mesh;
  const auto at = [&mesh](Index n) -> const Vec3& { return mesh.position[n]; };
  std::map<int, Region> regions;
  std::map<int, std::map<std::array<Index, 3>, int>> faces;
  smallest_angle = 180;
  for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c) {
    const Tetrahedron& t = mesh.tetrahedra[c];
    const int label = file.groups.tetrahedra[c];
    regions[label].volume += (at(t[1]) - at(t[0])).dot((at(t[2]) - at(t[0])).cross(at(t[3]) - at(t[0]))) / 6;
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<Index, 3> face;
      for (std::size_t i = 0, k = 0; i < 4; ++i)
        if (i != skip) face[k++] = t[i];
      std::sort(face.begin(), face.end());
      ++faces[label][face];
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const std::size_t k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
        const Vec3 e = (at(t[j]) - at(t[i])).normalized();
        Vec3 u = at(t[k]) - at(t[i]), v = at(t[l]) - at(t[i]);
        u -= u.dot(e) * e, v -= v.dot(e) * e;
        smallest_angle = std::min(smallest_angle, std::acos(u.normalized().dot(v.normalized())) * 180 / M_PI);
      }
  }
  for (const auto& [label, count] : faces) {
    std::map<std::array<Index, 2>, int> edges;
    for (const auto& [face, times] : count)
      if (times == 1)
        for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) ++edges[{face[i], face[j]}];
    for (const auto& [edge, triangles] : edges) ++regions[label].edges, regions[label].bad_edges += triangles != 2;
  }
  return regions;
}

}  // namespace stroma::test
