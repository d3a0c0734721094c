// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs that appear and vanish during a run: the assembled matrix gets a new pattern then, and only then.
#include <fmt/format.h>

#include <Eigen/Dense>

#include "framework/algebra/direct_solver.h"
#include "framework/mechanics/node_group_field.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

int patterns = 0;  ///< of all springs below

/// Springs of rest length zero between pairs of nodes, each from one time to another.
class ComingSprings final : public NodeGroupField<2, PairTangent> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("pairs", pairs_).help("nodes, two per spring");
    table.add("from", from_).help("first end of a step with each spring").unit("s");
    table.add("until", until_).help("last end of a step with each spring").unit("s");
    table.add("stiffness", k_).help("of each spring").unit("N/m");
    table.add("assemblyCost", assembly_cost_).help("0: the usual one").unit("-");
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.exact_tangent = traits.time_dependent = true;
    return traits;
  }
  void setTime(double t) override {
    std::vector<Group> now;
    for (std::size_t s = 0; 2 * s < pairs_.size(); ++s)
      if (from_[s] <= t && t <= until_[s])
        now.push_back({state().firstRow() + pairs_[2 * s], state().firstRow() + pairs_[2 * s + 1]});
    if (now == rows_) return;
    setGroups(std::move(now), false);
    ++revision_;
  }
  long patternRevision() const override { return revision_; }
  void addPattern(BlockPattern& pattern) const override { ++patterns, NodeGroupField::addPattern(pattern); }
  Cost cost() const override { return assembly_cost_ > 0 ? Cost{1, assembly_cost_} : NodeGroupField::cost(); }
  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Group& pair : rows_) sum += k_ / 2 * (x[pair[1]] - x[pair[0]]).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t s = 0; s < rows_.size(); ++s) {
      const auto [a, b] = rows_[s];
      const Vec3 pull = k_ * (x[b] - x[a]);
      f[a] += pull;
      f[b] -= pull;
      stiffness_[s].k = -k_ * Mat3::Identity();
    }
  }

 private:
  std::vector<int> pairs_;
  std::vector<double> from_, until_;
  double k_ = 0, assembly_cost_ = 0;
  long revision_ = 0;
};

int analyses = 0;  ///< of all factorisations below

class CountingFactorisation final : public Factorisation {
 public:
  bool analyse(const BlockMatrix&, StopToken) override { return ++analyses > 0; }
  void load(const BlockMatrix& matrix) override {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * matrix.rows(), 3 * matrix.rows());
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index s = matrix.rowStart()[std::size_t(i)]; s < matrix.rowStart()[std::size_t(i) + 1]; ++s)
        for (int c = 0; c < 9; ++c)
          dense(3 * i + c / 3, 3 * matrix.columns()[std::size_t(s)] + c % 3) =
              matrix.values()[std::size_t(s) * 9 + std::size_t(c)];
    factors_.compute(dense);
  }
  SolveStop factor(Index&, StopToken) override { return SolveStop::converged; }
  void apply(ConstRows b, Rows x) override {
    Eigen::VectorXd all(3 * b.count);
    for (Index i = 0; i < b.count; ++i) all.segment<3>(3 * i) = b[i];
    all = factors_.solve(all);
    for (Index i = 0; i < x.count; ++i) x[i] = all.segment<3>(3 * i);
  }
  Cost cost() const override { return {.factor = 6e-6}; }  // some hundred products of six nodes

 private:
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

class CountingSolver final : public DirectSolver {
 public:
  bool needsSymmetric() const override { return true; }

 private:
  std::unique_ptr<Factorisation> makeFactorisation(bool) const override {
    return std::make_unique<CountingFactorisation>();
  }
};

const bool registered = (factory().add<ComingSprings>("TestComingSprings", "test"),
                         factory().add<CountingSolver>("TestCountingSolver", "test"), true);

/// A chain of six nodes whose first is held, with springs 0-3, 1-4 and 2-5 for a while each.
std::string scene(const std::string& solver, const std::string& times, const std::string& pairs = "0 3 1 4 2 5") {
  return fmt::format(R"(<Node name="root" dt="0.01"><EulerImplicitSolver/>{}
    <MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0.1 0  3 0 0.2  4 0 0  5 0.1 0.1"/>
    <UniformMass totalMass="3"/>
    <FixedProjectiveConstraint indices="0"/>
    <SpringForceField spring="0 1 500 0 1  1 2 500 0 1  2 3 500 0 1  3 4 500 0 1  4 5 500 0 1"/>
    <TestComingSprings stiffness="80" pairs="{}" {}/></Node>)",
                     solver, pairs, times);
}
const std::string coming = "from=\"0.05 0.1 0.1\" until=\"0.2 0.15 0.25\"";
const std::string direct = "<TestCountingSolver/>", sparse = "<SparseLDLSolver/>",
                  products = "<CGLinearSolver iterations=\"200\" tolerance=\"1e-14\"/>";

double largestDifference(Simulation& a, Simulation& b) {
  Vector difference(a.systems()[0]->allRows());
  copy(a.systems()[0]->x, difference);
  axpy(-1, b.systems()[0]->x, difference);
  return largest(difference);
}

TEST(ChangingPattern, AnalysisIsMadeOncePerChangeAndNoOther) {
  analyses = 0;
  Simulation simulation = simulationFromText(scene(direct, coming));
  std::vector<int> steps;
  for (int step = 1; step <= 30; ++step) {
    const int before = analyses;
    ASSERT_FALSE(simulation.step().diverged);
    if (analyses > before) steps.push_back(step);
  }
  // the first step; springs come at the ends of steps 5 and 10, and are gone after those of 15, 20 and 25
  EXPECT_EQ(steps, (std::vector<int>{1, 5, 10, 16, 21, 26}));
  EXPECT_EQ(analyses, 6);
}

/// The blocks that always are there are enough to find that a matrix would not pay.
TEST(ChangingPattern, IsNotMadeForAMatrixThatWouldNotPay) {
  Simulation simulation = simulationFromText(scene(products, coming + " assemblyCost=\"1e5\""));
  const MechanicalMatrix& matrix = simulation.systems()[0]->matrix();
  ASSERT_GT(matrix.productCost(), 0);
  const int few = int(matrix.assemblyCost() / matrix.productCost()) + 1;  // by far too few for the products of blocks besides
  EXPECT_FALSE(matrix.prefersAssembled(few));
  const int before = patterns;
  for (int step = 1; step <= 30; ++step) {
    ASSERT_FALSE(simulation.step().diverged);
    EXPECT_FALSE(matrix.prefersAssembled(few)) << "step " << step;
  }
  EXPECT_EQ(patterns, before);
  EXPECT_TRUE(matrix.prefersAssembled(100 * few));
  EXPECT_EQ(patterns, before + 1) << "it is made to be sure";
}

TEST(ChangingPattern, ProductsAndFactorsGiveOneTrajectory) {
  Simulation assembled = simulationFromText(scene(sparse, coming)), free = simulationFromText(scene(products, coming));
  Simulation without = simulationFromText(scene(products, coming, "0 1 0 1 0 1"));
  for (int step = 1; step <= 30; ++step) {
    ASSERT_FALSE(assembled.step().diverged);
    ASSERT_FALSE(free.step().diverged);
    without.step();
    EXPECT_LT(largestDifference(assembled, free), 1e-10) << "step " << step;
  }
  EXPECT_GT(largestDifference(assembled, without), 1e-2) << "the springs matter";
}

TEST(ChangingPattern, IsThatOfASceneCompiledWithTheSameSprings) {
  // all three are there from step 10 to step 15
  Simulation changing = simulationFromText(scene(sparse, coming));
  for (int step = 1; step < 10; ++step) changing.step();
  Simulation fixed = simulationFromText(scene(sparse, "from=\"0 0 0\" until=\"9 9 9\""));
  copy(changing.systems()[0]->x, fixed.systems()[0]->x);
  copy(changing.systems()[0]->v, fixed.systems()[0]->v);
  for (int step = 10; step <= 15; ++step) {
    changing.step();
    fixed.step();
    EXPECT_LT(largestDifference(changing, fixed), 1e-13) << "step " << step;
  }
  System &a = *changing.systems()[0], &b = *fixed.systems()[0];
  EXPECT_EQ(a.matrix().assemble().columns(), b.matrix().assemble().columns());
  changing.step();
  EXPECT_LT(a.matrix().assemble().blocks(), b.matrix().assemble().blocks()) << "a spring has gone with its blocks";
}

/// Former factors precondition a matrix that has lost or won springs, until that takes too many iterations: the trajectory is that
/// of the matrix itself, also of a run that is taken up again while the factors are of another pattern.
TEST(ChangingPattern, AWarpedFactorOutlivesItsPatternAlsoInARestore) {
  const std::string warped =
      "<PCGLinearSolver iterations=\"200\" tolerance=\"1e-12\" preconditioner=\"warped\"/><TestCountingSolver/>";
  analyses = 0;
  Simulation whole = simulationFromText(scene(warped, coming));
  std::vector<Archive> stored;
  std::vector<std::uint64_t> hashes;
  for (int step = 1; step <= 30; ++step) {
    stored.push_back(whole.checkpoint());
    ASSERT_FALSE(whole.step().diverged);
    hashes.push_back(whole.stateHash());
  }
  EXPECT_LT(analyses, 6) << "one per pattern: nothing outlived it";
  Simulation plain = simulationFromText(scene(products, coming));
  for (int step = 1; step <= 30; ++step) plain.step();
  EXPECT_LT(largestDifference(whole, plain), 1e-9);
  Simulation restored = simulationFromText(scene(warped, coming));
  for (std::size_t from = 0; from < stored.size(); ++from) {
    restored.restore(stored[from]);
    for (std::size_t step = from; step < std::min(from + 8, stored.size()); ++step) {
      ASSERT_FALSE(restored.step().diverged);
      ASSERT_EQ(restored.stateHash(), hashes[step]) << "step " << step + 1 << " restored after step " << from;
    }
  }
}

/// However few iterations a scene allows: a solve that reaches its limit with former factors goes on with new ones.
TEST(ChangingPattern, FormerFactorsThatDoNotReachTheToleranceAreMadeAnew) {
  const std::string few =
      "<PCGLinearSolver iterations=\"3\" tolerance=\"1e-8\" preconditioner=\"warped\"/><TestCountingSolver/>";
  analyses = 0;
  Simulation simulation = simulationFromText(scene(few, coming));
  for (int step = 1; step <= 30; ++step) EXPECT_TRUE(simulation.step().linear_converged) << "step " << step;
  EXPECT_GT(analyses, 1);
}

TEST(ChangingPattern, ABodyThatOnlyAVanishingSpringHeldIsNamed) {
  // the tetrahedron can turn about the axis through nodes 0 and 1, but for a spring from node 2 to the held node 4
  Simulation simulation = simulationFromText(
      R"(<Node name="root" dt="1" gravity="0 -10 0"><StaticSolver/><SparseLDLSolver/>
           <MechanicalObject name="dofs" position="0 0 0  1 0 0  0 1 0  0 0 1  0 1 0"/>
           <MeshTopology position="@dofs.position" tetrahedra="0 1 2 3"/><UniformMass vertexMass="0.5"/>
           <TetrahedronFEMForceField youngModulus="5e9" poissonRatio="0.3" method="small"/>
           <FixedProjectiveConstraint indices="0 1 4"/>
           <TestComingSprings pairs="2 4" from="0" until="2" stiffness="1e9"/></Node>)");
  for (int step = 1; step <= 2; ++step) ASSERT_FALSE(simulation.step().diverged);
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  expectContains(report.reason, "the part of /dofs around node 0 (4 nodes) is not held against rotation");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
