// SPDX-License-Identifier: LGPL-2.1-or-later
// One homogeneous cell under uniaxial, biaxial and volumetric stretch and simple shear against stresses derived by
// hand, in every form and both kinds of cell; rest, rotation and small strains.
#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <map>

#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct ClosedForm {
  std::string attributes;
  /// lambda_i P_i for principal stretches.
  std::function<double(const Vec3& stretch, int i)> principal;
  /// P_12 of F = Id + gamma e1 (x) e2.
  std::function<double(double gamma)> shear;
};

double firstInvariant(const Vec3& l) { return l.squaredNorm(); }
double secondInvariant(const Vec3& l) {
  return l[0] * l[0] * l[1] * l[1] + l[1] * l[1] * l[2] * l[2] + l[2] * l[2] * l[0] * l[0];
}
/// lambda_i dI'/dlambda_i of the isochoric invariants.
double isochoric1(const Vec3& l, int i) {
  return 2 * std::pow(l.prod(), -2. / 3) * (l[i] * l[i] - firstInvariant(l) / 3);
}
double isochoric2(const Vec3& l, int i) {
  const double own = l[i] * l[i] * (firstInvariant(l) - l[i] * l[i]);
  return 2 * std::pow(l.prod(), -4. / 3) * (own - 2 * secondInvariant(l) / 3);
}
double i1(const Vec3& l) { return std::pow(l.prod(), -2. / 3) * firstInvariant(l); }

std::string set(const std::string& law, const std::string& values, const std::string& directions = "") {
  return "materialName=\"" + law + "\" ParameterSet=\"" + values + "\"" +
         (directions.empty() ? "" : " AnisotropyDirections=\"" + directions + "\"");
}

constexpr double mu = 1200, lambda = 4000, k0 = 5000;

ClosedForm neoHookean() {
  return {set("NeoHookean", "1200 4000"),
          [](const Vec3& l, int i) { return mu * (l[i] * l[i] - 1) + lambda * std::log(l.prod()); },
          [](double g) { return mu * g; }};
}

/// E1 E2 E3 G12 G23 G31 v12 v23 v31 c
constexpr double fung[10] = {5000, 3000, 2000, 1000, 700, 900, 0.3, 0.35, 0.1, 2000};
/// Hooke's orthotropic law on strains along the axes.
Vec3 orthotropicStress(const Vec3& e) {
  const double s12 = -fung[6] / fung[0], s23 = -fung[7] / fung[1], s31 = -fung[8] / fung[2];
  Mat3 compliance;
  compliance << 1 / fung[0], s12, s31, s12, 1 / fung[1], s23, s31, s23, 1 / fung[2];
  return compliance.fullPivLu().solve(e);
}
/// l F'(l) of the fibres of TransverselyIsotropicMooneyRivlin with c3 = 150, c4 = 12, c5 = 2500, lam_max = 1.06.
double ligamentForce(double l) {
  if (l <= 1) return 0;
  const double toe = 150 * (std::exp(12 * (std::min(l, 1.06) - 1)) - 1);
  return l < 1.06 ? toe : 2500 * l + (toe - 2500 * 1.06);
}

std::map<std::string, ClosedForm> closedFormsOfFibres() {
  std::map<std::string, ClosedForm> forms;
  forms["FungOrthotropic"] = {
      set("FungOrthotropic", "5000 3000 2000 1000 700 900 0.3 0.35 0.1 2000 5000", "1 0 0  0 1 0"),
      [](const Vec3& l, int i) {
        const Vec3 c = std::pow(l.prod(), -2. / 3) * l.array().square(), e = (c.array() - 1) / 2;
        const Vec3 s = orthotropicStress(e), slope = s.cwiseProduct(c);
        return std::exp(s.dot(e) / fung[9]) * (slope[i] - slope.sum() / 3) + k0 * std::log(l.prod());
      },
      [](double g) {
        const double n22 = orthotropicStress(Vec3::UnitY())[1], e = g * g / 2;
        return std::exp((n22 * e * e + fung[3] * g * g) / fung[9]) * (n22 * e * g + fung[3] * g);
      }};
  forms["TransverselyIsotropicMooneyRivlin"] = {
      set("TransverselyIsotropicMooneyRivlin", "300 200 150 12 2500 1.06 5000", "1 0 0"),
      [](const Vec3& l, int i) {
        const double fibre = ligamentForce(std::pow(l.prod(), -1. / 3) * l[0]), along = (i == 0 ? 1. : 0.) - 1. / 3;
        return 300 * isochoric1(l, i) + 200 * isochoric2(l, i) + along * fibre + k0 * std::log(l.prod());
      },
      [](double g) { return 2 * 500 * g; }};
  return forms;
}

std::map<std::string, ClosedForm> closedForms() {
  std::map<std::string, ClosedForm> forms = closedFormsOfFibres();
  forms["Yeoh"] = {set("Yeoh", "600 -40 30 5000"),
                   [](const Vec3& l, int i) {
                     const double x = i1(l) - 3;
                     return (600 - 80 * x + 90 * x * x) * isochoric1(l, i) + k0 * std::log(l.prod());
                   },
                   [](double g) { return 2 * g * (600 - 80 * g * g + 90 * g * g * g * g); }};
  forms["Yeoh, six terms"] = {set("Yeoh", "600 -40 30 8 -4 3 5000"),
                              [](const Vec3& l, int i) {
                                const double x = i1(l) - 3;
                                const double slope = 600 + x * (-80 + x * (90 + x * (32 + x * (-20 + x * 18))));
                                return slope * isochoric1(l, i) + k0 * std::log(l.prod());
                              },
                              [](double g) {
                                const double x = g * g;
                                return 2 * g * (600 + x * (-80 + x * (90 + x * (32 + x * (-20 + x * 18)))));
                              }};
  forms["Hencky"] = {set("Hencky", "1200 4000"),
                     [](const Vec3& l, int i) { return 2 * mu * std::log(l[i]) + lambda * std::log(l.prod()); },
                     // stretches e^a and e^-a, sinh a = g/2
                     [](double g) { return 2 * mu * std::asinh(g / 2) / std::sqrt(1 + g * g / 4); }};
  forms["StVenantKirchhoff"] = {set("StVenantKirchhoff", "1200 4000"),
                                [](const Vec3& l, int i) {
                                  const double trace = (firstInvariant(l) - 3) / 2;
                                  return l[i] * l[i] * (lambda * trace + mu * (l[i] * l[i] - 1));
                                },
                                [](double g) { return lambda * g * g * g / 2 + mu * (g + g * g * g); }};
  forms["NeoHookean"] = neoHookean();
  forms["StableNeoHookean"] = {set("StableNeoHookean", "1200 4000"),
                               [](const Vec3& l, int i) {
                                 const double j = l.prod(), a = 1 + mu / (lambda + mu);
                                 return mu * l[i] * l[i] + (lambda + mu) * (j - a) * j;
                               },
                               [](double g) { return mu * g; }};
  forms["MooneyRivlin"] = {
      set("MooneyRivlin", "300 200 5000"),
      [](const Vec3& l, int i) { return 300 * isochoric1(l, i) + 200 * isochoric2(l, i) + k0 * std::log(l.prod()); },
      [](double g) { return 2 * 500 * g; }};
  forms["VerondaWestman"] = {set("VerondaWestman", "500 2 5000"),
                             [](const Vec3& l, int i) {
                               return 1000 * std::exp(2 * (i1(l) - 3)) * isochoric1(l, i) - 500 * isochoric2(l, i) +
                                      k0 * std::log(l.prod());
                             },
                             [](double g) { return 2000 * g * std::exp(2 * g * g) - 1000 * g; }};
  const double c[5] = {0.5, 1. / 160, 11. / 67200, 19. / 3584000, 519. / 2759680000.};
  const auto slope = [c](double i) {
    double sum = 0;
    for (int n = 1; n <= 5; ++n) sum += mu * n * c[n - 1] * std::pow(i, n - 1);
    return sum;
  };
  forms["ArrudaBoyce"] = {
      set("ArrudaBoyce", "1200 5000"),
      [slope](const Vec3& l, int i) { return slope(i1(l)) * isochoric1(l, i) + k0 * std::log(l.prod()); },
      [slope](double g) { return 2 * g * slope(3 + g * g); }};
  const auto ogden = [](const Vec3& l, int i, double m, double a) {
    double mean = 0;
    for (int k = 0; k < 3; ++k) mean += std::pow(l[k], a) / 3;
    return m / a * std::pow(l.prod(), -a / 3) * (std::pow(l[i], a) - mean);
  };
  const auto ogdenShear = [](double g, double m, double a) {
    const double l = g / 2 + std::sqrt(1 + g * g / 4);
    return m / a * (std::pow(l, a - 1) - std::pow(l, -a - 1)) / (1 + 1 / (l * l));
  };
  forms["OgdenUnconstrained"] = {set("OgdenUnconstrained", "1500 3 500 -2 4000"),
                                 [](const Vec3& l, int i) {
                                   const double j = l.prod();
                                   return 500 * (std::pow(l[i], 3) - 1) - 250 * (std::pow(l[i], -2) - 1) +
                                          4000 * j * (j - 1);
                                 },
                                 [ogdenShear](double g) { return ogdenShear(g, 1500, 3) + ogdenShear(g, 500, -2); }};
  forms["Ogden"] = {
      set("Ogden", "1500 1.3 300 5 200 -2 5000"),
      [ogden](const Vec3& l, int i) {
        return ogden(l, i, 1500, 1.3) + ogden(l, i, 300, 5) + ogden(l, i, 200, -2) + k0 * std::log(l.prod());
      },
      [ogdenShear](double g) { return ogdenShear(g, 1500, 1.3) + ogdenShear(g, 300, 5) + ogdenShear(g, 200, -2); }};
  forms["Ogden, five terms"] = {set("Ogden", "900 1.3 400 4 300 -2 250 2.5 150 -1 5000"),
                                [ogden](const Vec3& l, int i) {
                                  return ogden(l, i, 900, 1.3) + ogden(l, i, 400, 4) + ogden(l, i, 300, -2) +
                                         ogden(l, i, 250, 2.5) + ogden(l, i, 150, -1) + k0 * std::log(l.prod());
                                },
                                [ogdenShear](double g) {
                                  return ogdenShear(g, 900, 1.3) + ogdenShear(g, 400, 4) + ogdenShear(g, 300, -2) +
                                         ogdenShear(g, 250, 2.5) + ogdenShear(g, 150, -1);
                                }};
  forms["Costa"] = {
      set("Costa", "500 5000 8 4 2 5 2.5 3", "1 0 0  0 1 0"),
      [](const Vec3& l, int i) {
        const Vec3 b(8, 2, 3), e = (l.array().square() - 1) / 2;
        const double q = (b.array() * e.array().square()).sum(), j = l.prod();
        const double scale = std::pow(j, -4. / 3);
        return 250 * std::exp(scale * q) * scale * (2 * b[i] * e[i] * l[i] * l[i] - 4. / 3 * q) + k0 * j * std::log(j);
      },
      [](double g) { return 250 * std::exp(2 * g * g * g * g / 4 + 4 * g * g / 2) * (2 * g * g * g + 4 * g); }};
  forms["TransverselyIsotropic"] = {set("TransverselyIsotropic", "1200 4000 3000 1.5", "1 0 0"),
                                    [](const Vec3& l, int i) {
                                      const double i4 = std::pow(l.prod(), -2. / 3) * l[0] * l[0];
                                      const double s = std::max(0., i4 - 1), along = (i == 0 ? 2. : 0.) - 2. / 3;
                                      return neoHookean().principal(l, i) +
                                             3000 * s * std::exp(1.5 * s * s) * along * i4;
                                    },
                                    [](double g) { return mu * g; }};
  return forms;
}

std::string cellScene(const std::string& type, const std::string& attributes) {
  const bool cube = type.rfind("Hexa", 0) == 0;
  const std::string cell =
      cube ? "<HexahedronSetTopologyContainer position=\"0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\" "
             "hexahedra=\"0 1 2 3 4 5 6 7\"/>"
           : "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\"/>";
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>" + cell +
         "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + type + " " + attributes + "/></Node>";
}

void move(FieldUnderTest& t, const Mat3& f) {
  t.rest();
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]) + Vec3(0.4, -0.3, 0.2);
}
/// P of a cell that is deformed by F everywhere: of the tetrahedron f_i = -P e_i / 6, of the cube P e_i is the sum on
/// the faces x_i = 1.
Mat3 firstStress(FieldUnderTest& t, const Mat3& f) {
  move(t, f);
  const Vector force = t.force();
  Mat3 p = Mat3::Zero();
  if (t.x.count() == 4) {
    for (int i = 0; i < 3; ++i) p.col(i) = -6 * Vec3(force[i + 1]);
    return p;
  }
  for (int i = 0; i < 3; ++i)
    for (Index n = 0; n < 8; ++n)
      if (t.field().state().rest_position[n][i] == 1) p.col(i) -= Vec3(force[n]);
  return p;
}

const std::vector<std::pair<std::string, std::string>> forms{
    {"TetrahedronHyperelasticityFEMForceField", ""},
    {"StandardTetrahedralFEMForceField", ""},
    {"MJEDTetrahedralForceField", "matrixRegularization=\"true\""},
    {"MJEDTetrahedralForceField", "projectedTangent=\"true\""},
    {"HexahedronHyperelasticityFEMForceField", ""},
    {"HexahedronHyperelasticityFEMForceField", "projectedTangent=\"true\""}};

TEST(HyperelasticClosedForms, StretchesAndShear) {
  const std::vector<Vec3> stretches{{1.3, 0.9, 0.9},   {0.7, 1.1, 1.1},       {1.25, 1.25, 0.7},
                                    {0.85, 0.85, 1.2}, {1.2, 1.2, 1.2},       {0.8, 0.8, 0.8},
                                    {1.3, 1.05, 0.8},  {1.001, 1.001, 0.999}, {1.5, 0.95, 0.95}};
  for (const auto& [law, closed] : closedForms())
    for (const auto& [type, form] : forms) {
      SCOPED_TRACE(law + " " + type + " " + form);
      if (law == "StVenantKirchhoff" && form.rfind("matrixRegularization", 0) == 0) continue;  // it has no J
      FieldUnderTest t(cellScene(type, closed.attributes + " " + form), type);
      for (const Vec3& l : stretches) {
        const Mat3 p = firstStress(t, l.asDiagonal());
        Mat3 expected = Mat3::Zero();
        for (int i = 0; i < 3; ++i) expected(i, i) = closed.principal(l, i) / l[i];
        EXPECT_LT((p - expected).norm(), 1e-10 * expected.norm()) << l.transpose();
      }
      for (double gamma : {0.01, 0.3, -0.6}) {
        Mat3 f = Mat3::Identity();
        f(0, 1) = gamma;
        EXPECT_NEAR(firstStress(t, f)(0, 1), closed.shear(gamma), 1e-10 * std::abs(closed.shear(gamma))) << gamma;
      }
    }
}

/// All of P for deformations without symmetry and axes that lie askew: the fibre of TransverselyIsotropic pulled,
/// sheared across and slack, that of TransverselyIsotropicMooneyRivlin straight too, and the three axes of Costa and
/// FungOrthotropic.
TEST(HyperelasticClosedForms, AxesThatLieAskew) {
  const Vec3 fibre = Vec3(1, 2, 1).normalized(), second = Vec3(2, -1, 0).normalized();
  Mat3 axes;
  axes << fibre, second, fibre.cross(second);
  const auto transverselyIsotropic = [&](const Mat3& f) -> Mat3 {
    const double j = f.determinant(), i4 = (f * fibre).squaredNorm(), s = std::pow(j, -2. / 3) * i4 - 1;
    const Mat3 inverse = f.inverse().transpose();
    Mat3 p = mu * (f - inverse) + lambda * std::log(j) * inverse;
    if (s > 0)
      p += 3000 * s * std::exp(1.5 * s * s) * std::pow(j, -2. / 3) *
           (2 * (f * fibre) * fibre.transpose() - 2. / 3 * i4 * inverse);
    return p;
  };
  Mat3 weight;
  weight << 8, 4, 5, 4, 2, 2.5, 5, 2.5, 3;
  const auto costa = [&](const Mat3& f) -> Mat3 {
    const double j = f.determinant(), scale = std::pow(j, -4. / 3);
    const Mat3 strain = axes.transpose() * (f.transpose() * f - Mat3::Identity()) / 2 * axes;
    const double q = scale * (weight.array() * strain.array().square()).sum();
    const Mat3 slope = axes * (2 * weight.array() * strain.array()).matrix() * axes.transpose();
    const Mat3 inverse = f.inverse().transpose();
    return 250 * std::exp(q) * (scale * f * slope - 4. / 3 * q * inverse) + k0 * j * std::log(j) * inverse;
  };
  const auto fungOrthotropic = [&](const Mat3& f) -> Mat3 {
    const double j = f.determinant(), scale = std::pow(j, -2. / 3);
    const Mat3 c = axes.transpose() * f.transpose() * f * axes, strain = (scale * c - Mat3::Identity()) / 2;
    Mat3 s = Vec3(orthotropicStress(strain.diagonal())).asDiagonal();
    for (const auto& [i, k, shear] : {std::tuple{0, 1, fung[3]}, {1, 2, fung[4]}, {2, 0, fung[5]}})
      s(i, k) = s(k, i) = 2 * shear * strain(i, k);
    const double q = s.cwiseProduct(strain).sum() / fung[9], mean = s.cwiseProduct(c).sum() / 3;
    const Mat3 inverse = f.inverse().transpose();
    return scale * std::exp(q) * (f * axes * s * axes.transpose() - mean * inverse) + k0 * std::log(j) * inverse;
  };
  const auto ligament = [&](const Mat3& f) -> Mat3 {
    const double j = f.determinant(), i4 = (f * fibre).squaredNorm();
    const Mat3 c = f.transpose() * f, inverse = f.inverse().transpose();
    const double first = c.trace(), second = (first * first - (c * c).trace()) / 2;
    const double force = ligamentForce(std::pow(j, -1. / 3) * std::sqrt(i4));
    return 600 * std::pow(j, -2. / 3) * (f - first / 3 * inverse) +
           400 * std::pow(j, -4. / 3) * (first * f - f * c - 2. / 3 * second * inverse) +
           force * (f * fibre * fibre.transpose() / i4 - inverse / 3) + k0 * std::log(j) * inverse;
  };
  std::vector<Mat3> deformations;
  for (const double g : {0.4, -0.3})
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        if (i != k) {
          deformations.emplace_back(Mat3::Identity());
          deformations.back()(i, k) = g;
        }
  deformations.emplace_back((Mat3() << 1.2, 0.3, -0.1, -0.2, 0.9, 0.25, 0.15, -0.3, 1.1).finished());
  deformations.emplace_back(Mat3::Identity() + 0.3 * fibre * fibre.transpose());   // pulled
  deformations.emplace_back(Mat3::Identity() - 0.3 * fibre * fibre.transpose());   // slack
  deformations.emplace_back(Mat3::Identity() + 0.3 * second * fibre.transpose());  // sheared across
  int pulled = 0, slack = 0;
  for (const Mat3& f : deformations)
    ((f * fibre).squaredNorm() > std::pow(f.determinant(), 2. / 3) ? pulled : slack) += 1;
  EXPECT_GT(std::min(pulled, slack), 3);
  const std::vector<std::pair<std::string, std::function<Mat3(const Mat3&)>>> laws{
      {set("TransverselyIsotropic", "1200 4000 3000 1.5", "1 2 1"), transverselyIsotropic},
      {set("Costa", "500 5000 8 4 2 5 2.5 3", "1 2 1  2 -1 0"), costa},
      {set("FungOrthotropic", "5000 3000 2000 1000 700 900 0.3 0.35 0.1 2000 5000", "1 2 1  2 -1 0"), fungOrthotropic},
      {set("TransverselyIsotropicMooneyRivlin", "300 200 150 12 2500 1.06 5000", "1 2 1"), ligament}};
  for (const auto& [attributes, stress] : laws)
    for (const auto& [type, form] : forms) {
      SCOPED_TRACE(attributes + " " + type + " " + form);
      FieldUnderTest t(cellScene(type, attributes + " " + form), type);
      for (const Mat3& f : deformations) {
        const Mat3 expected = stress(f);
        EXPECT_LT((firstStress(t, f) - expected).norm(), 1e-10 * expected.norm()) << f;
      }
    }
}

TEST(HyperelasticClosedForms, RestAndRotation) {
  const Mat3 turn = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  for (const auto& [law, closed] : closedForms())
    for (const auto& [type, form] : forms) {
      SCOPED_TRACE(law + " " + type + " " + form);
      if (law == "StVenantKirchhoff" && form.rfind("matrixRegularization", 0) == 0) continue;  // it has no J
      FieldUnderTest t(cellScene(type, closed.attributes + " " + form), type);
      const Mat3 p = firstStress(t, f);
      const double energy = t.field().energy(t.x);
      EXPECT_GT(energy, 1);
      EXPECT_LT(firstStress(t, Mat3::Identity()).norm(), 1e-12 * p.norm());
      EXPECT_LT(std::abs(t.field().energy(t.x)), 1e-12 * energy);
      EXPECT_LT(firstStress(t, turn).norm(), 1e-11 * p.norm());
      EXPECT_LT((firstStress(t, turn * f) - turn * p).norm(), 1e-12 * p.norm());
      EXPECT_NEAR(t.field().energy(t.x), energy, 1e-12 * energy);
    }
}

/// youngModulus and poissonRatio: the tangent at rest is Hooke's. With the dilatation of the points: what its mean is
/// taken of differs between the two (see test_mean_dilatation.cpp).
TEST(HyperelasticClosedForms, SmallStrainsAreHookes) {
  const std::map<std::string, std::string> besides{{"StVenantKirchhoff", ""},
                                                   {"NeoHookean", ""},
                                                   {"StableNeoHookean", ""},
                                                   {"MooneyRivlin", "c2=\"150\""},
                                                   {"VerondaWestman", "c2=\"2.5\""},
                                                   {"ArrudaBoyce", ""},
                                                   {"Ogden", "alpha1=\"5\""},
                                                   {"Yeoh", "c2=\"200\" c3=\"70\""},
                                                   {"Hencky", ""},
                                                   {"OgdenUnconstrained", "m1=\"3\""}};
  for (double nu : {0.3, 0.4999})
    for (const auto& [law, more] : besides)
      for (const bool cube : {false, true}) {
        SCOPED_TRACE(law);
        const std::string moduli = fmt::format(" youngModulus=\"3000\" poissonRatio=\"{}\" dilatation=\"local\" ", nu);
        const std::string type = cube ? "HexahedronHyperelasticityFEMForceField" : tetrahedral;
        const std::string linear = cube ? "HexahedronFEMForceField" : "TetrahedronFEMForceField";
        FieldUnderTest t(cellScene(type, "materialName=\"" + law + "\"" + moduli + more), type);
        FieldUnderTest hooke(cellScene(linear, "method=\"small\"" + moduli), linear);
        EXPECT_LT(relativeDifference(t.product(t.direction), hooke.product(t.direction)), 1e-11);
      }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
