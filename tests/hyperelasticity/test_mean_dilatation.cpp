// SPDX-License-Identifier: LGPL-2.1-or-later
// dilatation="mean" on hyperelastic hexahedra: derivatives of every law, Hooke's law with a mean dilatation as the
// limit of small strains, homogeneous shapes, and that nearly incompressible bodies do not lock.
#include <fmt/format.h>

#include <map>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "framework/mechanics/open_choices.h"
#include "tests/hyperelasticity/law_cases.h"
#include "tests/support/dense_algebra.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string type = "HexahedronHyperelasticityFEMForceField";
const std::string mean = " dilatation=\"mean\"", at_points = " dilatation=\"local\"";

/// A block of distorted hexahedra, or another field on it.
std::string block(const std::string& attributes, const std::string& field = type) {
  std::string scene = hexahedraScene("", false);
  const auto at = scene.find("<HexahedronFEMForceField");
  return scene.replace(at, scene.find("/>", at) + 2 - at, "<" + field + " " + attributes + "/>");
}
std::vector<LawCase> lawsWithVolume() {
  std::vector<LawCase> laws;
  for (const LawCase& law : lawCases())
    if (law.name != "StVenantKirchhoff") laws.push_back(law);
  return laws;
}

TEST(MeanDilatation, EnergyForceProductAndMatrixAgree) {
  for (const LawCase& law : lawsWithVolume()) {
    SCOPED_TRACE(law.name);
    FieldUnderTest t(block(law.attributes + mean), type);
    t.deform(0.05);
    const Vector f = t.force();
    ASSERT_TRUE(std::isfinite(dot(f, f)));
    expectForceOfEnergy(t, f);
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge())), 1e-6);
    expectMatrixOfProducts(t);
    expectSymmetricProducts(t);
    expectForceAndProductInOnePass(t);
    expectNoResultant(t, f);
  }
}

/// Where all cells have one J its mean is J: the local law, whatever the shapes of the cells. Elsewhere it is not.
TEST(MeanDilatation, AHomogeneousShapeFeelsTheLocalLaw) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  for (const LawCase& law : lawsWithVolume()) {
    SCOPED_TRACE(law.name);
    FieldUnderTest averaged(block(law.attributes + mean), type), local(block(law.attributes + at_points), type);
    for (Index i = 0; i < local.x.count(); ++i) averaged.x[i] = local.x[i] = f * Vec3(local.x[i]);
    EXPECT_LT(relativeDifference(averaged.force(), local.force()), 1e-12);
    EXPECT_NEAR(averaged.field().energy(averaged.x), local.field().energy(local.x),
                1e-12 * local.field().energy(local.x));
    averaged.deform(0.05), local.deform(0.05);
    EXPECT_GT(relativeDifference(averaged.force(), local.force()), 1e-3) << "nothing is averaged";
    averaged.moveRigidly();
    const Vector rigid = averaged.force(), bent = local.force();
    EXPECT_LT(std::sqrt(dot(rigid, rigid)), 1e-12 * std::sqrt(dot(bent, bent)));
  }
}

/// The tangent at rest of isochoric laws is that of linear hexahedra with a mean dilatation; of laws in I1 itself it is
/// 2 mu eps at the points, lambda on the mean.
TEST(MeanDilatation, SmallStrainsAreHookesWithAMeanDilatation) {
  const std::string linear = "HexahedronFEMForceField";
  const auto hooke = [&](double mu, double bulk, const std::string& more) {
    const double e = 9 * bulk * mu / (3 * bulk + mu), nu = (3 * bulk - 2 * mu) / (2 * (3 * bulk + mu));
    FieldUnderTest t(
        block(fmt::format("method=\"small\" youngModulus=\"{:.17g}\" poissonRatio=\"{:.17g}\" {}", e, nu, more),
              linear),
        linear);
    return t.product(t.direction);
  };
  const std::map<std::string, std::string> isochoric{
      {"MooneyRivlin", "c1=\"300\" c2=\"200\" k0=\"{}\""},
      {"VerondaWestman", "c1=\"500\" c2=\"2\" k0=\"{}\""},
      {"Yeoh", "c1=\"500\" c2=\"300\" k0=\"{}\""},
      {"Ogden",
       "mu1=\"900\" alpha1=\"3\" mu2=\"500\" alpha2=\"-2\" mu3=\"300\" alpha3=\"2\" mu4=\"300\" alpha4=\"1\" "
       "k0=\"{}\""}};
  for (const double bulk : {2000., 1e6}) {
    for (const auto& [law, parameters] : isochoric) {
      SCOPED_TRACE(law);
      FieldUnderTest t(block("materialName=\"" + law + "\" " + fmt::format(fmt::runtime(parameters), bulk) + mean),
                       type);
      EXPECT_LT(relativeDifference(t.product(t.direction), hooke(1000, bulk, mean)), 1e-10);
    }
    Vector expected = hooke(1000, 2000. / 3, "");  // lambda = 0
    axpy(1, hooke(1000, 1000 + bulk, mean), expected), axpy(-1, hooke(1000, 1000, mean), expected);
    for (const std::string law : {"NeoHookean", "StableNeoHookean", "Hencky"}) {
      SCOPED_TRACE(law);
      FieldUnderTest t(
          block("materialName=\"" + law + "\" mu=\"1000\" lambda=\"" + fmt::format("{}", bulk) + "\"" + mean), type);
      EXPECT_LT(relativeDifference(t.product(t.direction), expected), 1e-10);
    }
  }
}

TEST(MeanDilatation, ACellHasItsOwnStiffness) {
  const auto row = [](const std::string& k0, bool reversed = false) {
    const std::string cells = reversed ? "1 2 5 4 7 8 11 10  0 1 4 3 6 7 10 9" : "0 1 4 3 6 7 10 9  1 2 5 4 7 8 11 10";
    FieldUnderTest t(
        "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
        "<MeshTopology position=\"0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 2 1 "
        "1\" hexahedra=\"" +
            cells + "\"/><MechanicalObject/><UniformMass totalMass=\"1\"/><" + type +
            " materialName=\"MooneyRivlin\" c1=\"300\" c2=\"200\" k0=\"" + k0 + "\"" + mean + "/></Node>",
        type);
    t.deform(0.1);
    return t.force();
  };
  const Vector both = row("5000 90000");
  EXPECT_LT(relativeDifference(both, row("90000 5000", true)), 1e-14);
  EXPECT_EQ(Vec3(both[0]), Vec3(row("5000")[0])) << "a node of the first cell alone";
  EXPECT_EQ(Vec3(both[2]), Vec3(row("90000")[2]));
}

/// StableNeoHookean passes through J = 0, and the tangent of points can be projected.
TEST(MeanDilatation, WithInversionAndProjection) {
  FieldUnderTest t(block("materialName=\"StableNeoHookean\" ParameterSet=\"1000 400000\"" + mean), type);
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = Vec3(t.x[i]).cwiseProduct(Vec3(-0.5, 1.1, 0.9));
  const Vector f = t.force();
  EXPECT_TRUE(std::isfinite(dot(f, f)) && dot(f, f) > 0);
  EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge())), 1e-6);
  const std::string law = "materialName=\"NeoHookean\" ParameterSet=\"1000 40000\"" + mean;
  FieldUnderTest exact(block(law), type), projected(block(law + " projectedTangent=\"true\""), type);
  exact.deform(0.05), projected.deform(0.05);
  EXPECT_EQ(relativeDifference(exact.force(), projected.force()), 0);
  const BlockMatrix k = projected.matrix();
  Vector assembled(exact.x.count());
  k.multiply(projected.direction, assembled);
  EXPECT_LT(relativeDifference(assembled, projected.product(projected.direction)), 1e-12);
}

/// K of a field at the x of the last force, as a dense matrix.
Eigen::MatrixXd denseMatrix(FieldUnderTest& t) {
  const Index rows = t.x.count();
  Eigen::MatrixXd dense(3 * rows, 3 * rows);
  Vector unit(rows);
  for (Index column = 0; column < 3 * rows; ++column) {
    clear(unit);
    unit[column / 3][column % 3] = 1;
    const Vector product = t.product(unit);
    for (Index row = 0; row < 3 * rows; ++row) dense(row, column) = product[row / 3][row % 3];
  }
  return dense;
}

/// Under a pressure far above the stiffness of shapes the tangent has unstable directions; the one that Newton's method
/// asks for then has none, and the force is the same.
TEST(MeanDilatation, ADefiniteTangentHasNoUnstableDirection) {
  for (const LawCase& law : lawsWithVolume())
    for (const std::string& dilatation : {mean, at_points}) {
      SCOPED_TRACE(law.name + dilatation);
      FieldUnderTest t(block(law.attributes + dilatation), type);
      t.deform(0.1);
      for (Index i = 0; i < t.x.count(); ++i) t.x[i] = 0.7 * Vec3(t.x[i]);
      auto& open = dynamic_cast<OpenChoices&>(t.field());
      const Vector exact = t.force();
      const Eigen::VectorXd plain = eigenvalues(denseMatrix(t));
      EXPECT_GT(plain.maxCoeff(), 1e-6 * plain.cwiseAbs().maxCoeff()) << "no direction was unstable";
      ASSERT_TRUE(open.useDefiniteTangent(true));
      EXPECT_LT(relativeDifference(exact, t.force()), 1e-13);
      const Eigen::VectorXd definite = eigenvalues(denseMatrix(t));
      EXPECT_LT(definite.maxCoeff(), 1e-9 * definite.cwiseAbs().maxCoeff());
      expectMatrixOfProducts(t);
      expectSymmetricProducts(t);
      ASSERT_TRUE(open.useDefiniteTangent(false));
      EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge())), 1e-5);
    }
}

/// Laws and moduli scale together: a body of twice Young's modulus has twice the matrix, also where Poisson's ratio is written
/// as the very limit of dilatation="auto", whatever the round-off of the moduli that it becomes.
TEST(MeanDilatation, AutoHasOneAnswerForARatioAtItsLimit) {
  for (const std::string law : {"NeoHookean", "StableNeoHookean", "Yeoh", "Hencky"})
    for (const double young : {100., 1000., 2000., 3000., 7000., 20000., 1e5, 1e6, 12345.6, 777.}) {
      const std::string material = fmt::format("materialName=\"{}\" youngModulus=\"{}\" poissonRatio=", law, young);
      SCOPED_TRACE(material);
      const auto product = [&](const std::string& rest) {
        FieldUnderTest t(block(material + rest), type);
        t.deform(0.05);
        t.force();
        return t.product(t.direction);
      };
      const Vector open = product("\"0.4\""), below = product("\"0.3999\"");
      EXPECT_LT(relativeDifference(open, product("\"0.4\"" + mean)), 1e-15);
      EXPECT_LT(relativeDifference(below, product("\"0.3999\"" + at_points)), 1e-15);
      EXPECT_GT(relativeDifference(open, product("\"0.4\"" + at_points)), 1e-3) << "the two are not told apart";
    }
}

TEST(MeanDilatation, IsRefusedWhereItHasNoMeaning) {
  const auto expectRefused = [](const std::string& scene, const std::string& words) {
    const std::string problems = problemsOf(scene);
    EXPECT_NE(problems.find(words), std::string::npos) << problems;
  };
  expectRefused(block("materialName=\"StVenantKirchhoff\" ParameterSet=\"1000 4000\"" + mean),
                "the energy of StVenantKirchhoff has no part in J alone");
  expectRefused(lawScene("materialName=\"NeoHookean\" ParameterSet=\"1000 4000\"" + mean),
                "the mean dilatation of a hyperelastic law exists for hexahedra");
  std::string folded = block("materialName=\"NeoHookean\" ParameterSet=\"1000 4000\"" + mean);
  const auto at = folded.find("position=\""), end = folded.find('"', at + 10);
  folded.replace(at, end - at, "position=\"0 0 0 1 0 0 0.3 0.3 0 0 1 0 0 0 1 1 0 1 0.3 0.3 1 0 1 1");
  const auto cells = folded.find("hexahedra=\""), last = folded.find('"', cells + 11);
  folded.replace(cells, last - cells, "hexahedra=\"0 1 2 3 4 5 6 7");
  expectRefused(folded, "hexahedron 0 (nodes 0 1 2 3 4 5 6 7) is folded at rest");
}

/// Cook's membrane in plane strain, nu = 0.4999: rise of the middle of the right edge [mm] with n x n cells.
double cook(int n, const std::string& dilatation) {
  std::string position, cells, held, loaded, forces;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n, low = 44 * s, high = 44 + 16 * s;
        position += fmt::format("{} {} {} ", 48 * s, low + double(j) / n * (high - low), k);
        if (i == 0) held += fmt::format("{} ", node(i, j, k));
        if (i == n) {
          loaded += fmt::format("{} ", node(i, j, k));
          forces += fmt::format("0 {} 0 ", 0.0625 * 16 / n * (j == 0 || j == n ? 0.25 : 0.5));
        }
        if (k > 0 || i == n || j == n) continue;
        for (int c : {node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0), node(i, j, 1),
                      node(i + 1, j, 1), node(i + 1, j + 1, 1), node(i, j + 1, 1)})
          cells += fmt::format("{} ", c);
      }
  const double mu = 0.4225, bulk = 2 * mu * 1.4999 / (3 * 0.0002);  // mm, N
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver newton_iterations="60"/><SparseLDLSolver/>
  <MeshTopology position="{}" hexahedra="{}"/><MechanicalObject/><UniformMass totalMass="1"/>
  <FixedProjectiveConstraint indices="{}"/><PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 0 1"/>
  <ConstantForceField indices="{}" forces="{}"/>
  <HexahedronHyperelasticityFEMForceField materialName="MooneyRivlin" c1="{}" c2="0" k0="{}" dilatation="{}"/></Node>)",
      position, cells, held, loaded, forces, mu / 2, bulk, dilatation));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.newton_converged) << n << " " << dilatation << ": " << report.reason;
  const auto& rest = simulation.states()[0]->rest_position;
  for (std::size_t i = 0; i < rest.size(); ++i)
    if (rest[i].x() > 47.9 && std::abs(rest[i].y() - 52) < 1e-9)
      return simulation.systems()[0]->x[Index(i)].y() - rest[i].y();
  return 0;
}

TEST(MeanDilatation, CooksMembraneDoesNotLock) {
  std::map<int, double> averaged, local;
  for (const int n : {4, 8, 16, 32}) {
    averaged[n] = cook(n, "mean"), local[n] = cook(n, "local");
    std::printf("Cook's membrane, nu = 0.4999, %2d x %2d: mean %.3f mm, local %.3f mm\n", n, n, averaged[n], local[n]);
  }
  EXPECT_LT(std::abs(averaged[8] / averaged[32] - 1), 0.05);
  EXPECT_LT(std::abs(averaged[16] / averaged[32] - 1), 0.02);
  EXPECT_LT(local[16], 0.8 * averaged[16]) << "local cells lock";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
