// SPDX-License-Identifier: LGPL-2.1-or-later
// The porous part, on both kinds of cell: its stress, the fluid's mass, its tangents, what it refuses.
#include <Eigen/Geometry>

#include "components/hyperelasticity/porous_cells.h"
#include "tests/hyperelasticity/porous_bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// sigma of the only element: f_1 = -sigma cof F int grad N_1 dV.
double stress(const PorousKind& kind, FieldUnderTest& t, const Mat3& f) {
  t.rest();
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]);
  Mat3 cofactors;
  cofactors << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
  const Vec3 area = cofactors * kind.gradient;
  return -t.force()[1].dot(area) / area.squaredNorm();
}
Mat3 shapeOf(double j) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  f.row(0) *= j / f.determinant();
  return f;
}

TEST(Porous, HenckysStressAndItsTangentBelowTheBound) {
  for (const PorousKind& kind : porousKinds()) {
    FieldUnderTest t(kind.oneCell("permeability=\"0\""), kind.field);
    t.field().reset();
    const double bound = 0.2 + 400. / 2200;
    for (double j : {3., 1.3, 1., 0.7, 0.4, bound + 1e-9, bound - 1e-9, 0.3, 0.1, -0.5}) {
      const double at = std::max(j, bound);
      const double expected = 400 * 0.8 * std::log((0.8 + at - 1) / 0.8) + 0.8 * 2200 * (j - at);
      EXPECT_NEAR(stress(kind, t, shapeOf(j)), expected, 1e-9 * 400) << kind.name << " " << j;
    }
  }
}

/// Nothing flows: P = -alpha M ln J, and alpha P pushes.
TEST(Porous, FluidThatCannotLeaveIsCompressed) {
  struct Storage {
    std::string attributes;
    double alpha, modulus;
  };
  const std::vector<Storage> storages{
      {"", 1, 2200},
      {"biotCoefficient=\"0.85\" biotModulus=\"900\"", 0.85, 900},
      {"biotCoefficient=\"0.9\" grainModulus=\"5000\" fluidModulus=\"1600\"", 0.9, 1 / (0.1 / 5000 + 0.8 / 1600)}};
  for (const PorousKind& kind : porousKinds())
    for (const std::string& coupling : couplings)
      for (const Storage& storage : storages) {
        FieldUnderTest t(kind.oneCell("permeability=\"0\" coupling=\"" + coupling + "\" " + storage.attributes),
                         kind.field);
        t.field().reset();
        const double m = storage.modulus, alpha = storage.alpha;
        double previous = 1;
        for (int n = 1; n <= 10; ++n) {
          const double j = 1 - 0.04 * n;
          t.field().setTime(0.01 * n);
          const double found = stress(kind, t, shapeOf(j));
          // forces before the pressure follows: that of the step before
          const double seen = coupling == "implicit" ? j : previous;
          EXPECT_NEAR(found, 400 * 0.8 * std::log((j - 0.2) / 0.8) + alpha * alpha * m * std::log(seen), 1e-9 * 2200)
              << kind.name << " " << coupling << " " << storage.attributes;
          copy(t.x, t.system().x);
          History& history = dynamic_cast<History&>(t.field());
          history.stepEnded(0.01 * n);
          for (double p : history.history())
            EXPECT_NEAR(p, -alpha * m * std::log(j), 1e-9 * 2200) << kind.name << " " << coupling << " " << n;
          previous = j;
        }
      }
}

/// sum of W P / M + alpha V_0 ln J and of W |P| / M, from the mesh.
std::pair<double, double> fluid(const PorousKind& kind, FieldUnderTest& t, double alpha, double modulus) {
  const Mesh& mesh = t.field().node().find<Topology>(nullptr, true)->mesh();
  const std::vector<double>& p = dynamic_cast<History&>(t.field()).history();
  const auto& rest = t.field().state().rest_position;
  double sum = 0, size = 0;
  const auto add = [&](const auto& cell) {
    Vec3 before[8], now[8];
    for (std::size_t a = 0; a < cell.size(); ++a) before[a] = rest[cell[a]], now[a] = t.system().x[cell[a]];
    const double volume = kind.cell.size(before);
    sum += alpha * volume * std::log(kind.cell.size(now) / volume);
    for (const QuadraturePoint& point : kind.cell.rule(4).points) {  // int N_a dV
      double n[8];
      LocalPoint slopes[8];
      kind.cell.shapes(point.xi, n), kind.cell.gradients(point.xi, slopes);
      Mat3 j = Mat3::Zero();
      double* entry = j.data();  // in numbers: compiled without optimisation
      for (std::size_t a = 0; a < cell.size(); ++a)
        for (int k = 0; k < 9; ++k) entry[k] += before[a].data()[k % 3] * slopes[a][std::size_t(k / 3)];
      const double weight = point.weight * j.determinant();
      for (std::size_t a = 0; a < cell.size(); ++a) {
        const double share = weight * n[a];
        sum += share * p[cell[a]] / modulus, size += share * std::abs(p[cell[a]]) / modulus;
      }
    }
  };
  for (const Tetrahedron& cell : mesh.tetrahedra) add(cell);
  for (const Hexahedron& cell : mesh.hexahedra) add(cell);
  return {sum, size};
}

TEST(Porous, FluidIsKept) {
  for (const PorousKind& kind : porousKinds())
    for (const std::string& coupling : couplings)
      for (const double alpha : {1., 0.7})
        for (bool drained : {false, true}) {
          FieldUnderTest t(
              kind.body("permeability=\"1e-7\" coupling=\"" + coupling + "\" biotCoefficient=\"" + textOf(alpha) +
                        "\" biotModulus=\"1500\"" + (drained ? " drainedIndices=\"0 1 2 3\"" : "")),
              kind.field);
          t.field().reset();
          t.rest();
          copy(t.x, t.system().x);
          for (int n = 1; n <= 20; ++n) {
            t.field().setTime(0.01 * n);
            t.deform(0.005, unsigned(n));                                      // J stays above J_0, where ln J is ln J
            for (Index i = 0; i < t.x.count(); ++i) t.x[i] -= Vec3(3, -2, 1);  // near the origin sums round less
            t.force();
            copy(t.x, t.system().x);
            dynamic_cast<History&>(t.field()).stepEnded(0.01 * n);
            const auto [sum, size] = fluid(kind, t, alpha, 1500);
            ASSERT_GT(size, 0);
            if (!drained) {
              EXPECT_LT(std::abs(sum), 1e-13 * size) << kind.name << " " << coupling << " step " << n;
            } else if (n == 20) {
              EXPECT_GT(std::abs(sum), 1e-6 * size) << kind.name;
            }
          }
        }
}

/// With the pressure of the step frozen the tangent is exact, and the force the slope of the energy. With it following
/// the tangent is exact but for the differences of J between the elements that a pressure joins: they are of the size of
/// the strains.
TEST(Porous, TangentHasThePressureThatFollows) {
  const std::string biot = " biotCoefficient=\"0.8\" biotModulus=\"3000\"";
  for (const PorousKind& kind : porousKinds()) {
    const auto error = [&kind](const std::string& scene, double noise) {
      FieldUnderTest t(scene, kind.field);
      t.deform(noise);
      t.field().setTime(0.02);
      return relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge()));
    };
    EXPECT_LT(error(kind.body("permeability=\"1e-7\"" + biot), 0.03), 1e-6) << kind.name;
    const std::string implicit = " coupling=\"implicit\"";
    for (const std::string cell : {"permeability=\"0\"", "permeability=\"1\" drainedIndices=\"0 1 2 3\"",
                                   "permeability=\"1\" drainedIndices=\"0 1\""})
      for (const std::string& more : {std::string(), biot})
        EXPECT_LT(error(kind.oneCell(cell + implicit + more), 0.03), 1e-6) << kind.name << " " << cell << more;
    for (const std::string whole : {"permeability=\"1e-7\"", "permeability=\"1e-4\" drainedIndices=\"0 1 2 3\""}) {
      const std::string scene = kind.body(whole + implicit + biot);
      const double coarse = error(scene, 0.03), fine = error(scene, 0.01);
      std::printf("%s, %s: tangent errs by %.3f with noise of 3 %%, by %.3f with 1 %%\n", kind.name.c_str(),
                  whole.c_str(), coarse, fine);
      EXPECT_LT(coarse, 0.1) << kind.name << " " << whole;
      EXPECT_LT(fine, 0.5 * coarse) << kind.name << " " << whole;
    }
  }
}

/// A product with the pressure that follows solves for the flow, and says that it costs as much more.
TEST(Porous, ProductsCostTheFlowThatTheySolve) {
  constexpr double each_node = 60, least_each_node = 1.45;  // of a factor with its diagonal alone
  for (const PorousKind& kind : porousKinds()) {
    const auto cost = [&](const std::string& coupling) {
      FieldUnderTest t(kind.body("permeability=\"1e-7\" coupling=\"" + coupling + "\""), kind.field);
      t.rest();
      t.field().setTime(0.02);
      return t.field().cost().product / double(t.x.count());
    };
    EXPECT_GT(cost("implicit") - cost("semi_implicit"), each_node + least_each_node) << kind.name;
  }
}

/// Of a pressure that is there and does not change.
TEST(Porous, ForceIsTheSlopeOfTheEnergy) {
  for (const PorousKind& kind : porousKinds()) {
    std::string pressures;
    FieldUnderTest plain(kind.body("permeability=\"0\""), kind.field);
    for (Index i = 0; i < plain.x.count(); ++i) pressures += textOf(500 * std::sin(i)) + " ";
    FieldUnderTest t(
        kind.body("permeability=\"0\" biotCoefficient=\"0.7\" biotModulus=\"2200\" pressure=\"" + pressures + "\""),
        kind.field);
    t.deform(0.05);
    const double step = 1e-6 * t.typicalEdge();
    Vector a(t.x.count()), b(t.x.count());
    copy(t.x, a), copy(t.x, b);
    axpy(step, t.direction, a), axpy(-step, t.direction, b);
    const double slope = (t.field().energy(a) - t.field().energy(b)) / (2 * step);
    EXPECT_NEAR(dot(t.force(), t.direction), -slope, 1e-7 * std::abs(slope)) << kind.name;
    EXPECT_GT(std::abs(dot(t.force(), t.direction) - dot(plain.forceAt(t.x), t.direction)), 0.01 * std::abs(slope));
  }
}

TEST(Porous, ProductsAreOfTheMatrix) {
  for (const PorousKind& kind : porousKinds())
    for (const std::string& coupling : couplings)
      for (const std::string biot : {"", "biotCoefficient=\"0.7\" biotModulus=\"3000\""}) {
        FieldUnderTest t(kind.body("permeability=\"1e-7\" coupling=\"" + coupling + "\" " + biot), kind.field);
        t.deform(0.03);
        t.field().setTime(0.02);
        SCOPED_TRACE(kind.name + " " + coupling + " " + biot);
        expectMatrixOfProducts(t);
        expectSymmetricProducts(t);
      }
}

/// A uniform pressure on cells of any shape pushes as uniform tractions on their outer faces do, and not inside.
TEST(Porous, AUniformPressureIsAUniformTraction) {
  const PorousKind& kind = porousKinds()[1];
  std::string pressures;
  for (int i = 0; i < 60; ++i) pressures += "300 ";
  FieldUnderTest t(
      kind.body("permeability=\"0\" biotCoefficient=\"0.7\" biotModulus=\"2200\" pressure=\"" + pressures + "\""),
      kind.field);
  const Mesh& mesh = t.field().node().find<Topology>(nullptr, true)->mesh();
  for (const double j : {1., 0.8, 1.3}) {
    const Mat3 f = shapeOf(j);
    t.rest();
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]);
    const double traction = 400 * 0.5 * std::log((j - 0.5) / 0.5) - 0.7 * 300;
    Vector expected(t.x.count());
    for (const Quad& face : mesh.boundaryQuads())
      for (const QuadraturePoint& point : cell_kinds::quad.rule(3).points) {
        double n[4];
        LocalPoint slopes[4];
        cell_kinds::quad.shapes(point.xi, n), cell_kinds::quad.gradients(point.xi, slopes);
        Vec3 along = Vec3::Zero(), across = Vec3::Zero();
        for (std::size_t a = 0; a < 4; ++a)
          along += slopes[a][0] * Vec3(t.x[face[a]]), across += slopes[a][1] * Vec3(t.x[face[a]]);
        for (std::size_t a = 0; a < 4; ++a) expected[face[a]] -= traction * point.weight * n[a] * along.cross(across);
      }
    EXPECT_GT(dot(expected, expected), 0);
    EXPECT_LT(relativeDifference(t.force(), expected), 1e-13) << j;
  }
}

/// A pressure that is linear in space flows through cells of any shape without a change: L P = 0 inside. The shares of
/// the nodes are the volume.
TEST(Porous, ALinearPressureFlowsSteadily) {
  for (const PorousKind& kind : porousKinds()) {
    FieldUnderTest t(kind.body("permeability=\"0\""), kind.field);
    const Mesh& mesh = t.field().node().find<Topology>(nullptr, true)->mesh();
    const std::vector<Vec3>& rest = t.field().state().rest_position;
    const porous::PorousCells cells(kind.cell, mesh, rest);
    std::vector<char> outside(rest.size(), 0);
    for (const Triangle& face : mesh.boundaryTriangles())
      for (Index node : face) outside[node] = 1;
    for (const Quad& face : mesh.boundaryQuads())
      for (Index node : face) outside[node] = 1;
    std::vector<double> flow(rest.size(), 0.), size(rest.size(), 0.);
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      const auto nodes = cells.nodes(cell);
      const auto gradients = cells.gradients(cell);
      const auto shares = cells.shares(cell);
      Vec3 corner[8];
      double volume = 0;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        corner[a] = rest[nodes[a]], volume += shares[a];
        for (std::size_t b = 0; b < nodes.size(); ++b) {
          const double part = gradients[a][b] * rest[nodes[b]].dot(Vec3(300, -200, 500));
          flow[nodes[a]] += part, size[nodes[a]] += std::abs(part);
        }
      }
      EXPECT_NEAR(volume, kind.cell.size(corner), 1e-13 * volume) << kind.name;
    }
    int inside = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (outside[i]) continue;
      EXPECT_LT(std::abs(flow[i]), 1e-12 * size[i]) << kind.name << " " << i;
      ++inside;
    }
    EXPECT_GE(inside, 6) << kind.name;
  }
}

/// The cheap tangent is the one of a single cell that nothing leaves; matrix and product agree, and it needs more
/// iterations.
TEST(Porous, TheUndrainedTangentIsThatOfFluidThatStays) {
  const std::string undrained =
      " coupling=\"implicit\" tangent=\"undrained\" biotCoefficient=\"0.9\" biotModulus=\"2200\"";
  for (const PorousKind& kind : porousKinds()) {
    FieldUnderTest closed(kind.oneCell("permeability=\"0\"" + undrained), kind.field);
    closed.deform(0.03);
    closed.field().setTime(0.02);
    const double step = 1e-6 * closed.typicalEdge();
    EXPECT_LT(relativeDifference(closed.product(closed.direction), closed.differenceOfForces(step)), 1e-6);
    FieldUnderTest whole(kind.body("permeability=\"1e-7\"" + undrained), kind.field);
    whole.deform(0.03);
    whole.field().setTime(0.02);
    expectMatrixOfProducts(whole);
    int iterations[2];
    for (int coupled = 0; coupled < 2; ++coupled) {
      Column column;
      column.kind = &kind;
      column.limit = 7e3;
      if (!coupled) column.coupling += "\" tangent=\"undrained";
      Simulation s = simulationFromText(column.scene());
      iterations[coupled] = s.step().newton_iterations;
    }
    EXPECT_GT(iterations[0], 10 * iterations[1]) << kind.name;
  }
}

TEST(Porous, SaysWhatIsWrong) {
  for (const PorousKind& kind : porousKinds()) {
    const auto expect = [&kind](const std::string& attributes, const std::string& words) {
      const std::string problems = problemsOf(kind.oneCell(attributes));
      EXPECT_NE(problems.find(words), std::string::npos) << kind.name << " " << attributes << ": " << problems;
    };
    expect("", "permeability");
    expect("permeability=\"0\" pressure=\"1 2\"", "pressure has 2 values");
    expect("permeability=\"0\" drainedIndices=\"9\"", "9");
    expect("permeability=\"0\" biotCoefficient=\"1.1\"", "biotCoefficient");
    expect("permeability=\"0\" biotCoefficient=\"0.85\"", "grains that give way store fluid too");
    expect("permeability=\"0\" biotCoefficient=\"0.7\"", "a biotCoefficient between fluidFraction and 1");
    expect("permeability=\"0\" grainModulus=\"1e4\"", "grainModulus needs fluidModulus");
    expect("permeability=\"0\" fluidModulus=\"1e4\"", "fluidModulus needs grainModulus");
    expect("permeability=\"0\" grainModulus=\"1e4\" fluidModulus=\"1e4\" biotModulus=\"1e4\"",
           "give the storage twice");
    std::string text = kind.oneCell("permeability=\"0\"");
    text.replace(text.find("limitModulus=\"2200\""), 19, "limitModulus=\"450\"");
    EXPECT_NE(problemsOf(text).find("limitModulus of at least"), std::string::npos) << problemsOf(text);
  }
  const PorousKind& hexahedra = porousKinds()[1];
  const auto expectCell = [&](const std::string& from, const std::string& to, const std::string& words) {
    std::string text = hexahedra.oneCell("permeability=\"0\"");
    text.replace(text.find(from), from.size(), to);
    EXPECT_NE(problemsOf(text).find(words), std::string::npos) << problemsOf(text);
  };
  expectCell("0 0 1 1 0 1 1 1 1 0 1 1\"", "0 0 0 1 0 0 1 1 0 0 1 0\"", "is flat at rest");
  expectCell("1 1 1 0 1 1\"", "-2 -2 1 0 1 1\"", "is folded at rest");
  expectCell("0 1 1\" hexa", "0 1 1 5 5 5\" hexa", "there is no hexahedron with node 8");
}

/// What is said of a scene at load.
std::string saidOf(const std::string& scene) {
  testing::internal::CaptureStderr();
  simulationFromText(scene);
  return testing::internal::GetCapturedStderr();
}

TEST(Porous, AloneResistsNoChangeOfShape) {
  const std::string words = "nothing here resists changes of shape";
  for (const PorousKind& kind : porousKinds()) {
    const std::string alone = kind.oneCell("permeability=\"1e-6\""), end = "</Node>";
    expectContains(saidOf(alone), words);
    const std::string whole = std::regex_replace(alone, std::regex(end + "$"), "<RestShapeSpringsForceField stiffness=\"1\"/>" + end);
    EXPECT_EQ(saidOf(whole).find(words), std::string::npos);
  }
}

/// No default fits two tissues: a fluid of 2200 Pa, which one of them has, carries nothing in another.
TEST(Porous, TheModuliOfTheFluidMustBeWritten) {
  for (const PorousKind& kind : porousKinds())
    for (const std::string name : {"bulkModulus", "limitModulus"})
      expectContains(problemsOf(std::regex_replace(kind.oneCell("permeability=\"1e-6\""), std::regex(name + "=\"[^\"]*\""), "")),
                     name);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
