// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma mesh` on closed surfaces of triangles.
#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "framework/scene/component.h"
#include "tests/meshing/meshing_fixture.h"
#include "tools/mesh/voxels.h"

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
      const Vec3& p = s.position[n];
      text += fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid s\n";
}

double volumeOf(const Surface& s) {
  double volume = 0;
  for (const auto& [a, b, c] : s.triangles) volume += s.position[a].dot(s.position[b].cross(s.position[c])) / 6;
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

/// Two unit balls a unit apart: the cap of each within the other has the height 1/2.
constexpr double two_balls = 2 * 4. / 3 * M_PI - 2 * M_PI * 0.25 * (3 - 0.5) / 3;

Surface joined(Surface first, const Surface& second) {
  const Index shift = Index(first.position.size());
  first.position.insert(first.position.end(), second.position.begin(), second.position.end());
  for (const auto& [a, b, c] : second.triangles) first.triangles.push_back({a + shift, b + shift, c + shift});
  return first;
}

TEST_F(MeshCommand, ASurfaceThatCutsItselfIsFilledWithVoxels) {
  const Surface pair = joined(sphere(40, 80), sphere(40, 80, Vec3(1, 0, 0)));
  write("pair.obj", objText(pair)), write("pair.stl", stlText(pair));
  const Finished refused = stroma("mesh pair.obj -o pair.msh");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--voxels"), std::string::npos) << refused.err;
  for (const char* input : {"pair.obj", "pair.stl"}) {
    ASSERT_FALSE(report(fmt::format("{} -o pair.msh --cell-size 0.35 --voxels 0.05", input)).is_null());
    double angle = 0;
    const auto regions = regionsOf(readGmsh((folder_ / "pair.msh").string()), angle);
    ASSERT_EQ(regions.size(), 1u);
    EXPECT_NEAR(regions.at(1).volume, two_balls, 0.01 * two_balls);
    EXPECT_EQ(regions.at(1).bad_edges, 0);
    EXPECT_GT(angle, 8);
  }
  EXPECT_EQ(stroma("mesh pair.obj -o pair.msh --voxels 0.05 --feature-angle 60").code, 2);
  EXPECT_EQ(stroma("mesh leg.nii -o pair.msh --voxels 0.05").code, 2);
}

TEST(VoxelsInside, FollowTheWindingOfTheSurface) {
  const Surface ball = sphere(40, 80);
  const auto volume = [](const Voxels& v) { return double(v.image.voxels().at(0)) * v.image.voxelVolume(); };
  // voxels at the boundary err one way and the other: far less than a voxel times the area
  const Voxels single = voxelsInside(ball.position, ball.triangles, 0.05);
  EXPECT_NEAR(volume(single), volumeOf(ball), 0.1 * 0.05 * 4 * M_PI);
  EXPECT_EQ(single.covered + single.reversed, 0);

  Surface inward = ball;
  for (Triangle& t : inward.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(voxelsInside(inward.position, inward.triangles, 0.05).image.region, single.image.region);

  const Surface pair = joined(ball, sphere(40, 80, Vec3(1, 0, 0)));
  const Voxels both = voxelsInside(pair.position, pair.triangles, 0.05);
  EXPECT_NEAR(volume(both), two_balls, 0.1 * 0.05 * 8 * M_PI);
  EXPECT_NEAR(double(both.covered) * both.image.voxelVolume(), 2 * volumeOf(ball) - two_balls, 0.1 * 0.05 * 4 * M_PI);
  EXPECT_EQ(both.reversed, 0);

  // a hollow is turned inward; a smaller ball outside turned inward is enclosed the wrong way round
  Surface small = sphere(20, 40);
  for (Vec3& p : small.position) p *= 0.5;
  for (Triangle& t : small.triangles) std::swap(t[0], t[1]);
  const Surface hollow = joined(ball, small);
  EXPECT_NEAR(volume(voxelsInside(hollow.position, hollow.triangles, 0.05)), volumeOf(hollow), 0.1 * 0.05 * 5 * M_PI);
  for (Vec3& p : small.position) p.y() += 3;
  const Surface beside = joined(ball, small);
  const Voxels apart = voxelsInside(beside.position, beside.triangles, 0.05);
  EXPECT_NEAR(volume(apart), volumeOf(ball), 0.1 * 0.05 * 4 * M_PI);
  EXPECT_GT(apart.reversed, 0);
}

/// Lines through edges, corners and along faces: a cube of the grid's own size, however its corners fall on it.
TEST(VoxelsInside, AreExactWhereTheSurfaceLiesInTheGrid) {
  const Surface block = cube();
  for (const int n : {1, 2, 7, 10}) {
    const Voxels v = voxelsInside(block.position, block.triangles, 1. / n);
    EXPECT_EQ(v.image.voxels().at(0), n * n * n) << n;
  }
  // centres of voxels in the planes of faces: on one side or the other, but every line comes out again
  const Surface small = sphere(4, 4);
  EXPECT_GT(voxelsInside(small.position, small.triangles, 2. / 5).image.voxels().at(0), 0);
  EXPECT_GT(voxelsInside(block.position, block.triangles, 2. / 3).image.voxels().at(0), 0);
}

TEST(VoxelsInside, RefuseWhatHasNoInside) {
  const auto sentence = [](const Surface& s, double size) -> std::string {
    try {
      voxelsInside(s.position, s.triangles, size);
    } catch (const ComponentError& error) {
      return error.what();
    }
    return "";
  };
  Surface open = sphere(10, 20), mixed = open;
  open.triangles.pop_back();
  std::swap(mixed.triangles[50][0], mixed.triangles[50][1]);
  EXPECT_NE(sentence(open, 0.02).find("the surface is open, or some of its triangles"), std::string::npos);
  EXPECT_NE(sentence(mixed, 0.02).find("turned inward"), std::string::npos);
  EXPECT_NE(sentence(sphere(10, 20), 1e-4).find("more than 2e9"), std::string::npos);
  Surface dots = joined(sphere(10, 20), sphere(10, 20, Vec3(40, 0, 0)));
  EXPECT_NE(sentence(dots, 30).find("no centre of a voxel"), std::string::npos);
}

/// A real liver, whose surface cuts itself: the size of mesh that the literature uses.
TEST_F(MeshCommand, ALiverIsMeshedFromItsSurface) {
  const std::string surface = STROMA_SHARED_DATA "/meshes/liver-smooth.obj";
  if (!std::filesystem::exists(surface)) GTEST_SKIP() << "there is no " << surface;
  const auto json = report("'" + surface + "' -o liver.msh --scale 0.034 --cell-size 0.0115 --voxels 0.0015");
  ASSERT_FALSE(json.is_null());
  const GmshFile file = readGmsh((folder_ / "liver.msh").string());
  EXPECT_NEAR(double(file.mesh.nodes()), 1240, 60);
  EXPECT_NEAR(double(file.mesh.tetrahedra.size()), 5000, 300);
  double angle = 0;
  const auto regions = regionsOf(file, angle);
  EXPECT_EQ(regions.at(1).bad_edges, 0);
  EXPECT_GT(angle, 8);
  // the volume behind the surface, read here: where it cuts itself it is off by less than a voxel
  Surface liver;
  std::ifstream lines(surface);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, node;
    words >> kind;
    double x = 0, y = 0, z = 0;
    if (kind == "v" && words >> x >> y >> z) liver.position.emplace_back(0.034 * Vec3(x, y, z));
    if (kind != "f") continue;
    std::vector<Index> nodes;
    while (words >> node) nodes.push_back(Index(std::stol(node)) - 1);
    ASSERT_EQ(nodes.size(), 3u);
    liver.triangles.push_back({nodes[0], nodes[1], nodes[2]});
  }
  EXPECT_NEAR(regions.at(1).volume, volumeOf(liver), 0.01 * volumeOf(liver));
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
                                          {"none.stl", "there is no file none.stl"}})
    expectRefused(input, sentence);
}

/// The surface of a box from `low` to `high`; `hollow`: turned inward.
Surface box(const Vec3& low, const Vec3& high, bool hollow) {
  Surface s = cube();
  for (Vec3& p : s.position) p = low + p.cwiseProduct(high - low);
  if (hollow)
    for (auto& [a, b, c] : s.triangles) std::swap(b, c);
  return s;
}

/// The nodes of the triangles of a physical group.
std::set<Index> nodesOfGroup(const GmshFile& file, const std::string& name) {
  std::set<Index> nodes;
  for (std::size_t t = 0; t < file.mesh.triangles.size(); ++t) {
    const auto found = file.group_names.find({2, file.groups.triangles[t]});
    if (found == file.group_names.end() || found->second != name) continue;
    nodes.insert(file.mesh.triangles[t].begin(), file.mesh.triangles[t].end());
  }
  return nodes;
}

/// The edges of the outer box are convex, those of the hollows concave: both are kept, so the volume is that of the boxes
/// and every node of a wall lies in one of its planes. Skin and hollows are groups of their own.
TEST_F(MeshCommand, ABoxInABoxKeepsItsEdgesAndItsCavityIsAGroup) {
  const Surface one = joined(box({0, 0, 0}, {10, 2, 2}, false), box({1, 0.5, 0.5}, {6, 1.5, 1.5}, true)),
                two = joined(one, box({7, 0.5, 0.5}, {9, 1.5, 1.5}, true));
  write("one.obj", objText(one)), write("two.obj", objText(two));
  for (const std::string& size : {std::string("0.5"), std::string("0.3")}) {
    ASSERT_FALSE(report("one.obj -o one.msh --cell-size " + size + " --name 1=finger").is_null());
    const GmshFile file = readGmsh((folder_ / "one.msh").string());
    EXPECT_NEAR(file.mesh.report().volume, 40 - 5, 1e-6 * 35) << size;
    const std::set<Index> skin = nodesOfGroup(file, "finger.outside"), cavity = nodesOfGroup(file, "finger.cavity");
    EXPECT_GT(skin.size(), 20u);
    EXPECT_GT(cavity.size(), 20u);
    for (const Index n : cavity) {
      const Vec3 p = file.mesh.position[n], from = (p - Vec3(1, 0.5, 0.5)).cwiseAbs(),
                 to = (p - Vec3(6, 1.5, 1.5)).cwiseAbs();
      EXPECT_LT(std::min(from.minCoeff(), to.minCoeff()), 1e-6) << p.transpose();
      EXPECT_EQ(skin.count(n), 0u);
    }
  }
  ASSERT_FALSE(report("two.obj -o two.msh --cell-size 0.5 --name 1=finger").is_null());
  const GmshFile file = readGmsh((folder_ / "two.msh").string());
  const auto largestX = [&file](const std::string& name) {
    double largest = 0;
    for (const Index n : nodesOfGroup(file, name)) largest = std::max(largest, file.mesh.position[n].x());
    return largest;
  };
  EXPECT_NEAR(largestX("finger.cavity_1"), 6, 1e-6);
  EXPECT_NEAR(largestX("finger.cavity_2"), 9, 1e-6);
  EXPECT_NEAR(largestX("finger.outside"), 10, 1e-6);
  EXPECT_NEAR(file.mesh.report().volume, 40 - 5 - 2, 1e-6 * 33);
}

}  // namespace
}  // namespace stroma::test
