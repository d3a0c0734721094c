// SPDX-License-Identifier: LGPL-2.1-or-later
// Patch tests: a constant strain is reproduced on any mesh, in any orientation. MacNeal and Harder's cube of seven
// distorted hexahedra, as it is or each cut into tetrahedra: E = 1e6, nu = 0.25, u = 1e-3 (2x + y + z)/2 and so on give
// normal stresses 2000 and shear stresses 400.
#include <map>
#include <set>
#include <sstream>

#include "framework/mesh/mesh.h"
#include "framework/mesh/simplex_size.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::vector<Vec3> inner{{.249, .342, .192}, {.826, .288, .288}, {.850, .649, .263}, {.273, .750, .230},
                              {.320, .186, .643}, {.677, .305, .683}, {.788, .693, .644}, {.165, .745, .702}};

/// The first 8 nodes are the cube's corners, the next 8 the corners of the hexahedron inside.
struct PatchMesh {
  std::vector<Vec3> position;
  std::string container, cells, boundary;  ///< the topology's type and attribute; numbers of the nodes on the surface
  std::vector<bool> on_boundary;
};

constexpr int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Every hexahedron has a node at its centre and at the centres of its faces, which its neighbour shares, so that the
/// 7 x 24 tetrahedra match.
std::string cutIntoTetrahedra(const std::vector<std::array<int, 8>>& hexahedra, std::vector<Vec3>& position) {
  std::string tetrahedra;
  std::map<std::set<int>, int> centre_of;
  const auto centre = [&](const std::set<int>& nodes) {
    if (const auto found = centre_of.find(nodes); found != centre_of.end()) return found->second;
    Vec3 p = Vec3::Zero();
    for (int n : nodes) p += position[n] / double(nodes.size());
    position.push_back(p);
    return centre_of[nodes] = int(position.size()) - 1;
  };
  for (const auto& h : hexahedra) {
    const int middle = centre(std::set<int>(h.begin(), h.end()));
    for (const auto& f : faces) {
      const int at = centre({h[f[0]], h[f[1]], h[f[2]], h[f[3]]});
      for (int k = 0; k < 4; ++k) {
        int a = h[f[k]], b = h[std::size_t(f[(k + 1) % 4])];
        const auto& p = position;
        if (tetrahedronVolume(p[middle], p[at], p[a], p[b]) < 0) std::swap(a, b);
        for (int n : {middle, at, a, b}) tetrahedra += std::to_string(n) + " ";
      }
    }
  }
  return tetrahedra;
}

PatchMesh patchMesh(bool in_tetrahedra) {
  PatchMesh m;
  m.position = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  m.position.insert(m.position.end(), inner.begin(), inner.end());
  std::vector<std::array<int, 8>> hexahedra{{8, 9, 10, 11, 12, 13, 14, 15}};
  // a face of the cube and, towards the inside, that of the inner hexahedron
  for (const auto& f : faces) hexahedra.push_back({f[3], f[2], f[1], f[0], f[3] + 8, f[2] + 8, f[1] + 8, f[0] + 8});
  if (in_tetrahedra) {
    m.container = "Tetrahedron", m.cells = "tetrahedra=\"" + cutIntoTetrahedra(hexahedra, m.position) + "\"";
  } else {
    m.container = "Hexahedron", m.cells = "hexahedra=\"";
    for (const auto& h : hexahedra)
      for (int n : h) m.cells += std::to_string(n) + " ";
    m.cells += "\"";
  }
  for (std::size_t i = 0; i < m.position.size(); ++i) {
    const Vec3& p = m.position[i];
    m.on_boundary.push_back(p.minCoeff() < 1e-12 || p.maxCoeff() > 1 - 1e-12);
    if (m.on_boundary.back()) m.boundary += std::to_string(i) + " ";
  }
  return m;
}

Mat3 displacementGradient() {
  Mat3 g;
  g << 2, 1, 1, 1, 2, 1, 1, 1, 2;
  return 0.5e-3 * g;
}

/// The boundary takes the linear field turned by r; inner nodes start turned only when they are to be solved for.
std::string patchScene(const ElasticBody& body, const std::string& attributes, const Mat3& r, bool solve) {
  const PatchMesh m = patchMesh(body.tetrahedra);
  std::ostringstream rest, current;
  rest.precision(17), current.precision(17);
  for (std::size_t i = 0; i < m.position.size(); ++i) {
    const Vec3& p = m.position[i];
    rest << p.transpose() << " ";
    current << (r * (m.on_boundary[i] || !solve ? Vec3(p + displacementGradient() * p) : p)).transpose() << " ";
  }
  return "<Node name=\"root\" gravity=\"0 0 0\" dt=\"1\"><Node name=\"body\"><StaticSolver/><SparseLDLSolver/><" +
         m.container + "SetTopologyContainer position=\"" + rest.str() + "\" " + m.cells +
         "/><MechanicalObject position=\"" + current.str() + "\" rest_position=\"" + rest.str() +
         "\"/><UniformMass totalMass=\"1\"/><" + body.type + " youngModulus=\"1e6\" poissonRatio=\"0.25\" " +
         attributes + "/><FixedProjectiveConstraint indices=\"" + m.boundary + "\"/></Node></Node>";
}

/// The bodies of each kind of cell.
const ElasticBody& tetrahedra = elasticBodies()[0];
const ElasticBody& hexahedra = elasticBodies()[2];

/// Solves for the inner nodes, and compares them and the stresses of all cells.
void checkSolution(const ElasticBody& body, const Variant& variant, const Mat3& r) {
  FieldUnderTest t(patchScene(body, variant.attributes, r, true), body.type);
  for (int step = 0; step < 3; ++step) ASSERT_FALSE(t.simulation().step().diverged);
  const State& state = t.field().state();
  const Mat3 gradient = displacementGradient();
  // a QR frame depends on the order of the vertices: equal strains give stresses that differ by the square of the
  // strain, of which the largest is 2e-3
  const double tolerance = variant.is("large") ? 4e-6 : 1e-10;
  for (Index i = 8; i < state.size(); ++i) {
    const Vec3 p = state.rest_position[i];
    EXPECT_LT((Vec3(state.x()[i]) - r * (p + gradient * p)).norm(), tolerance) << "node " << i;
  }
  std::vector<double> strain;
  t.field().cellField("strain", state.x(), strain);
  ASSERT_EQ(strain.size(), 6u * (body.tetrahedra ? 168 : 7));
  const double quadratic = variant.is("large") ? 2.5 : 2;  // [Pa]: strain 1e-3, squared; QR frames turn a little more
  const double mu = 1e6 / 2.5, lambda = 1e6 * 0.25 / (1.25 * 0.5);
  for (std::size_t e = 0; e < strain.size() / 6; ++e) {
    const double* s = &strain[6 * e];
    const double trace = s[0] + s[1] + s[2];
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(2 * mu * s[k] + lambda * trace, 2000, quadratic) << e;
      EXPECT_NEAR(2 * mu * s[3 + k], 400, quadratic) << e;
    }
  }
}

TEST(PatchTest, SolvedAndTurned) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond any(normal(random), normal(random), normal(random), normal(random));
  const Mat3 turn = any.normalized().toRotationMatrix();
  for (const ElasticBody* body : {&tetrahedra, &hexahedra})
    for (const Variant& variant : body->variants()) {
      if (variant.is("nodal")) continue;  // ghost forces: no patch test
      for (const Mat3& r : {Mat3(Mat3::Identity()), turn}) {
        const bool turned = !r.isIdentity();
        if (turned && variant.is("small")) continue;
        SCOPED_TRACE(body->name + " " + variant.name + (turned ? " turned" : ""));
        checkSolution(*body, variant, r);
      }
    }
}

/// What fails by construction is said when the scene is loaded, and so by `stroma check`.
TEST(PatchTest, AMethodThatFailsItSaysSo) {
  for (const ElasticBody& body : elasticBodies()) {
    const auto told = [&body](const std::string& attributes) {
      return sceneFromText(body.scene(attributes)).diagnostics.text();
    };
    EXPECT_EQ(told("method='svd'"), "");
    if (body.quadratic) continue;  // whose frames are those of the scene's axes: it passes
    expectContains(told("method='large'"), "fails the patch test");
    expectContains(told("method='large'"), "turn a free body");
    expectContains(told("method='large' updateStiffnessMatrix='true'"), "fails the patch test");
    EXPECT_EQ(told("method='large' updateStiffnessMatrix='true'").find("turn a free body"), std::string::npos);
  }
}

TEST(PatchTest, LinearMethodIsExact) {
  for (const ElasticBody* body : {&tetrahedra, &hexahedra}) {
    SCOPED_TRACE(body->name);
    FieldUnderTest t(patchScene(*body, "method=\"small\"", Mat3::Identity(), false), body->type);
    const State& state = t.field().state();
    std::vector<double> strain;
    t.field().cellField("strain", state.x(), strain);
    ASSERT_EQ(strain.size(), 6u * (body->tetrahedra ? 168 : 7));
    for (std::size_t i = 0; i < strain.size(); ++i) EXPECT_NEAR(strain[i], i % 6 < 3 ? 1e-3 : 0.5e-3, 1e-14);
    copy(t.system().x, t.x);
    const Vector f = t.force();
    for (Index i = 8; i < 16; ++i) EXPECT_LT(f[i].norm(), 1e-9) << "an inner node is not in equilibrium";
    EXPECT_GT(f[0].norm(), 10);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
