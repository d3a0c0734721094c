// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies for the tests of position constraints, and what is measured of them.
#pragma once
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "framework/mesh/topology.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

inline std::string root(const std::string& content, const std::string& dt = "0.01",
                        const std::string& gravity = "0 0 0") {
  return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"" + gravity + "\">" + content + "</Node>";
}

/// The liver hanging by one end, stretched by its weight towards a plane.
inline std::string hangingOrgan(
    const std::string& integrator, const std::string& constraints, const std::string& dt,
    const std::string& held = "<FixedProjectiveConstraint indices=\"180 181 182 183 184 185\"/>",
    const std::string& gravity = "-9.81 0 0") {
  return root(integrator +
                  "<MeshGmshLoader name=\"loader\" filename=\"" STROMA_SOURCE_DIR
                  "/scenes/meshes/organ_600.msh\"/><TetrahedronSetTopologyContainer src=\"@loader\"/>"
                  "<MechanicalObject/><UniformMass totalMass=\"0.5\"/>"
                  "<ShapeMemoryForceField stiffness=\"60\"/>" +
                  held + constraints,
              dt, gravity);
}

inline const std::string implicit_euler =
    "<EulerImplicitSolver rayleighMass=\"0.5\"/><CGLinearSolver iterations=\"50\" tolerance=\"1e-8\"/>";

/// Sum of the volumes of the tetrahedra: not over the surface, as the constraint does.
inline double volumeOf(const System& system) {
  double volume = 0;
  for (const Tetrahedron& t : system.states()[0]->find<Topology>(true)->mesh().tetrahedra) {
    // in numbers: after each step, compiled without optimisation
    const auto at = [&](std::size_t corner) { return system.x.rows().data + std::size_t(t[corner]) * row_doubles; };
    const double *a = at(0), *b = at(1), *c = at(2), *d = at(3);
    const double u0 = b[0] - a[0], u1 = b[1] - a[1], u2 = b[2] - a[2], v0 = c[0] - a[0], v1 = c[1] - a[1],
                 v2 = c[2] - a[2];
    volume += ((u1 * v2 - u2 * v1) * (d[0] - a[0]) + (u2 * v0 - u0 * v2) * (d[1] - a[1]) +
               (u0 * v1 - u1 * v0) * (d[2] - a[2])) /
              6;
  }
  return volume;
}

struct Motion {
  double mass = 0;
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero(), centre = Vec3::Zero();
};
inline Motion motionOf(const System& system) {
  Motion sum;
  const std::vector<double>& mass = system.masses()[0]->lumped();
  for (Index i = 0; i < system.x.count(); ++i) {
    const double m = mass[i];
    sum.mass += m;
    sum.centre += m * system.x[i];
    sum.linear += m * system.v[i];
    sum.angular += m * Vec3(system.x[i]).cross(Vec3(system.v[i]));
  }
  sum.centre /= sum.mass;
  return sum;
}

inline double lowest(const System& system, const Vec3& normal) {
  double depth = 1e300;
  for (Index i = 0; i < system.x.count(); ++i) depth = std::min(depth, normal.dot(system.x[i]));
  return depth;
}

/// Steps that must succeed and satisfy their constraints.
inline void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
    ASSERT_TRUE(report.constraints_converged) << "step " << i << ": " << report.constraint_reason;
  }
}

inline const std::string brick = "0 0 0  2 0 0  0 1 0  2 1 0  0 0 0.5  2 0 0.5  0 1 0.5  2 1 0.5  1.3 0.2 0.1";

inline std::string rigid(const std::string& positions, const std::string& more, const std::string& dt = "0.01",
                         const std::string& gravity = "0 0 0",
                         const std::string& integrator = "<EulerExplicitSolver/>") {
  return root(integrator + "<MechanicalObject position=\"" + positions +
                  "\"/><UniformMass vertexMass=\"0.5\"/><RigidConstraint/>" + more,
              dt, gravity);
}

/// The largest change of a distance between two nodes, over the largest distance.
inline double distortion(const System& system) {
  const auto& rest = system.states()[0]->rest_position;
  double worst = 0, size = 0;
  for (std::size_t i = 0; i < rest.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double length = (rest[i] - rest[j]).norm();
      size = std::max(size, length);
      worst = std::max(worst, std::abs((system.x[Index(i)] - system.x[Index(j)]).norm() - length));
    }
  return worst / size;
}

/// After a step the constraints do not hold; the report says why, and the sweeps end at once.
inline void expectConflict(Simulation simulation, const std::string& why) {
  const StepReport report = simulation.step();
  EXPECT_FALSE(report.constraints_converged);
  expectContains(report.constraint_reason, why);
  EXPECT_LT(report.constraint_sweeps, 10) << "nothing changes after the first";
}

}  // namespace stroma::test
