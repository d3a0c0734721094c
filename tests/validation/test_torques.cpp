// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's law (the elastic forces sum to zero) and Euler's law (their torques do too) on a whole organ in large
// deformation, for each method and update: which variants break Euler's law, and by how much.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <random>

#include "tests/validation/scene_run.h"

namespace stroma::test {
namespace {

std::string organ() {
  const std::string liver = STROMA_SHARED_DATA "/meshes/liver.msh";
  return std::filesystem::exists(liver) ? liver : STROMA_SOURCE_DIR "/scenes/meshes/organ_600.msh";
}

struct Law {
  double newton = 0, euler = 0;  ///< |sum f| / sum |f|, |sum x x f| / sum |x| |f|
};

enum class Shape { turned, bent, random };

/// turned: a rotation alone; bent: twisted by 1.5 rad along x and stretched by half; random: every node moved by a
/// tenth of the size as well.
Law laws(const std::string& method, const std::string& update, Shape shape) {
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name=\"root\" gravity=\"0 0 0\"><EulerExplicitSolver/><MeshGmshLoader name=\"loader\" filename=\"{}\"/>"
      "<TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
      "<TetrahedronFEMForceField method=\"{}\" youngModulus=\"1000\" poissonRatio=\"0.4\" {}/></Node>",
      organ(), method,
      update == "none" ? ""
      : update == "B"  ? "updateStiffnessMatrix=\"true\""
                       : "updateStiffnessMatrix=\"true\" updateVolume=\"true\""));
  System& system = *simulation.systems().at(0);
  const auto& rest = simulation.states().at(0)->rest_position;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : rest) box.extend(p);
  const double size = box.diagonal().norm();
  std::mt19937 generator(7);
  std::normal_distribution<double> noise(0, 0.1 * size);
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Index i = 0; i < Index(rest.size()); ++i) {
    Vec3 p = rest[i] - box.center();
    if (shape != Shape::turned) {
      p = Eigen::AngleAxisd(1.5 * p.x() / size, Vec3::UnitX()) * p;
      p.x() *= 1.5;
    }
    if (shape == Shape::random) p += Vec3(noise(generator), noise(generator), noise(generator));
    system.x[i] = turn * p;
  }
  system.computeForce(system.x, system.v, system.f);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double forces = 0, torques = 0;
  for (Index i = 0; i < Index(rest.size()); ++i) {
    force += system.f[i], forces += system.f[i].norm();
    torque += Vec3(system.x[i]).cross(Vec3(system.f[i])), torques += system.x[i].norm() * system.f[i].norm();
  }
  if (shape == Shape::turned) return {forces / (1000 * size * size), torques / (1000 * size * size * size)};
  return {force.norm() / forces, torque.norm() / torques};
}

TEST(Torques, EulersLawByMethodAndUpdate) {
  fmt::print("{}\n", organ().substr(organ().rfind('/') + 1));
  for (const std::string method : {"small", "large", "polar", "svd", "nodal"})
    for (const std::string update : {"none", "B", "B and V"}) {
      const bool plain = method == "small" || method == "nodal";
      if (plain && update != "none") continue;
      const Law turned = laws(method, update, Shape::turned), bent = laws(method, update, Shape::bent),
                random = laws(method, update, Shape::random);
      fmt::print(
          "{:6} {:8} bent: forces {:.1e}, torques {:.1e}; random: forces {:.1e}, torques {:.1e}; turned: {:.1e}\n",
          method, update, bent.newton, bent.euler, random.newton, random.euler, turned.newton);
      const std::string what = method + " " + update;
      if (method != "small") {
        EXPECT_LT(turned.newton, 1e-12) << what;  // no force in a turned body
      }
      if (method == "nodal") {
        EXPECT_GT(random.newton, 1e-4) << "ghost forces";
        continue;
      }
      EXPECT_LT(bent.newton, 1e-12) << what;
      EXPECT_LT(random.newton, 1e-12) << what;
      if (update != "none") {
        EXPECT_LT(bent.euler, 1e-12) << what;
        EXPECT_LT(random.euler, 1e-12) << what;
      }
      if (update != "none") continue;
      // R^T F is symmetric and commutes with the stress, so a constant B exerts no torque either: with polar while
      // nothing is inverted, with svd always
      if (method == "svd" || method == "polar") {
        EXPECT_LT(bent.euler, 1e-12) << what;
      } else {
        EXPECT_GT(bent.euler, 1e-3) << what;
      }
      if (method == "svd") {
        EXPECT_LT(random.euler, 1e-12) << what;
      } else {
        EXPECT_GT(random.euler, 1e-3) << what;
      }
    }
}

}  // namespace
}  // namespace stroma::test
