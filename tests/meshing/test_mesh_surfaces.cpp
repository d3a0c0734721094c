// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma mesh` on closed surfaces of triangles.
#include <Eigen/Geometry>
#include <cmath>

#include "tests/meshing/meshing_fixture.h"

namespace stroma::test {
namespace {

struct Surface {
  std::vector<Vec3> position;
  std::vector<Triangle> triangles;
};

/// A unit sphere of meridians and parallels about `centre`, poles on z.
Surface sphere(int rings, int sides, const Vec3& centre = Vec3::Zero()) {
  Surface s;
  s.position.push_back(centre + Vec3::UnitZ());
  for (int r = 1; r < rings; ++r)
    for (int k = 0; k < sides; ++k) {
      const double a = M_PI * r / rings, b = 2 * M_PI * k / sides;
      s.position.push_back(centre + Vec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  s.position.push_back(centre - Vec3::UnitZ());
  const Index last = Index(s.position.size()) - 1;
  const auto node = [sides](int r, int k) { return Index(1 + (r - 1) * sides + k % sides); };
  for (int k = 0; k < sides; ++k) {
    s.triangles.push_back({0, node(1, k), node(1, k + 1)});
    s.triangles.push_back({last, node(rings - 1, k + 1), node(rings - 1, k)});
    for (int r = 1; r + 1 < rings; ++r) {
      s.triangles.push_back({node(r, k), node(r + 1, k), node(r + 1, k + 1)});
      s.triangles.push_back({node(r, k), node(r + 1, k + 1), node(r, k + 1)});
    }
  }
  return s;
}

Surface cube() {
  Surface s;
  for (int i = 0; i < 8; ++i) s.position.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  s.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return s;
}

std::string objText(const Surface& s) {
  std::string text;
  for (const Vec3& p : s.position) text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
  for (const Triangle& t : s.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

std::string stlText(const Surface& s) {
  std::string text = "solid s\n";
  for (const Triangle& t : s.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const Index n : t) {
      const Vec3& p = s.position[std::size_t(n)];
      text += fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid s\n";
}

double volumeOf(const Surface& s) {
  double volume = 0;
  for (const auto& [a, b, c] : s.triangles)
    volume += s.position[std::size_t(a)].dot(s.position[std::size_t(b)].cross(s.position[std::size_t(c)])) / 6;
  return volume;
}

TEST_F(MeshCommand, ASphereOfObjAndStlHasItsVolumeToTheDistanceAllowed) {
  const Surface ball = sphere(40, 80);
  write("ball.obj", objText(ball)), write("ball.stl", stlText(ball));
  constexpr double distance = 0.01;
  for (const char* input : {"ball.obj", "ball.stl"}) {
    const auto json = report(fmt::format("{} -o ball.msh --cell-size 0.4 --distance {}", input, distance));
    ASSERT_FALSE(json.is_null());
    double angle = 0;
    const auto regions = regionsOf(readGmsh((folder_ / "ball.msh").string()), angle);
    ASSERT_EQ(regions.size(), 1u);
    const Region& region = regions.at(1);
    // inscribed triangles whose centres are at most `distance` inside: the shell has at most area times distance
    EXPECT_LT(region.volume, volumeOf(ball));
    EXPECT_GT(region.volume, volumeOf(ball) - 4 * M_PI * distance);
    EXPECT_EQ(region.bad_edges, 0);
    EXPECT_GT(angle, 8);
  }
}

TEST_F(MeshCommand, TheEdgesOfACubeAreKept) {
  write("cube.obj", objText(cube()));
  ASSERT_FALSE(report("cube.obj -o cube.msh --cell-size 0.3").is_null());
  const GmshFile file = readGmsh((folder_ / "cube.msh").string());
  EXPECT_NEAR(file.mesh.report().volume, 1, 1e-9);
  // without them the corners are cut
  ASSERT_FALSE(report("cube.obj -o round.msh --cell-size 0.3 --feature-angle 170").is_null());
  const double volume = readGmsh((folder_ / "round.msh").string()).mesh.report().volume;
  EXPECT_LT(volume, 0.9999);
  EXPECT_GT(volume, 0.8);
}

TEST_F(MeshCommand, ASurfaceInsideIsAHollowAndTheSameRunGivesTheSameFile) {
  Surface hollow = sphere(20, 40);
  const Surface inner = sphere(20, 40);
  const Index shift = Index(hollow.position.size());
  for (const Vec3& p : inner.position) hollow.position.push_back(0.5 * p);
  for (const auto& [a, b, c] : inner.triangles) hollow.triangles.push_back({a + shift, c + shift, b + shift});
  write("hollow.obj", objText(hollow));
  const std::string arguments = " --cell-size 0.35 --distance 0.03";
  const auto json = report("hollow.obj -o one.msh" + arguments);
  ASSERT_FALSE(json.is_null());
  EXPECT_NEAR(json["regions"][0]["volume"].get<double>(), 4. / 3 * M_PI * (1 - 0.125), 4 * M_PI * 1.25 * 0.03 + 0.03);
  EXPECT_NEAR(json["regions"][0]["inputVolume"].get<double>(), volumeOf(hollow), 1e-9);
  ASSERT_FALSE(report("hollow.obj -o two.msh" + arguments).is_null());
  EXPECT_EQ(bytes("one.msh"), bytes("two.msh"));
}

TEST_F(MeshCommand, SurfacesThatEncloseNothingAreRefused) {
  Surface open = sphere(10, 20), cut = open, branched = open;
  open.triangles.pop_back();
  const Surface other = sphere(10, 20, Vec3(0.37, 0.11, 0));
  const Index shift = Index(cut.position.size());
  cut.position.insert(cut.position.end(), other.position.begin(), other.position.end());
  for (const auto& [a, b, c] : other.triangles) cut.triangles.push_back({a + shift, b + shift, c + shift});
  branched.position.emplace_back(0, 0, 3);
  branched.triangles.push_back({0, 1, Index(branched.position.size()) - 1});
  write("open.obj", objText(open)), write("cut.obj", objText(cut)), write("branched.obj", objText(branched));
  for (const auto& [input, sentence] :
       std::map<std::string, std::string>{{"open.obj", "the surface is open: 3 of its edges"},
                                          {"cut.obj", "the surface cuts itself"},
                                          {"branched.obj", "the surface branches"},
                                          {"none.stl", "there is no file none.stl"}}) {
    const Finished finished = stroma("mesh " + input + " -o mesh.msh");
    EXPECT_EQ(finished.code, 2) << input;
    EXPECT_NE(finished.err.find(sentence), std::string::npos) << input << ": " << finished.err;
    EXPECT_FALSE(exists("mesh.msh")) << input;
  }
}

}  // namespace
}  // namespace stroma::test
