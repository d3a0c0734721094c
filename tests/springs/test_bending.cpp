// SPDX-License-Identifier: LGPL-2.1-or-later
// Bending of triangle surfaces against plate theory.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

/// A grid of cells a x b, sheared, each cut along the same diagonal, in the plane z = 0.
struct Sheet {
  int columns, rows;
  double a, b, shear;
  Vec3 place(int i, int j) const { return {a * i + shear * j, b * j, 0}; }
  int node(int i, int j) const { return j * (columns + 1) + i; }
  std::string positions() const {
    std::string text;
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i) text += fmt::format("{:.17g} {:.17g} 0  ", place(i, j).x(), place(i, j).y());
    return text;
  }
  std::string triangles() const {
    std::string text;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i)
        text += fmt::format("{0} {1} {2}  {0} {2} {3}  ", node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1));
    return text;
  }
};

std::string bendingOf(const Sheet& sheet, const std::string& bending, const std::string& more, const std::string& integrator) {
  return fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0">{}<MechanicalObject name="dofs" position="{}"/>
        <MeshTopology position="{}" triangles="{}"/>
      <UniformMass totalMass="1"/><FastTriangularBendingSprings {}/>{}</Node>)",
      integrator, sheet.positions(), sheet.positions(), sheet.triangles(), bending, more);
}

/// w = p x^4/24 + q x^2 y^2/4 + r y^4/24 needs a load of D (p + 2 q + r) per area: that of a cell is what each inner node bears.
TEST(FastTriangularBendingSprings, BearTheLoadOfAPlate) {
  const double d = 0.7, p = 0.3, q = -0.2, r = 0.5;
  for (const double length : {1., 1000.})
    for (const Sheet& sheet : {Sheet{6, 6, length, length, 0}, Sheet{6, 6, 1.5 * length, 0.8 * length, 0},
                               Sheet{6, 6, length, length * std::sqrt(0.75), -0.5 * length},
                               Sheet{6, 6, 1.2 * length, 0.7 * length, 0.9 * length}}) {
      Simulation simulation = simulationFromText(
          bendingOf(sheet, fmt::format("bendingStiffness=\"{}\"", d), "", "<EulerExplicitSolver/>"));
      System& system = *simulation.systems().at(0);
      const Vec3 middle = sheet.place(3, 3);
      for (int j = 0; j <= sheet.rows; ++j)
        for (int i = 0; i <= sheet.columns; ++i) {
          const double x = sheet.place(i, j).x() - middle.x(), y = sheet.place(i, j).y() - middle.y();
          system.x[sheet.node(i, j)].z() = p * std::pow(x, 4) / 24 + q * x * x * y * y / 4 + r * std::pow(y, 4) / 24;
        }
      system.computeForce(system.x, system.v, system.f);
      const double load = d * (p + 2 * q + r) * sheet.a * sheet.b;
      EXPECT_NEAR(system.f[sheet.node(3, 3)].z(), -load, 1e-9 * load) << sheet.a << ' ' << sheet.b << ' ' << sheet.shear;
    }
}

/// A cantilevered strip: P L^3 / (3 D b). Only at edges the curvature is not exact: half the size, half the error.
TEST(FastTriangularBendingSprings, DeflectAsAPlate) {
  const double d = 0.05, length = 1, width = 0.25, load = 1e-6;
  double before = 0;
  for (const int cells : {8, 16, 32}) {
    const Sheet sheet{cells + 1, cells / 4, length / cells, 4 * width / cells, 0};  // the first column is held
    std::string held, tip, forces;
    for (int j = 0; j <= sheet.rows; ++j) {
      held += fmt::format("{} {} ", sheet.node(0, j), sheet.node(1, j));
      tip += fmt::format("{} ", sheet.node(sheet.columns, j));
      forces += fmt::format("0 0 {:.17g}  ", load / sheet.rows * (j == 0 || j == sheet.rows ? 0.5 : 1));
    }
    Simulation simulation = simulationFromText(bendingOf(
        sheet, fmt::format("bendingStiffness=\"{}\"", d),
        fmt::format(R"(<TriangularFEMForceField youngModulus="1e6" poissonRatio="0" thickness="0.01" method="small"/>
        <FixedProjectiveConstraint indices="{}"/><ConstantForceField indices="{}" forces="{}"/>)", held, tip, forces),
        "<StaticSolver/><SparseLDLSolver/>"));
    ASSERT_TRUE(simulation.step().newton_converged);
    double w = 0;
    for (int j = 0; j <= sheet.rows; ++j)
      w += simulation.states().at(0)->x()[sheet.node(sheet.columns, j)].z() * (j == 0 || j == sheet.rows ? 0.5 : 1) / sheet.rows;
    const double error = w / (load * std::pow(length, 3) / (3 * d * width)) - 1;
    if (cells > 8) {
      EXPECT_NEAR(error / before, 0.5, 0.1) << cells << " cells: " << error;
    }
    before = error;
  }
  EXPECT_LT(std::abs(before), 0.06);
}

/// One fold by the angle t: |R| = 2 sin(t/2) h_a h_b / (h_a + h_b) where both are as high, E = mu l (h_a + h_b) / (h_a h_b)^2 |R|^2.
TEST(FastTriangularBendingSprings, EnergyOfOneFold) {
  const double l = 2, h = 1.5, mu = 0.7;
  Simulation simulation = simulationFromText(
      R"(<Node name="root" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject position="0 0 0 2 0 0 3 1.5 0 2.5 -1.5 0"/>
      <MeshTopology position="0 0 0 2 0 0 3 1.5 0 2.5 -1.5 0" triangles="0 1 2 1 0 3"/><UniformMass totalMass="1"/>
      <FastTriangularBendingSprings bendingStiffness="0.7"/></Node>)");
  System& system = *simulation.systems().at(0);
  EXPECT_NEAR(system.elasticEnergy(system.x), 0, 1e-28) << "flat, with both other nodes beyond the end of the edge";
  for (double t : {0.01, 0.5}) {
    system.x[2] = Vec3(3, h * std::cos(t), h * std::sin(t));
    EXPECT_NEAR(system.elasticEnergy(system.x), mu * l * std::pow(2 * std::sin(t / 2), 2) / (2 * h), 1e-14) << t;
  }
}

/// Where three triangles share an edge each pair bends by itself.
TEST(FastTriangularBendingSprings, ThreeTrianglesAtAnEdge) {
  const double c = std::cos(0.2), s = std::sin(0.2);
  const auto energy = [&](const std::string& triangles) {
    const std::string places = fmt::format("0 0 0 1 0 0 0.5 1 0 0.5 -1 0 0.5 {:.17g} {:.17g}", -c, s);
    Simulation simulation = simulationFromText(fmt::format(
        R"(<Node name="root" gravity="0 0 0"><EulerExplicitSolver/><MechanicalObject position="{0}"/>
        <MeshTopology position="{0}" triangles="{1}"/><UniformMass totalMass="1"/>
        <FastTriangularBendingSprings bendingStiffness="3"/></Node>)", places, triangles));
    System& system = *simulation.systems().at(0);
    return system.elasticEnergy(system.x);
  };
  EXPECT_NEAR(energy("0 1 2 1 0 3 1 0 4"), energy("0 1 2 1 0 3") + energy("0 1 2 1 0 4") + energy("1 0 3 1 0 4"), 1e-13);
  EXPECT_GT(energy("0 1 2 1 0 4"), 0.01);
}

}  // namespace
}  // namespace stroma::test
