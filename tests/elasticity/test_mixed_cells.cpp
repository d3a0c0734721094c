// SPDX-License-Identifier: LGPL-2.1-or-later
// Prisms and pyramids: alone, and in one mesh with tetrahedra and hexahedra.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "framework/mechanics/mass.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/topology.h"
#include "tests/support/field_derivatives.h"

namespace stroma::test {
namespace {

std::string words(const std::vector<Vec3>& list) {
  std::string text;
  for (const Vec3& p : list) text += fmt::format("{:.17g} {:.17g} {:.17g} ", p.x(), p.y(), p.z());
  return text;
}

/// Attributes of a topology.
std::string textOf(const Mesh& mesh) {
  std::string text = fmt::format("position='{}'", words(mesh.position));
  forEachCellList(
      [&text](const CellKind& kind, const auto& cells) {
        if (cells.empty()) return;
        text += fmt::format(" {}='", kind.plural);
        for (const auto& cell : cells)
          for (const Index node : cell) text += fmt::format("{} ", node);
        text += "'";
      },
      mesh);
  return text;
}

const std::vector<std::string> kind_words{"Tetrahedron", "Hexahedron", "Prism", "Pyramid"};

/// MacNeal and Harder's cube. Of the six hexahedra between the cube and the one inside two are cut into prisms; the one inside is
/// cut around its centre into pyramids, and into two tetrahedra each where prisms meet it.
Mesh mixedCube() {
  constexpr std::array<std::array<Index, 4>, 6> faces{
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  Mesh mesh;
  mesh.position = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1},
                   {.249, .342, .192}, {.826, .288, .288}, {.850, .649, .263}, {.273, .750, .230},
                   {.320, .186, .643}, {.677, .305, .683}, {.788, .693, .644}, {.165, .745, .702}, {.5, .48, .47}};
  constexpr Index centre = 16;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [a, b, c, d] = faces[f];
    const Hexahedron h{d, c, b, a, d + 8, c + 8, b + 8, a + 8};
    if (f < 2) {
      mesh.prisms.push_back({h[0], h[1], h[2], h[4], h[5], h[6]});
      mesh.prisms.push_back({h[0], h[2], h[3], h[4], h[6], h[7]});
      mesh.tetrahedra.push_back({h[4], h[5], h[6], centre}), mesh.tetrahedra.push_back({h[4], h[6], h[7], centre});
    } else {
      mesh.hexahedra.push_back(h);
      mesh.pyramids.push_back({h[4], h[5], h[6], h[7], centre});
    }
  }
  return mesh;
}

bool isOnCube(const Vec3& p) { return p.minCoeff() < 1e-12 || p.maxCoeff() > 1 - 1e-12; }

Mat3 displacementGradient() {
  Mat3 g;
  g << 2, 1, 1, 1, 2, 1, 1, 1, 2;
  return 0.5e-3 * g;
}

/// One force field for each kind of cell.
std::string fieldsOf(const std::string& type, const std::string& attributes) {
  std::string text;
  for (const std::string& word : kind_words)
    text += fmt::format("<{} name='of{}' template='Vec3,{}' {}/>", type, word, word, attributes);
  return text;
}

TEST(MixedCells, FillTheCubeWithOneBoundary) {
  const Mesh mesh = mixedCube();
  EXPECT_EQ(mesh.firstError(), "");
  const MeshReport report = mesh.report();
  EXPECT_EQ(report.prisms, 4);
  EXPECT_EQ(report.pyramids, 4);
  EXPECT_TRUE(report.inverted.empty() && report.flat.empty());
  EXPECT_NEAR(report.volume, 1, 1e-14);
  // four triangles of prisms and four quads of hexahedra, turned outward: Gauss's theorem
  EXPECT_EQ(mesh.boundaryTriangles().size(), 4u);
  EXPECT_EQ(mesh.boundaryQuads().size(), 4u);
  double flux = 0;
  const auto add = [&](Index a, Index b, Index c) {
    flux += mesh.position[std::size_t(a)].dot(mesh.position[std::size_t(b)].cross(mesh.position[std::size_t(c)])) / 6;
  };
  for (const auto& [a, b, c] : mesh.boundaryTriangles()) add(a, b, c);
  for (const auto& [a, b, c, d] : mesh.boundaryQuads()) add(a, b, c), add(a, c, d);
  EXPECT_NEAR(flux, 1, 1e-14);
}

TEST(MixedCells, PassThePatchTest) {
  const Mesh mesh = mixedCube();
  const Mat3 gradient = displacementGradient(), turn = Eigen::AngleAxisd(2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const std::vector<std::pair<std::string, std::string>> ways{
      {"LinearSmallStrainFEMForceField", ""}, {"CorotationalFEMForceField", "method='small'"},
      {"CorotationalFEMForceField", "method='polar'"}, {"CorotationalFEMForceField", "method='svd'"},
      {"CorotationalFEMForceField", "method='svd' tangent='exact'"}, {"CorotationalFEMForceField", "method='polar' polarOf='nodes'"},
      {"CorotationalFEMForceField", "method='green'"}};
  for (const auto& [type, attributes] : ways)
    for (const Mat3& r : {Mat3(Mat3::Identity()), turn}) {
      const bool small = attributes.empty() || attributes == "method='small'";
      if (small && !r.isIdentity()) continue;
      SCOPED_TRACE(type + " " + attributes + (r.isIdentity() ? "" : " turned"));
      std::vector<Vec3> current;
      std::string held;
      for (std::size_t n = 0; n < mesh.position.size(); ++n) {
        const Vec3& p = mesh.position[n];
        current.push_back(r * (isOnCube(p) ? Vec3(p + gradient * p) : p));
        if (isOnCube(p)) held += fmt::format("{} ", n);
      }
      Simulation simulation = simulationFromText(
          "<Node name='root' gravity='0 0 0' dt='1'><StaticSolver/><SparseLDLSolver/><MeshTopology " + textOf(mesh) +
          "/><MechanicalObject position='" + words(current) + "' rest_position='" + words(mesh.position) +
          "'/><UniformMass totalMass='1'/>" + fieldsOf(type, attributes + " youngModulus='1e6' poissonRatio='0.25'") +
          "<FixedProjectiveConstraint indices='" + held + "'/></Node>");
      for (int step = 0; step < 3; ++step) ASSERT_FALSE(simulation.step().diverged);
      const System& system = *simulation.systems()[0];
      // the polar factor of the nodes' sum is not quite that of F, but for regular cells: it is off by squares of the strain
      const double tolerance = attributes.find("nodes") == std::string::npos ? 1e-10 : 4e-6;
      for (Index n = 8; n < system.allRows(); ++n) {
        const Vec3& p = mesh.position[std::size_t(n)];
        EXPECT_LT((Vec3(system.x[n]) - r * (p + gradient * p)).norm(), tolerance) << n;
      }
      ASSERT_EQ(system.forceFields().size(), 4u);
      for (const ForceField* field : system.forceFields()) {
        std::vector<double> strain;
        field->cellField("strain", system.x, strain);
        ASSERT_EQ(strain.size(), 24u) << field->path();
        const double squared = 5e-6;  // Green's strain, and a polar factor, differ by the square of 2e-3
        for (std::size_t i = 0; i < strain.size(); ++i)
          EXPECT_NEAR(strain[i], i % 6 < 3 ? 1e-3 : 0.5e-3, small ? 1e-12 : squared) << field->path() << " " << i;
      }
    }
}

/// Distorted prisms or pyramids of hexahedra.
Mesh cutBlock(bool prisms) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.15, 0.15);
  Mesh mesh;
  const std::array<int, 3> n{4, 3, 3};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        mesh.position.push_back(Vec3(0.02, 0.015, 0.03).cwiseProduct(Vec3(i + noise(random), j + noise(random), k + noise(random))));
  for (int k = 0; k + 1 < n[2]; ++k)
    for (int j = 0; j + 1 < n[1]; ++j)
      for (int i = 0; i + 1 < n[0]; ++i) {
        const Index first = (k * n[1] + j) * n[0] + i, row = n[0], layer = n[0] * n[1];
        const Hexahedron h{first, first + 1, first + row + 1, first + row, first + layer, first + layer + 1,
                           first + layer + row + 1, first + layer + row};
        if (prisms) {
          mesh.prisms.push_back({h[0], h[1], h[2], h[4], h[5], h[6]}), mesh.prisms.push_back({h[0], h[2], h[3], h[4], h[6], h[7]});
          continue;
        }
        Vec3 centre = Vec3::Zero();
        for (const Index node : h) centre += mesh.position[std::size_t(node)] / 8;
        const Index top = mesh.nodes();
        mesh.position.push_back(centre);
        for (const LocalFace& face : cell_kinds::hexahedron.faces)
          mesh.pyramids.push_back({h[std::size_t(face.nodes[3])], h[std::size_t(face.nodes[2])], h[std::size_t(face.nodes[1])],
                                   h[std::size_t(face.nodes[0])], top});
      }
  return mesh;
}

std::string blockScene(const Mesh& mesh, const std::string& attributes, const std::string& more = "") {
  return "<Node name='root' dt='0.01'><Node name='body'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology name='mesh' " +
         textOf(mesh) + "/><MechanicalObject/><UniformMass totalMass='1'/><CorotationalFEMForceField youngModulus='3000' "
         "poissonRatio='0.4' " + attributes + "/>" + more + "</Node></Node>";
}

/// What the contract of force fields asks, for each method.
TEST(PrismsAndPyramids, KeepTheContract) {
  for (const bool prisms : {true, false})
    for (const std::string method : {"small", "large", "polar", "svd", "green", "nodes"})
      for (const std::string more : {"", " tangent='exact'", " dilatation='mean'", " tangent='exact' dilatation='mean'"}) {
        if (method == "nodes" && !more.empty()) continue;
        const std::string way = method == "nodes" ? "method='polar' polarOf='nodes' dilatation='local'" : "method='" + method + "'" + more;
        SCOPED_TRACE((prisms ? "prisms " : "pyramids ") + way);
        FieldUnderTest t(blockScene(cutBlock(prisms), way), "CorotationalFEMForceField");
        const ForceTraits traits = t.field().traits();
        t.deform(0.03);
        const Vector f = t.force();
        const double scale = std::sqrt(dot(f, f)), step = 1e-6 * t.typicalEdge();
        ASSERT_GT(scale, 0);
        EXPECT_LT(momentumOf(t.x, f).force, 1e-12);
        EXPECT_EQ(traits.conservative, method == "small" || method == "svd" || method == "green");
        if (method == "svd" || method == "green") {
          EXPECT_TRUE(traits.torques_balance);
          EXPECT_LT(momentumOf(t.x, f).torque, 1e-12);
        }
        if (traits.conservative) expectForceOfEnergy(t, f);
        const double error = relativeDifference(t.product(t.direction), t.differenceOfForces(step));
        EXPECT_LT(error, traits.exact_tangent ? 1e-6 : 0.3);
        expectMatrixOfProducts(t);
        if (traits.symmetric) expectSymmetricProducts(t);
        t.rest();
        const Vector still = t.force();
        EXPECT_LT(std::sqrt(dot(still, still)), 1e-11 * scale) << "force at rest";
        if (method == "small") continue;
        t.moveRigidly();
        const Vector moved = t.force();
        EXPECT_LT(std::sqrt(dot(moved, moved)), 1e-10 * scale) << "force of a rigid motion";
      }
}

/// Six motions without a force, and no more: the points see every strain of a cell.
TEST(PrismsAndPyramids, HaveSixRigidModes) {
  for (const bool prisms : {true, false}) {
    Mesh one = cutBlock(prisms);
    if (prisms)
      one.prisms.resize(1);
    else
      one.pyramids.resize(1);
    std::vector<Index> nodes;
    if (prisms)
      nodes.assign(one.prisms[0].begin(), one.prisms[0].end()), one.prisms[0] = {0, 1, 2, 3, 4, 5};
    else
      nodes.assign(one.pyramids[0].begin(), one.pyramids[0].end()), one.pyramids[0] = {0, 1, 2, 3, 4};
    std::vector<Vec3> position;
    for (const Index node : nodes) position.push_back(one.position[std::size_t(node)]);
    one.position = position;
    FieldUnderTest t(blockScene(one, "method='small'"), "CorotationalFEMForceField");
    const Eigen::Index size = 3 * Eigen::Index(nodes.size());
    Eigen::MatrixXd k(size, size);
    for (Eigen::Index column = 0; column < size; ++column) {
      Vector unit(t.x.count());
      unit.rows().data[std::size_t(column / 3) * row_doubles + std::size_t(column % 3)] = 1;
      const Vector product = t.product(unit);
      for (Eigen::Index row = 0; row < size; ++row) k(row, column) = Vec3(product[Index(row / 3)])[row % 3];
    }
    const Eigen::VectorXd values = (-k).selfadjointView<Eigen::Lower>().eigenvalues();
    for (Eigen::Index i = 0; i < size; ++i) {
      if (i < 6)
        EXPECT_LT(std::abs(values[i]), 1e-12 * values[size - 1]) << i;
      else
        EXPECT_GT(values[i], 1e-4 * values[size - 1]) << i;
    }
  }
}

/// A cantilever under its weight, its tip: hexahedra, or each cut into two prisms.
double sag(bool prisms, int finer) {
  const std::array<int, 3> n{8 * finer + 1, 2 * finer + 1, 2 * finer + 1};
  Mesh mesh;
  std::string held;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        if (i == 0) held += fmt::format("{} ", mesh.nodes());
        mesh.position.emplace_back(0.4 * i / (n[0] - 1), 0.1 * j / (n[1] - 1), 0.1 * k / (n[2] - 1));
        if (i + 1 == n[0] || j + 1 == n[1] || k + 1 == n[2]) continue;
        const Index a = (k * n[1] + j) * n[0] + i, row = n[0], up = n[0] * n[1];
        if (prisms)
          mesh.prisms.push_back({a, a + 1, a + row + 1, a + up, a + up + 1, a + up + row + 1}),
              mesh.prisms.push_back({a, a + row + 1, a + row, a + up, a + up + row + 1, a + up + row});
        else
          mesh.hexahedra.push_back({a, a + 1, a + row + 1, a + row, a + up, a + up + 1, a + up + row + 1, a + up + row});
      }
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='1' gravity='0 -1 0'><StaticSolver/><SparseLDLSolver/><MeshTopology " + textOf(mesh) +
      "/><MechanicalObject/><MeshMatrixMass massDensity='1000'/><LinearSmallStrainFEMForceField youngModulus='1e6' "
      "poissonRatio='0.3' dilatation='local'/><FixedProjectiveConstraint indices='" + held + "'/></Node>");
  simulation.step();
  const System& system = *simulation.systems()[0];
  const Index tip = n[0] - 1;
  return 0.0 - (system.x[tip].y() - mesh.position[std::size_t(tip)].y());
}

/// The two extrapolated limits (errors of second order) agree within what is extrapolated. Prisms are stiffer: their strain in the
/// plane of the triangle is constant.
TEST(PrismsAndPyramids, ACantileverOfPrismsConvergesToThatOfHexahedra) {
  double fine[2], more[2];
  for (const bool prisms : {false, true}) {
    const double coarse = sag(prisms, 2);
    fine[prisms] = sag(prisms, 4), more[prisms] = (fine[prisms] - coarse) / 3;
    EXPECT_GT(more[prisms], 0) << "from below";
  }
  EXPECT_NEAR(fine[1] + more[1], fine[0] + more[0], more[0] + more[1]);
  EXPECT_LT(fine[1], fine[0]);
}

TEST(PrismsAndPyramids, CarryTheMassOfTheirVolume) {
  const Mesh mesh = mixedCube();
  for (const std::string mass : {"MeshMatrixMass massDensity='1000'", "DiagonalMass massDensity='1000'", "UniformMass totalMass='1000'"}) {
    SCOPED_TRACE(mass);
    Simulation simulation = simulationFromText("<Node name='root' dt='1e-3' gravity='0 0 -1'><EulerImplicitSolver/><SparseLDLSolver/>"
                                               "<MeshTopology " + textOf(mesh) + "/><MechanicalObject/><" + mass + "/></Node>");
    double sum = 0;
    for (const double m : simulation.systems()[0]->masses()[0]->lumped()) sum += m;
    EXPECT_NEAR(sum, 1000, 1e-9);
    simulation.step();
    for (Index n = 0; n < simulation.systems()[0]->allRows(); ++n)
      EXPECT_NEAR(simulation.systems()[0]->v[n].z(), -1e-3, 1e-9) << "all nodes fall alike: M a = M g";
  }
  for (const bool prisms : {true, false}) {
    const Mesh block = cutBlock(prisms);
    Simulation simulation = simulationFromText("<Node name='root' dt='1e-3'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology " +
                                               textOf(block) + "/><MechanicalObject/><NodalMassDensity property='1000'/>"
                                               "<FEMMass template='Vec3," + (prisms ? "Prism" : "Pyramid") + "'/></Node>");
    double sum = 0;
    for (const double m : simulation.systems()[0]->masses()[0]->lumped()) sum += m;
    EXPECT_NEAR(sum, 1000 * block.report().volume, 1e-14) << "[kg]";
  }
}

TEST(PrismsAndPyramids, CarryPointsThatFollowALinearMotion) {
  const Mesh mesh = mixedCube();
  std::vector<Vec3> points;
  for (double x = 0.05; x < 1; x += 0.1)
    for (double y = 0.05; y < 1; y += 0.1)
      for (double z = 0.05; z < 1; z += 0.1) points.emplace_back(x, y, z);
  Simulation simulation = simulationFromText(
      "<Node name='root' dt='1' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology name='mesh' " + textOf(mesh) +
      "/><MechanicalObject name='body'/><UniformMass totalMass='1'/><Node name='inside'><MechanicalObject name='points' position='" +
      words(points) + "'/><BarycentricMapping/></Node></Node>");
  EXPECT_EQ(simulation.diagnostics().text().find("outside"), std::string::npos) << simulation.diagnostics().text();
  Mat3 f = Mat3::Identity() + 100 * displacementGradient();
  f(0, 1) += 0.3;
  System& system = *simulation.systems()[0];
  for (std::size_t n = 0; n < mesh.position.size(); ++n) system.x[Index(n)] = f * mesh.position[n];
  system.applyMappings();
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((Vec3(system.x[Index(mesh.position.size() + i)]) - f * points[i]).norm(), 1e-12) << i;
}

TEST(PrismsAndPyramids, AreRefusedAsOtherCells) {
  const auto problem = [](Mesh mesh, const std::string& attributes) { return problemsOf(blockScene(mesh, attributes)); };
  for (const bool prisms : {true, false}) {
    Mesh flat = cutBlock(prisms);
    for (Vec3& p : flat.position) p.z() = 0;
    expectContains(problem(flat, ""), prisms ? "prism 0 (nodes" : "pyramid 0 (nodes");
    expectContains(problem(flat, ""), "is flat or folded at rest");
    expectContains(problem(cutBlock(prisms), "method='nodal'"), prisms ? "does not exist for a prism" : "does not exist for a pyramid");
    expectContains(problem(cutBlock(prisms), "updateStiffnessMatrix='true'"), "updateStiffnessMatrix does not exist for a");
    expectContains(problem(cutBlock(prisms), "template='Vec3,Tetrahedron'"), "holds no tetrahedra");
  }
  expectContains(problem(mixedCube(), ""), "one force field for each kind of cell");
}

}  // namespace
}  // namespace stroma::test
