// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra of ten nodes: the patch test, the order of convergence against a manufactured solution, a beam against
// Timoshenko's, locking near Poisson's ratio 1/2.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "framework/fem/isotropic.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/simplex_size.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

constexpr int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// MacNeal and Harder's cube of seven distorted hexahedra, each cut into 24 tetrahedra around its centre, raised.
QuadraticBlock patch() {
  std::vector<Vec3> p{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (const Vec3& inner :
       {Vec3(.249, .342, .192), Vec3(.826, .288, .288), Vec3(.850, .649, .263), Vec3(.273, .750, .230),
        Vec3(.320, .186, .643), Vec3(.677, .305, .683), Vec3(.788, .693, .644), Vec3(.165, .745, .702)})
    p.push_back(inner);
  std::vector<std::array<int, 8>> hexahedra{{8, 9, 10, 11, 12, 13, 14, 15}};
  for (const auto& f : faces) hexahedra.push_back({f[3], f[2], f[1], f[0], f[3] + 8, f[2] + 8, f[1] + 8, f[0] + 8});
  std::map<std::set<int>, int> centre_of;
  const auto centre = [&](const std::set<int>& nodes) {
    const auto [at, is_new] = centre_of.try_emplace(nodes, int(p.size()));
    if (!is_new) return at->second;
    Vec3 sum = Vec3::Zero();
    for (int n : nodes) sum += p[std::size_t(n)] / double(nodes.size());
    p.push_back(sum);
    return at->second;
  };
  std::vector<Tetrahedron> cells;
  for (const auto& h : hexahedra) {
    const int middle = centre(std::set<int>(h.begin(), h.end()));
    for (const auto& f : faces) {
      const auto corner = [&](int k) { return h[std::size_t(f[k % 4])]; };
      const int at = centre({corner(0), corner(1), corner(2), corner(3)});
      for (int k = 0; k < 4; ++k) {
        Tetrahedron t{middle, at, corner(k), corner(k + 1)};
        if (tetrahedronVolume(p[std::size_t(t[0])], p[std::size_t(t[1])], p[std::size_t(t[2])], p[std::size_t(t[3])]) <
            0)
          std::swap(t[2], t[3]);
        cells.push_back(t);
      }
    }
  }
  return QuadraticBlock::raised(std::move(p), std::move(cells));
}

std::string words(const std::vector<Vec3>& list) {
  std::string text;
  for (const Vec3& p : list) text += fmt::format("{:.17g} {:.17g} {:.17g} ", p.x(), p.y(), p.z());
  return text;
}
bool isOnUnitCube(const Vec3& p) { return p.minCoeff() < 1e-12 || p.maxCoeff() > 1 - 1e-12; }

/// u = 1e-3 (2x + y + z)/2 and so on: normal stresses 2000 and shear stresses 400 for E = 1e6, nu = 0.25.
Mat3 displacementGradient() {
  Mat3 g;
  g << 2, 1, 1, 1, 2, 1, 1, 1, 2;
  return 0.5e-3 * g;
}

/// The boundary of the unit cube takes `place`; the rest starts turned and is solved for by `field` under nodal `forces`.
Simulation solved(const QuadraticBlock& block, const std::string& field, const std::function<Vec3(const Vec3&)>& place,
                  const std::vector<Vec3>& forces = {}, const Mat3& turn = Mat3::Identity()) {
  std::vector<Vec3> current;
  std::string held;
  for (std::size_t n = 0; n < block.position.size(); ++n) {
    const bool boundary = isOnUnitCube(block.position[n]);
    current.push_back(boundary ? place(block.position[n]) : Vec3(turn * block.position[n]));
    if (boundary) held += fmt::format("{} ", n);
  }
  std::string loads;
  if (!forces.empty()) {
    std::string indices;
    for (std::size_t n = 0; n < forces.size(); ++n) indices += fmt::format("{} ", n);
    loads = "<ConstantForceField indices=\"" + indices + "\" forces=\"" + words(forces) + "\"/>";
  }
  return simulationFromText("<Node name=\"root\" gravity=\"0 0 0\" dt=\"1\"><StaticSolver/><SparseLDLSolver/>" +
                            block.topology() + "<MechanicalObject position=\"" + words(current) +
                            "\" rest_position=\"" + block.positions() + "\"/><UniformMass totalMass=\"1\"/><" + field +
                            "/>" + loads + "<FixedProjectiveConstraint indices=\"" + held + "\"/></Node>");
}

TEST(QuadraticTetrahedra, PassThePatchTest) {
  const QuadraticBlock block = patch();
  const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const std::string method : {"small", "large", "polar", "svd", "green"})
    for (const std::string more : {"", " dilatation='mean'", " tangent='exact'"})
      for (const Mat3& r : {Mat3(Mat3::Identity()), turn}) {
        const bool turned = !r.isIdentity();
        if (turned && method == "small") continue;
        SCOPED_TRACE(method + more + (turned ? " turned" : ""));
        const std::string field = fmt::format(
            "QuadraticTetrahedronFEMForceField youngModulus='1e6' poissonRatio='0.25' method='{}'{}", method, more);
        const Mat3 gradient = displacementGradient();
        Simulation simulation = solved(
            block, field, [&](const Vec3& p) { return Vec3(r * (p + gradient * p)); }, {}, r);
        for (int step = 0; step < 3; ++step) ASSERT_FALSE(simulation.step().diverged);
        const System& system = *simulation.systems()[0];
        int inner = 0;
        for (Index n = 0; n < system.allRows(); ++n) {
          const Vec3& p = block.position[std::size_t(n)];
          EXPECT_LT((Vec3(system.x[n]) - r * (p + gradient * p)).norm(), 1e-10) << n;
          inner += !isOnUnitCube(p);
        }
        EXPECT_GT(inner, 150);
        std::vector<double> strain;
        for (ForceField* f : system.forceFields())
          if (f->type() == "QuadraticTetrahedronFEMForceField") f->cellField("strain", system.x, strain);
        ASSERT_EQ(strain.size(), 6u * 168);
        const double mu = 1e6 / 2.5, lambda = 1e6 * 0.25 / (1.25 * 0.5);
        const double quadratic = method == "green" ? 5 : method == "small" ? 1e-6 : 2.5;  // [Pa], strain 1e-3 squared
        for (std::size_t e = 0; e < strain.size() / 6; ++e) {
          const double* s = &strain[6 * e];
          for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(2 * mu * s[k] + lambda * (s[0] + s[1] + s[2]), 2000, quadratic);
            EXPECT_NEAR(2 * mu * s[3 + k], 400, quadratic);
          }
        }
      }
}

// ---- order ----

/// u = A sin(pi x) cos(pi y) (1 + z^2) and two others, with the body force that Hooke's law needs for it.
constexpr double amplitude = 1e-4, young = 1000;
using Numbers = std::array<double, 3>;  ///< as loops have them: tests are compiled without optimisation
Numbers exactNumbers(const Numbers& p) {
  using std::numbers::pi;
  return {amplitude * (std::sin(pi * p[0]) * std::cos(pi * p[1]) * (1 + p[2] * p[2])),
          amplitude * (std::cos(pi * p[2]) * std::sin(pi * p[1] + 1)),
          amplitude * (std::sin(pi * (p[0] + p[2])) * p[1])};
}
Vec3 exact(const Vec3& p) { return Vec3(exactNumbers({p.x(), p.y(), p.z()}).data()); }
/// -div sigma by differences of the displacement, whose error of 1e-8 is far below the elements'.
Vec3 bodyForce(const Vec3& p, double lambda, double mu) {
  constexpr double h = 1e-3;
  Mat3 second[3];  // second[c](i, j) = d2 u_c / dx_i dx_j, of fourth order in h
  const Numbers u = exactNumbers({p.x(), p.y(), p.z()});
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto moved = [&](double along_i, double along_j) {
        Numbers q{p.x(), p.y(), p.z()};
        q[i] += along_i * h, q[j] += along_j * h;
        return exactNumbers(q);
      };
      const auto at = [&](double s) {
        Numbers value;
        if (i == j) {
          const Numbers after = moved(s, 0), before = moved(-s, 0);
          for (std::size_t c = 0; c < 3; ++c) value[c] = (after[c] - 2 * u[c] + before[c]) / (s * s * h * h);
        } else {
          const Numbers pp = moved(s, s), pm = moved(s, -s), mp = moved(-s, s), mm = moved(-s, -s);
          for (std::size_t c = 0; c < 3; ++c) value[c] = (pp[c] - pm[c] - mp[c] + mm[c]) / (4 * s * s * h * h);
        }
        return value;
      };
      const Numbers near = at(1), far = at(2);
      for (std::size_t c = 0; c < 3; ++c) second[c](Index(i), Index(j)) = (4 * near[c] - far[c]) / 3;
    }
  Vec3 force;
  for (int c = 0; c < 3; ++c) {
    double gradient_of_divergence = 0;
    for (int k = 0; k < 3; ++k) gradient_of_divergence += second[k](k, c);
    force[c] = -(lambda + mu) * gradient_of_divergence - mu * second[c].trace();
  }
  return force;
}

/// The error in displacement, L2 over the unit cube, relative to the solution.
double errorOf(int n, double poisson, const std::string& dilatation, bool curved) {
  QuadraticBlock block = QuadraticBlock::box({n, n, n}, [](const Vec3& p) { return p; });
  if (curved)
    for (Vec3& p : block.position) {  // nothing moves on the boundary
      const Vec3 q = p.cwiseProduct(Vec3::Ones() - p);
      p += 0.5 * q.x() * q.y() * q.z() * Vec3(1, -2, 1.5);
    }
  const Lame lame = Lame::from(young, poisson);
  const CellKind& kind = cell_kinds::quadratic_tetrahedron;
  const auto forEachPoint = [&](auto&& visit) {
    for (const QuadraticTetrahedron& cell : block.cells)
      for (const QuadraturePoint& point : kind.rule(5).points) {
        std::array<double, 10> shape;
        std::array<LocalPoint, 10> slopes;
        kind.shapes(point.xi, shape.data());
        kind.gradients(point.xi, slopes.data());
        Mat3 j = Mat3::Zero();
        Vec3 place = Vec3::Zero();
        for (std::size_t a = 0; a < 10; ++a) {
          const double* p = block.position[std::size_t(cell[a])].data();
          for (int k = 0; k < 9; ++k) j.data()[k] += p[k % 3] * slopes[a][std::size_t(k / 3)];
          for (int k = 0; k < 3; ++k) place.data()[k] += shape[a] * p[k];
        }
        visit(cell, shape, place, point.weight * j.determinant());
      }
  };
  std::vector<Vec3> forces(block.position.size(), Vec3::Zero());
  forEachPoint([&](const auto& cell, const auto& shape, const Vec3& place, double weight) {
    const Vec3 b = bodyForce(place, lame.lambda, lame.mu);
    for (std::size_t a = 0; a < 10; ++a)
      for (int k = 0; k < 3; ++k) forces[std::size_t(cell[a])].data()[k] += weight * shape[a] * b.data()[k];
  });
  Simulation simulation = solved(
      block,
      fmt::format("QuadraticTetrahedronFEMForceField youngModulus='{}' poissonRatio='{}' method='small' "
                  "dilatation='{}'",
                  young, poisson, dilatation),
      [](const Vec3& p) { return Vec3(p + exact(p)); }, forces);
  EXPECT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  double error = 0, size = 0;
  forEachPoint([&](const auto& cell, const auto& shape, const Vec3& place, double weight) {
    Vec3 u = Vec3::Zero();
    for (std::size_t a = 0; a < 10; ++a) {
      const double *now = system.x.rows().data + std::size_t(cell[a]) * row_doubles,
                   *before = block.position[std::size_t(cell[a])].data();
      for (int k = 0; k < 3; ++k) u.data()[k] += shape[a] * (now[k] - before[k]);
    }
    error += weight * (u - exact(place)).squaredNorm(), size += weight * exact(place).squaredNorm();
  });
  return std::sqrt(error / size);
}

TEST(QuadraticTetrahedra, ConvergeWithTheThirdOrder) {
  for (const bool curved : {false, true}) {
    const double errors[] = {errorOf(2, 0.3, "local", curved), errorOf(4, 0.3, "local", curved),
                             errorOf(6, 0.3, "local", curved)};
    const double order = std::log(errors[1] / errors[2]) / std::log(1.5);
    fmt::print("{} edges, nu 0.3: L2 errors {:.3e} {:.3e} {:.3e}, order {:.2f}\n", curved ? "curved" : "straight",
               errors[0], errors[1], errors[2], order);
    EXPECT_GT(order, 2.8);
    EXPECT_LT(order, 3.4);
    EXPECT_LT(errors[2], 4e-3);
  }
}

// ---- bending and locking ----

/// A cantilever of 8 x 1 x 1 under an end shear, `cells` over the height, twice as long as high: the tip's deflection over
/// that of Timoshenko's beam. The clamp stops the cross-section from narrowing: 1 % at most.
double beam(int cells, double poisson, const std::string& attributes) {
  constexpr double length = 8, force = 1e-4;
  const QuadraticBlock block =
      QuadraticBlock::box({4 * cells, cells, cells}, [](const Vec3& p) { return Vec3(length * p.x(), p.y(), p.z()); });
  std::string held, loaded;
  int count = 0;
  for (std::size_t n = 0; n < block.position.size(); ++n) {
    if (block.position[n].x() < 1e-9) held += fmt::format("{} ", n);
    if (block.position[n].x() > length - 1e-9) loaded += fmt::format("{} ", n), ++count;
  }
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" gravity=\"0 0 0\" dt=\"1\"><StaticSolver/><SparseLDLSolver/>" + block.topology() +
      "<MechanicalObject/><UniformMass totalMass=\"1\"/>" +
      fmt::format("<QuadraticTetrahedronFEMForceField youngModulus='{}' poissonRatio='{}' {}/>"
                  "<ConstantForceField indices='{}' totalForce='0 0 {}'/><FixedProjectiveConstraint indices='{}'/>",
                  young, poisson, attributes, loaded, force, held) +
      "</Node>");
  EXPECT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  double tip = 0;
  for (std::size_t n = 0; n < block.position.size(); ++n)
    if (block.position[n].x() > length - 1e-9) tip += (system.x[Index(n)].z() - block.position[n].z()) / count;
  const double mu = young / (2 * (1 + poisson));
  return tip / (force * length * length * length / (3 * young / 12) + force * length / (5. / 6 * mu));
}

TEST(QuadraticTetrahedra, BendWithTwoCellsAndDoNotLock) {
  for (const double poisson : {0.0, 0.3, 0.45, 0.49, 0.499, 0.4999}) {
    const double local = beam(2, poisson, "method='small' dilatation='local'"),
                 mean = beam(2, poisson, "method='small' dilatation='mean'");
    fmt::print(
        "nu {:6}: tip over Timoshenko's, 2 cells: local {:.4f}, mean {:.4f}; 1 cell: local {:.4f}, mean {:.4f}\n",
        poisson, local, mean, beam(1, poisson, "method='small' dilatation='local'"),
        beam(1, poisson, "method='small' dilatation='mean'"));
    // what auto takes
    if (poisson < 0.45) {
      EXPECT_NEAR(local, 1, 0.03) << poisson;
    } else {
      EXPECT_NEAR(mean, 1, 0.03) << poisson;
      EXPECT_LT(std::abs(mean - 1), std::abs(local - 1)) << poisson;
    }
  }
}

}  // namespace
}  // namespace stroma::test
