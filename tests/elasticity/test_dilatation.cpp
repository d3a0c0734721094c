// SPDX-License-Identifier: LGPL-2.1-or-later
// The mean dilatation where the exact solution is known: layers of two materials under confined compression, whose
// strains jump at the interface and lie in the space of the elements; a thick tube under pressure.
#include <fmt/format.h>

#include <numbers>

#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

constexpr double young = 1000, lower_ratio = 0.499, upper_ratio = 0.3, half_height = 0.02;

double confinedModulus(double poisson) { return young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)); }

/// 2 x 2 x 4 hexahedra, or each cut into `cut` tetrahedra: the lower half nearly incompressible.
std::string layers(const std::string& attributes, const std::string& cut) {
  constexpr int hexahedra = 16;
  const int each = cut.empty() ? 1 : cut == "five" ? 5 : 6;
  std::string ratios;
  for (int cell = 0; cell < hexahedra * each; ++cell)
    ratios += fmt::format("{} ", cell < hexahedra / 2 * each ? lower_ratio : upper_ratio);
  const std::string grid =
      fmt::format("<RegularGridTopology name='grid' n='3 3 5' min='0 0 0' max='0.02 0.02 {}'/>", 2 * half_height);
  const std::string field = fmt::format("youngModulus='{}' poissonRatio='{}' {}/>", young, ratios, attributes);
  const std::string common = "<MechanicalObject/><UniformMass totalMass='1'/>";
  if (cut.empty())
    return "<Node name='root'><EulerImplicitSolver/><SparseLDLSolver/>" + grid + common + "<HexahedronFEMForceField " +
           field + "</Node>";
  return "<Node name='root'>" + grid +
         "<Node name='body'><EulerImplicitSolver/><SparseLDLSolver/><TetrahedronSetTopologyContainer name='tets'/>"
         "<Hexa2TetraTopologicalMapping input='@../grid' output='@tets' cutting='" +
         cut + "'/>" + common + "<TetrahedronFEMForceField " + field + "</Node></Node>";
}

/// Forces along the load on the nodes between bottom and top, relative to those on the top: zero in equilibrium.
double unbalanced(const std::string& attributes, const std::string& cut) {
  FieldUnderTest t(layers(attributes, cut), cut.empty() ? "HexahedronFEMForceField" : "TetrahedronFEMForceField");
  constexpr double stress = -1e-3 * young;
  const double lower = stress / confinedModulus(lower_ratio), upper = stress / confinedModulus(upper_ratio);
  for (Index i = 0; i < t.x.count(); ++i) {
    const double z = t.x[i].z();
    t.x[i].z() += lower * std::min(z, half_height) + upper * std::max(z - half_height, 0.);
  }
  const Vector f = t.force();
  const auto& rest = t.field().state().rest_position;
  double inside = 0, top = 0;
  for (Index i = 0; i < f.count(); ++i) {
    const double z = rest[i].z();
    if (z > 1e-9 && z < 2 * half_height - 1e-9) inside = std::max(inside, std::abs(f[i].z()));
    if (z > 2 * half_height - 1e-9) top += f[i].z();
  }
  EXPECT_NEAR(top, -stress * 0.02 * 0.02, 1e-2 * std::abs(stress) * 0.02 * 0.02);  // QR frames: strain 1e-3 squared
  return inside / std::abs(top);
}

TEST(MeanDilatation, LayersOfTwoMaterialsAreExact) {
  for (const std::string cut : {"", "five", "six"})
    for (const std::string method : {"small", "polar"})
      for (const std::string dilatation : {"local", "mean"}) {
        const double worst = unbalanced(fmt::format("method='{}' dilatation='{}'", method, dilatation), cut);
        EXPECT_LT(worst, 1e-9) << (cut.empty() ? "hexahedra" : cut + " tetrahedra") << " " << method << " "
                               << dilatation;
      }
}

TEST(MeanDilatation, AProductAndAMatrixOfTwoMaterialsAgree) {
  FieldUnderTest t(layers("method='polar' dilatation='mean'", "six"), "TetrahedronFEMForceField");
  t.deform(0.05);
  Vector through_matrix(t.x.count());
  t.matrix().multiply(t.direction, through_matrix);
  EXPECT_LT(relativeDifference(through_matrix, t.product(t.direction)), 1e-12);
}

/// Lame's thick tube in plane strain, radii 10 and 20 mm, under an inner pressure of E / 100; a quarter of it with n x
/// n cells. Returns the inner wall's displacement over the closed form's, u(r) = (1 + nu) / E p a^2 / (b^2 - a^2) ((1 -
/// 2 nu) r + b^2 / r).
double tube(int n, double nu, const std::string& attributes, bool tetrahedra) {
  constexpr double a = 0.01, b = 0.02, pressure = 0.01 * young, thickness = 0.002;
  std::string position, cells, forces, inner, on_x, on_y;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  const auto place = [n](int i, int j) {
    const double r = a + (b - a) * i / n, angle = std::numbers::pi / 2 * j / n;
    return Vec3(r * std::cos(angle), r * std::sin(angle), 0);
  };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const Vec3 p = place(i, j);
        position += fmt::format("{} {} {} ", p.x(), p.y(), k * thickness);
        if (j == 0) on_x += fmt::format("{} ", node(i, j, k));
        if (j == n) on_y += fmt::format("{} ", node(i, j, k));
        if (i == 0) {
          const Vec3 chord = place(0, std::min(j + 1, n)) - place(0, std::max(j - 1, 0));
          const double share = pressure * thickness / 4;
          inner += fmt::format("{} ", node(i, j, k));
          forces += fmt::format("{} {} 0 ", share * chord.y(), -share * chord.x());
        }
        if (k > 0 || i == n || j == n) continue;
        for (int c : {node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0), node(i, j, 1),
                      node(i + 1, j, 1), node(i + 1, j + 1, 1), node(i, j + 1, 1)})
          cells += fmt::format("{} ", c);
      }
  const std::string topology = tetrahedra ? "<TetrahedronSetTopologyContainer name='cells'/>"
                                            "<Hexa2TetraTopologicalMapping input='@../mesh' output='@cells' "
                                            "cutting='five'/>"
                                          : "<HexahedronSetTopologyContainer name='cells' src='@../mesh'/>";
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><MeshTopology name="mesh" position="{}" hexahedra="{}"/>
  <Node name="body"><StaticSolver/><SparseLDLSolver/>{}<MechanicalObject/><UniformMass totalMass="1"/>
  <PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 0 1"/>
  <PartialFixedProjectiveConstraint indices="{}" fixedDirections="0 1 0"/>
  <PartialFixedProjectiveConstraint indices="{}" fixedDirections="1 0 0"/>
  <ConstantForceField indices="{}" forces="{}"/>
  <{}FEMForceField youngModulus="{}" poissonRatio="{}" {}/></Node></Node>)",
      position, cells, topology, on_x, on_y, inner, forces, tetrahedra ? "Tetrahedron" : "Hexahedron", young, nu,
      attributes));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << report.reason;
  const double exact = (1 + nu) / young * pressure * a * a / (b * b - a * a) * ((1 - 2 * nu) * a + b * b / a);
  return (simulation.systems()[0]->x[0].x() - a) / exact;
}

TEST(MeanDilatation, ANearlyIncompressibleTubeDoesNotLock) {
  for (const std::string method : {"small", "polar"}) {
    const std::string attributes = fmt::format("method='{}' dilatation=", method);
    for (const double nu : {0.3, 0.4999}) {
      double error[3];
      for (int level = 0; level < 3; ++level)
        error[level] = std::abs(tube(4 << level, nu, attributes + "'mean'", false) - 1);
      std::printf("tube of hexahedra, %s, nu = %g: errors %.2e %.2e %.2e\n", method.c_str(), nu, error[0], error[1],
                  error[2]);
      EXPECT_LT(error[2], 0.01);
      EXPECT_NEAR(std::log2(error[1] / error[2]), 2, 0.2) << "order in h";
    }
    EXPECT_LT(tube(8, 0.4999, attributes + "'local'", false), 0.9) << "local hexahedra lock";
    const double mean = tube(16, 0.4999, attributes + "'mean'", true);
    std::printf("tube of tetrahedra, %s, nu = 0.4999: %.4f of the exact displacement\n", method.c_str(), mean);
    EXPECT_NEAR(mean, 1, 0.01);
  }
}

/// What a scene that does not choose gets, by its forces.
TEST(MeanDilatation, IsTheDefaultWhereCellsLock) {
  const auto forces = [](const std::string& cut, const std::string& poisson, const std::string& attributes) {
    std::string text = layers("method='svd' " + attributes, cut);
    const std::size_t at = text.find("poissonRatio='") + 14;
    text.replace(at, text.find('\'', at) - at, poisson);
    FieldUnderTest t(text, cut.empty() ? "HexahedronFEMForceField" : "TetrahedronFEMForceField");
    for (Index i = 0; i < t.x.count(); ++i) t.x[i].z() *= 1 + 3 * t.x[i].x();
    const Vector f = t.force();
    std::vector<double> all;
    for (Index i = 0; i < f.count(); ++i)
      for (int c = 0; c < 3; ++c) all.push_back(f[i][c]);
    return all;
  };
  for (const std::string cut : {"", "six"})
    for (const std::string poisson : {"0.3", "0.39", "0.42", "0.45", "0.46", "0.499"}) {
      const bool mean = std::stod(poisson) > (cut.empty() ? 0.395 : 0.455);
      const auto chosen = forces(cut, poisson, "");
      EXPECT_EQ(chosen == forces(cut, poisson, "dilatation='mean'"), mean) << cut << " " << poisson;
      EXPECT_EQ(chosen == forces(cut, poisson, "dilatation='local'"), !mean) << cut << " " << poisson;
    }
}

TEST(MeanDilatation, WhereThereIsNoneLockingIsSaid) {
  const auto warnings = [](const std::string& attributes) {
    const Scene scene = sceneFromText(layers(attributes, "six"));
    std::string all;
    for (const Problem& problem : scene.diagnostics.problems()) all += problem.message + "\n";
    return all;
  };
  EXPECT_NE(warnings("method='green'").find("locks"), std::string::npos);
  EXPECT_NE(warnings("method='svd' dilatation='local'").find("locks"), std::string::npos);
  EXPECT_EQ(warnings("method='svd'").find("locks"), std::string::npos);
}

TEST(MeanDilatation, RefusesAMaterialForEachCell) {
  std::string moduli;
  for (int cell = 0; cell < 16 * 6 * 6; ++cell) moduli += fmt::format("{} ", 1000 + cell);
  const std::string scene =
      "<Node name='root'><RegularGridTopology name='grid' n='5 5 7' min='0 0 0' max='1 1 1'/>"
      "<Node name='body'><EulerImplicitSolver/><CGLinearSolver/><TetrahedronSetTopologyContainer name='tets'/>"
      "<Hexa2TetraTopologicalMapping input='@../grid' output='@tets' cutting='six'/><MechanicalObject/>"
      "<UniformMass totalMass='1'/><TetrahedronFEMForceField dilatation='mean' poissonRatio='0.4' youngModulus='" +
      moduli + "'/></Node></Node>";
  EXPECT_NE(problemsOf(scene).find("at most 100 materials"), std::string::npos) << problemsOf(scene);
}

/// Boxes make their diagonal blocks by themselves, and a uniform mass writes its product: both are those of the matrix.
TEST(Boxes, DiagonalAndProductsAreThoseOfTheMatrix) {
  for (const char* method : {"small", "polar", "svd"})
    for (const char* nu : {"0.3", "0.45"}) {
      SCOPED_TRACE(fmt::format("{} {}", method, nu));
      Simulation simulation = simulationFromText(fmt::format(
          "<Node gravity='0 -9.81 2' dt='0.02'><EulerImplicitSolver/><SparseLDLSolver/>"
          "<RegularGridTopology n='7 3 3' min='0 0 0' max='0.6 0.1 0.16'/><MechanicalObject/><UniformMass totalMass='5'/>"
          "<FixedProjectiveConstraint indices='0 7 14 21 28 35 42 49 56'/>"
          "<HexahedronFEMForceField method='{}' youngModulus='2e4' poissonRatio='{}'/></Node>",
          method, nu));
      for (int step = 0; step < 20; ++step) simulation.step();
      System& system = *simulation.systems()[0];
      Vector f(system.allRows());
      system.computeForce(system.x, system.v, f);
      MechanicalMatrix& matrix = system.matrix().withFactors({.mass = 3, .stiffness = -2});
      std::vector<double> blocks;
      matrix.diagonalBlocks(blocks);  // before there is a matrix to take them from
      Vector p(system.independentRows()), product(p.count()), assembled(p.count());
      for (Index i = 0; i < p.count(); ++i) p[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(7 * i + 1));
      system.constraints().project(p);
      matrix.multiply(p, product);
      const BlockMatrix& whole = matrix.assemble();
      whole.multiply(p, assembled);
      double most = 0, apart = 0;
      for (Index i = 0; i < p.count(); ++i)
        for (std::size_t k = 0; k < 9; ++k) {
          const double here = whole.values()[std::size_t(whole.diagonal()[i]) * 9 + k];
          most = std::max(most, std::abs(here)), apart = std::max(apart, std::abs(here - blocks[std::size_t(i) * 9 + k]));
        }
      EXPECT_LT(apart, 1e-13 * most);
      axpy(-1, product, assembled);
      EXPECT_LT(norm(assembled), 1e-13 * norm(product));
    }
}

}  // namespace
}  // namespace stroma::test
