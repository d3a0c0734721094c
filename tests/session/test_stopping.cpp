// SPDX-License-Identifier: LGPL-2.1-or-later
// A run that is asked to stop gives a long step up within a few operations, whatever the step is doing, and is then where
// its last whole step left it: going on gives the bits of a run that nobody stopped.
#include <cmath>
#include <random>

#include "tests/support/scene_fixture.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Springs to the ground that stiffen with distance. It counts what is asked of it, and makes a request at a given count.
class CountingGround final : public ForceField {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows x) const override {
    count();
    double sum = 0;
    for (Index i = 0; i < state().size(); ++i) {
      const double square = away(x, i).squaredNorm();
      sum += stiffness * (square / 2 + square * square / 4);
    }
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    count();
    tangents_.resize(std::size_t(state().size()));
    for (Index i = 0; i < state().size(); ++i) {
      const Vec3 d = away(x, i);
      f[state().firstRow() + i] -= stiffness * (1 + d.squaredNorm()) * d;
      tangents_[i] = -stiffness * ((1 + d.squaredNorm()) * Mat3::Identity() + 2 * d * d.transpose());
    }
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    count();
    for (Index i = 0; i < state().size(); ++i) {
      const Index row = state().firstRow() + i;
      df[row] += factor * (tangents_[i] * dx[row]);
    }
  }
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    count();
    for (Index i = 0; i < state().size(); ++i)
      matrix.add(state().firstRow() + i, state().firstRow() + i, factor * tangents_[i]);
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    count();
    for (Index i = 0; i < state().size(); ++i)
      for (int c = 0; c < 9; ++c)
        blocks[9 * std::size_t(state().firstRow() + i) + std::size_t(c)] += factor * tangents_[i](c / 3, c % 3);
  }
  std::function<void()> at_count;
  long when = -1;
  mutable long counted = 0;

 private:
  static constexpr double stiffness = 40;
  Vec3 away(ConstRows x, Index i) const { return x[state().firstRow() + i] - state().rest_position[std::size_t(i)]; }
  void count() const {
    if (++counted == when && at_count) at_count();
  }
  std::vector<Mat3> tangents_;
};

/// A session that knows it.
struct GroundSession : Session {
  GroundSession() { factory().add<CountingGround>("TestCountingGround", "test"); }
};

struct Method {
  const char *integrator, *solver;
};
const Method methods[] = {
    {"StaticSolver", "<SparseLDLSolver/>"},
    {"StaticSolver", "<EigenSparseLU/>"},
    {"StaticSolver", "<CGLinearSolver/>"},
    {"StaticSolver", "<CGLinearSolver warmStart='true'/>"},
    {"StaticSolver", "<PCGLinearSolver/>"},
    {"StaticSolver", "<PCGLinearSolver preconditioner='warped'/><SparseLDLSolver/>"},
    {"StaticSolver", "<MinResLinearSolver/>"},
    {"EulerImplicitSolver newtonIterations='20'", "<PCGLinearSolver/>"},
    {"EulerImplicitSolver", "<PCGLinearSolver preconditioner='warped'/><SparseLDLSolver/>"},
    {"NewmarkImplicitSolver newtonIterations='20'", "<CGLinearSolver/>"},
    {"BDFOdeSolver order='2' newtonIterations='20'", "<SparseLDLSolver/>"},
};

std::string scene(const Method& method) {
  return fmt::format(R"(<Node name="root" dt="0.05" gravity="0 -10 0"><{}/>{}
    <MechanicalObject name="dofs" position="0 0 0  1 0 0  1 1 0  0 0 1  2 0 0.5"/><UniformMass totalMass="30"/>
    <SpringForceField spring="0 1 500 0 1  1 2 300 0 1  2 3 400 0 1.5  3 4 300 0 2  0 4 80 0 2"/>
    <TestCountingGround name="ground"/></Node>)",
                     method.integrator, method.solver);
}

CountingGround& groundOf(Session& session) {
  return dynamic_cast<CountingGround&>(*findComponent(session.simulation().root(), "/ground"));
}

/// What is done after the last look: one product, a force or the energies of a trial of a line search, the diagonal.
constexpr long most_after = 6;

TEST(Stopping, ALongStepIsGivenUpWithinAFewOperations) {
  std::mt19937 random(7);
  for (const Method& method : methods) {
    SCOPED_TRACE(fmt::format("{} {}", method.integrator, method.solver));
    GroundSession whole;
    whole.loadText(scene(method), "ground.xml");
    CountingGround& counter = groundOf(whole);
    std::vector<long> counts;  // after each step
    std::vector<std::uint64_t> hashes{whole.simulation().stateHash()};
    for (int step = 0; step < 5; ++step) {
      whole.run({.steps = 1});
      counts.push_back(counter.counted);
      hashes.push_back(whole.simulation().stateHash());
    }
    for (int trial = 0; trial < 20; ++trial) {
      const long when = std::uniform_int_distribution<long>(1, counts.back() - 1)(random);
      SCOPED_TRACE(when);
      GroundSession session;
      Simulation& simulation = session.loadText(scene(method), "ground.xml");
      CountingGround& ground = groundOf(session);
      ground.when = when;
      ground.at_count = [&session] { session.requestStop(); };
      const RunReport report = session.run({.steps = 5});
      ASSERT_EQ(report.end, RunEnd::stopped);
      EXPECT_LE(ground.counted, when + most_after);
      const long made = simulation.steps();
      EXPECT_LE(made, 5);
      EXPECT_EQ(report.statistics.step_ms.size(), std::size_t(made)) << "a step that was given up is no step";
      EXPECT_EQ(simulation.stateHash(), hashes[std::size_t(made)]);
      EXPECT_EQ(simulation.time(), 0.05 * double(made));
      session.run({.steps = 5 - made});
      EXPECT_EQ(simulation.stateHash(), hashes.back()) << "stopped after " << made;
    }
  }
}

/// In a checkpoint too there is nothing of the step that was given up.
TEST(Stopping, TheCheckpointIsThatOfTheLastWholeStep) {
  for (const Method& method : methods) {
    SCOPED_TRACE(fmt::format("{} {}", method.integrator, method.solver));
    GroundSession whole, stopped;
    whole.loadText(scene(method), "ground.xml");
    stopped.loadText(scene(method), "ground.xml");
    whole.run({.steps = 2});
    const Archive expected = whole.simulation().checkpoint();
    stopped.run({.steps = 2});
    CountingGround& ground = groundOf(stopped);
    ground.when = ground.counted + 4;
    ground.at_count = [&stopped] { stopped.requestStop(); };
    ASSERT_EQ(stopped.run({.steps = 1}).end, RunEnd::stopped);
    ASSERT_EQ(stopped.simulation().steps(), 2);
    const Archive found = stopped.simulation().checkpoint();
    ASSERT_EQ(found.entries().size(), expected.entries().size());
    for (const auto& [name, entry] : expected.entries())
      EXPECT_TRUE(found.entries().at(name).bytes == entry.bytes) << name;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
