// SPDX-License-Identifier: LGPL-2.1-or-later
// UncoupledConstraintCorrection on rigid frames: what is caught off its centre turns as an impulse there turns it.
#include <fmt/format.h>

#include <Eigen/LU>

#include "framework/mechanics/frames.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using Six = Eigen::Matrix<double, 6, 6>;
using Six1 = Eigen::Matrix<double, 6, 1>;
constexpr double dt = 1e-5;
const Vec3 arm(0.6, 0.2, -0.1), own_inertia(0.3, 0.5, 0.4);

Mat3 crossMatrix(const Vec3& w) {
  Mat3 m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

struct Body {
  double own_mass = 0;         ///< of the frame, with own_inertia for each 2 kg [kg]
  std::vector<Vec3> points{};  ///< 1 kg each, which follow it
};

/// Velocities after the tip of the arm was held: v + M^-1 G^T p with G v = 0 after it.
Six1 closedForm(const Body& body, const Quaternion& q, const Six1& v) {
  const Mat3 turn = q.toRotationMatrix();
  Six inertia = Six::Zero();
  inertia.topLeftCorner<3, 3>() = body.own_mass * Mat3::Identity();
  inertia.bottomRightCorner<3, 3>() = body.own_mass / 2 * (turn * own_inertia.asDiagonal() * turn.transpose());
  for (const Vec3& point : body.points) {
    Eigen::Matrix<double, 3, 6> moves;
    moves << Mat3::Identity(), -crossMatrix(turn * point);
    inertia += moves.transpose() * moves;
  }
  Eigen::Matrix<double, 3, 6> tip;
  tip << Mat3::Identity(), -crossMatrix(turn * arm);
  const Eigen::Matrix<double, 6, 3> answer = inertia.inverse() * tip.transpose();
  const Mat3 w = tip * answer;
  return v - answer * w.inverse() * (tip * v);
}

std::string scene(const Body& body, const Quaternion& q, const Six1& v) {
  std::string own, followers;
  if (body.own_mass > 0) own = fmt::format(R"(<UniformMass vertexMass="{} 1 0.15 0 0 0 0.25 0 0 0 0.2"/>)", body.own_mass);
  for (const Vec3& p : body.points) followers += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
  if (!followers.empty())
    followers = fmt::format(R"(<Node name="masses"><MechanicalObject position="{}"/><UniformMass vertexMass="1"/><RigidMapping/></Node>)",
                            followers);
  return fmt::format(R"(<Node name="root" dt="{}" gravity="0 0 0"><EulerImplicitSolver newtonIterations="1"/><SparseLDLSolver/>
  <MechanicalObject template="Rigid3" position="0 0 0 {:.17g} {:.17g} {:.17g} {:.17g}" velocity="{} {} {} {} {} {}"/>{}
  <UncoupledConstraintCorrection/>{}<Node name="arm"><MechanicalObject position="{} {} {}"/><RigidMapping/>
  <FixedLagrangianConstraint indices="0"/></Node></Node>)",
                     dt, q.x(), q.y(), q.z(), q.w(), v[0], v[1], v[2], v[3], v[4], v[5], own, followers, arm.x(), arm.y(), arm.z());
}

TEST(UncoupledFrames, TurnAsAnImpulseTurnsThem) {
  const std::vector<Vec3> corners{Vec3(0.3, 0.4, 0.5), Vec3(-0.3, 0.4, -0.2), Vec3(0.1, -0.5, 0.3), Vec3(-0.4, 0, 0.2)};
  const Six1 v = (Six1() << 0.3, 0, -0.2, 0.5, -1, 0.4).finished();
  for (const Body& body : {Body{2}, Body{0, corners}, Body{2, corners}, Body{2, {Vec3(0.7, 0, 0)}}})
    for (const Vec3& turned : {Vec3(0, 0, 0), Vec3(1, 0.5, -0.7)}) {
      const Quaternion q = turnedBy(turned);
      Simulation simulation = simulationFromText(scene(body, q, v));
      const StepReport report = simulation.step();
      ASSERT_TRUE(!report.failed() && report.constraints_converged) << report.reason << report.constraint_reason;
      const System& system = *simulation.systems()[0];
      const Six1 right = closedForm(body, q, v);
      const Vec3 centre = right.head<3>(), turn = right.tail<3>();
      EXPECT_LT((system.v[0] - centre).norm(), 3e-5) << body.own_mass << " " << body.points.size();
      EXPECT_LT((system.v[1] - turn).norm(), 3e-5) << body.own_mass << " " << body.points.size();
      EXPECT_GT(turn.norm(), 0.01);
    }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
