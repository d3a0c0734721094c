// SPDX-License-Identifier: LGPL-2.1-or-later
// What the jumps of strains between cells say of the error of a mesh: against errors that are known.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>

#include "framework/mesh/cell_kind.h"
#include "tests/support/meshes.h"
#include "tests/support/quadratic_block.h"
#include "tools/checks/mesh_error.h"

namespace stroma::test {
namespace {

/// nx x ny x nz cells over a box that is twice as long as high.
Mesh beam(int n, bool tetrahedra) {
  Mesh mesh = tetrahedra ? tetrahedronMesh(2 * n, n, n, HexahedronCut::six, 0) : gridMesh(2 * n, n, n);
  Vec3 low = mesh.position[0], high = low;
  for (const Vec3& p : mesh.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (Vec3& p : mesh.position) p = (p - low).cwiseQuotient(high - low).cwiseProduct(Vec3(2, 1, 1));
  return mesh;
}

using Map = std::function<Vec3(const Vec3&)>;

std::vector<Vec3> moved(const Mesh& mesh, const Map& map) {
  std::vector<Vec3> now;
  for (const Vec3& p : mesh.position) now.push_back(map(p));
  return now;
}

StrainError errorOf(const Mesh& mesh, const Map& map, const std::vector<double>& modulus = {}, double bulk = 0) {
  return mesh.tetrahedra.empty() ? strainError(mesh.hexahedra, mesh.position, moved(mesh, map), modulus, bulk)
                                 : strainError(mesh.tetrahedra, mesh.position, moved(mesh, map), modulus, bulk);
}

TEST(MeshError, StrainsThatAreEqualHaveNone) {
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  Mat3 stretch;
  stretch << 1.1, 0.2, 0, 0, 0.9, 0.1, -0.1, 0, 1.3;
  for (const bool tetrahedra : {false, true}) {
    const Mesh mesh = beam(3, tetrahedra);
    const StrainError turned = errorOf(mesh, [&](const Vec3& p) -> Vec3 { return turn * p + Vec3(1, 2, 3); });
    EXPECT_LT(turned.largest, 1e-24);
    const StrainError same = errorOf(mesh, [&](const Vec3& p) -> Vec3 { return turn * (stretch * p); });
    EXPECT_GT(same.strain, 0.01);
    EXPECT_LT(same.error, 1e-20 * same.strain);
  }
}

/// Pure bending, u = k (x y, -x^2/2, 0): strains of tetrahedra are constant and off by what the plane of each cell misses;
/// hexahedra bend with a shear that does not belong there. The true error of the strain is that against k y.
TEST(MeshError, IsThatOfBentCells) {
  static constexpr double k = 1e-4;
  const Map bend = [](const Vec3& p) -> Vec3 {
    const double y = p.y() - 0.5;
    return p + k * Vec3(p.x() * y, -p.x() * p.x() / 2, 0);
  };
  for (const bool tetrahedra : {false, true})
    for (const int n : {2, 4, 8}) {
      const Mesh mesh = beam(n, tetrahedra);
      const StrainError found = errorOf(mesh, bend);
      // k y on the cells, less the mean shear of each: at Gauss points of a fine grid in each cell
      const double h = 1. / n, volume = 2;
      // the deviator of a strain e along one axis has 2/3 e^2; y is off by h^2/12 in a box of one strain
      const double strain = 2. / 3 * k * k / 12 * volume;
      const double shear = k * k * h * h / 24 * volume;  // 2 e_xy^2, e_xy = k (x - middle) / 2
      if (!tetrahedra) {
        EXPECT_NEAR(found.error, shear, 0.02 * shear) << n;
        EXPECT_NEAR(found.strain, strain + shear, 0.02 * strain) << n;
        // k y is the change of volume too
        const StrainError both = errorOf(mesh, bend, {}, 5);
        EXPECT_NEAR(both.error, shear, 0.02 * shear) << n;
        EXPECT_NEAR(both.strain - found.strain, 5 * k * k / 12 * volume, 0.01 * strain) << n;
      } else {
        EXPECT_GT(found.error, 0.7 * shear) << n;
        EXPECT_GT(errorOf(mesh, bend, {}, 5).error, 2 * found.error) << n << ": a volume that jumps between cells";
        const double finest = errorOf(beam(8, true), bend).error * 64;
        if (n > 2) {
          EXPECT_NEAR(found.error * n * n, finest, 0.35 * finest) << n;
        }
      }
      EXPECT_LT(found.share(), 8. / (n * n)) << n;
    }
}

/// The same bending of a strip of triangles with legs h: in each k y is that of one of its corners, and the shear k h / 4.
TEST(MeshError, IsThatOfBentTriangles) {
  static constexpr double k = 1e-4, area = 2;
  for (const int n : {4, 8, 16}) {
    Mesh mesh;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= 2 * n; ++i) mesh.position.push_back(Vec3(double(i) / n, double(j) / n, 0));
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < 2 * n; ++i) {
        const Index a = i + (2 * n + 1) * j, up = 2 * n + 1;
        mesh.triangles.push_back({a, a + 1, a + 1 + up});
        mesh.triangles.push_back({a, a + 1 + up, a + up});
      }
    const Map bend = [](const Vec3& p) -> Vec3 {
      const double y = p.y() - 0.5;
      return p + k * Vec3(p.x() * y, -p.x() * p.x() / 2, 0);
    };
    const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    std::vector<Vec3> rest, now = moved(mesh, bend);
    for (std::size_t i = 0; i < now.size(); ++i) rest.push_back(turn * mesh.position[i]);  // wherever the strip lies
    const StrainError found = strainError(mesh.triangles, rest, now, {}, 1. / 3);
    const double h = 1. / n, error = k * k * h * h * (1. / 6 + 1. / 8) * area;
    EXPECT_NEAR(found.error, error, 0.35 * error) << n;
    EXPECT_NEAR(found.share(), 3.5 * h * h, 0.4 * 3.5 * h * h) << n;
    EXPECT_LT(strainError(mesh.triangles, rest, mesh.position, {}, 1. / 3).largest, 1e-24) << "turned only";
  }
}

/// Integral of |dev(eps - exact)|^2 over cells, eps their own small strain.
template <class Cell>
double trueError(const std::vector<Cell>& cells, const std::vector<Vec3>& rest, const std::vector<Vec3>& now,
                 const std::function<Mat3(const Vec3&)>& exact) {
  const CellKind& kind = cells.front().size() == 6 ? cell_kinds::prism : cells.front().size() == 5 ? cell_kinds::pyramid
                                                                                           : cell_kinds::quadratic_tetrahedron;
  double sum = 0;
  for (const Cell& cell : cells)
    for (const QuadraturePoint& point : kind.rule(4).points) {
      std::array<double, 10> shapes;
      std::array<LocalPoint, 10> slopes;
      kind.shapes(point.xi, shapes.data()), kind.gradients(point.xi, slopes.data());
      Mat3 before = Mat3::Zero(), after = Mat3::Zero();
      Vec3 place = Vec3::Zero();
      for (std::size_t a = 0; a < cell.size(); ++a) {
        const Vec3 slope(slopes[a][0], slopes[a][1], slopes[a][2]);
        before += rest[std::size_t(cell[a])] * slope.transpose(), after += now[std::size_t(cell[a])] * slope.transpose();
        place += shapes[a] * rest[std::size_t(cell[a])];
      }
      const Mat3 f = after * before.inverse();
      Mat3 off = (f + f.transpose()) / 2 - Mat3::Identity() - exact(place);
      off -= off.trace() / 3 * Mat3::Identity();
      sum += point.weight * std::abs(before.determinant()) * off.squaredNorm();
    }
  return sum;
}

/// Hexahedra in two prisms with triangles across z, or in six pyramids around their centres; quadratic tetrahedra in quadratic shapes.
/// Linear ones are bent, which quadratic ones can, and these get a shear that they cannot have.
TEST(MeshError, IsThatOfPrismsPyramidsAndQuadraticCells) {
  static constexpr double k = 1e-4;
  const Map bend = [](const Vec3& p) -> Vec3 { return p + k * Vec3(p.x() * (p.y() - 0.5), -p.x() * p.x() / 2, 0); };
  const auto bent = [](const Vec3& p) -> Mat3 { return Vec3(k * (p.y() - 0.5), 0, 0).asDiagonal(); };
  const Map cubic = [](const Vec3& p) -> Vec3 { return p + k * Vec3(p.y() * p.y() * p.y(), 0, p.x() * p.x() * p.x()); };
  const auto sheared = [](const Vec3& p) -> Mat3 {
    Mat3 e = Mat3::Zero();
    e(0, 1) = e(1, 0) = 1.5 * k * p.y() * p.y(), e(0, 2) = e(2, 0) = 1.5 * k * p.x() * p.x();
    return e;
  };
  const auto expectNear = [&](const auto& cells, const std::vector<Vec3>& rest, const Map& map, const auto& exact) {
    std::vector<Vec3> now;
    for (const Vec3& p : rest) now.push_back(map(p));
    const double expected = trueError(cells, rest, now, exact), found = strainError(cells, rest, now).error;
    EXPECT_GT(found, 0.5 * expected);
    EXPECT_LT(found, 1.6 * expected);
  };
  for (const int n : {2, 4}) {
    SCOPED_TRACE(n);
    Mesh mesh = beam(n, false);
    for (const Hexahedron& h : mesh.hexahedra) {
      mesh.prisms.push_back({h[0], h[1], h[2], h[4], h[5], h[6]}), mesh.prisms.push_back({h[0], h[2], h[3], h[4], h[6], h[7]});
      Vec3 centre = Vec3::Zero();
      for (const Index a : h) centre += mesh.position[std::size_t(a)] / 8;
      const Index top = Index(mesh.position.size());
      mesh.position.push_back(centre);
      for (const auto& f : {std::array<int, 4>{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}})
        mesh.pyramids.push_back({h[std::size_t(f[0])], h[std::size_t(f[1])], h[std::size_t(f[2])], h[std::size_t(f[3])], top});
    }
    expectNear(mesh.prisms, mesh.position, bend, bent);
    expectNear(mesh.pyramids, mesh.position, bend, bent);
    const QuadraticBlock block = QuadraticBlock::box({2 * n, n, n}, [](const Vec3& p) { return Vec3(2 * p.x(), p.y(), p.z()); });
    expectNear(block.cells, block.position, cubic, sheared);
    std::vector<Vec3> now;
    for (const Vec3& p : block.position) now.push_back(bend(p));
    EXPECT_LT(strainError(block.cells, block.position, now).share(), 1e-12) << "bending is in their shapes";
  }
}

/// A shear that keeps every volume, u = (0.3 y^2, 0, 0), in cells that have it exactly. Its tr(E) does not vanish, and near Poisson's
/// ratio 1/2 would count for far more than the shear itself.
TEST(MeshError, LargeShapesOfOneVolumeHaveNoChangeOfIt) {
  const QuadraticBlock block = QuadraticBlock::box({4, 2, 2}, [](const Vec3& p) { return Vec3(2 * p.x(), p.y(), p.z()); });
  std::vector<Vec3> now;
  for (const Vec3& p : block.position) now.push_back(p + Vec3(0.3 * p.y() * p.y(), 0, 0));
  constexpr double bulk = 5000;
  using Of = VolumeChange::Of;
  EXPECT_LT(strainError(block.cells, block.position, now, {}, bulk, {Of::volume, true}).share(), 0.03);
  EXPECT_GT(strainError(block.cells, block.position, now, {}, bulk, {Of::green, true}).share(), 0.03);
  // pressed cells of which each second one grows and each other shrinks
  const Mesh mesh = beam(4, false);
  std::vector<Vec3> swung = mesh.position;
  for (std::size_t i = 0; i < swung.size(); ++i) swung[i].z() += 1e-3 * std::pow(-1, std::lround(4 * swung[i].z()));
  EXPECT_GT(strainError(mesh.hexahedra, mesh.position, swung, {}, bulk, {Of::volume, true}).share(), 0.3);
}

/// Two layers of which one is ten times as stiff: the strain jumps between them, and does in the body.
TEST(MeshError, StrainsMayJumpBetweenMaterials) {
  for (const bool tetrahedra : {false, true}) {
    const Mesh mesh = beam(4, tetrahedra);
    const Map pressed = [](const Vec3& p) -> Vec3 {
      return {p.x(), p.y(), p.z() - (p.z() < 0.5 ? 0.1 * p.z() : 0.05 + 0.01 * (p.z() - 0.5))};
    };
    std::vector<double> modulus;
    const auto add = [&](const auto& cells) {
      for (const auto& cell : cells) {
        double z = 0;
        for (const Index n : cell) z += mesh.position[std::size_t(n)].z() / double(cell.size());
        modulus.push_back(z < 0.5 ? 1 : 10);
      }
    };
    add(mesh.tetrahedra), add(mesh.hexahedra);
    EXPECT_GT(errorOf(mesh, pressed).share(), 0.05);
    EXPECT_LT(errorOf(mesh, pressed, modulus).share(), 1e-12);
  }
}

}  // namespace
}  // namespace stroma::test
