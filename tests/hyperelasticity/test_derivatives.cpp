// SPDX-License-Identifier: LGPL-2.1-or-later
// Energy, force and matrix of every law on a mesh against automatic differentiation of the energy's formula, cell by
// cell; product against both.
#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "tests/hyperelasticity/dual.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Reference {
  double energy = 0;
  Vector force;
  std::vector<Mat3> matrix;  ///< shape (rows, rows)
};

/// All that a reference depends on.
std::vector<double> inputsOf(const FieldUnderTest& t, const HyperelasticForceField& field, const Mat3& axes) {
  std::vector<double> numbers(axes.data(), axes.data() + 9);
  const ConstRows x = t.x.rows();
  numbers.insert(numbers.end(), x.data, x.data + x.doubles());
  for (const Vec3& place : field.state().rest_position) numbers.insert(numbers.end(), place.data(), place.data() + 3);
  for (std::size_t cell = 0; cell < field.mesh().tetrahedra.size(); ++cell) {
    const Tetrahedron& n = field.mesh().tetrahedra[cell];
    numbers.insert(numbers.end(), n.begin(), n.end());
    const auto values = field.parameters(cell);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  return numbers;
}

Reference differentiated(const FieldUnderTest& t, const HyperelasticForceField& field, const Mat3& axes) {
  const std::vector<Vec3>& rest = field.state().rest_position;
  const Index rows = t.x.count();
  Reference out;
  out.force.resize(rows);
  out.matrix.assign(std::size_t(rows) * std::size_t(rows), Mat3::Zero());
  for (std::size_t cell = 0; cell < field.mesh().tetrahedra.size(); ++cell) {
    const Tetrahedron& n = field.mesh().tetrahedra[cell];
    Mat3 before, now;
    for (int a = 0; a < 3; ++a) {
      before.col(a) = rest[n[(a + 1)]] - rest[n[0]];
      now.col(a) = Vec3(t.x[n[a + 1]]) - Vec3(t.x[n[0]]);
    }
    const double volume = std::abs(before.determinant()) / 6;
    Eigen::Matrix<double, 3, 4> g;
    g.rightCols<3>() = axes.transpose() * before.inverse().transpose();
    g.col(0) = -g.rightCols<3>().rowwise().sum();
    const Mat3 f = now * before.inverse() * axes;
    const auto values = field.parameters(cell);
    const std::vector<double> p(values.begin(), values.end());
    const Dual w = referenceEnergy(field.law().name, p, variables(f));
    const double *h = w.h.data(), *gradients = g.data();  // columns one after the other
    out.energy += volume * w.v;
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) out.force[n[a]][i] -= volume * w.g[3 * i + k] * g(k, a);
        for (int b = 0; b < 4; ++b) {
          Mat3& block = out.matrix[std::size_t(n[a]) * std::size_t(rows) + std::size_t(n[b])];
          for (int j = 0; j < 3; ++j) {
            double sum = 0;  // over numbers: tests are compiled without optimisation
            for (int k = 0; k < 3; ++k)
              for (int l = 0; l < 3; ++l)
                sum += h[9 * (3 * j + l) + 3 * i + k] * gradients[3 * a + k] * gradients[3 * b + l];
            block(i, j) -= volume * sum;
          }
        }
      }
  }
  return out;
}

void expectDerivatives(const std::string& scene, const std::string& type, const Mat3& axes, const std::string& what) {
  SCOPED_TRACE(what);
  FieldUnderTest t(scene, type);
  t.deform(0.04);
  const auto& field = dynamic_cast<const HyperelasticForceField&>(t.field());
  // two types of component have the same one, which takes longest
  static std::pair<std::string, std::vector<double>> known;
  static Reference reference;
  if (std::pair now(field.law().name, inputsOf(t, field, axes)); now != known)
    reference = differentiated(t, field, axes), known = now;
  ASSERT_GT(reference.energy, 0);
  EXPECT_NEAR(t.field().energy(t.x), reference.energy, 1e-12 * reference.energy);
  const double force = relativeDifference(t.force(), reference.force);
  const BlockMatrix k = t.matrix();
  double worst = 0, largest = 0;
  Vector product(t.x.count());
  for (Index row = 0; row < t.x.count(); ++row)
    for (Index column = 0; column < t.x.count(); ++column) {
      const Mat3& block = reference.matrix[std::size_t(row) * std::size_t(t.x.count()) + std::size_t(column)];
      const double *entry = block.data(), *direction = t.direction.rows().data + std::size_t(column) * row_doubles;
      double* sum = product.rows().data + std::size_t(row) * row_doubles;
      double size = 0;  // entry (i, j) is the number 3 j + i
      for (int n = 0; n < 9; ++n) sum[n % 3] += entry[n] * direction[n / 3], size = std::max(size, std::abs(entry[n]));
      largest = std::max(largest, size);
      const double* found = size == 0 ? nullptr : k.values().data() + std::size_t(k.slot(row, column)) * 9;
      for (int n = 0; found && n < 9; ++n) worst = std::max(worst, std::abs(entry[n] - found[3 * (n % 3) + n / 3]));
    }
  const double along = relativeDifference(t.product(t.direction), product);
  std::printf("%-50s force %.1e matrix %.1e product %.1e\n", what.c_str(), force, worst / largest, along);
  EXPECT_LT(force, 1e-12);
  EXPECT_LT(worst, 1e-12 * largest);
  EXPECT_LT(along, 1e-12);
}

TEST(HyperelasticDerivatives, OfTheFormulasByAutomaticDifferentiation) {
  for (const LawCase& law : lawCases())
    for (const std::string type : {"TetrahedronHyperelasticityFEMForceField", "StandardTetrahedralFEMForceField"})
      expectDerivatives(lawScene(law.attributes, type, STROMA_SOURCE_DIR "/scenes/meshes/organ_600.msh"), type,
                        law.axes(), law.name + " " + type);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
