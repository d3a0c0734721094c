// SPDX-License-Identifier: LGPL-2.1-or-later
// What a field says of the volumes that it resists: without them its matrix does not depend on the bulk modulus.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "framework/algebra/volume_terms.h"
#include "framework/simulation/system.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/stored_matrix.h"

namespace stroma::test {
namespace {

struct Case {
  const char *mesh, *field, *method;
  double corner;  ///< that one node is moved by at rest: cells that are no boxes
};

/// K - sum w b b^T of a block of mu = 1000 that bends, has turned and is held at a face.
Eigen::MatrixXd withoutVolumes(const Case& it, double poisson, double& size) {
  const bool tetrahedra = std::string(it.mesh) == "tetrahedra";
  std::string position;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const double off = i + j + k == 3 && i == j ? it.corner : 0;
        position += fmt::format("{} {} {} ", i + off, j - off / 2, k + off / 3);
      }
  std::string elements;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const auto node = [&](int c) { return i + (c & 1) + 3 * (j + (c >> 1 & 1)) + 9 * (k + (c >> 2)); };
        if (tetrahedra)
          for (const auto& t : {std::array{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}})
            elements += fmt::format("{} {} {} {} ", node(t[0]), node(t[1]), node(t[2]), node(t[3]));
        else
          elements += fmt::format("{} {} {} {} {} {} {} {} ", node(0), node(1), node(3), node(2), node(4), node(5), node(7), node(6));
      }
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name='root' dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position='{}' {}='{}'/>"
      "<MechanicalObject/><UniformMass totalMass='1'/><{} method='{}' dilatation='mean' tangent='warped' youngModulus='{}' "
      "poissonRatio='{}'/><FixedProjectiveConstraint indices='0 3 6'/></Node>",
      position, it.mesh, elements, it.field, it.method, 2000 * (1 + poisson), poisson));
  System& system = *simulation.systems()[0];
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Index i = 0; i < system.x.count(); ++i) {
    const Vec3 at = system.x[i];
    system.x[i] = turn * Vec3(at + 0.05 * Vec3(at.y() * at.z(), at.x() * at.x(), -at.x() * at.y()));
  }
  Vector f(system.allRows());
  system.computeForce(system.x, system.v, f);
  MechanicalMatrix& matrix = system.matrix().withFactors({.stiffness = -1});
  Eigen::MatrixXd k = StoredMatrix(matrix.assemble()).dense();
  size = k.norm();
  VolumeTerms terms;
  for (const ForceField* field : system.actors().stiff_fields)
    if (const auto* resists = dynamic_cast<const ResistsVolumes*>(field)) resists->addVolumeTerms(terms);
  EXPECT_EQ(terms.count(), tetrahedra ? 27 : 8);
  for (Index c = 0; c < terms.count(); ++c) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(k.rows());
    for (Index e = terms.start[std::size_t(c)]; e < terms.start[std::size_t(c) + 1]; ++e)
      if (const Index row = terms.rows[std::size_t(e)]; row != 0 && row != 3 && row != 6)
        b.segment<3>(3 * row) += terms.gradients[std::size_t(e)];
    k -= terms.bulk[std::size_t(c)] * b * b.transpose();
    EXPECT_NEAR(terms.bulk[std::size_t(c)] / terms.shear[std::size_t(c)], 2 * (1 + poisson) / (3 * (1 - 2 * poisson)),
                1e-9 / (1 - 2 * poisson));
  }
  for (const Index held : {0, 3, 6}) k.middleRows<3>(3 * held).setZero();  // their diagonal is of the size of the others
  return k;
}

TEST(VolumeTerms, WithoutThemTheMatrixDoesNotDependOnTheBulkModulus) {
  constexpr double at_rest = 0, oblique = 0.2;
  for (const Case& it :
       {Case{"hexahedra", "HexahedronFEMForceField", "small", at_rest}, Case{"hexahedra", "HexahedronFEMForceField", "svd", at_rest},
        Case{"hexahedra", "HexahedronFEMForceField", "small", oblique}, Case{"hexahedra", "HexahedronFEMForceField", "polar", oblique},
        Case{"hexahedra", "HexahedronFEMForceField", "large", oblique}, Case{"tetrahedra", "TetrahedronFEMForceField", "small", at_rest},
        Case{"tetrahedra", "TetrahedronFEMForceField", "svd", oblique}, Case{"tetrahedra", "TetrahedronFEMForceField", "large", oblique}}) {
    double size = 0, stiff_size = 0;
    const Eigen::MatrixXd soft = withoutVolumes(it, 0.49, size), stiff = withoutVolumes(it, 0.4999, stiff_size);
    EXPECT_GT(stiff_size, 50 * size) << "the bulk modulus is in neither";
    EXPECT_LE((soft - stiff).norm(), 1e-13 * stiff_size) << it.mesh << " " << it.method << " " << it.corner;
    EXPECT_GT(soft.norm(), 1e-3 * size);
  }
}

}  // namespace
}  // namespace stroma::test
