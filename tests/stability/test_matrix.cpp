// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/stability/matrix.h"

namespace stroma::test::matrix {

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

namespace {

class Matrix : public testing::TestWithParam<Row> {};

/// FNV-1a: the same sample with every standard library.
std::size_t hashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619u;
  return hash;
}

TEST_P(Matrix, EveryCellRecoversOrStopsWithASentence) {
  const Row& row = GetParam();
  const bool all = std::getenv("STROMA_WHOLE_MATRIX") != nullptr;
  const std::size_t row_index = hashOf(row.name);
  for (std::size_t c = 0; c < conditions().size(); ++c)
    for (std::size_t i = 0; i < integrators().size(); ++i) {
      if (!all && i != (row_index + c) % integrators().size()) continue;
      const Condition& condition = conditions()[c];
      if (condition.poisson != 0.4 && !row.has_poisson) continue;
      const Outcome outcome = run(row, integrators()[i], condition);
      fmt::print("cell|{}|{}|{}|{}|{}|{:.2g}|{}|{}\n", row.name, integrators()[i].name, condition.name,
                 wordOf(outcome.ending), outcome.steps, outcome.distance, outcome.inverted, outcome.text);
      EXPECT_NE(outcome.ending, Ending::broken) << outcome.text;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Matrix, testing::ValuesIn(rows()), [](const auto& tested) {
  std::string name = tested.param.name;
  for (char& letter : name)
    if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
  return name;
});

}  // namespace
}  // namespace stroma::test::matrix
