// SPDX-License-Identifier: LGPL-2.1-or-later
// States whose rows are not points: rigid frames (centre and orientation) and single numbers, moved by every kind of
// step, against closed forms.
#include <fmt/format.h>

#include <cmath>

#include "framework/mechanics/frames.h"

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Frames at `position`, each with its orientation at (0 0 0 1).
class FrameState final : public State {
 public:
  void declare(DataTable& table) override {
    table.add("centres", centres_).help("centres").unit("m");
    table.add("spin", spin_).help("angular velocity of all").unit("rad/s");
    table.add("orientation", orientation_).help("x y z of the quaternions");
  }
  void init() override {
    rows_per_node = 2;
    const Vec3 turn = rotationVector(
        Quaternion(std::sqrt(1 - orientation_.squaredNorm()), orientation_.x(), orientation_.y(), orientation_.z()));
    for (const Vec3& centre : centres_) {
      position.insert(position.end(), {centre, turn});
      velocity.insert(velocity.end(), {Vec3::Zero(), spin_});
      row_kinds.insert(row_kinds.end(), {RowKind::place, RowKind::turn});
    }
    rest_position = position;
  }

 private:
  std::vector<Vec3> centres_{Vec3::Zero()};
  Vec3 spin_ = Vec3::Zero(), orientation_ = Vec3::Zero();
};

class ScalarState final : public State {
 public:
  void declare(DataTable& table) override { table.add("values", values_).help("initial values"); }
  void init() override {
    for (const double value : values_) position.push_back({value, 0, 0});
    rest_position = position;
    velocity.assign(position.size(), Vec3::Zero());
    row_kinds.assign(position.size(), RowKind::value);
  }

 private:
  std::vector<double> values_;
};

/// 2 kg per place and per number, and 0.5 kg m^2, the same about all axes, per orientation.
class FrameMass final : public Mass {
 public:
  void init() override {
    Mass::init();
    for (Index i = 0; i < state().size(); ++i) lumped_.push_back(state().kindOf(i) == RowKind::turn ? 0.5 : 2);
  }
  const std::vector<double>& lumped() const override { return lumped_; }
  bool isDiagonal() const override { return true; }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  std::vector<double> lumped_;
};

/// A torque of 0.6 N m about x on each orientation, and f = -8 x on each number.
class RowLoad final : public ForceField {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (Index i = 0; i < state().size(); ++i)
      if (state().kindOf(i) == RowKind::turn) f[state().firstRow() + i] += Vec3(0.6, 0, 0);
    addStiffnessProduct(x, 1, f);
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    forEachNumber([&](Index row) { df[row] -= factor * spring * dx[row]; });
  }
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    forEachNumber([&](Index row) { matrix.add(row, row, -factor * spring * Mat3::Identity()); });
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    forEachNumber([&](Index row) {
      for (std::size_t c : {0, 4, 8}) blocks[9 * std::size_t(row) + c] -= factor * spring;
    });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  static constexpr double spring = 8;
  template <class Body>
  void forEachNumber(Body&& body) const {
    for (Index i = 0; i < state().size(); ++i)
      if (state().kindOf(i) == RowKind::value) body(state().firstRow() + i);
  }
};

const bool registered =
    (factory().add<FrameState>("TestFrames", "test"), factory().add<ScalarState>("TestNumbers", "test"),
     factory().add<FrameMass>("TestFrameMass", "test"), factory().add<RowLoad>("TestRowLoad", "test"), true);

Eigen::Quaterniond orientationOf(const Simulation& simulation, Index row = 1) {
  return Eigen::Quaterniond(simulation.systems()[0]->x.rows().data + std::size_t(row) * row_doubles);
}
Eigen::Quaterniond turn(double angle, const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}
std::string scene(const std::string& integrator, const std::string& more, const std::string& frames = "") {
  return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -10 0">{}
    <CGLinearSolver iterations="50" tolerance="1e-14"/>
    <TestFrames name="frames" {}/><TestFrameMass/>{}</Node>)",
                     integrator, frames, more);
}
const Vec3 spin(1, 2, -2);  // 3 rad/s

class EveryStep : public testing::TestWithParam<std::string> {};

TEST_P(EveryStep, TurnsAFreeFrameByItsAngularVelocity) {
  Simulation simulation = simulationFromText(scene(GetParam(), "", "spin=\"1 2 -2\" orientation=\"0.6 0 0\""));
  const Eigen::Quaterniond start(0.8, 0.6, 0, 0);
  EXPECT_LT(orientationOf(simulation).angularDistance(start), 1e-15);
  for (int step = 0; step < 300; ++step) ASSERT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  EXPECT_NEAR(orientationOf(simulation).norm(), 1, 1e-15);
  EXPECT_LT((orientationOf(simulation).coeffs() - (turn(9, spin) * start).coeffs()).norm(), 1e-12) << "9 rad in 3 s, and its sign";
  EXPECT_LT((Vec3(system.v[1]) - spin).norm(), 1e-12);
  EXPECT_EQ(system.v.rows().data[row_doubles + 3], 0);
  EXPECT_NEAR(system.x[0][1], -45, 1) << "its centre falls";
  EXPECT_NEAR(system.kineticEnergy(), 0.5 * 2 * system.v[0].squaredNorm() + 0.5 * 0.5 * 9, 1e-9);
  EXPECT_NEAR(system.gravityEnergy(system.x), 2 * 10 * system.x[0][1], 1e-9) << "an orientation has no weight";
}

/// A torque of 0.6 N m on 0.5 kg m^2: the angle 1.2 t^2/2 about a fixed axis.
TEST_P(EveryStep, TurnsAFrameUnderATorque) {
  Simulation simulation = simulationFromText(scene(GetParam(), "<TestRowLoad/>"));
  for (int step = 0; step < 200; ++step) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_NEAR(simulation.systems()[0]->v[1][0], 2.4, 0.007) << "velocities at the middle of steps are half a step late";
  EXPECT_LT(orientationOf(simulation).angularDistance(turn(2.4, Vec3::UnitX())), 0.0121) << "h/2 of 2.4 rad/s";
  EXPECT_NEAR(orientationOf(simulation).norm(), 1, 1e-15);
}

TEST_P(EveryStep, MovesANumberAsAPoint) {
  // m x'' = -k x with w = 2 rad/s
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="0.001" gravity="0 -10 0">{}<CGLinearSolver iterations="50" tolerance="1e-14"/>
      <TestNumbers values="3 -1"/><TestFrameMass/><TestRowLoad/></Node>)",
      GetParam()));
  for (int step = 0; step < 500; ++step) ASSERT_FALSE(simulation.step().diverged);
  const System& system = *simulation.systems()[0];
  EXPECT_NEAR(system.x[0][0], 3 * std::cos(1.), 0.004);
  EXPECT_NEAR(system.x[1][0], -std::cos(1.), 0.004);
  EXPECT_EQ(system.x[0][1], 0) << "a number does not fall";
}

INSTANTIATE_TEST_SUITE_P(Integrators, EveryStep,
                         testing::Values("<EulerExplicitSolver/>", "<EulerExplicitSolver symplectic='false'/>",
                                         "<CentralDifferenceSolver/>", "<RungeKutta2Solver/>", "<RungeKutta4Solver/>",
                                         "<EulerImplicitSolver/>", "<EulerImplicitSolver newtonIterations='5'/>",
                                         "<EulerImplicitSolver trapezoidalScheme='true'/>", "<BDFOdeSolver order='2'/>",
                                         "<NewmarkImplicitSolver/>", "<TrapezoidalRuleSolver newtonIterations='3'/>",
                                         "<VariationalSymplecticSolver/>"),
                         [](const auto& values) { return fmt::format("Case{}", values.index); });

/// x' = -k/m x in first-order motion: x = x0 exp(-k t / m).
TEST(Motion, ANumberRelaxesExponentially) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="0.00025" gravity="0 0 0"><EulerImplicitSolver firstOrder="true"/>
      <CGLinearSolver iterations="50" tolerance="1e-14"/><TestNumbers values="3"/><TestFrameMass/>
      <TestRowLoad/></Node>)");
  for (int step = 0; step < 1000; ++step) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_NEAR(simulation.systems()[0]->x[0][0], 3 * std::exp(-1.), 1e-3);
}

TEST(Motion, DifferenceIsWhatAdvanceAdds) {
  Simulation simulation = simulationFromText(scene("<TestIntegrator/>", "", "centres=\"1 2 3  4 5 6\""));
  System& system = *simulation.systems()[0];
  ASSERT_TRUE(system.motion().turns());
  Vector before(4), increment(4);
  for (Index i = 0; i < 4; ++i) increment[i] = Vec3(0.3 * i - 1, 0.7, 0.2 * i);
  copy(system.x, before);
  system.motion().advance(1.5, increment, system.x);
  EXPECT_EQ(Vec3(system.x[2]), Vec3(4, 5, 6) + 1.5 * increment[2]);
  system.motion().difference(system.x, before);
  axpy(-1.5, increment, before);
  EXPECT_LT(largest(before), 1e-14);
}

TEST(Motion, ARestartTurnsBack) {
  Simulation simulation = simulationFromText(scene("<EulerImplicitSolver/>", "", "spin=\"1 2 -2\""));
  const auto start = simulation.stateHash();
  for (int step = 0; step < 10; ++step) simulation.step();
  const auto later = simulation.stateHash();
  EXPECT_NE(later, start);
  simulation.reset();
  EXPECT_EQ(simulation.stateHash(), start);
  for (int step = 0; step < 10; ++step) simulation.step();
  EXPECT_EQ(simulation.stateHash(), later);
}

TEST(Motion, HeldRowsKeepTheirOrientation) {
  Simulation simulation =
      simulationFromText(scene("<EulerImplicitSolver/>", "<FixedProjectiveConstraint indices=\"0\"/><TestRowLoad/>"));
  for (int step = 0; step < 10; ++step) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_LT(orientationOf(simulation).angularDistance(Eigen::Quaterniond::Identity()), 1e-15);
}

TEST(Motion, FramesAreNotMovedAsPoints) {
  for (const auto& [constraint, what] :
       {std::pair("<LinearMovementProjectiveConstraint indices=\"0\" keyTimes=\"0 1\" movements=\"0 0 0  1 0 0\"/>",
                  "movements has 1 values for 2 keyTimes"),
        std::pair("<LinearMovementProjectiveConstraint indices=\"0\" keyTimes=\"0 1\" movements=\"0 0 0  1 0 0  1\"/>",
                  "6: for x, y, z and the turns about them"),
        std::pair("<FixedPlaneProjectiveConstraint indices=\"0\" direction=\"0 0 1\"/>", "has rigid frames")})
    expectContains(problemsOf(scene("<EulerImplicitSolver/>", constraint, "centres=\"1 2 3  4 5 6\"")), what);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
