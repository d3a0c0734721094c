// SPDX-License-Identifier: LGPL-2.1-or-later
// What hyperelastic hexahedra say of the volumes that they resist: without them, and without a pressure, their matrix does not depend on
// the stiffness against changes of volume.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "framework/algebra/volume_terms.h"
#include "framework/simulation/system.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/stored_matrix.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// K - sum w b b^T of two cells, one of them oblique, that are sheared without a change of volume, and turned.
Eigen::MatrixXd withoutVolumes(const char* law, double stiffness, double& size) {
  std::string position;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) position += fmt::format("{} {} {} ", i + (i + j + k == 4 ? 0.3 : 0), j + 0.1 * i * k, k);
  Simulation simulation = simulationFromText(
      fmt::format("<Node name='root' dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position='{}' "
                  "hexahedra='0 1 4 3 6 7 10 9  1 2 5 4 7 8 11 10'/><MechanicalObject/><UniformMass totalMass='1'/>"
                  "<HexahedronHyperelasticityFEMForceField materialName='{}' dilatation='mean' ParameterSet='1000 {}'/></Node>",
                  position, law, stiffness));
  System& system = *simulation.systems()[0];
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 0.4, shear(1, 2) = -0.3;
  const Mat3 f = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix() * shear;
  for (Index i = 0; i < system.x.count(); ++i) system.x[i] = (f * system.x[i]).eval();
  Vector force(system.allRows());
  system.computeForce(system.x, system.v, force);
  MechanicalMatrix& matrix = system.matrix().withFactors({.stiffness = -1});
  Eigen::MatrixXd k = StoredMatrix(matrix.assemble()).dense();
  size = k.norm();
  VolumeTerms terms;
  for (const ForceField* field : system.actors().stiff_fields)
    if (const auto* resists = dynamic_cast<const ResistsVolumes*>(field)) resists->addVolumeTerms(terms);
  EXPECT_EQ(terms.count(), 2);
  for (Index c = 0; c < terms.count(); ++c) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(k.rows());
    for (Index e = terms.start[c]; e < terms.start[c + 1]; ++e) b.segment<3>(3 * terms.rows[e]) += terms.gradients[e];
    k -= terms.bulk[c] * b * b.transpose();
    EXPECT_NEAR(terms.bulk[c] / terms.shear[c], stiffness / 1000, 1e-9 * stiffness);
  }
  return k;
}

TEST(HyperelasticVolumes, WithoutThemTheMatrixDoesNotDependOnTheStiffnessAgainstThem) {
  for (const char* law : {"NeoHookean", "StableNeoHookean"}) {
    double size = 0, stiff_size = 0;
    const Eigen::MatrixXd soft = withoutVolumes(law, 4e4, size), stiff = withoutVolumes(law, 4e6, stiff_size);
    EXPECT_GT(stiff_size, 50 * size);
    EXPECT_LE((soft - stiff).norm(), 1e-12 * stiff_size) << law;
    EXPECT_GT(soft.norm(), 1e-3 * size);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
