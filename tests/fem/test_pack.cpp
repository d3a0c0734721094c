// SPDX-License-Identifier: LGPL-2.1-or-later
// Packs as kernels use them, compiled once for each instruction set: rows to packs and back, roots, lanes apart.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <random>

#include "framework/fem/rotation.h"

namespace stroma::test {
namespace {

#if defined(__AVX512F__)
constexpr const char* level = "x86-64-v4";
#elif defined(__AVX2__)
constexpr const char* level = "x86-64-v3";
#else
constexpr const char* level = "";
#endif
bool machineHasLevel() {
  __builtin_cpu_init();
#if defined(__AVX512F__)
  return __builtin_cpu_supports("x86-64-v4");
#elif defined(__AVX2__)
  return __builtin_cpu_supports("x86-64-v3");
#else
  return true;
#endif
}
/// Skips every test of this executable on a machine that cannot run it.
struct OnThisMachine : ::testing::Environment {
  void SetUp() override {
    if (!machineHasLevel()) GTEST_SKIP() << "this machine has no " << level;
  }
};
[[maybe_unused]] const auto* const environment = ::testing::AddGlobalTestEnvironment(new OnThisMachine);

using Lanes = std::array<double, pack_lanes>;
Lanes lanesOf(Pack p) {
  alignas(64) Lanes out;
  p.store_aligned(out.data());
  return out;
}
Pack packOf(const Lanes& values) {
  alignas(64) Lanes in = values;
  return Pack::load_aligned(in.data());
}

constexpr Index rows = 40;
struct alignas(64) RowsOf {
  std::array<double, std::size_t(rows) * row_doubles> data{};
  RowsOf() {
    for (Index r = 0; r < rows; ++r)
      for (Index k = 0; k < 3; ++k) data[std::size_t(r * row_doubles + k)] = 100. * r + k;
  }
};

TEST(Pack, GatheringTakesEachLanesRow) {
  std::mt19937 random(1);
  std::uniform_int_distribution<Index> row(0, rows - 1);
  const RowsOf from;
  for (int repeat = 0; repeat < 200; ++repeat) {
    std::array<Index, pack_lanes> at{};
    for (Index& offset : at) offset = row(random) * row_doubles;
    const V3<Pack> got = gatherRows(from.data.data(), at.data());
    const Lanes x = lanesOf(got.x), y = lanesOf(got.y), z = lanesOf(got.z);
    for (std::size_t l = 0; l < pack_lanes; ++l) {
      const double* expected = from.data.data() + at[l];
      EXPECT_EQ(x[l], expected[0]);
      EXPECT_EQ(y[l], expected[1]);
      EXPECT_EQ(z[l], expected[2]);
    }
  }
}

TEST(Pack, AddingReachesRowsThatLanesShare) {
  std::mt19937 random(2);
  std::uniform_int_distribution<Index> row(0, 3);  // few rows: lanes meet
  std::uniform_real_distribution<double> number(-1, 1);
  for (int repeat = 0; repeat < 200; ++repeat) {
    RowsOf to, expected;
    std::array<Index, pack_lanes> at{};
    Lanes x{}, y{}, z{};
    for (std::size_t l = 0; l < pack_lanes; ++l) {
      at[l] = row(random) * row_doubles;
      x[l] = number(random), y[l] = number(random), z[l] = number(random);
      double* sum = expected.data.data() + at[l];  // in the order of the lanes
      sum[0] += x[l], sum[1] += y[l], sum[2] += z[l];
    }
    addToRows(V3<Pack>{packOf(x), packOf(y), packOf(z)}, at.data(), to.data.data());
    EXPECT_EQ(to.data, expected.data);
  }
}

TEST(Pack, BlocksGetTheNumbersOfTheFirstLanesAndThoseBesideThemNone) {
  std::mt19937 random(4);
  std::uniform_int_distribution<Index> block(0, 4);  // few blocks: lanes meet
  std::uniform_int_distribution<int> number(-99, 99);
  for (int lanes = 0; lanes <= pack_lanes; ++lanes)
    for (int repeat = 0; repeat < 50; ++repeat) {
      std::array<double, 45> to{}, expected{};
      std::array<Index, pack_lanes> at{};
      for (Index& slot : at) slot = block(random);
      std::array<Pack, 9> k;
      for (std::size_t e = 0; e < 9; ++e) {
        Lanes values{};
        for (std::size_t l = 0; l < pack_lanes; ++l) {
          values[l] = number(random);
          if (int(l) < lanes) expected[std::size_t(at[l]) * 9 + e] += 0.5 * values[l];
        }
        k[e] = packOf(values);
      }
      addToBlocks(k.data(), Pack(0.5), at.data(), lanes, to.data());
      EXPECT_EQ(to, expected) << lanes << " lanes";
    }
}

TEST(Pack, SettingRowsWritesEachLanesRowAndNoOther) {
  Lanes x{}, y{}, z{};
  for (std::size_t l = 0; l < pack_lanes; ++l) x[l] = 1. + double(l), y[l] = 20. + double(l), z[l] = 300. + double(l);
  RowsOf to, expected;
  for (std::size_t l = 0; l < pack_lanes; ++l) {
    double* row = expected.data.data() + l * row_doubles;
    row[0] = x[l], row[1] = y[l], row[2] = z[l];
  }
  setRows(V3<Pack>{packOf(x), packOf(y), packOf(z)}, to.data.data());
  EXPECT_EQ(to.data, expected.data);
}

TEST(Pack, RootsHoldTheirDigits) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-300, 300);
  const double unit = std::ldexp(1, -52);
  for (int repeat = 0; repeat < 2000; ++repeat) {
    Lanes a{};
    for (double& value : a) value = std::pow(10, exponent(random));
    const Lanes inverse = lanesOf(reciprocalSqrt(packOf(a))), fourth = lanesOf(roughFourthRoot(packOf(a)));
    for (std::size_t l = 0; l < pack_lanes; ++l) {
      EXPECT_NEAR(double(inverse[l] * std::sqrt((long double)a[l])), 1, 2 * unit) << a[l];
      EXPECT_NEAR(fourth[l] / std::pow(a[l], 0.25), 1, 2e-4) << a[l];
    }
  }
}

/// A lane with columns that are nearly parallel, zero or not numbers takes the long way alone: not a bit of the other
/// lanes changes.
TEST(Pack, QrLanesDoNotMeet) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  std::array<Lanes, 9> f{};
  for (Lanes& entry : f)
    for (double& value : entry) value = number(random);
  const auto frame = [&f] {
    const auto column = [&f](std::size_t k) { return V3<Pack>{packOf(f[k]), packOf(f[k + 1]), packOf(f[k + 2])}; };
    const M3<Pack> r = rotation::gramSchmidt(M3<Pack>{column(0), column(3), column(6)});
    return std::array<Lanes, 9>{lanesOf(r.c0.x), lanesOf(r.c0.y), lanesOf(r.c0.z), lanesOf(r.c1.x), lanesOf(r.c1.y),
                                lanesOf(r.c1.z), lanesOf(r.c2.x), lanesOf(r.c2.y), lanesOf(r.c2.z)};
  };
  for (std::size_t l = 0; l < pack_lanes; ++l) f[0][l] += 3, f[4][l] += 3;  // columns well apart
  const std::array<Lanes, 9> before = frame();
  for (const double slope : {1e-3, 1e-9, 0., std::nan("")}) {
    for (std::size_t k = 0; k < 3; ++k) f[k + 3][0] = f[k][0] * (slope > 0 ? 1 : slope);
    if (slope > 0) f[4][0] += slope;
    const std::array<Lanes, 9> after = frame();
    for (std::size_t k = 0; k < 9; ++k)
      for (std::size_t l = 1; l < pack_lanes; ++l)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(before[k][l]), std::bit_cast<std::uint64_t>(after[k][l]));
    for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(std::isnan(after[k][0]), std::isnan(slope) && k > 2);
  }
}

}  // namespace
}  // namespace stroma::test
