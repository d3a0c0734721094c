// SPDX-License-Identifier: LGPL-2.1-or-later
// The mean dilatation where the exact solution is known: layers of two materials under confined compression, whose
// strains jump at the interface and lie in the space of the elements.
#include <fmt/format.h>

#include "tests/elasticity/field_under_test.h"

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
    const double z = rest[std::size_t(i)].z();
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

}  // namespace
}  // namespace stroma::test
