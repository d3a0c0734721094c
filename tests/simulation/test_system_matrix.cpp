// SPDX-License-Identifier: LGPL-2.1-or-later
// The matrix P (m M + k K) P + D (I - P): products against the assembled form, revisions, and projection.
#include <fmt/format.h>

#include <Eigen/Dense>

#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A bent line of five nodes, one held, one in a slanted plane, one along an axis.
std::string scene(const std::string& fields, const std::string& more = "") {
  return fmt::format(R"(<Node name="root"><TestIntegrator/>
    <MechanicalObject name="dofs" position="0 0 0  1 0.3 0  2 0 0.4  3 0.2 0.1  4 0 0"
                      rest_position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0"/>
    <UniformMass name="mass" totalMass="10" rayleighMass="0.5"/>{}
    <FixedProjectiveConstraint indices="0"/>
    <TestPlane name="plane" indices="2 3"/>
    <PartialFixedProjectiveConstraint indices="3" fixedDirections="0 1 0"/>{}</Node>)",
                     fields, more);
}
const std::string springs = "<TestSprings name='springs' rayleighStiffness='0.02' stiffness='80'/>";
const std::string net = "<TestLinearNet name='net' rayleighStiffness='0.01'/>";
const std::string curl = "<TestUnsymmetric name='curl'/>";

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(3 * matrix.rows(), 3 * matrix.rows());
  for (Index i = 0; i < matrix.rows(); ++i)
    for (Index s = matrix.rowStart()[i]; s < matrix.rowStart()[i + 1]; ++s)
      for (int c = 0; c < 9; ++c)
        out(3 * i + c / 3, 3 * matrix.columns()[s] + c % 3) = matrix.values()[std::size_t(s) * 9 + std::size_t(c)];
  return out;
}

/// The matrix by its products with unit vectors that are projected first.
Eigen::MatrixXd byProducts(const System& system) {
  const Index rows = system.independentRows();
  Eigen::MatrixXd out(3 * rows, 3 * rows);
  Vector p(rows), product(rows);
  for (Index j = 0; j < 3 * rows; ++j) {
    clear(p);
    p[j / 3][j % 3] = 1;
    system.constraints().project(p);
    system.matrix().multiply(p, product);
    for (Index i = 0; i < 3 * rows; ++i) out(i, j) = product[i / 3][i % 3];
  }
  return out;
}

Eigen::MatrixXd projector(const System& system) {
  Eigen::MatrixXd p = Eigen::MatrixXd::Identity(3 * system.independentRows(), 3 * system.independentRows());
  for (const NodeProjector& held : system.constraints().projectors())
    p.block<3, 3>(3 * held.row, 3 * held.row) = held.projector;
  return p;
}

/// D (I - P): of each held node a power of two times what its projector takes away.
Eigen::MatrixXd heldPart(const System& system, const Eigen::MatrixXd& assembled) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(assembled.rows(), assembled.cols());
  for (const NodeProjector& node : system.constraints().projectors()) {
    const Mat3 held = Mat3::Identity() - node.projector;
    const double mean = (held * assembled.block<3, 3>(3 * node.row, 3 * node.row) * held).trace() / held.trace();
    const double size = std::exp2(std::round(std::log2(mean)));
    EXPECT_NEAR(mean, size, 1e-12 * size);
    out.block<3, 3>(3 * node.row, 3 * node.row) = size * held;
  }
  return out;
}

class Matrices : public testing::TestWithParam<std::string> {};

TEST_P(Matrices, AssembledIsTheProductsAndNumbersOfTheirSizeInHeldDirections) {
  Simulation simulation(sceneFromText(scene(GetParam())));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  system.matrix().withFactors({.mass = 2, .stiffness = -0.3, .rayleigh_mass = 0.4, .rayleigh_stiffness = -0.7});
  const Eigen::MatrixXd p = projector(system);
  std::vector<double> before, after;
  system.matrix().diagonalBlocks(before);  // by the fields, and once there is a matrix, out of it
  const Eigen::MatrixXd products = byProducts(system), assembled = dense(system.matrix().assemble());
  system.matrix().diagonalBlocks(after);
  EXPECT_GT((products - p * 4.4 * p).norm(), 1) << "more than the mass";
  const Eigen::MatrixXd held = heldPart(system, assembled);
  EXPECT_LT((assembled - products - held).norm(), 1e-12 * assembled.norm());
  EXPECT_EQ((assembled - assembled.transpose()).norm() < 1e-12 * assembled.norm(), system.matrix().symmetric());
  ASSERT_EQ(before.size(), after.size());
  for (Index i = 0; i < system.independentRows(); ++i)
    for (int c = 0; c < 9; ++c) {
      const double expected = assembled(3 * i + c / 3, 3 * i + c % 3);
      EXPECT_NEAR(before[std::size_t(i) * 9 + std::size_t(c)], expected, 1e-12);
      EXPECT_EQ(after[std::size_t(i) * 9 + std::size_t(c)], expected);
    }
  // held: row and column of a multiple of the identity
  EXPECT_EQ(assembled.block(0, 0, 3, 3), held.block(0, 0, 3, 3));
  EXPECT_EQ(assembled.block(0, 3, 3, 12).norm(), 0);
  EXPECT_EQ(assembled.block(3, 0, 12, 3).norm(), 0);
}

INSTANTIATE_TEST_SUITE_P(Fields, Matrices, testing::Values(springs, net, springs + net, springs + curl),
                         [](const auto& fields) { return fmt::format("Case{}", fields.index); });

/// In any unit: a matrix times a power of two has its held numbers times that too, so that no direction loses digits to them.
TEST(SystemMatrix, HeldNumbersScaleWithTheOthers) {
  Simulation simulation(sceneFromText(scene(springs)));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  const Eigen::MatrixXd one = dense(system.matrix().withFactors({.mass = 1, .stiffness = -1}).assemble());
  for (const int exponent : {-60, -3, 40}) {
    const double factor = std::ldexp(1., exponent);
    const Eigen::MatrixXd other = dense(system.matrix().withFactors({.mass = factor, .stiffness = -factor}).assemble());
    EXPECT_EQ((other - factor * one).norm(), 0) << exponent;
  }
  const double held = one(0, 0), at_least = 2;  // node 0 has 2 kg and a spring of 80 N/m
  EXPECT_GT(held, at_least);
  EXPECT_LT(held, at_least + 80);
}

TEST(SystemMatrix, HasTheFactorsOfEachTerm) {
  Simulation simulation(sceneFromText(scene(springs)));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  const Eigen::MatrixXd p = projector(system);
  const auto terms = [&](double m, double k, double k_rayleigh, double m_rayleigh) -> Eigen::MatrixXd {
    const MatrixFactors factors{.mass = m, .stiffness = k, .rayleigh_mass = m_rayleigh, .rayleigh_stiffness = k_rayleigh};
    return p * dense(system.matrix().withFactors(factors).assemble()) * p;
  };
  EXPECT_LT((terms(3, 0, 0, 0) - 6 * p).norm(), 1e-12);  // 2 kg per node
  EXPECT_LT((terms(0, 0, 0, 3) - 3 * p).norm(), 1e-12);  // times rayleighMass
  const Eigen::MatrixXd stiffness = terms(0, 1, 0, 0);
  EXPECT_GT(stiffness.norm(), 100);
  EXPECT_LT((terms(0, 0, 10, 0) - 0.2 * stiffness).norm(), 1e-12 * stiffness.norm());
  Vector out(system.independentRows()), v(system.independentRows());
  for (Index i = 0; i < system.independentRows(); ++i) v[i] = Vec3(1, 2, i);
  system.addRayleighMassProduct(v, 0.25, 3, out);
  EXPECT_LT((Vec3(out[4]) - (0.25 + 0.5) * 3 * 2 * Vec3(1, 2, 4)).norm(), 1e-13);
}

TEST(SystemMatrix, TwoConstraintsLeaveWhatBothLeave) {
  Simulation simulation(sceneFromText(scene(springs)));
  System& system = *simulation.systems()[0];
  ASSERT_EQ(system.constraints().projectors().size(), 3u);
  const Vec3 n = Vec3(1, 2, 3).normalized(), free = Vec3::UnitY().cross(n).normalized();
  EXPECT_LT((system.constraints().projectors()[1].projector - (Mat3::Identity() - n * n.transpose())).norm(), 1e-15);
  EXPECT_LT((system.constraints().projectors()[2].projector - free * free.transpose()).norm(), 1e-7);
}

TEST(SystemMatrix, KeyChangesWithValuesOnly) {
  Simulation simulation(sceneFromText(scene(net)));
  System& system = *simulation.systems()[0];
  system.computeForce(system.x, system.v, system.f);
  const MatrixKey first = system.matrix().withFactors({.mass = 1, .stiffness = -1}).key();
  system.matrix().assemble();
  system.computeForce(system.x, system.v, system.f);
  EXPECT_TRUE(system.matrix().withFactors({.mass = 1, .stiffness = -1}).key() == first)
      << "a constant stiffness does not change with a force evaluation";
  system.matrix().assemble();
  EXPECT_EQ(system.counts.assemblies, 1);
  EXPECT_FALSE(system.matrix().withFactors({.mass = 1, .stiffness = -2}).key() == first);
  system.matrix().assemble();
  EXPECT_EQ(system.counts.assemblies, 2);

  Simulation changing(sceneFromText(scene(springs)));
  System& other = *changing.systems()[0];
  other.computeForce(other.x, other.v, other.f);
  const MatrixKey before = other.matrix().withFactors({.mass = 1, .stiffness = -1}).key();
  EXPECT_TRUE(other.matrix().withFactors({.mass = 1, .stiffness = -1}).key() == before);
  other.computeForce(other.x, other.v, other.f);
  EXPECT_FALSE(other.matrix().withFactors({.mass = 1, .stiffness = -1}).key() == before);
}

TEST(SystemMatrix, ConstantStiffnessBesideAChangingOneIsAssembledOnce) {
  Simulation simulation(sceneFromText(scene(springs + net)));
  System& system = *simulation.systems()[0];
  for (int step = 0; step < 4; ++step) {
    system.x[4] += Vec3(0, 0.1, 0);
    system.computeForce(system.x, system.v, system.f);
    const Eigen::MatrixXd assembled =
        dense(system.matrix().withFactors({.mass = 1, .stiffness = -0.1, .rayleigh_stiffness = -0.2}).assemble());
    EXPECT_LT((assembled - byProducts(system) - heldPart(system, assembled)).norm(), 1e-12);
  }
  EXPECT_EQ(assembliesOf(*findComponent(simulation.root(), "/net")), 1);
  EXPECT_EQ(assembliesOf(*findComponent(simulation.root(), "/springs")), 4);
}

TEST(SystemMatrix, VelocityDerivativeIsInProductsAndMatrix) {
  Simulation simulation(sceneFromText(scene(net + "<TestDrag name='drag'/>")));
  System& system = *simulation.systems()[0];
  for (Index i = 0; i < system.independentRows(); ++i) system.v[i] = Vec3(std::sin(1 + i), std::cos(i), 0.2 * i);
  system.constraints().project(system.v);
  Vector p(system.independentRows()), product(system.independentRows()), v(system.independentRows()),
      plus(system.independentRows()), minus(system.independentRows());
  for (Index i = 0; i < system.independentRows(); ++i) p[i] = Vec3(1 - i, std::sin(i), 0.3);
  system.constraints().project(p);
  const double step = 1e-5;
  copy(system.v, v), axpy(step, p, v), system.computeForce(system.x, v, plus);
  copy(system.v, v), axpy(-step, p, v), system.computeForce(system.x, v, minus);
  axpy(-1, minus, plus), scale(1 / (2 * step), plus), system.constraints().project(plus);
  system.computeForce(system.x, system.v, system.f);
  system.matrix().withFactors({.damping = 1}).multiply(p, product);
  const double size = std::sqrt(dot(product, product));
  EXPECT_GT(size, 1);
  axpy(-1, product, plus);
  EXPECT_LT(std::sqrt(dot(plus, plus)), 1e-8 * size);
  const Eigen::MatrixXd assembled = dense(system.matrix().withFactors({.mass = 1, .damping = -0.5}).assemble());
  EXPECT_LT((assembled - byProducts(system) - heldPart(system, assembled)).norm(), 1e-12);
}

TEST(SystemMatrix, TurningConstraintIsFollowed) {
  Simulation simulation(sceneFromText(scene(net, "<TestTurningPlane name='turn' indices='4'/>")));
  System& system = *simulation.systems()[0];
  const MatrixKey before = system.matrix().key();
  simulation.step();
  EXPECT_FALSE(system.matrix().key() == before);
  const Vec3 n(std::cos(0.01), std::sin(0.01), 0);
  EXPECT_LT((system.constraints().projectors()[3].projector - (Mat3::Identity() - n * n.transpose())).norm(), 1e-14);
}

/// That of stiffnesses that never change is made once for all steps.
TEST(SystemMatrix, TellsWhatAnAssemblyCosts) {
  const auto cost = [](const std::string& fields) {
    Simulation simulation(sceneFromText(scene(fields)));
    return simulation.systems()[0]->matrix().assemblyCost();
  };
  EXPECT_LT(cost("<TestSprings/>"), 0) << "costs are not known";
  EXPECT_EQ(cost("<TestSprings productCost='155' assemblyCost='1000'/>"), 1000);
  EXPECT_EQ(cost("<TestSprings name='a' productCost='155' assemblyCost='1000'/>"
                 "<TestSprings name='b' productCost='1' assemblyCost='30'/>"), 1030);
  EXPECT_EQ(cost("<TestLinearNet productCost='155' assemblyCost='1000'/>"), 0);
}

TEST(SystemMatrix, ChoosesTheCheaperForm) {
  const auto prefers = [](const std::string& field, int products) {
    Simulation simulation(sceneFromText(scene(field)));
    return simulation.systems()[0]->matrix().prefersAssembled(products);
  };
  // 19 blocks at 0.9 ns are 17 ns per product; to keep a half of them takes 2.5 of these after each assembly
  EXPECT_FALSE(prefers("<TestSprings/>", 1000)) << "costs are not known";
  EXPECT_FALSE(prefers("<TestSprings productCost='15' assemblyCost='100'/>", 1000)) << "a block product costs more";
  EXPECT_TRUE(prefers("<TestSprings productCost='155' assemblyCost='1000'/>", 20));
  EXPECT_FALSE(prefers("<TestSprings productCost='155' assemblyCost='1000'/>", 7));
  EXPECT_TRUE(prefers("<TestLinearNet productCost='155' assemblyCost='1000'/>", 8)) << "assembled once for all steps";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
