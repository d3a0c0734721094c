// SPDX-License-Identifier: LGPL-2.1-or-later
// Every entry of the table of kinds of cells, by enumeration: against closed forms, differences and Gauss's theorem.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "framework/mesh/area_vectors.h"
#include "framework/mesh/cell_lists.h"
#include "tests/support/cell_kind_names.h"
#include "tools/mesh_report/cell_quality.h"

namespace stroma::test {
namespace {

class CellKinds : public testing::TestWithParam<const CellKind*> {
 protected:
  const CellKind& kind_ = *GetParam();
  std::mt19937 random_{7};

  double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  LocalPoint somePoint() {
    LocalPoint xi{};
    for (int i = 0; i < kind_.dimension; ++i) xi[i] = number();
    if (kind_.type != CellType::pyramid) return xi;
    const double height = 0.25 + 0.25 * xi[2];  // within it, and not at its top: there the shapes are no polynomials
    return {(1 - height) * xi[0], (1 - height) * xi[1], height};
  }
  std::vector<double> shapes(const LocalPoint& xi) const {
    std::vector<double> n(std::size_t(kind_.nodes));
    kind_.shapes(xi, n.data());
    return n;
  }
  std::vector<LocalPoint> gradients(const LocalPoint& xi) const {
    std::vector<LocalPoint> slopes(std::size_t(kind_.nodes));
    kind_.gradients(xi, slopes.data());
    return slopes;
  }
  /// The reference cell, turned, stretched and moved in space.
  std::vector<Vec3> affineCell() {
    Mat3 map = Mat3::Identity();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) map(i, j) += 0.3 * number();
    const Vec3 shift(number(), number(), number());
    std::vector<Vec3> x;
    for (const LocalPoint& xi : kind_.reference) x.push_back(map * Vec3(xi.data()) + shift);
    return x;
  }
  /// With nodes off their places, so that faces are warped.
  std::vector<Vec3> warpedCell() {
    std::vector<Vec3> x = affineCell();
    for (Vec3& p : x) p += 0.1 * Vec3(number(), number(), number());
    return x;
  }
  std::vector<Face> facesOf() const {
    std::vector<Face> faces;
    for (const LocalFace& face : kind_.faces) {
      const auto& n = face.nodes;
      const int count = kindOf(face.type).nodes;
      faces.push_back(count == 3   ? Face(Triangle{n[0], n[1], n[2]})
                      : count == 4 ? Face(Quad{n[0], n[1], n[2], n[3]})
                                   : Face(QuadraticTriangle(n)));
    }
    return faces;
  }
};

TEST_P(CellKinds, HaveTheirPlaceAndCountsInTheTable) {
  EXPECT_EQ(&kindOf(kind_.type), &kind_);
  EXPECT_EQ(kind_.reference.size(), std::size_t(kind_.nodes));
  EXPECT_LE(kind_.nodes, most_cell_nodes);
  EXPECT_EQ(std::string(kind_.word), char(std::toupper(kind_.singular[0])) + std::string(kind_.singular.substr(1)));
  EXPECT_EQ(kind_.faces.empty(), kind_.dimension < 3);
  EXPECT_EQ(kind_.edges.empty(), kind_.dimension < 1);
  const std::size_t corners = kind_.order == 1 ? std::size_t(kind_.nodes) : 4;
  EXPECT_EQ(kind_.corner_edges.size(), kind_.dimension < 3 ? 0u : corners);
  for (const CellFormat& format : {kind_.vtk, kind_.gmsh}) {
    std::set<int> order(format.order.begin(), format.order.end());
    EXPECT_EQ(order.size(), std::size_t(kind_.nodes));
    EXPECT_EQ(*order.begin(), 0);
    EXPECT_EQ(*order.rbegin(), kind_.nodes - 1);
  }
  EXPECT_EQ(kindByNumber(&CellKind::vtk, kind_.vtk.number), &kind_);
  EXPECT_EQ(kindByNumber(&CellKind::gmsh, kind_.gmsh.number), &kind_);
}

TEST_P(CellKinds, ShapesInterpolateAndSumToOne) {
  for (std::size_t a = 0; a < kind_.reference.size(); ++a) {
    const auto n = shapes(kind_.reference[a]);
    for (std::size_t b = 0; b < n.size(); ++b) EXPECT_EQ(n[b], a == b ? 1 : 0);
  }
  for (int k = 0; k < 20; ++k) {
    const LocalPoint xi = somePoint();
    const auto n = shapes(xi);
    double sum = 0;
    Vec3 x = Vec3::Zero();
    for (std::size_t a = 0; a < n.size(); ++a) sum += n[a], x += n[a] * Vec3(kind_.reference[a].data());
    const double round_off = kind_.order == 1 ? 1e-15 : 1e-14;  // outside of the cell quadratic functions reach 10
    EXPECT_NEAR(sum, 1, round_off);
    EXPECT_NEAR((x - Vec3(xi.data())).norm(), 0, round_off);  // linear functions are reproduced
  }
}

TEST_P(CellKinds, GradientsAreDifferencesOfShapes) {
  constexpr double h = 1e-5;
  for (int k = 0; k < 20; ++k) {
    const LocalPoint xi = somePoint();
    const auto slopes = gradients(xi);
    for (int i = 0; i < 3; ++i) {
      LocalPoint plus = xi, minus = xi;
      plus[i] += h, minus[i] -= h;
      const auto high = shapes(plus), low = shapes(minus);
      for (std::size_t a = 0; a < high.size(); ++a)
        EXPECT_NEAR(slopes[a][i], i < kind_.dimension ? (high[a] - low[a]) / (2 * h) : 0,
                    kind_.order == 1 ? 1e-10 : 1e-9)
            << a << " " << i;
    }
  }
}

bool isBox(const CellKind& kind) { return kind.reference[0][0] < 0 && kind.type != CellType::pyramid; }

/// The integral of xi^p eta^q zeta^r over the reference cell: 2/(p + 1) along each axis of a box for even powers, and
/// p! q! r! / (p + q + r + d)! over a simplex; of a prism the product of both; of a pyramid the base's square, times the
/// integral of (1 - zeta)^(p + q + 2) zeta^r.
double monomialIntegral(const CellKind& kind, const std::array<int, 3>& power) {
  const auto along = [](int p) { return p % 2 ? 0 : 2. / (p + 1); };
  if (kind.type == CellType::prism)
    return std::tgamma(power[0] + 1) * std::tgamma(power[1] + 1) / std::tgamma(power[0] + power[1] + 3) * along(power[2]);
  if (kind.type == CellType::pyramid)
    return along(power[0]) * along(power[1]) * std::tgamma(power[0] + power[1] + 3) * std::tgamma(power[2] + 1) /
           std::tgamma(power[0] + power[1] + power[2] + 4);
  const bool box = isBox(kind);
  double box_value = 1, simplex_value = 1;
  int sum = kind.dimension;
  for (int i = 0; i < kind.dimension; ++i) {
    box_value *= power[i] % 2 ? 0 : 2. / (power[i] + 1);
    simplex_value *= std::tgamma(power[i] + 1);
    sum += power[i];
  }
  return box ? box_value : simplex_value / std::tgamma(sum + 1);
}

TEST_P(CellKinds, RulesAreExactUpToTheirDegreeAndNoFurther) {
  const bool box = isBox(kind_);
  for (const QuadratureRule& rule : kind_.rules) {
    const int degree = std::min(rule.degree, 4);
    double worst_beyond = 0;
    const int last[3] = {kind_.dimension > 0 ? degree + 1 : 0, kind_.dimension > 1 ? degree + 1 : 0,
                         kind_.dimension > 2 ? degree + 1 : 0};
    for (int p = 0; p <= last[0]; ++p)
      for (int q = 0; q <= last[1]; ++q)
        for (int r = 0; r <= last[2]; ++r) {
          double sum = 0;
          for (const QuadraturePoint& point : rule.points)
            sum += point.weight * std::pow(point.xi[0], p) * std::pow(point.xi[1], q) * std::pow(point.xi[2], r);
          const double error = std::abs(sum - monomialIntegral(kind_, {p, q, r}));
          const int used = box ? std::max({p, q, r}) : p + q + r;
          if (used <= degree)
            EXPECT_LT(error, 1e-15 * 8) << p << q << r << " degree " << degree;
          else
            worst_beyond = std::max(worst_beyond, error);
        }
    if (kind_.dimension > 0) {
      EXPECT_GT(worst_beyond, rule.degree < 5 ? 1e-4 : 1e-6) << "the rule is better than it says";
    }
    EXPECT_EQ(&kind_.rule(rule.degree), &rule);
  }
}

TEST_P(CellKinds, PointsOfARuleOfNodesLieTowardsTheirNodes) {
  for (const QuadratureRule& rule : kind_.rules)
    for (std::size_t a = 0; rule.points.size() == kind_.reference.size() && a < rule.points.size(); ++a) {
      if (!isBox(kind_)) continue;
      const Vec3 point(rule.points[a].xi.data()), node(kind_.reference[a].data());
      EXPECT_NEAR((point * std::sqrt(3.) - node).norm(), 0, 1e-15);
    }
}

TEST_P(CellKinds, FacesAreClosedAndTurnedOutward) {
  if (kind_.dimension < 3) return;
  for (const std::vector<Vec3>& x : {affineCell(), warpedCell()}) {
    Vec3 area = Vec3::Zero();
    double flux = 0;  // of x/3: the volume, by Gauss's theorem
    for (const Face& face : facesOf()) {
      area_vectors::Corners corners;
      for (std::size_t a = 0; a < corners.size(); ++a) corners[a] = x[std::size_t(face.nodes[a])];
      const auto areas = area_vectors::of(corners, face.corners);
      for (std::size_t a = 0; a < std::size_t(face.corners); ++a)
        area += areas[a], flux += corners[a].dot(areas[a]) / 3;
    }
    EXPECT_NEAR(area.norm(), 0, 1e-14);
    EXPECT_GT(kind_.size(x.data()), 0);
    EXPECT_NEAR(flux, kind_.size(x.data()), 1e-13);
  }
}

TEST_P(CellKinds, EdgesAreThoseOfTheFacesAndCorners) {
  const auto sorted = [](int a, int b) { return std::pair(std::min(a, b), std::max(a, b)); };
  std::set<std::pair<int, int>> edges, of_faces, of_corners;
  for (const auto& [a, b] : kind_.edges) EXPECT_TRUE(edges.insert(sorted(a, b)).second);
  if (kind_.dimension < 3) return;
  for (const LocalFace& face : kind_.faces)
    for (const auto& [a, b] : kindOf(face.type).edges) of_faces.insert(sorted(face.nodes[a], face.nodes[b]));
  EXPECT_EQ(of_faces, edges);
  for (int a = 0; a < int(kind_.corner_edges.size()); ++a) {
    std::array<Vec3, 3> along;
    for (std::size_t k = 0; k < 3; ++k) {
      const int b = kind_.corner_edges[a][k];
      of_corners.insert(sorted(a, b));
      along[k] = Vec3(kind_.reference[b].data()) - Vec3(kind_.reference[a].data());
    }
    EXPECT_GT(along[0].cross(along[1]).dot(along[2]), 0) << "corner " << a;
  }
  EXPECT_EQ(of_corners, edges);
}

TEST_P(CellKinds, SizeIsTheIntegralOfTheMap) {
  if (!kind_.size) return;
  const std::vector<Vec3> x = affineCell();
  double reference = 0;
  for (const QuadraturePoint& point : kind_.rules[0].points) reference += point.weight;
  const auto slopes = gradients(kind_.reference[0]);
  Mat3 j = Mat3::Zero();
  for (std::size_t a = 0; a < x.size(); ++a) j += x[a] * Vec3(slopes[a].data()).transpose();
  const double measure = kind_.dimension == 1   ? j.col(0).norm()
                         : kind_.dimension == 2 ? j.col(0).cross(j.col(1)).norm()
                                                : j.determinant();
  EXPECT_NEAR(kind_.size(x.data()), measure * reference, 1e-14);
  if (kind_.dimension < 3) return;
  std::vector<Vec3> mirrored = x;
  for (Vec3& p : mirrored) p.x() = -p.x();
  EXPECT_NEAR(kind_.size(mirrored.data()), -kind_.size(x.data()), 1e-14);
  EXPECT_LT(cellQuality(kind_, mirrored.data()), 0);
  EXPECT_GT(cellQuality(kind_, x.data()), 0);
  EXPECT_LE(cellQuality(kind_, x.data()), 1 + 1e-15);
}

TEST_P(CellKinds, HoldMovesOutsidePointsToTheBorder) {
  for (int k = 0; k < 50; ++k) {
    LocalPoint xi = somePoint();
    for (double& value : xi) value *= 3;
    const LocalPoint before = xi;
    const auto least = [&](const LocalPoint& at) {
      std::vector<double> n = shapes(at);
      if (kind_.order > 1) {  // the volume coordinates
        n.assign(std::size_t(kind_.dimension) + 1, 1);
        for (int i = 0; i < kind_.dimension; ++i)
          n[0] -= at[std::size_t(i)], n[std::size_t(i) + 1] = at[std::size_t(i)];
      }
      return *std::min_element(n.begin(), n.end());
    };
    const bool box = isBox(kind_);
    const bool inside =
        box ? std::all_of(xi.begin(), xi.end(), [](double v) { return std::abs(v) <= 1; }) : least(xi) >= 0;
    kind_.hold(xi);
    if (inside) {
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(xi[i], before[i], 1e-15);
    } else {
      EXPECT_NEAR(least(xi), 0, 1e-15);
    }
    const LocalPoint held = xi;
    kind_.hold(xi);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(xi[i], held[i], 1e-15);
  }
}

INSTANTIATE_TEST_SUITE_P(All, CellKinds, testing::ValuesIn(cell_kinds::all),
                         [](const auto& kind) { return std::string(kind.param->singular); });

TEST(CellLists, GoThroughAMeshInAscendingDimension) {
  Mesh mesh;
  EXPECT_EQ(highestDimension(mesh), 0);
  std::vector<std::string_view> words;
  int dimension = 1;
  forEachCellList(
      [&](const CellKind& kind, const auto& cells) {
        words.push_back(kind.plural);
        EXPECT_GE(kind.dimension, dimension);
        EXPECT_EQ(std::tuple_size_v<typename std::decay_t<decltype(cells)>::value_type>, std::size_t(kind.nodes));
        dimension = kind.dimension;
      },
      mesh);
  EXPECT_EQ(words.size(), std::size_t(cell_types) - 1);  // all but points
  mesh.edges.push_back({0, 1});
  EXPECT_EQ(highestDimension(mesh), 1);
  mesh.quads.push_back({0, 1, 2, 3});
  EXPECT_EQ(highestDimension(mesh), 2);
  mesh.tetrahedra.push_back({0, 1, 2, 3});
  EXPECT_EQ(highestDimension(mesh), 3);
}

}  // namespace
}  // namespace stroma::test
