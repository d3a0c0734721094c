// SPDX-License-Identifier: LGPL-2.1-or-later
// Masses against closed forms: a box of sides a, b, c and density rho has the mass rho a b c, its centre in the middle,
// and turning about the z axis through its corner the energy 1/2 w^2 m (a^2 + b^2) / 3.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string body(const std::string& mesh, const std::string& mass, const std::string& state = "") {
  return fmt::format(R"(<Node name="root" gravity="0 -10 1"><TestIntegrator/><TestMesh name="mesh" {}/>
    <MechanicalObject name="dofs" {}/>{}</Node>)",
                     mesh, state, mass);
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (double value : values) total += value;
  return total;
}

Vec3 centre(const System& system) {
  Vec3 moment = Vec3::Zero();
  const auto& mass = system.masses()[0]->lumped();
  for (std::size_t i = 0; i < mass.size(); ++i) moment += mass[i] * system.x[Index(i)];
  return moment / sum(mass);
}

double turningEnergy(System& system, double omega) {
  for (Index i = 0; i < system.allRows(); ++i) system.v[i] = Vec3(0, 0, omega).cross(Vec3(system.x[i]));
  return system.kineticEnergy();
}

class Boxes : public testing::TestWithParam<std::string> {};

TEST_P(Boxes, HaveTheMassTheCentreAndTheWeightOfABox) {
  for (const std::string type : {"DiagonalMass", "MeshMatrixMass"}) {
    Simulation simulation(sceneFromText(
        body("cells='4 3 2' size='0.4 0.2 0.1' " + GetParam(), "<" + type + " name='mass' massDensity='1000'/>")));
    System& system = *simulation.systems()[0];
    EXPECT_NEAR(system.masses()[0]->totalMass(), 8.0, 1e-12);
    EXPECT_NEAR((centre(system) - Vec3(0.2, 0.1, 0.05)).norm(), 0, 1e-14);
    system.computeForce(system.x, system.v, system.f);
    Vec3 weight = Vec3::Zero();
    for (Index i = 0; i < system.allRows(); ++i) weight += system.f[i];
    EXPECT_NEAR((weight - 8 * Vec3(0, -10, 1)).norm(), 0, 1e-12);
    EXPECT_NEAR(system.gravityEnergy(system.x), -8 * Vec3(0, -10, 1).dot(Vec3(0.2, 0.1, 0.05)), 1e-12);
  }
}

TEST_P(Boxes, TurnWithTheEnergyOfARigidBody) {
  const std::string mesh = "cells='3 2 2' size='0.4 0.2 0.1' " + GetParam();
  const double omega = 3, exact = 0.5 * omega * omega * 8 * (0.16 + 0.04) / 3;
  Simulation consistent(sceneFromText(body(mesh, "<MeshMatrixMass massDensity='1000'/>")));
  EXPECT_NEAR(turningEnergy(*consistent.systems()[0], omega), exact, 1e-13 * exact);
  // lumping moves mass away from the middle of cells: more energy, by the second order of the cell size
  Simulation lumped(sceneFromText(body(mesh, "<DiagonalMass massDensity='1000'/>")));
  const double error = turningEnergy(*lumped.systems()[0], omega) / exact - 1;
  EXPECT_GT(error, 0.02);
  EXPECT_LT(error, 0.2);
}

TEST_P(Boxes, LumpingIsTheDiagonalMass) {
  const std::string mesh = "cells='3 2 2' size='1 2 3' " + GetParam();
  Simulation a(sceneFromText(body(mesh, "<MeshMatrixMass massDensity='7' lumping='true'/>")));
  Simulation b(sceneFromText(body(mesh, "<DiagonalMass massDensity='7'/>")));
  const Mass &lumped = *a.systems()[0]->masses()[0], &diagonal = *b.systems()[0]->masses()[0];
  EXPECT_TRUE(lumped.isDiagonal());
  for (std::size_t i = 0; i < lumped.lumped().size(); ++i) EXPECT_NEAR(lumped.lumped()[i], diagonal.lumped()[i], 1e-13);
  EXPECT_GT(diagonal.lumped()[0], 0.1);
}

TEST_P(Boxes, ProductsAreTheAssembledMatrix) {
  Simulation simulation(
      sceneFromText(body("cells='2 2 2' size='1 2 3' " + GetParam(), "<MeshMatrixMass massDensity='7'/>")));
  System& system = *simulation.systems()[0];
  const Mass& mass = *system.masses()[0];
  EXPECT_FALSE(mass.isDiagonal());
  std::vector<double> blocks;
  system.matrix()
      .withFactors({.mass = 2, .stiffness = 0})
      .diagonalBlocks(blocks);  // before there is a matrix to take them from
  const BlockMatrix& matrix = system.matrix().assemble();
  Vector p(system.independentRows()), product(system.independentRows()), assembled(system.independentRows());
  for (Index i = 0; i < system.independentRows(); ++i) p[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(2 + 5 * i));
  system.matrix().multiply(p, product);
  matrix.multiply(p, assembled);
  axpy(-1, product, assembled);
  EXPECT_GT(std::sqrt(dot(product, product)), 1);
  EXPECT_LT(std::sqrt(dot(assembled, assembled)), 1e-13 * std::sqrt(dot(product, product)));
  for (Index i = 0; i < system.independentRows(); ++i)
    for (std::size_t c = 0; c < 9; ++c)
      EXPECT_NEAR(blocks[std::size_t(i) * 9 + c], matrix.values()[std::size_t(matrix.diagonal()[i]) * 9 + c], 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Cells, Boxes, testing::Values("tetrahedra='false'", "tetrahedra='true'"),
                         [](const auto& cells) { return cells.index == 0 ? "hexahedra" : "tetrahedra"; });

TEST(MeshMatrixMass, OneTetrahedronAndOneCubeHaveTheKnownEntries) {
  // a cube: product of three matrices h/6 [2 1; 1 2], so 8/216, 4/216, 2/216 and 1/216 of its mass
  Simulation cube(sceneFromText(body("", "<MeshMatrixMass massDensity='216'/>")));
  System& system = *cube.systems()[0];
  const BlockMatrix& matrix = system.matrix().withFactors({.mass = 1, .stiffness = 0}).assemble();
  const double expected[4] = {8, 4, 2, 1};
  for (int other = 0; other < 8; ++other) {
    const int apart = (other & 1) + (other >> 1 & 1) + (other >> 2 & 1);
    EXPECT_NEAR(matrix.values()[std::size_t(matrix.slot(0, other)) * 9], expected[apart], 1e-13);
    EXPECT_EQ(matrix.values()[std::size_t(matrix.slot(0, other)) * 9 + 1], 0);
  }
  // node 1 of a cube cut around the diagonal 0-7 is in two tetrahedra of volume 1/6: 2 * rho V 2/20
  Simulation tets(sceneFromText(body("tetrahedra='true'", "<MeshMatrixMass massDensity='60'/>")));
  const BlockMatrix& m = tets.systems()[0]->matrix().withFactors({.mass = 1}).assemble();
  EXPECT_NEAR(m.values()[std::size_t(m.slot(1, 1)) * 9], 2.0, 1e-13);
  EXPECT_NEAR(m.values()[std::size_t(m.slot(0, 7)) * 9], 3.0, 1e-13);
  EXPECT_EQ(m.slot(1, 2), -1);
}

TEST(MeshMatrixMass, NodesAndEdgesGiveTheMatrixThatTheyWereTakenFrom) {
  const std::string mesh = "cells='2 2 1' size='1 2 3' tetrahedra='true'";
  Simulation whole(sceneFromText(body(mesh, "<MeshMatrixMass name='mass' massDensity='60'/>")));
  const BlockMatrix& m = whole.systems()[0]->matrix().withFactors({.mass = 1}).assemble();
  const auto entry = [](const BlockMatrix& matrix, Index i, Index j) {
    return matrix.values()[std::size_t(matrix.slot(i, j)) * 9];
  };
  std::string nodes, edges;
  for (Index i = 0; i < m.rows(); ++i) {
    nodes += " " + std::to_string(entry(m, i, i));
    for (Index j = i + 1; j < m.rows(); ++j)
      if (m.slot(i, j) >= 0) edges += " " + std::to_string(entry(m, i, j));
  }
  Simulation parts(sceneFromText(body(mesh, "<MeshMatrixMass vertexMass='" + nodes + "' edgeMass='" + edges + "'/>")));
  const BlockMatrix& n = parts.systems()[0]->matrix().withFactors({.mass = 1}).assemble();
  for (Index i = 0; i < m.rows(); ++i)
    for (Index j = 0; j < m.rows(); ++j) {
      ASSERT_EQ(n.slot(i, j) >= 0, m.slot(i, j) >= 0);
      if (m.slot(i, j) < 0) continue;
      EXPECT_NEAR(entry(n, i, j), entry(m, i, j), 1e-6) << "six decimals were written";
    }
  EXPECT_NEAR(parts.systems()[0]->masses()[0]->totalMass(), 360, 1e-3);
  EXPECT_FALSE(parts.systems()[0]->masses()[0]->isDiagonal());
  const Data* given = findComponent(whole.root(), "/mass")->data().find("vertexMass");
  EXPECT_EQ(std::get<std::vector<double>*>(given->pointer())->at(0), entry(m, 0, 0)) << "for links";

  const auto problems = [&](const std::string& attributes) {
    return problemsOf(body(mesh, "<MeshMatrixMass " + attributes + "/>"));
  };
  expectContains(problems("edgeMass='1'"), "edgeMass has no meaning without");
  expectContains(problems("vertexMass='1' edgeMass='1 2'"), "edgeMass has 2 values");
  expectContains(problems("vertexMass='1' edgeMass='1'"), "not positive definite");
}

TEST(MeshMass, TotalMassDensityPerCellFacesAndOverlap) {
  const auto total = [](const std::string& mesh, const std::string& mass) {
    Simulation simulation(sceneFromText(body(mesh, mass)));
    return simulation.systems()[0]->masses()[0]->totalMass();
  };
  EXPECT_NEAR(total("size='2 2 2' tetrahedra='true'", "<DiagonalMass totalMass='3'/>"), 3, 1e-14);
  EXPECT_NEAR(total("size='2 2 2' tetrahedra='true'", "<MeshMatrixMass totalMass='3'/>"), 3, 1e-14);
  EXPECT_NEAR(total("size='2 2 2' cells='2 1 1'", "<DiagonalMass massDensity='1 5'/>"), 4 * 1 + 4 * 5, 1e-13);
  EXPECT_NEAR(total("size='2 3 1' faces='true'", "<DiagonalMass massDensity='4' name='shell'/>"), 24, 1e-13);
  EXPECT_NEAR(total("size='2 2 2' overlap='2'", "<DiagonalMass massDensity='10'/>"), 40, 1e-13);
  EXPECT_NEAR(total("size='2 2 2' overlap='2'", "<MeshMatrixMass totalMass='10'/>"), 10, 1e-13);
  EXPECT_NEAR(total("", "<DiagonalMass vertexMass='0.5'/>"), 4, 1e-14);
  EXPECT_NEAR(total("", "<MeshMatrixMass vertexMass='1 2 3 4 5 6 7 8'/>"), 36, 1e-14);
}

TEST(MeshMass, RestOrInitialPositions) {
  const std::string stretched =
      "translation2='0 0 0' rest_position='@mesh.position' position='@mesh.position' scale3d='2 1 1'";
  const auto total = [&](const std::string& mass) {
    Simulation simulation(sceneFromText(body("tetrahedra='true'", mass, stretched)));
    return simulation.systems()[0]->masses()[0]->totalMass();
  };
  EXPECT_NEAR(total("<DiagonalMass massDensity='3'/>"), 3, 1e-13);
  EXPECT_NEAR(total("<DiagonalMass massDensity='3' computeMassOnRest='false'/>"), 6, 1e-13);
  EXPECT_NEAR(total("<MeshMatrixMass massDensity='3'/>"), 6, 1e-13);
  EXPECT_NEAR(total("<MeshMatrixMass massDensity='3' computeMassOnRest='true'/>"), 3, 1e-13);
}

TEST(UniformMass, TotalVertexAndSomeNodes) {
  const auto masses = [](const std::string& mass) {
    Simulation simulation(
        sceneFromText(body("", "<UniformMass " + mass + "/><FixedProjectiveConstraint fixAll='1'/>")));
    return simulation.systems()[0]->masses()[0]->lumped();
  };
  EXPECT_EQ(masses("totalMass='4'"), std::vector<double>(8, 0.5));
  EXPECT_EQ(masses("vertexMass='3'"), std::vector<double>(8, 3));
  EXPECT_EQ(masses("vertexMass='3' totalMass='4'"), std::vector<double>(8, 3));
  EXPECT_EQ(masses("totalMass='4' indices='1 3'"), (std::vector<double>{0, 2, 0, 2, 0, 0, 0, 0}));
  EXPECT_EQ(masses("vertexMass='4' localRange='5 7'"), (std::vector<double>{0, 0, 0, 0, 0, 4, 4, 4}));
}

/// Eight parts of a full cube: along each axis (5/4 3/4; 3/4 5/4) in place of ones. Of a cube whose upper half is empty the gravity is
/// half of that of the full one at each corner, as in SOFA.
TEST(MeshMatrixMass, PairsOfThePartsOfACell) {
  const auto matrix = [](const std::string& more, int column) {
    Simulation simulation(sceneFromText("<Node name='root'><TestIntegrator/><TestMesh cells='1 1 1' size='1 1 1'/><MechanicalObject/>"
                                        "<MeshMatrixMass massDensity='27' matrix='pairs' " + more + "/></Node>"));
    System& system = *simulation.systems()[0];
    Vector unit(8), out(8);
    unit[column] = Vec3(1, 0, 0);
    system.masses()[0]->addProduct(unit, 1, out);
    std::vector<double> entries(system.masses()[0]->rowSums());
    for (Index i = 0; i < 8; ++i) entries.push_back(Vec3(out[i])[0]);
    return entries;
  };
  const std::vector<double> full = matrix("cellFactors='1 1 1 1 1 1 1 1'", 0), half = matrix("cellFactors='1 1 1 1 0 0 0 0'", 0);
  const std::vector<double> plain = matrix("", 0);
  std::vector<double> lower, sorted(full.begin() + 8, full.end());
  std::sort(sorted.begin(), sorted.end());
  const double a = 1.25, b = 0.75;
  const std::vector<double> expected = {8 * b * b * b, 8 * a * b * b, 8 * a * b * b, 8 * a * b * b,
                                        8 * a * a * b, 8 * a * a * b, 8 * a * a * b, 8 * a * a * a};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(sorted[i], expected[i], 1e-13);
    EXPECT_NEAR(plain[8 + i], 8, 1e-13);
    EXPECT_NEAR(full[i], 27. / 8, 1e-13);
    EXPECT_NEAR(half[i], 27. / 16, 1e-13);
  }
  // z = 1/4 alone: 3/2 and 1/2 for the lower and the upper corners, half of the mass
  EXPECT_NEAR(half[8], 8 * a * a * (1.5 * 1.5 / 2), 1e-13);
  EXPECT_NEAR(matrix("cellFactors='1 1 1 1 0 0 0 0' totalMass='54'", 0)[8] / half[8], 4, 1e-13) << "the mass of the body";
  expectContains(problemsOf("<Node name='root'><TestIntegrator/><TestMesh cells='1 1 1' size='1 1 1'/><MechanicalObject/><MeshMatrixMass "
                            "massDensity='27' matrix='pairs' cellFactors='1 1 1'/></Node>"),
                 "cellFactors has 3 values for 1 cells");
}

TEST(Masses, SayWhatIsWrong) {
  expectContains(problemsOf(body("tetrahedra='true' flip='true'", "<DiagonalMass name='m' massDensity='1'/>")),
                 "tetrahedron 0 (nodes 1 0 3 7)");
  expectContains(problemsOf(body("cells='2 1 1'", "<DiagonalMass massDensity='1 2 3'/>")), "3 values for the 2 cells");
  expectContains(problemsOf(body("", "<DiagonalMass massDensity='0'/>")), "massDensity");
  expectContains(problemsOf(body("", "<DiagonalMass vertexMass='1 2'/>")), "2 values for the 8 nodes");
  expectContains(problemsOf(body("", "<UniformMass totalMass='-1'/>")), "totalMass");
  expectContains(problemsOf(body("", "<UniformMass totalMass='1' indices='8'/>")), "indices in 0 ... 7");
  expectContains(problemsOf(body("", "<DiagonalMass massDensity='1'/>", "position='0 0 0'")), "/mesh has 8 nodes");
  expectContains(problemsOf("<Node name='root'><TestIntegrator/><MechanicalObject position='0 0 0'/>"
                            "<MeshMatrixMass massDensity='1'/></Node>"),
                 "no mesh whose cells");
  expectContains(problemsOf("<Node name='root'><UniformMass totalMass='1'/></Node>"), "no mechanical state");
}

TEST(Masses, WarnOfDefaultsAndOfNodesWithoutCells) {
  const auto warnings = [](const std::string& xml) { return sceneFromText(xml).diagnostics.text(); };
  expectContains(warnings(body("", "<UniformMass/>")), "the total mass is set to 1 kg");
  expectContains(warnings(body("", "<DiagonalMass/>")), "the total mass is set to 1 kg");
  expectContains(warnings(body("", "<DiagonalMass massDensity='1' totalMass='2'/>")), "totalMass is used");
  expectContains(warnings(body("extraNodes='2'", "<DiagonalMass massDensity='1'/>")),
                 "2 of 10 nodes belong to no cell");
  expectContains(warnings(body("", "<UniformMass totalMass='1' separateGravity='true'/>")), "separateGravity");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
