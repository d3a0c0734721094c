// SPDX-License-Identifier: LGPL-2.1-or-later
// Patch tests: a constant strain is reproduced on any mesh, in any orientation. MacNeal and Harder's cube of seven
// hexahedra, each cut into tetrahedra: E = 1e6, nu = 0.25, u = 1e-3 (2x + y + z)/2 and so on give normal stresses 2000
// and shear stresses 400.
#include <map>
#include <set>
#include <sstream>

#include "framework/mesh/mesh.h"
#include "tests/elasticity/field_under_test.h"

namespace stroma::test {
namespace {

const std::vector<Vec3> inner{{.249, .342, .192}, {.826, .288, .288}, {.850, .649, .263}, {.273, .750, .230},
                              {.320, .186, .643}, {.677, .305, .683}, {.788, .693, .644}, {.165, .745, .702}};

/// The cube in tetrahedra: every hexahedron has a node at its centre and at the centres of its faces, which its
/// neighbour shares, so that the 7 x 24 tetrahedra match. The first 8 nodes are the cube's corners.
struct PatchMesh {
  std::vector<Vec3> position;
  std::string tetrahedra, boundary;
  std::vector<bool> on_boundary;
};

PatchMesh patchMesh() {
  PatchMesh m;
  m.position = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  m.position.insert(m.position.end(), inner.begin(), inner.end());
  const int face[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<std::array<int, 8>> hexes{{8, 9, 10, 11, 12, 13, 14, 15}};
  for (const auto& f : face) hexes.push_back({f[0], f[1], f[2], f[3], f[0] + 8, f[1] + 8, f[2] + 8, f[3] + 8});
  std::map<std::set<int>, int> centre_of;
  const auto centre = [&](const std::set<int>& nodes) {
    if (const auto found = centre_of.find(nodes); found != centre_of.end()) return found->second;
    Vec3 p = Vec3::Zero();
    for (int n : nodes) p += m.position[std::size_t(n)] / double(nodes.size());
    m.position.push_back(p);
    return centre_of[nodes] = int(m.position.size()) - 1;
  };
  for (const auto& h : hexes) {
    const int middle = centre(std::set<int>(h.begin(), h.end()));
    for (const auto& f : face) {
      const int at = centre({h[std::size_t(f[0])], h[std::size_t(f[1])], h[std::size_t(f[2])], h[std::size_t(f[3])]});
      for (int k = 0; k < 4; ++k) {
        int a = h[std::size_t(f[k])], b = h[std::size_t(f[(k + 1) % 4])];
        const auto& p = m.position;
        if (tetrahedronVolume(p[std::size_t(middle)], p[std::size_t(at)], p[std::size_t(a)], p[std::size_t(b)]) < 0)
          std::swap(a, b);
        for (int n : {middle, at, a, b}) m.tetrahedra += std::to_string(n) + " ";
      }
    }
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
std::string patchScene(const std::string& attributes, const Mat3& r, bool solve) {
  const PatchMesh m = patchMesh();
  std::ostringstream rest, current;
  rest.precision(17), current.precision(17);
  for (std::size_t i = 0; i < m.position.size(); ++i) {
    const Vec3& p = m.position[i];
    rest << p.transpose() << " ";
    current << (r * (m.on_boundary[i] || !solve ? Vec3(p + displacementGradient() * p) : p)).transpose() << " ";
  }
  return "<Node name=\"root\" gravity=\"0 0 0\" dt=\"1\"><Node name=\"body\"><StaticSolver/><SparseLDLSolver/>"
         "<TetrahedronSetTopologyContainer position=\"" +
         rest.str() + "\" tetrahedra=\"" + m.tetrahedra +
         "\"/>"
         "<MechanicalObject position=\"" +
         current.str() + "\" rest_position=\"" + rest.str() +
         "\"/><UniformMass totalMass=\"1\"/>"
         "<TetrahedronFEMForceField youngModulus=\"1e6\" poissonRatio=\"0.25\" " +
         attributes +
         "/>"
         "<FixedProjectiveConstraint indices=\"" +
         m.boundary + "\"/></Node></Node>";
}

TEST(PatchTest, SolvedAndTurned) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.7).normalized()).toRotationMatrix();
  for (const Variant& variant : bodyOfTetrahedra().variants()) {
    if (variant.name == "nodal") continue;  // ghost forces: no patch test
    for (const Mat3& r : {Mat3(Mat3::Identity()), turn}) {
      const bool turned = !r.isIdentity();
      if (turned && variant.name.rfind("small", 0) == 0) continue;
      SCOPED_TRACE(variant.name + (turned ? " turned" : ""));
      FieldUnderTest t(patchScene(variant.attributes, r, true), "TetrahedronFEMForceField");
      for (int step = 0; step < 3; ++step) ASSERT_FALSE(t.simulation().step().diverged);
      const State& state = t.field().state();
      const Mat3 gradient = displacementGradient();
      // a QR frame depends on the order of the vertices: equal strains give stresses that differ by the square of the
      // strain
      const double tolerance = variant.name.rfind("large", 0) == 0 ? 1e-6 : 1e-10;
      for (Index i = 8; i < state.size(); ++i) {
        const Vec3 p = state.rest_position[std::size_t(i)];
        EXPECT_LT((Vec3(state.x()[i]) - r * (p + gradient * p)).norm(), tolerance) << "node " << i;
      }
      std::vector<double> strain;
      t.field().cellField("strain", state.x(), strain);
      const double mu = 1e6 / 2.5, lambda = 1e6 * 0.25 / (1.25 * 0.5);
      for (std::size_t e = 0; e < strain.size() / 6; ++e) {
        const double* s = &strain[6 * e];
        const double trace = s[0] + s[1] + s[2];
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(2 * mu * s[k] + lambda * trace, 2000, 2) << e;  // strain 1e-3: quadratic terms of 0.1 %
          EXPECT_NEAR(2 * mu * s[3 + k], 400, 2) << e;
        }
      }
    }
  }
}

TEST(PatchTest, LinearMethodIsExact) {
  FieldUnderTest t(patchScene("method=\"small\"", Mat3::Identity(), false), "TetrahedronFEMForceField");
  const State& state = t.field().state();
  std::vector<double> strain;
  t.field().cellField("strain", state.x(), strain);
  ASSERT_EQ(strain.size(), 6u * 168);
  for (std::size_t i = 0; i < strain.size(); ++i) EXPECT_NEAR(strain[i], i % 6 < 3 ? 1e-3 : 0.5e-3, 1e-14);
  copy(t.system().x, t.x);
  const Vector f = t.force();
  for (Index i = 8; i < 16; ++i) EXPECT_LT(f[i].norm(), 1e-9) << "an inner node is not in equilibrium";
  EXPECT_GT(f[0].norm(), 10);
}

}  // namespace
}  // namespace stroma::test
