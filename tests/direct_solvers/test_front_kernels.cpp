// SPDX-License-Identifier: LGPL-2.1-or-later
// The loops on fronts of every instruction set that this machine has, against the same operations written down in double
// precision; of all sizes around those of registers and blocks.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "components/direct_solvers/front_kernels.h"
#include "framework/algebra/memory.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::vector<const FrontKernels*> kernelsHere() {
  std::vector<const FrontKernels*> list{&front_kernels_v2};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) list.push_back(&front_kernels_v3);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) list.push_back(&front_kernels_v4);
  return list;
}

int padded(int rows) { return (rows + front_rows - 1) / front_rows * front_rows; }

/// Columns as the loops have them: zero beyond the last row, and room behind the last one.
struct Columns {
  int rows, columns, ld;
  Array<float> numbers;
  Columns(int rows_, int columns_) : rows(rows_), columns(columns_), ld(padded(rows_)) {
    numbers.assign(std::size_t(ld) * std::size_t(columns) + 64, 0.0f);
  }
  Columns(const Eigen::MatrixXd& from) : Columns(int(from.rows()), int(from.cols())) {
    for (int c = 0; c < columns; ++c)
      for (int r = 0; r < rows; ++r) at(r, c) = float(from(r, c));
  }
  float& at(int r, int c) { return numbers[std::size_t(c) * std::size_t(ld) + std::size_t(r)]; }
  float* data() { return numbers.data(); }
  Eigen::MatrixXd dense() {
    Eigen::MatrixXd all(rows, columns);
    for (int c = 0; c < columns; ++c)
      for (int r = 0; r < rows; ++r) all(r, c) = double(at(r, c));
    return all;
  }
  Eigen::MatrixXd lower() { return dense().triangularView<Eigen::Lower>(); }
};

Eigen::MatrixXd randomNumbers(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  Eigen::MatrixXd matrix(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r) matrix(r, c) = number(generator);
  return matrix;
}

double errorOf(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / std::max(1.0, b.norm()); }
constexpr double round_off = 2e-6;

const int sizes[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 24, 31, 33, 47, 48, 49, 63, 65, 95, 96};

TEST(FrontKernels, FactorAndSolve) {
  for (const FrontKernels* kernels : kernelsHere())
    for (const int n : sizes) {
      SCOPED_TRACE(n);
      const Eigen::MatrixXd root = randomNumbers(n, n, 1), a = root * root.transpose() + n * Eigen::MatrixXd::Identity(n, n);
      Columns l(a);
      ASSERT_EQ(kernels->factor(l.data(), l.ld, n), -1);
      Eigen::MatrixXd triangle = l.lower();
      triangle.diagonal() = triangle.diagonal().cwiseInverse().eval();
      EXPECT_LT(errorOf(triangle * triangle.transpose(), a), round_off);
      for (const int rows : {1, 13, 48, 70}) {
        const Eigen::MatrixXd b = randomNumbers(rows, n, 2);
        Columns x(b);
        kernels->solveRows(l.data(), l.ld, n, x.data(), x.ld, rows);
        EXPECT_LT(errorOf(x.dense() * triangle.transpose(), b), round_off) << rows;
      }
      const Eigen::MatrixXd b = randomNumbers(n, 1, 3);
      Columns x(b);
      kernels->solveForward(l.data(), l.ld, n, x.data());
      EXPECT_LT(errorOf(triangle * x.dense(), b), round_off);
      kernels->solveBackward(l.data(), l.ld, n, x.data());
      EXPECT_LT(errorOf(a * x.dense(), b), round_off);
      Columns bad(a - 2 * a(n - 1, n - 1) * Eigen::VectorXd::Unit(n, n - 1) * Eigen::RowVectorXd::Unit(n, n - 1));
      EXPECT_EQ(kernels->factor(bad.data(), bad.ld, n), n - 1) << "the last pivot is negative";
    }
}

TEST(FrontKernels, SubtractProducts) {
  for (const FrontKernels* kernels : kernelsHere())
    for (const int rows : sizes)
      for (const int depth : {1, 5, 40}) {
        SCOPED_TRACE(testing::Message() << rows << " " << depth);
        const Eigen::MatrixXd a = randomNumbers(rows, depth, 1), c = randomNumbers(rows, rows, 2);
        for (const bool is_fresh : {false, true}) {
          const Eigen::MatrixXd before = is_fresh ? Eigen::MatrixXd::Zero(rows, rows) : c;
          Columns left(a), lower(c);
          kernels->subtractLower(left.data(), left.ld, rows, depth, is_fresh, lower.data(), lower.ld);
          EXPECT_LT(errorOf(lower.lower(), (before - a * a.transpose()).triangularView<Eigen::Lower>()), round_off);
          const int columns = std::min(rows, 11);
          Columns right(randomNumbers(columns, depth, 3)), whole(c.leftCols(columns));
          whole.numbers[std::size_t(whole.ld) * std::size_t(columns)] = 42;  // what is behind stays
          kernels->subtract(left.data(), left.ld, rows, right.data(), right.ld, columns, depth, is_fresh, whole.data(), whole.ld);
          EXPECT_LT(errorOf(whole.dense(), before.leftCols(columns) - a * right.dense().transpose()), round_off);
          EXPECT_EQ(whole.numbers[std::size_t(whole.ld) * std::size_t(columns)], 42);
        }
        Columns left(a), x(randomNumbers(depth, 1, 4)), y(randomNumbers(rows, 1, 5));
        const Eigen::MatrixXd y0 = y.dense(), x0 = x.dense();
        kernels->subtractProduct(left.data(), left.ld, rows, depth, x.data(), y.data());
        EXPECT_LT(errorOf(y.dense(), y0 - a * x0), round_off);
        kernels->subtractTransposed(left.data(), left.ld, rows, depth, y.data(), x.data());
        EXPECT_LT(errorOf(x.dense(), x0 - a.transpose() * y.dense()), round_off);
      }
}

/// A child of 40 rows, every second or two of three of which the parent has, by ranges of the parent's columns.
TEST(FrontKernels, AddAnUpdateToItsParent) {
  constexpr int columns = 21, below = 45, all = columns + below, rows = 40;
  std::vector<FrontRun> runs;
  std::vector<int> place;
  for (int to = 0, from = 0; from < rows; ++to) {
    if (to % 5 == 2) continue;  // a row that the child has not
    place.push_back(to);
    if (!runs.empty() && runs.back().to + runs.back().count == to && to != columns)
      ++runs.back().count;
    else
      runs.push_back({from, to, 1});
    ++from;
  }
  for (const FrontKernels* kernels : kernelsHere()) {
    Columns update(randomNumbers(rows, rows, 1)), triangle(columns, columns), rest(below, columns), own(below, below);
    const FrontParts child{3, rows, 16, update.ld, nullptr, nullptr, update.data()};
    const FrontParts parent{columns, below, triangle.ld, rest.ld, triangle.data(), rest.data(), own.data()};
    for (const auto& [first, last] : {std::pair{0, 10}, {10, columns}, {columns, 30}, {30, all}})
      kernels->add(child, runs.data(), runs.data() + runs.size(), parent, first, last);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(all, all), front = expected;
    for (int c = 0; c < rows; ++c)
      for (int r = c; r < rows; ++r) expected(place[std::size_t(r)], place[std::size_t(c)]) = double(update.at(r, c));
    front.topLeftCorner(columns, columns) = triangle.dense();
    front.bottomLeftCorner(below, columns) = rest.dense();
    front.bottomRightCorner(below, below) = own.dense();
    EXPECT_EQ(front, expected);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
