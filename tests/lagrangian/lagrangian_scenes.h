// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes with Lagrangian constraints, and what is read of them.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test::lagrangian {

constexpr double g = 10;

inline std::string sceneOf(const std::string& content, double dt = 0.01, const std::string& gravity = "0 -10 0",
                           const std::string& integrator = "<EulerImplicitSolver/>") {
  return fmt::format("<Node name=\"root\" dt=\"{}\" gravity=\"{}\">{}<SparseLDLSolver/>{}</Node>", dt, gravity, integrator,
                     content);
}

inline void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed()) << "step " << i << ": " << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
}

inline std::vector<double> numbersOf(const Simulation& simulation, const std::string& type, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (Component* component : all)
    if (component->type() == type) {
      std::istringstream text(component->data().find(name)->print());
      for (double value = 0; text >> value;) values.push_back(value);
    }
  return values;
}

inline double numberOf(const Simulation& simulation, const std::string& type, const char* name) {
  return numbersOf(simulation, type, name).at(0);
}

inline Vec3 at(const Simulation& simulation, Index node, std::size_t state = 0) {
  return simulation.states()[state]->x()[node];
}

/// A chain of links of one length: nodes 0 to n, the middle as deep as they reach.
inline std::string chain(int n, double span, double length, const std::string& velocity = "") {
  std::string positions, first, second, distances;
  const double dip = std::sqrt(std::max(0.0, length * length - span * span / n / n));
  for (int i = 0; i <= n; ++i) positions += fmt::format("{} {} 0  ", span * i / n, -dip * std::min(i, n - i));
  for (int i = 0; i < n; ++i)
    first += fmt::format("{} ", i), second += fmt::format("{} ", i + 1), distances += fmt::format("{} ", length);
  return fmt::format(
      "<MechanicalObject name=\"dofs\" position=\"{}\" {}/><UniformMass vertexMass=\"0.5\"/>"
      "<DistanceLagrangianConstraint first_point=\"{}\" second_point=\"{}\" distances=\"{}\"/>",
      positions, velocity, first, second, distances);
}

}  // namespace stroma::test::lagrangian
