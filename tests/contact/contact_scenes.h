// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies for the tests of contact.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <sstream>

#include "framework/mesh/topology.h"
#include "tests/support/field_under_test.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// A cloud of points and tetrahedra, as attributes.
struct Body {
  std::vector<Vec3> points;
  std::vector<std::array<int, 4>> cells;

  void turn(const Mat3& rotation, const Vec3& shift) {
    for (Vec3& p : points) p = rotation * p + shift;
  }
  double lowest(int axis) const {
    double low = 1e300;
    for (const Vec3& p : points) low = std::min(low, p[axis]);
    return low;
  }
  std::string mesh() const {
    std::string text = "<MeshTopology name=\"mesh\" position=\"";
    for (const Vec3& p : points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
    text += "\" tetrahedra=\"";
    for (auto c : cells) {  // positive volumes
      const Vec3 a = points[std::size_t(c[0])];
      if ((points[std::size_t(c[1])] - a).cross(points[std::size_t(c[2])] - a).dot(points[std::size_t(c[3])] - a) < 0)
        std::swap(c[0], c[1]);
      text += fmt::format("{} {} {} {}  ", c[0], c[1], c[2], c[3]);
    }
    return text + "\"/>";
  }
};

/// A box of n[0] x n[1] x n[2] cells, each cut into six tetrahedra.
inline Body boxOf(const Vec3& low, const Vec3& high, std::array<int, 3> n = {1, 1, 1}) {
  Body body;
  const auto node = [&](int i, int j, int k) { return i + (n[0] + 1) * (j + (n[1] + 1) * k); };
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i)
        body.points.push_back(low +
                              (high - low).cwiseProduct(Vec3(double(i) / n[0], double(j) / n[1], double(k) / n[2])));
  const int paths[6][2] = {{1, 2}, {1, 4}, {2, 1}, {2, 4}, {4, 1}, {4, 2}};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        for (const auto& [first, second] : paths) {
          const auto corner = [&](int bits) { return node(i + (bits & 1), j + (bits >> 1 & 1), k + (bits >> 2 & 1)); };
          body.cells.push_back({corner(0), corner(first), corner(first | second), corner(7)});
        }
  return body;
}

/// A pyramid with its tip up, or down.
inline Body spike(bool down = false) {
  Body body{{{-.5, 0, -.5}, {.5, 0, -.5}, {.5, 0, .5}, {-.5, 0, .5}, {0, 3, 0}}, {{0, 1, 2, 4}, {0, 2, 3, 4}}};
  if (down)
    for (Vec3& p : body.points) p.y() = -p.y();
  return body;
}
/// A roof with its ridge along z.
inline Body wedge(bool down = false) {
  Body body{{{-.5, 0, -1}, {.5, 0, -1}, {0, 3, -1}, {-.5, 0, 1}, {.5, 0, 1}, {0, 3, 1}},
            {{0, 1, 2, 3}, {1, 2, 3, 4}, {2, 3, 4, 5}}};
  if (down)
    for (Vec3& p : body.points) p.y() = -p.y();
  return body;
}

/// A node with a state "dofs", its mesh and a field for it.
inline std::string bodyNode(const std::string& name, const Body& body, const std::string& more,
                            const std::string& state = "", double young = 1e6, double poisson = 0.4) {
  return fmt::format(
      "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\" {}/><MeshMatrixMass massDensity=\"1000\" lumping=\"true\"/>"
      "<TetrahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\"/>{}</Node>",
      name, body.mesh(), state, young, poisson, more);
}

inline std::string contactScene(
    const std::string& content, double dt = 0.01, const Vec3& gravity = Vec3::Zero(),
    const std::string& integrator = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-8\"/>") {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"{} {} {}\">{}<SparseLDLSolver/>{}</Node>", dt,
                     gravity.x(), gravity.y(), gravity.z(), integrator, content);
}

/// From 0 in `even` cells of size h, then each larger than the one before, up to about `end`.
inline std::vector<double> graded(double h, int even, double growth, double end) {
  std::vector<double> x{0};
  for (int i = 0; i < even; ++i) x.push_back(x.back() + h);
  while (x.back() < end) {
    h *= growth;
    const double next = x.back() + h;
    x.push_back(next > 0.85 * end ? end : next);
  }
  return x;
}

inline const std::string between =
    "<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" {}/>";

/// A step that converges and after which nothing crosses.
inline void expectCleanStep(Simulation& simulation, int step, bool must_converge = true) {
  const StepReport report = simulation.step();
  ASSERT_FALSE(report.diverged) << "step " << step << ": " << report.reason;
  ASSERT_TRUE(report.constraints_converged) << "step " << step << ": " << report.constraint_reason;
  if (must_converge) {
    ASSERT_TRUE(report.newton_converged) << "step " << step << ": " << report.reason;
  }
  for (const auto& system : simulation.systems())
    ASSERT_TRUE(std::isfinite(dot(system->x, system->x))) << "step " << step;
}

/// A box above another one, turned and shifted at random, `gap` [m] above its top.
inline Body boxAbove(unsigned seed, double gap) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Body box = boxOf(Vec3(0, 0, 0), Vec3(0.7, 0.6, 0.5));
  const double angle = 3 * uniform(random), a = uniform(random), b = uniform(random), c = uniform(random);
  box.turn(Eigen::AngleAxisd(angle, Vec3(a, b, c).normalized()).toRotationMatrix(), Vec3::Zero());
  const double x = uniform(random), y = uniform(random);
  box.turn(Mat3::Identity(), Vec3(x, y, 1 + gap - box.lowest(2)));
  return box;
}

/// The force of `t` is minus the slope of its energy along the direction, taken over two `step`s [m].
inline void expectForceOfEnergy(FieldUnderTest& t, double step, unsigned seed) {
  Vector up(t.x.count()), down(t.x.count());
  copy(t.x, up), copy(t.x, down);
  axpy(step, t.direction, up), axpy(-step, t.direction, down);
  const Vector f = t.force();
  const double slope = (t.field().energy(up) - t.field().energy(down)) / (2 * step);
  EXPECT_NEAR(-slope, dot(f, t.direction), 1e-6 * std::sqrt(dot(f, f) * dot(t.direction, t.direction))) << "seed " << seed;
}

/// What is said where a scene is loaded: its errors, or its warnings.
inline std::string saidOf(const std::string& text) {
  std::string said;
  ::testing::internal::CaptureStderr();  // of what is seen after loading
  const std::string errors = problemsIn([&] {
    Simulation simulation = simulationFromText(text);
    for (const Problem& problem : simulation.diagnostics().problems())
      if (problem.severity == Severity::warning) said += problem.text() + "\n";
  });
  return errors + said + ::testing::internal::GetCapturedStderr();
}

/// Of an output of all ConstraintContacts.
inline std::vector<double> constraintOutput(const Simulation& simulation, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (const Component* component : all)
    if (component->type() == "ConstraintContact") {
      std::istringstream text(component->data().find(name)->print());
      for (double value = 0; text >> value;) values.push_back(value);
    }
  return values;
}

/// Of an output of all contacts of a type.
inline std::vector<double> numbersOf(Simulation& simulation, const char* name, const char* type = "BarrierContact") {
  std::vector<double> values;
  for (const auto& system : simulation.systems())
    for (ForceField* field : system->forceFields())
      if (field->type() == type) {
        std::istringstream text(field->data().find(name)->print());
        for (double value = 0; text >> value;) values.push_back(value);
      }
  return values;
}
inline double outputOf(Simulation& simulation, const char* name) { return numbersOf(simulation, name).at(0); }

/// [N s], of points alone.
inline Vec3 momentumOf(System& system) {
  Vector product(system.allRows());
  system.addMassProduct(system.v, 1, product);
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < product.count(); ++i) sum += product[i];
  return sum;
}

}  // namespace stroma::test
