// SPDX-License-Identifier: LGPL-2.1-or-later
// The stress of a body with a plastic strain: what the elastic force field beside it does not know.
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A cube that is turned by R and stretched by 1 + s along each axis, with a given strain p.
std::string cube(const std::string& strain) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><StaticSolver/><SparseLDLSolver/>"
         "<RegularGridTopology name=\"grid\" n=\"3 3 3\" min=\"0 0 0\" max=\"1 1 1\"/><Node name=\"a\">"
         "<TetrahedronSetTopologyContainer name=\"tets\"/><Hexa2TetraTopologicalMapping "
         "input=\"@../grid\" output=\"@tets\"/><MechanicalObject name=\"dofs\"/><DiagonalMass massDensity=\"1000\"/>"
         "<TetrahedronFEMForceField name=\"fem\" method=\"svd\" youngModulus=\"1e4\" poissonRatio=\"0.3\"/>"
         "<PlasticStrainForceField name=\"plastic\" method=\"svd\" youngModulus=\"1e4\" poissonRatio=\"0.3\" initialStrain=\"" +
         strain + "\"/></Node></Node>";
}

std::vector<double> fieldOf(FieldUnderTest& t, const std::string& name) {
  std::vector<double> values;
  t.field().cellField(name, t.x, values);
  return values;
}

/// What swells freely has no stress, wherever it is turned; the elastic force field has that of the whole strain.
TEST(PlasticFields, WhatSwellsFreelyHasNoStress) {
  const Mat3 r = Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  FieldUnderTest t(cube("0.1 0.1 0.1 0 0 0"), "PlasticStrainForceField");
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = 1.1 * r * Vec3(t.x[i]);
  for (const char* name : {"elasticStress", "elasticVonMises"})
    for (const double value : fieldOf(t, name)) EXPECT_NEAR(value, 0, 1e-9 * 1e4);
  const std::vector<double> strain = fieldOf(t, "plasticStrain");
  ASSERT_EQ(strain.size() % 6, 0u);
  for (std::size_t k = 0; k < strain.size(); ++k) EXPECT_EQ(strain[k], k % 6 < 3 ? 0.1 : 0);
}

/// sigma = R D (eps - eps_p) R^T with a sheared eps_p, and von Mises' number of it.
TEST(PlasticFields, TheStressIsThatOfTheElasticStrain) {
  const Mat3 r = Eigen::AngleAxisd(-1, Vec3(3, -1, 2).normalized()).toRotationMatrix();
  const double mu = 1e4 / 2.6, lambda = 1e4 * 0.3 / (1.3 * 0.4);
  Mat3 stretch, plastic;
  stretch << 1.05, 0.02, 0.01, 0.02, 0.97, -0.03, 0.01, -0.03, 1.02;
  plastic << 0.02, 0.01, -0.005, 0.01, -0.01, 0.015, -0.005, 0.015, 0.03;
  FieldUnderTest t(cube("0.02 -0.01 0.03 0.02 0.03 -0.01"), "PlasticStrainForceField");
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = r * stretch * Vec3(t.x[i]);
  const Mat3 elastic = stretch - Mat3::Identity() - plastic;
  const Mat3 stress = r * (lambda * elastic.trace() * Mat3::Identity() + 2 * mu * elastic) * r.transpose();
  const double expected[] = {stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0)};
  const std::vector<double> values = fieldOf(t, "elasticStress"), mises = fieldOf(t, "elasticVonMises");
  ASSERT_EQ(values.size(), 6 * mises.size());
  for (std::size_t k = 0; k < values.size(); ++k) EXPECT_NEAR(values[k], expected[k % 6], 1e-9 * 1e4);
  const Mat3 deviator = stress - stress.trace() / 3 * Mat3::Identity();
  for (const double value : mises) EXPECT_NEAR(value, std::sqrt(1.5 * deviator.squaredNorm()), 1e-9 * 1e4);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
