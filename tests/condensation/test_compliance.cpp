// SPDX-License-Identifier: LGPL-2.1-or-later
// The dense products by themselves, against Eigen.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>

#include "components/condensation/compliance.h"
#include "framework/algebra/memory.h"

using namespace stroma;

namespace {

Eigen::MatrixXd symmetric(Index n) {
  std::srand(7);
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(n, n);
  return a + a.transpose();
}

}  // namespace

TEST(Compliance, SelectedColumnsEqualTheFullProduct) {
  for (const Index nodes : {1, 5, 17, 100}) {
    const Eigen::MatrixXd a = symmetric(3 * nodes);
    Array<double> data(ColumnPanels<double>::size(std::size_t(nodes)), 0.0);
    const ColumnPanels<double> panels{data.data(), std::size_t(nodes)};
    for (Index i = 0; i < 3 * nodes; ++i)
      for (Index j = 0; j < 3 * nodes; ++j) data[panels.offset(std::size_t(i), std::size_t(j))] = a(i, j);
    for (const Index count : {1, 3, 10, 100}) {
      if (count > nodes) continue;
      Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * nodes);
      std::vector<Index> loaded;
      std::vector<std::array<double, 3>> forces;
      for (Index k = 0; k < count; ++k) {
        const Index node = (k * 7 + 3) % nodes;
        if (f.segment<3>(3 * node).any()) continue;
        f.segment<3>(3 * node) << 0.3 * k + 1, -0.7, 0.2 * k;
        loaded.push_back(node);
        forces.push_back({f[3 * node], f[3 * node + 1], f[3 * node + 2]});
      }
      Array<double> u(chunksOf(3 * std::size_t(nodes)) * lanes, 0.0);
      panels.addColumns(loaded.data(), forces.data(), loaded.size(), u.data());
      const Eigen::VectorXd expected = a * f;
      EXPECT_LT((Eigen::Map<Eigen::VectorXd>(u.data(), 3 * nodes) - expected).norm(), 1e-14 * a.norm() * f.norm());
      EXPECT_GT(expected.norm(), 0.1);
    }
  }
}

TEST(Compliance, HalfOfTheMatrixGivesTheWholeProduct) {
  for (const Index n : {3, 8, 51, 333, 1200}) {
    const Eigen::MatrixXd a = symmetric(n);
    Array<double> data(SymmetricPanels<double>::size(std::size_t(n)), 0.0);
    const SymmetricPanels<double> panels{data.data(), std::size_t(n)};
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) {
        const bool diagonal = i / 8 == j / 8;
        if (i / 8 >= j / 8) data[panels.offset(std::size_t(i), std::size_t(j))] = diagonal ? a(i, j) / 2 : a(i, j);
      }
    const std::size_t length = chunksOf(std::size_t(n)) * lanes;
    Array<double> r(length, 0.0), y(length, 1.0), again(length, 1.0), work(panels.pieces() * length);
    for (Index i = 0; i < n; ++i) r[i] = std::sin(i + 1.0);
    panels.multiply(r.data(), y.data(), work.data());
    const Eigen::VectorXd expected = a * Eigen::Map<Eigen::VectorXd>(r.data(), n);
    EXPECT_LT((Eigen::Map<Eigen::VectorXd>(y.data(), n) - expected).norm(), 1e-14 * a.norm() * expected.norm());
    setThreads(2);
    panels.multiply(r.data(), again.data(), work.data());
    setThreads(1);
    EXPECT_EQ(std::memcmp(y.data(), again.data(), length * sizeof(double)), 0);
  }
}
