// SPDX-License-Identifier: LGPL-2.1-or-later
// The porous part: its stress, the fluid's mass, Terzaghi's consolidation.
#include <Eigen/Geometry>
#include <numbers>

#include "framework/mechanics/history.h"
#include "framework/mesh/topology.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {
namespace {

const std::string porous = "TetrahedronPorousForceField";
const std::vector<std::string> couplings{"semi_implicit", "implicit"};

std::string oneCell(const std::string& attributes) {
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>"
         "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\"/>"
         "<MechanicalObject/><UniformMass totalMass=\"1\"/><" +
         porous + " fluidFraction=\"0.8\" bulkModulus=\"400\" limitModulus=\"2200\" " + attributes + "/></Node>";
}
/// sigma of the only element: f_1 = -sigma cof F e_1 / 6.
double stress(FieldUnderTest& t, const Mat3& f) {
  t.rest();
  for (Index i = 0; i < 4; ++i) t.x[i] = f * Vec3(t.x[i]);
  const Vec3 area = f.col(1).cross(f.col(2));
  return -6 * t.force()[1].dot(area) / area.squaredNorm();
}
Mat3 shapeOf(double j) {
  Mat3 f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, 0.1, -0.2, 1.2;
  f.row(0) *= j / f.determinant();
  return f;
}

TEST(Porous, HenckysStressAndItsTangentBelowTheBound) {
  FieldUnderTest t(oneCell("permeability=\"0\""), porous);
  t.field().reset();
  const double bound = 0.2 + 400. / 2200;
  for (double j : {3., 1.3, 1., 0.7, 0.4, bound + 1e-9, bound - 1e-9, 0.3, 0.1, -0.5}) {
    const double at = std::max(j, bound);
    const double expected = 400 * 0.8 * std::log((0.8 + at - 1) / 0.8) + 0.8 * 2200 * (j - at);
    EXPECT_NEAR(stress(t, shapeOf(j)), expected, 1e-9 * 400) << j;
  }
}

/// Nothing flows: P = -K_lim ln J.
TEST(Porous, FluidThatCannotLeaveIsCompressed) {
  for (const std::string& coupling : couplings) {
    FieldUnderTest t(oneCell("permeability=\"0\" coupling=\"" + coupling + "\""), porous);
    t.field().reset();
    double previous = 1;
    for (int n = 1; n <= 10; ++n) {
      const double j = 1 - 0.04 * n;
      t.field().setTime(0.01 * n);
      const double found = stress(t, shapeOf(j));
      // forces before the pressure follows: that of the step before
      const double seen = coupling == "implicit" ? j : previous;
      EXPECT_NEAR(found, 400 * 0.8 * std::log((j - 0.2) / 0.8) + 2200 * std::log(seen), 1e-9 * 2200) << coupling;
      copy(t.x, t.system().x);
      History& history = dynamic_cast<History&>(t.field());
      history.stepEnded(0.01 * n);
      for (double p : history.history()) EXPECT_NEAR(p, -2200 * std::log(j), 1e-9 * 2200) << coupling << " " << n;
      previous = j;
    }
  }
}

std::string organ(const std::string& attributes) {
  return lawScene("fluidFraction=\"0.5\" bulkModulus=\"400\" limitModulus=\"2200\" " + attributes, porous);
}
/// sum of M P / K_lim + V_0 ln J and of M |P| / K_lim, from the mesh.
std::pair<double, double> fluid(FieldUnderTest& t) {
  const Mesh& mesh = t.field().node().find<Topology>(nullptr, true)->mesh();
  const std::vector<double>& p = dynamic_cast<History&>(t.field()).history();
  const auto& rest = t.field().state().rest_position;
  const auto volume = [&](const Tetrahedron& c, const auto& x) {
    return tetrahedronVolume(x(c[0]), x(c[1]), x(c[2]), x(c[3]));
  };
  double sum = 0, size = 0;
  for (const Tetrahedron& c : mesh.tetrahedra) {
    const double v0 = volume(c, [&](Index i) -> Vec3 { return rest[i]; });
    sum += v0 * std::log(volume(c, [&](Index i) -> Vec3 { return t.system().x[i]; }) / v0);
    for (Index node : c) sum += v0 / 4 * p[node] / 2200, size += v0 / 4 * std::abs(p[node]) / 2200;
  }
  return {sum, size};
}

TEST(Porous, FluidIsKept) {
  for (const std::string& coupling : couplings)
    for (bool drained : {false, true}) {
      FieldUnderTest t(
          organ("permeability=\"1e-7\" coupling=\"" + coupling + "\"" + (drained ? " drainedIndices=\"0 1 2 3\"" : "")),
          porous);
      t.field().reset();
      t.rest();
      copy(t.x, t.system().x);
      for (int n = 1; n <= 20; ++n) {
        t.field().setTime(0.01 * n);
        t.deform(0.005, unsigned(n));  // J stays above J_0, where ln J is ln J
        t.force();
        copy(t.x, t.system().x);
        dynamic_cast<History&>(t.field()).stepEnded(0.01 * n);
        const auto [sum, size] = fluid(t);
        ASSERT_GT(size, 0);
        if (!drained) {
          EXPECT_LT(std::abs(sum), 1e-13 * size) << coupling << " step " << n;
        } else if (n == 20) {
          EXPECT_GT(std::abs(sum), 1e-6 * size);
        }
      }
    }
}

/// With the pressure of the step frozen the tangent is exact. With it following it is, but for the differences of J
/// between the elements that a pressure joins: they are of the size of the strains.
TEST(Porous, TangentHasThePressureThatFollows) {
  const auto error = [](const std::string& scene, double noise) {
    FieldUnderTest t(scene, porous);
    t.deform(noise);
    t.field().setTime(0.02);
    return relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge()));
  };
  EXPECT_LT(error(organ("permeability=\"1e-7\""), 0.03), 1e-6);
  const std::string implicit = " coupling=\"implicit\"";
  for (const std::string cell : {"permeability=\"0\"", "permeability=\"1\" drainedIndices=\"0 1 2 3\"",
                                 "permeability=\"1\" drainedIndices=\"0 1\""})
    EXPECT_LT(error(oneCell(cell + implicit), 0.03), 1e-6) << cell;
  for (const std::string whole : {"permeability=\"1e-7\"", "permeability=\"1e-4\" drainedIndices=\"0 1 2 3\""}) {
    const double coarse = error(organ(whole + implicit), 0.03), fine = error(organ(whole + implicit), 0.01);
    std::printf("organ, %s: tangent errs by %.3f with noise of 3 %%, by %.3f with 1 %%\n", whole.c_str(), coarse, fine);
    EXPECT_LT(coarse, 0.1) << whole;
    EXPECT_LT(fine, 0.5 * coarse) << whole;
  }
}

TEST(Porous, ProductsAreOfTheMatrix) {
  for (const std::string& coupling : couplings) {
    FieldUnderTest t(organ("permeability=\"1e-7\" coupling=\"" + coupling + "\""), porous);
    t.deform(0.03);
    t.field().setTime(0.02);
    const BlockMatrix k = t.matrix();
    Vector assembled(t.x.count());
    k.multiply(t.direction, assembled);
    EXPECT_LT(relativeDifference(assembled, t.product(t.direction)), 1e-12) << coupling;
  }
}

// ---- Terzaghi ----

/// A column of height 1 between walls, drained at its top, under a pressure on its top. c_v = 1, so T_v = t.
struct Column {
  double limit = 2200, elastic = 1000, bulk = 400, load = 0.1;
  std::string coupling = "implicit";
  int cells = 20, across = 2;  ///< cells along it; nodes across it
  double dt = 0.001;
  double drained() const { return elastic + bulk; }
  double permeability() const { return 1 / limit + 1 / drained(); }
  std::string scene() const {
    const auto text = [](double v) {
      std::ostringstream out;
      out.precision(17);
      out << v;
      return out.str();
    };
    return "<Node name=\"root\" dt=\"" + text(dt) +
           "\" gravity=\"0 0 0\"><StaticSolver newton_iterations=\"200\" "
           "relative_residual_tolerance_threshold=\"1e-7\"/><SparseLDLSolver/><RegularGridTopology name=\"grid\" n=\"" +
           std::to_string(across) + " " + std::to_string(across) + " " + std::to_string(cells + 1) +
           "\" min=\"0 0 0\" max=\"0.2 0.2 1\"/><Node name=\"b\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
           "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\" cutting=\"ten\"/><MechanicalObject/>"
           "<UniformMass totalMass=\"1\"/><" +
           tetrahedral + " materialName=\"StVenantKirchhoff\" ParameterSet=\"" + text(elastic / 2) + " 0\"/><" +
           porous + " fluidFraction=\"0.8\" bulkModulus=\"" + text(bulk) + "\" limitModulus=\"" + text(limit) +
           "\" permeability=\"" + text(permeability()) + "\" coupling=\"" + coupling +
           "\" drainedIndices=\"@top.indices\"/><BoxROI name=\"top\" box=\"-1 -1 0.9999 1 1 2\"/>"
           "<BoxROI name=\"base\" box=\"-1 -1 -0.1 1 1 0.0001\"/>"
           "<BoxROI name=\"all\" box=\"-1 -1 -1 1 1 2\"/>"
           "<FixedProjectiveConstraint indices=\"@base.indices\"/>"
           "<PartialFixedProjectiveConstraint indices=\"@all.indices\" fixedDirections=\"1 1 0\"/>"
           "<ConstantForceField indices=\"@top.indices\" totalForce=\"0 0 " +
           text(-load * 0.04) + "\"/></Node></Node>";
  }
  /// Degree of consolidation at the given times.
  std::vector<double> run(const std::vector<double>& times) const {
    Simulation s = simulationFromText(scene());
    std::vector<double> out;
    const double last = load / drained(), first = load / (drained() + limit);
    for (double t : times) {
      while (s.time() < t - 1e-9) {
        const StepReport report = s.step();
        EXPECT_TRUE(!report.diverged && !report.unsolved) << report.reason;
        if (report.diverged || report.unsolved) return out;
      }
      double settlement = 0;
      const System& system = *s.systems()[0];
      for (Index i = system.allRows() - 4; i < system.allRows(); ++i) settlement += (1 - system.x[i].z()) / 4;
      out.push_back((settlement - first) / (last - first));
    }
    return out;
  }
};
double consolidation(double t) {
  double sum = 1;
  for (int m = 0; m < 200; ++m) {
    const double k = std::numbers::pi * (2 * m + 1) / 2;
    sum -= 2 / (k * k) * std::exp(-k * k * t);
  }
  return sum;
}

TEST(Porous, TerzaghisConsolidation) {
  const std::vector<double> times{0.01, 0.1, 0.197, 0.5, 0.848}, published{0.11284, 0.35682, 0.50034, 0.76395, 0.89998};
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(consolidation(times[i]), published[i], 6e-6);
  for (const std::string& coupling : couplings) {
    Column column;
    column.coupling = coupling;
    if (coupling == "semi_implicit") column.limit = 700;  // a fluid stiffer than the tissue is beyond that coupling
    const std::vector<double> found = column.run(times);
    ASSERT_EQ(found.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      std::printf("%-14s T_v = %.3f: U = %.5f, series %.5f\n", coupling.c_str(), times[i], found[i], published[i]);
      EXPECT_NEAR(found[i], published[i], 0.01) << coupling << " " << times[i];
    }
  }
}

/// Against the series, one error at a time: that in h with steps extrapolated to none, that in dt with cells
/// extrapolated to none.
TEST(Porous, OrdersInSpaceAndTime) {
  constexpr double when = 0.2;
  for (const std::string& coupling : couplings) {
    const auto at = [&coupling](int cells, double dt) {
      Column column;
      column.coupling = coupling, column.cells = cells, column.dt = dt;
      column.load = 0.01;  // strains of 1e-5: the series is linear
      if (coupling == "semi_implicit") column.limit = 700;
      return column.run({when}).at(0);
    };
    const auto withoutSteps = [&at](int cells) {
      const double a = at(cells, 0.008), b = at(cells, 0.004), c = at(cells, 0.002);
      return (8 * c - 6 * b + a) / 3;
    };
    const auto withoutCells = [&at](double dt) { return (4 * at(20, dt) - at(10, dt)) / 3; };
    const double h[] = {withoutSteps(5), withoutSteps(10), withoutSteps(20)};
    const double t[] = {withoutCells(0.02), withoutCells(0.01), withoutCells(0.005)};
    for (const auto& [what, found, order] : {std::tuple("h ", h, 2), std::tuple("dt", t, 1)}) {
      double error[3];
      for (int i = 0; i < 3; ++i) error[i] = std::abs(found[i] - consolidation(when));
      std::printf("%-14s in %s: errors %.2e %.2e %.2e against the series, orders %.2f %.2f\n", coupling.c_str(), what,
                  error[0], error[1], error[2], std::log2(error[0] / error[1]), std::log2(error[1] / error[2]));
      EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.15) << coupling << " " << what;
      EXPECT_NEAR(std::log2(error[1] / error[2]), order, 0.15) << coupling << " " << what;
    }
  }
}

/// Mandel and Cryer: the rim drains and shrinks first, and squeezes the centre of a cube under pressure on all sides;
/// an eighth of it.
TEST(Porous, PressureAtTheCentreRisesBeforeItFalls) {
  const double load = 1, limit = 3000, mu = 1000, bulk = 100, drained = bulk + 2 * mu / 3;
  Simulation s = simulationFromText(
      "<Node name=\"root\" dt=\"0.005\" gravity=\"0 0 0\"><StaticSolver newton_iterations=\"300\" "
      "relative_residual_tolerance_threshold=\"1e-6\"/><SparseLDLSolver/><RegularGridTopology name=\"grid\" n=\"6 6 "
      "6\" "
      "min=\"0 0 0\" max=\"1 1 1\"/><Node name=\"b\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
      "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\"/><MechanicalObject/><UniformMass "
      "totalMass=\"1\"/><" +
      tetrahedral + " materialName=\"StVenantKirchhoff\" ParameterSet=\"1000 0\"/><" + porous +
      " fluidFraction=\"0.5\" bulkModulus=\"100\" limitModulus=\"3000\" permeability=\"0.001\" coupling=\"implicit\" "
      "drainedIndices=\"@outer.indices\"/><BoxROI name=\"outer\" box=\"0.999 -1 -1 2 2 2  -1 0.999 -1 2 2 2  -1 -1 "
      "0.999 "
      "2 2 2\"/><BoxROI name=\"x\" box=\"-1 -1 -1 0.001 2 2\"/><BoxROI name=\"y\" box=\"-1 -1 -1 2 0.001 2\"/>"
      "<BoxROI name=\"z\" box=\"-1 -1 -1 2 2 0.001\"/>"
      "<PartialFixedProjectiveConstraint indices=\"@x.indices\" fixedDirections=\"1 0 0\"/>"
      "<PartialFixedProjectiveConstraint indices=\"@y.indices\" fixedDirections=\"0 1 0\"/>"
      "<PartialFixedProjectiveConstraint indices=\"@z.indices\" fixedDirections=\"0 0 1\"/>"
      "<SurfacePressureForceField pressure=\"-1\"/></Node></Node>");
  const double start = load * limit / (drained + limit);
  const History* history = nullptr;
  for (const ForceField* field : s.systems()[0]->forceFields())
    if (field->type() == porous) history = dynamic_cast<const History*>(field);
  double highest = 0, last = 0;
  for (int n = 0; n < 120; ++n) {
    const StepReport report = s.step();
    ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
    last = history->history()[0] / start;
    highest = std::max(highest, last);
    if (n % 10 == 0) std::printf("t = %.3f: P = %.4f of the start\n", s.time(), last);
  }
  EXPECT_GT(highest, 1.05);
  EXPECT_LT(highest, 1.6);
  EXPECT_LT(last, 0.9);
}

// ---- a fluid stiffer than its tissue ----

/// K_lim = 5 to 5000 times the modulus of the drained tissue, steps from a thousandth to a tenth of the time that
/// consolidation takes.
TEST(Porous, ImplicitStepsTakeFewNewtonIterationsWhateverTheFluid) {
  for (const auto& [limit, load] : {std::pair(7e3, 1.), std::pair(7e4, 1.), std::pair(7e6, 1.), std::pair(7e4, 200.)})
    for (const double dt : {0.001, 0.1}) {
      Column column;
      column.limit = limit, column.dt = dt, column.load = load;
      Simulation s = simulationFromText(column.scene());
      int most = 0;
      for (int n = 0; n < 5; ++n) {
        const StepReport report = s.step();
        ASSERT_TRUE(report.newton_converged) << report.reason;
        most = std::max(most, report.newton_iterations);
      }
      std::printf("K_lim = %.0e Pa, dt = %.3f s, load %g Pa: at most %d Newton iterations\n", limit, dt, load, most);
      EXPECT_LE(most, 15) << limit << " " << dt;
    }
}

TEST(Porous, ConsolidationUnderAStiffFluidIsTerzaghis) {
  Column column;
  column.limit = 1.4e6;
  const std::vector<double> times{0.1, 0.197, 0.5, 0.848};
  const std::vector<double> found = column.run(times);
  ASSERT_EQ(found.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(found[i], consolidation(times[i]), 0.01) << times[i];
}

/// The cheap tangent is the one of a single cell that nothing leaves; matrix and product agree, and it needs more
/// iterations.
TEST(Porous, TheUndrainedTangentIsThatOfFluidThatStays) {
  FieldUnderTest closed(oneCell("permeability=\"0\" coupling=\"implicit\" tangent=\"undrained\""), porous);
  closed.deform(0.03);
  closed.field().setTime(0.02);
  const double step = 1e-6 * closed.typicalEdge();
  EXPECT_LT(relativeDifference(closed.product(closed.direction), closed.differenceOfForces(step)), 1e-6);
  FieldUnderTest whole(organ("permeability=\"1e-7\" coupling=\"implicit\" tangent=\"undrained\""), porous);
  whole.deform(0.03);
  whole.field().setTime(0.02);
  expectMatrixOfProducts(whole);
  int iterations[2];
  for (int coupled = 0; coupled < 2; ++coupled) {
    Column column;
    column.limit = 7e3;
    if (!coupled) column.coupling += "\" tangent=\"undrained";
    Simulation s = simulationFromText(column.scene());
    iterations[coupled] = s.step().newton_iterations;
  }
  EXPECT_GT(iterations[0], 10 * iterations[1]);
}

/// A body too large for a dense matrix: products have the whole coupling.
TEST(Porous, LargeBodiesConvergeWithASolverByProducts) {
  Column column;
  column.limit = 7e4, column.dt = 0.01, column.load = 1, column.cells = 12, column.across = 10;
  std::string text = column.scene();
  const std::string direct = "<SparseLDLSolver/>";
  text.replace(text.find(direct), direct.size(), "<CGLinearSolver iterations=\"5000\" tolerance=\"1e-9\"/>");
  Simulation s = simulationFromText(text);
  ASSERT_GT(s.systems()[0]->allRows(), 1000);
  for (int n = 0; n < 2; ++n) {
    const StepReport report = s.step();
    ASSERT_TRUE(report.newton_converged) << report.reason;
    EXPECT_LE(report.newton_iterations, 15);
  }
}

TEST(Porous, PressureThatSwingsIsNoResult) {
  Column column;
  column.coupling = "semi_implicit";
  for (const double limit : {700., 2200., 14000.}) {
    column.limit = limit;
    Simulation s = simulationFromText(column.scene());
    StepReport report;
    for (int n = 0; n < 30; ++n) report = s.step();
    if (limit < column.drained()) {
      EXPECT_FALSE(report.unsolved) << report.reason;
    } else {
      EXPECT_TRUE(report.unsolved || report.diverged) << limit;
      EXPECT_NE(report.reason.find("coupling=\"implicit\""), std::string::npos) << limit << ": " << report.reason;
    }
  }
}

TEST(Porous, SaysWhatIsWrong) {
  const auto expect = [](const std::string& attributes, const std::string& words) {
    std::string text = oneCell(attributes);
    const std::string problems = problemsOf(text);
    EXPECT_NE(problems.find(words), std::string::npos) << attributes << ": " << problems;
  };
  expect("", "permeability");
  expect("permeability=\"0\" pressure=\"1 2\"", "pressure has 2 values");
  expect("permeability=\"0\" drainedIndices=\"9\"", "9");
  std::string text = oneCell("permeability=\"0\"");
  text.replace(text.find("limitModulus=\"2200\""), 19, "limitModulus=\"450\"");
  EXPECT_NE(problemsOf(text).find("limitModulus of at least"), std::string::npos) << problemsOf(text);
}

}  // namespace
}  // namespace stroma::test
