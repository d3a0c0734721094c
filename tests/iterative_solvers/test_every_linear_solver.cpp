// SPDX-License-Identifier: LGPL-2.1-or-later
// What holds for every linear solver, on systems of an elastic block that no component made.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "framework/algebra/parallel.h"
#include "framework/algebra/stop.h"
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {
namespace {

constexpr double tolerance = 1e-11;

struct Kind {
  std::string name, element;
  bool definite_only = false;  ///< conjugate gradients and L L^T
  bool is_direct = false;
  bool keeps_first = false;  ///< the factors of the first matrix for all
};

std::ostream& operator<<(std::ostream& out, const Kind& kind) { return out << kind.name; }

std::vector<Kind> kinds() {
  std::vector<Kind> all;
  const std::string limits = " iterations=\"20000\" tolerance=\"1e-11\"";
  all.push_back({"CG", "<CGLinearSolver" + limits + "/>", true});
  all.push_back({"MinRes", "<MinResLinearSolver" + limits + "/>"});
  all.push_back({"MinResAssembled", "<MinResLinearSolver template=\"CompressedRowSparseMatrix\"" + limits + "/>"});
  for (const char* word : {"auto", "none", "jacobi", "block_jacobi", "ssor", "incomplete_cholesky", "multigrid"})
    all.push_back({std::string("PCG_") + word,
                   "<PCGLinearSolver preconditioner=\"" + std::string(word) + "\"" + limits + "/>", true});
  all.push_back({"PCG_warped", "<PCGLinearSolver preconditioner=\"warped\"" + limits + "/><SparseLDLSolver/>", true});
  for (const char* type : {"Jacobi", "BlockJacobi", "SSOR", "IncompleteCholesky", "Multigrid"})
    all.push_back({std::string("PCG_linked_") + type,
                   "<PCGLinearSolver preconditioner=\"@p\"" + limits + "/><" + type + "Preconditioner name=\"p\"/>",
                   true});
  for (const char* type : {"Warp", "PrecomputedWarp"})
    all.push_back({std::string("PCG_linked_") + type,
                   "<PCGLinearSolver preconditioner=\"@p\"" + limits + "/><" + type + "Preconditioner name=\"p\"/><EigenSimplicialLLT/>",
                   true});
  all.push_back({"Automatic", "<AutomaticLinearSolver/>", true, true});
  for (const char* type : {"SparseLDLSolver", "EigenSimplicialLLT", "SparseCholeskySolver", "CholeskySolver"})
    all.push_back({type, "<" + std::string(type) + "/>", true, true});
  all.push_back({"Precomputed", "<PrecomputedLinearSolver/>", true, true, true});
  for (const char* type :
       {"EigenSimplicialLDLT", "EigenSparseLU", "SparseLUSolver", "EigenSparseQR", "SVDLinearSolver"})
    all.push_back({type, "<" + std::string(type) + "/>", false, true});
  return all;
}

TEST(LinearSolvers, AreAllHere) {
  modules().openAll();
  const std::vector<Kind> all = kinds();
  for (const ComponentEntry* entry : factory().entries()) {
    const std::string role = factory().make(entry->type)->roleText();
    if (role != "linear solver" && role != "preconditioner") continue;
    const auto names = [entry](const Kind& kind) { return kind.element.find("<" + entry->type) != std::string::npos; };
    EXPECT_TRUE(entry->module.empty() || std::any_of(all.begin(), all.end(), names))
        << entry->type << " is registered as a " << role << ": kinds() has no element of it";
  }
}

class EveryLinearSolver : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Solvers, EveryLinearSolver, testing::ValuesIn(kinds()),
                         [](const auto& tested) { return tested.param.name; });

ElasticBlock block(Index n) {
  ElasticBlock result;
  result.cells = {n, n, n};
  return result;
}

std::vector<std::pair<std::string, ElasticBlock>> systems() {
  ElasticBlock held = block(3), sliding = block(3), dynamic = block(3), stiff = block(3), incompressible = block(3);
  sliding.slide_wall = true;
  dynamic.hold_floor = false, dynamic.density = 0.1;
  stiff.stiffer = [](Vec3 at) { return at.x() > 1 ? 1e4 : 1.; };
  incompressible.poisson = 0.499;
  return {{"held", held},
          {"sliding wall", sliding},
          {"consistent mass", dynamic},
          {"stiff half", stiff},
          {"nearly incompressible", incompressible}};
}

/// The same matrix with the diagonal blocks of some rows made negative: indefinite and regular.
StoredMatrix indefinite() {
  StoredMatrix matrix = block(3).matrix();
  for (const Index row : {20, 30, 50}) matrix.values.add(matrix.values.diagonal()[row], -3 * Mat3::Identity());
  return matrix;
}

bool solved(const SolveReport& report) { return report.stop == SolveStop::converged; }

TEST_P(EveryLinearSolver, FindsTheSolutionToItsTolerance) {
  for (const auto& [name, system] : systems()) {
    StoredMatrix matrix = system.matrix();
    const Eigen::MatrixXd a = matrix.dense();
    const Vector b = randomVector(matrix.rows(), 5);
    SolverInScene solver(GetParam().element);
    Vector x;
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_TRUE(solved(report)) << name << ": " << describe(report.stop);
    EXPECT_EQ(report.factored, GetParam().is_direct || GetParam().name.find("arp") != std::string::npos) << name;
    const double measured = (dense(b) - a * dense(x)).norm() / dense(b).norm();
    EXPECT_LE(measured, GetParam().is_direct ? 1e-10 : 1.2 * tolerance) << name;
    EXPECT_NEAR(report.relative_residual, measured, 1e-11) << name;
    const Eigen::VectorXd values = eigenvalues(a);
    const double condition = values.maxCoeff() / values.minCoeff();
    const double bound = condition * std::max(measured, 1e-15) * 2;
    EXPECT_LE(relativeError(x, denseSolution(a, dense(b))), bound) << name;
  }
}

TEST_P(EveryLinearSolver, GivesZeroForAZeroRightSide) {
  StoredMatrix matrix = block(2).matrix();
  SolverInScene solver(GetParam().element);
  Vector x = randomVector(matrix.rows(), 1);
  const SolveReport report = solver.solve(matrix, Vector(matrix.rows()).rows(), x);
  EXPECT_EQ(report.stop, SolveStop::zero_right_side);
  EXPECT_EQ(dot(x, x), 0);
}

/// Of a block of right sides each is solved for as if it were alone: whole ones, those of two nodes, and one that is zero.
TEST_P(EveryLinearSolver, SolvesForManyRightSidesAtOnce) {
  StoredMatrix matrix = block(3).matrix();
  const Eigen::MatrixXd a = matrix.dense();
  for (const std::size_t count : {std::size_t(2), std::size_t(37)}) {
    std::vector<Vector> b(count), x(count);
    std::vector<ConstRows> asked;
    std::vector<Rows> answers;
    for (std::size_t i = 0; i < count; ++i) {
      b[i] = randomVector(matrix.rows(), unsigned(i));
      x[i].resize(matrix.rows());
      for (Index row = 0; row < matrix.rows(); ++row)
        if (i == 1 || (i % 3 == 2 && row / 2 != Index(i) % 20)) b[i][row].setZero();
      asked.push_back(b[i]), answers.push_back(x[i]);
    }
    SolverInScene solver(GetParam().element);
    const SolveReport report = solver.solver->solveAll(matrix, asked, answers);
    EXPECT_TRUE(solved(report)) << describe(report.stop);
    EXPECT_GE(report.iterations, int(count) - 1);
    EXPECT_EQ(report.factored, GetParam().is_direct || GetParam().name.find("arp") != std::string::npos);
    EXPECT_EQ(largest(x[1]), 0);
    for (std::size_t i = 0; i < count; ++i) {
      const double left = (dense(b[i]) - a * dense(x[i])).norm();
      EXPECT_LE(left, (GetParam().is_direct ? 1e-10 : 1.2 * tolerance) * norm(b[i])) << i;
    }
    b[0][4][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(solver.solver->solveAll(matrix, asked, answers).stop, SolveStop::not_finite);
  }
}

TEST_P(EveryLinearSolver, NamesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StoredMatrix matrix = block(2).matrix();
  SolverInScene solver(GetParam().element);
  Vector b = randomVector(matrix.rows(), 1), x;
  b[4][2] = nan;
  EXPECT_EQ(solver.solve(matrix, b, x).stop, SolveStop::not_finite);
  matrix.values.add(13, 13, nan * Mat3::Ones());
  ++matrix.revision_number;
  const SolveReport report = solver.solve(matrix, randomVector(matrix.rows(), 1), x);
  EXPECT_FALSE(report.usable()) << describe(report.stop);
  if (report.row >= 0) {
    EXPECT_EQ(report.row, 13);
  }
}

TEST_P(EveryLinearSolver, SolvesAnIndefiniteSystemOrSaysThatItIsOne) {
  StoredMatrix matrix = indefinite();
  ASSERT_LT(eigenvalues(matrix.dense()).minCoeff(), -0.1);
  const Vector b = randomVector(matrix.rows(), 3);
  SolverInScene solver(GetParam().element);
  Vector x;
  const SolveReport report = solver.solve(matrix, b, x);
  if (GetParam().definite_only) {
    EXPECT_EQ(report.stop, SolveStop::not_definite) << describe(report.stop);
  } else {
    EXPECT_TRUE(solved(report)) << describe(report.stop);
    EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-8);
  }
}

/// `matrix` and one more row, which nothing ties to the others.
StoredMatrix withLooseRow(const StoredMatrix& matrix, double size) {
  const BlockMatrix& from = matrix.values;
  BlockPattern pattern(matrix.rows() + 1);
  for (Index i = 0; i < from.rows(); ++i)
    for (Index s = from.rowStart()[i]; s < from.rowStart()[i + 1]; ++s) {
      const std::array<Index, 2> pair{i, from.columns()[s]};
      pattern.addClique(pair.data(), 2);
    }
  BlockMatrix values(std::move(pattern));
  for (Index i = 0; i < from.rows(); ++i)
    for (Index s = from.rowStart()[i]; s < from.rowStart()[i + 1]; ++s)
      values.add(i, from.columns()[s], Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from.values().data() + 9 * s));
  values.add(matrix.rows(), matrix.rows(), size * Mat3::Identity());
  return StoredMatrix(std::move(values));
}

TEST_P(EveryLinearSolver, MovesWhatIsFarLighterThanTheRest) {
  if (GetParam().name == "EigenSparseQR") return;  // leaves small pivots, and says so
  const StoredMatrix body = block(3).matrix();
  for (const double mass : {1e-6, 1e-12, 1e-20}) {
    StoredMatrix matrix = withLooseRow(body, mass);
    Vector b = randomVector(matrix.rows(), 5), x;
    b[body.rows()] = mass * Vec3(1, -2, 3);
    SolverInScene solver(GetParam().element);
    EXPECT_TRUE(solved(solver.solve(matrix, b, x))) << mass;
    EXPECT_LT((x[body.rows()] - Vec3(1, -2, 3)).norm(), 4e-3 * dense(x).cwiseAbs().maxCoeff()) << mass;
  }
}

TEST(LightRows, AreSeenByLooseSolves) {
  const StoredMatrix body = block(8).matrix();
  StoredMatrix matrix = withLooseRow(body, 1e-20);
  Vector b = randomVector(matrix.rows(), 5);
  const Eigen::VectorXd of_body = denseSolution(body.dense(), dense(b).head(3 * body.rows()));
  const Vec3 exact = Vec3(1, -2, 3) * of_body.cwiseAbs().maxCoeff();
  b[body.rows()] = 1e-20 * exact;
  for (const std::string name :
       {"CGLinearSolver preconditioner='none'", "CGLinearSolver preconditioner='block_jacobi'", "PCGLinearSolver preconditioner='none'",
        "PCGLinearSolver preconditioner='block_jacobi'", "PCGLinearSolver preconditioner='ssor'", "MinResLinearSolver",
        "AutomaticLinearSolver"}) {
    SolverInScene solver("<" + name + " tolerance='1e-2' iterations='1000'/>");
    Vector x;
    EXPECT_TRUE(solved(solver.solve(matrix, b, x))) << name;
    EXPECT_LT((x[body.rows()] - exact).cwiseAbs().maxCoeff(), 1e-2 * dense(x).cwiseAbs().maxCoeff()) << name;
  }
}

void setDiagonal(StoredMatrix& matrix, Index row, const Mat3& block) {
  const Index slot = matrix.values.diagonal()[row];
  const Mat3 old = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.values.values().data() + 9 * slot);
  matrix.values.add(slot, -old), matrix.values.add(slot, block);
  ++matrix.revision_number;
}

/// Bits do not depend on the matrices that a solver has had before.
TEST(LightRows, AreThoseOfTheMatrixSolved) {
  StoredMatrix matrix = withLooseRow(block(3).matrix(), 1);
  const Index loose = matrix.rows() - 1;
  Vector b = randomVector(matrix.rows(), 5);
  for (const std::string name :
       {"CGLinearSolver preconditioner='none'", "PCGLinearSolver preconditioner='none'", "PCGLinearSolver preconditioner='ssor'",
        "MinResLinearSolver", "AutomaticLinearSolver"}) {
    SolverInScene used("<" + name + " tolerance='1e-6' iterations='1000'/>"), fresh("<" + name + " tolerance='1e-6' iterations='1000'/>");
    Vector x, again;
    for (const double size : {1., 1e-12}) {
      setDiagonal(matrix, loose, size * Mat3::Identity());
      b[loose] = size * Vec3(1, -2, 3);
      x = Vector();
      EXPECT_TRUE(solved(used.solve(matrix, b, x))) << name << " " << size;
    }
    EXPECT_LT((x[loose] - Vec3(1, -2, 3)).norm(), 4e-3 * dense(x).cwiseAbs().maxCoeff()) << name;
    EXPECT_TRUE(solved(fresh.solve(matrix, b, again))) << name;
    EXPECT_TRUE(dense(x) == dense(again)) << name;
  }
}

/// One row with a block of its own in the way: negative, of no size, or singular but for round-off. No force acts there.
TEST(LightRows, AreSeenBesideBlocksThatAreNotDefinite) {
  const Vec3 along(1, 2, 3);
  for (const Mat3& bad : {Mat3(-Mat3::Identity()), Mat3(Mat3::Zero()), Mat3(along * along.transpose() / 7)}) {
    StoredMatrix matrix = withLooseRow(withLooseRow(block(3).matrix(), 0), 1e-12);
    const Index loose = matrix.rows() - 1;
    setDiagonal(matrix, loose - 1, bad);
    Vector b = randomVector(matrix.rows(), 5), x;
    b[loose - 1].setZero(), b[loose] = 1e-12 * Vec3(1, -2, 3);
    for (const std::string name : {"CGLinearSolver preconditioner='none'", "PCGLinearSolver preconditioner='none'", "MinResLinearSolver"}) {
      SolverInScene solver("<" + name + " tolerance='1e-6' iterations='1000'/>");
      EXPECT_TRUE(solved(solver.solve(matrix, b, x))) << name << " " << bad;
      EXPECT_LT((x[loose] - Vec3(1, -2, 3)).norm(), 4e-3 * dense(x).cwiseAbs().maxCoeff()) << name << " " << bad;
    }
  }
}

TEST(LightRows, AreSeenByMinResInAnIndefiniteSystem) {
  StoredMatrix matrix = withLooseRow(indefinite(), 1e-12);
  Vector b = randomVector(matrix.rows(), 3), x;
  b[matrix.rows() - 1] = 1e-12 * Vec3(1, -2, 3);
  SolverInScene solver("<MinResLinearSolver tolerance='1e-6' iterations='2000'/>");
  EXPECT_TRUE(solved(solver.solve(matrix, b, x)));
  EXPECT_LT((x[matrix.rows() - 1] - Vec3(1, -2, 3)).norm(), 4e-3 * dense(x).cwiseAbs().maxCoeff());
}

/// One body of which the first product tells all, and two far lighter ones that lean on each other. The second product asks to stop.
class StoppingMatrix final : public SystemMatrix {
 public:
  mutable StopRequest request;
  mutable int products = 0, diagonals = 0;
  StoppingMatrix() : inner(make()) {}
  MatrixKey key() const override { return {identity().get(), 1, 1}; }
  Index rows() const override { return 3; }
  void multiply(ConstRows p, Rows out) const override {
    inner.multiply(p, out);
    if (++products == 2) request.make();
  }
  const BlockMatrix& assemble() override { return inner.assemble(); }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    ++diagonals;
    inner.diagonalBlocks(blocks);
  }
  bool symmetric() const override { return true; }
  bool prefersAssembled(int) const override { return false; }
  std::string describeRow(Index row) const override { return inner.describeRow(row); }

 private:
  StoredMatrix inner;
  static StoredMatrix make() {
    BlockPattern pattern(3);
    const std::array<Index, 2> pair{1, 2};
    pattern.addClique(pair.data(), 2);
    const Index first = 0;
    pattern.addClique(&first, 1);
    BlockMatrix values(std::move(pattern));
    values.add(0, 0, Mat3::Identity());
    for (const Index row : {1, 2}) values.add(row, row, 2e-12 * Mat3::Identity());
    values.add(1, 2, -1e-12 * Mat3::Identity()), values.add(2, 1, -1e-12 * Mat3::Identity());
    return StoredMatrix(std::move(values));
  }
};

TEST(LightRows, AreLeftBySolvesThatAreStopped) {
  for (const std::string name : {"CGLinearSolver preconditioner='none'", "PCGLinearSolver preconditioner='none'"}) {
    StoppingMatrix matrix;
    Vector b(3), x(3);
    b[0] = Vec3(1, -2, 3), b[1] = Vec3(1e-12, 0, 0);
    SolverInScene solver("<" + name + " tolerance='1e-6' iterations='1000'/>");
    EXPECT_EQ(solver.solver->solve(matrix, b, x, {.stop = StopToken(matrix.request)}).stop, SolveStop::stopped) << name;
  }
}

/// The diagonal that preconditions tells what is left: it is not taken again.
TEST(LightRows, AreSeenByTheBlocksThatPrecondition) {
  for (const std::string type : {"CGLinearSolver", "PCGLinearSolver"}) {
    StoppingMatrix matrix;
    Vector b(3), x(3);
    b[0] = Vec3(1, -2, 3), b[1] = Vec3(1e-12, 0, 0);
    SolverInScene solver("<" + type + " preconditioner='block_jacobi' tolerance='1e-6' iterations='1000'/>");
    EXPECT_TRUE(solved(solver.solver->solve(matrix, b, x, {}))) << type;
    EXPECT_NEAR(x[1][0], 2. / 3, 4e-3) << type;
    EXPECT_EQ(matrix.diagonals, 1) << type;
  }
}

/// What moves along the one stiff direction of a row, as in a chain of springs: elimination leaves round-off for the others.
TEST(LightRows, AreNotMadeOfRoundOff) {
  StoredMatrix matrix = withLooseRow(block(3).matrix(), 0);
  const Index loose = matrix.rows() - 1;
  Vector b = randomVector(matrix.rows(), 5), x;
  for (int k = 1; k < 20; ++k) {
    const Vec3 along = Vec3(1, 0.1 * k, 0.37 * k).normalized();
    setDiagonal(matrix, loose, 1e-3 * along * along.transpose());
    b[loose] = 1e-3 * along;
    for (const std::string name : {"CGLinearSolver preconditioner='none'", "PCGLinearSolver preconditioner='none'", "MinResLinearSolver"}) {
      SolverInScene solver("<" + name + " tolerance='1e-9' iterations='1000'/>");
      EXPECT_TRUE(solved(solver.solve(matrix, b, x))) << name << " " << k;
    }
  }
}

TEST(LightRows, AreLeftWhereTheyAreBySofasEnds) {
  StoredMatrix matrix = withLooseRow(block(3).matrix(), 1e-20);
  Vector b = randomVector(matrix.rows(), 5), x;
  SolverInScene solver("<CGLinearSolver tolerance='1e-5' iterations='100' absoluteThreshold='1e-300'/>");
  b[matrix.rows() - 1] = 1e-20 * Vec3(1, 0, 0);
  EXPECT_TRUE(solved(solver.solve(matrix, b, x)));
  EXPECT_LT(x[matrix.rows() - 1].norm(), 1e-6);  // as SOFA leaves it
}

TEST_P(EveryLinearSolver, DoesNotSolveASingularSystemSilently) {
  ElasticBlock free = block(2);
  free.hold_floor = false;
  StoredMatrix matrix = free.matrix();
  const Vector b = randomVector(matrix.rows(), 3);  // pushes the body along its rigid motions: no solution
  SolverInScene solver(GetParam().element);
  Vector x;
  const SolveReport report = solver.solve(matrix, b, x);
  EXPECT_FALSE(solved(report)) << describe(report.stop);
}

TEST_P(EveryLinearSolver, DoesNotDependOnTheNumberOfThreads) {
  StoredMatrix matrix = block(6).matrix();
  const Vector b = randomVector(matrix.rows(), 3);
  Vector x[2];
  for (const int count : {1, 2}) {
    setThreads(count);
    SolverInScene solver(GetParam().element);
    EXPECT_TRUE(solved(solver.solve(matrix, b, x[count - 1])));
  }
  setThreads(1);
  ASSERT_GT(x[0].count(), 0);
  EXPECT_EQ(std::memcmp(x[0].rows().data, x[1].rows().data, x[0].rows().doubles() * sizeof(double)), 0);
}

TEST_P(EveryLinearSolver, FollowsAMatrixThatChanges) {
  if (GetParam().keeps_first) return;
  StoredMatrix matrix = block(3).matrix();
  const Vector b = randomVector(matrix.rows(), 3);
  SolverInScene solver(GetParam().element);
  for (int change = 0; change < 4; ++change) {
    for (Index row = change; row < matrix.rows(); row += 3) matrix.values.add(row, row, 0.5 * Mat3::Identity());
    ++matrix.revision_number;
    Vector x;
    EXPECT_TRUE(solved(solver.solve(matrix, b, x)));
    EXPECT_LT((dense(b) - matrix.dense() * dense(x)).norm(), 1e-10 * dense(b).norm());
  }
}

TEST(LinearSolvers, LUAndQRSolveUnsymmetricSystems) {
  StoredMatrix matrix = block(3).matrix();
  for (Index i = 16; i < matrix.rows(); ++i)
    matrix.values.add(i, i, (Mat3() << 0, 1, 2, -1, 0, 3, -2, -3, 0).finished());
  matrix.is_symmetric = false;
  const Vector b = randomVector(matrix.rows(), 1);
  for (const char* type : {"EigenSparseLU", "EigenSparseQR", "SVDLinearSolver", "SparseLDLSolver"}) {
    SolverInScene solver("<" + std::string(type) + "/>");
    EXPECT_FALSE(solver.solver->needsSymmetric());
    Vector x;
    EXPECT_TRUE(solved(solver.solve(matrix, b, x))) << type;
    EXPECT_LT(relativeError(x, denseSolution(matrix.dense(), dense(b))), 1e-10) << type;
  }
  for (const char* type : {"EigenSimplicialLLT", "EigenSimplicialLDLT", "CholeskySolver", "MinResLinearSolver",
                           "PCGLinearSolver", "CGLinearSolver"})
    EXPECT_TRUE(SolverInScene("<" + std::string(type) + "/>").solver->needsSymmetric()) << type;
}

TEST(LinearSolvers, SingularValuesGiveTheShortestLeastSquaresSolution) {
  ElasticBlock free = block(2);
  free.hold_floor = false;
  StoredMatrix matrix = free.matrix();
  const Vector b = randomVector(matrix.rows(), 3);
  SolverInScene solver("<SVDLinearSolver minSingularValue=\"1e-10\"/>");
  Vector x;
  solver.solve(matrix, b, x);
  const Eigen::VectorXd exact = leastSquares(matrix.dense(), dense(b));
  EXPECT_LT(relativeError(x, exact), 1e-9);
}

TEST(MinRes, TheResidualNeverGrowsAndEndsAtTheLeastSquares) {
  StoredMatrix matrix = indefinite();
  SolverInScene solver("<MinResLinearSolver iterations=\"2000\" tolerance=\"1e-9\"/>");
  Vector x;
  solver.solve(matrix, randomVector(matrix.rows(), 3), x);
  const std::vector<double> history = solver.reals("graph");
  ASSERT_GT(history.size(), 10u);
  for (std::size_t i = 1; i < history.size(); ++i) EXPECT_LE(history[i], history[i - 1]);

  ElasticBlock free = block(2);
  free.hold_floor = false;
  StoredMatrix singular = free.matrix();
  const Vector b = randomVector(singular.rows(), 3);
  SolverInScene again("<MinResLinearSolver iterations=\"2000\" tolerance=\"1e-13\"/>");
  EXPECT_EQ(again.solve(singular, b, x).stop, SolveStop::breakdown);
  const Eigen::VectorXd residual = dense(b) - singular.dense() * dense(x);
  const Eigen::VectorXd least =
      dense(b) - singular.dense() * leastSquares(singular.dense(), dense(b));
  EXPECT_NEAR(residual.norm(), least.norm(), 1e-9 * least.norm());
}

TEST(LinearSolvers, ProductsWithAMatrixOfZerosAreABreakdown) {
  StoredMatrix matrix = block(2).matrix();
  std::fill(matrix.values.values().begin(), matrix.values.values().end(), 0.0);
  for (const char* element : {"<MinResLinearSolver/>", "<CGLinearSolver preconditioner='none'/>",
                              "<PCGLinearSolver preconditioner='none'/>"}) {
    SolverInScene solver(element);
    Vector x;
    EXPECT_EQ(solver.solve(matrix, randomVector(matrix.rows(), 3), x).stop, SolveStop::breakdown) << element;
    EXPECT_EQ(norm(x), 0) << element;
  }
}

TEST(MinRes, EachIterateMinimisesTheResidualOverItsKrylovSpace) {
  StoredMatrix matrix = indefinite();
  const Vector b = randomVector(matrix.rows(), 3);
  const Eigen::MatrixXd a = matrix.dense();
  Eigen::MatrixXd basis = dense(b).normalized();
  for (int iterations = 1; iterations <= 8; ++iterations) {
    SolverInScene solver("<MinResLinearSolver tolerance=\"0\" iterations=\"" + std::to_string(iterations) + "\"/>");
    Vector x;
    const SolveReport report = solver.solve(matrix, b, x);
    EXPECT_EQ(report.stop, SolveStop::iteration_limit);
    const Eigen::VectorXd weights = leastSquares(a * basis, dense(b));
    EXPECT_NEAR(report.relative_residual, (dense(b) - a * basis * weights).norm() / dense(b).norm(), 1e-10);
    Eigen::VectorXd next = a * basis.rightCols(1);
    for (int pass = 0; pass < 2; ++pass) next -= basis * (basis.transpose() * next);
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols(1) = next.normalized();
  }
}

}  // namespace
}  // namespace stroma::test
