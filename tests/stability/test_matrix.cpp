// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>

#include "tests/stability/matrix.h"

namespace stroma::test::matrix {

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

namespace {

/// Cells that end astray with a word, by patterns for the whole name of row, integrator and condition. No cell ends in
/// silence.
struct Known {
  const char *row, *integrator, *condition, *reason;
};

constexpr const char *shapes = "inverted|flat|line|point|random", *any = ".*";

const std::vector<Known>& known() {
  static const std::vector<Known> all{
      {"(tetrahedra|boxes|hexahedra|quadratic) (large|polar|svd).*|.*Corotational.*|HexahedralFEM.*|TetrahedralFEM.*",
       any, any,
       "a defect that the run's warning names: forces in frames of elements have no potential, so that crushed and "
       "inverted elements, above all with gradients of the present shape, can feed a motion that does not end"},
      {".*StableNeoHookean.*", any, shapes,
       "the same, but that the run's warning says it: elements that balance upside down open slowly or not at all"},
      {".* green", any, shapes,
       "a crushed element of St. Venant and Kirchhoff's law has no force left, and opens again slowly or not at all"},
      {".*viscous.*", any, "inverted|flat|line|point|random|nu=0.4999",
       "a defect that the run's warning names: viscous stresses of the second Piola-Kirchhoff kind grow without bound "
       "in flat elements, and push when these open"},
      {"(Tetra|Hexa)hedronPorousForceField.*", any, "E=1 dt=.*",
       "the fluid keeps its modulus while the tissue loses its own: the semi-implicit coupling is unstable where the "
       "fluid is much stiffer"},
      {"(Tetra|Hexa)hedronPorousForceField.*", "BDF 2.*", any,
       "the load of the scene warns of it: semi-implicit fluid acts a step late, which this rule hardly damps"},
      {"(ShapeMemoryForceField|Phymul) reaction=(false|upright).*", any, shapes,
       "without the reaction the forces have no potential, and turned neighbourhoods feed what they push"},
      {any, "Euler|BDF [12]|static", any,
       "one linear solve per step follows its tangent too far; Newton's method does not"}};
  return all;
}

/// Why a cell is let pass, or nothing.
const char* reasonOf(const Row& row, const IntegratorChoice& integrator, const Condition& condition,
                     const Outcome& outcome) {
  const auto fits = [](const std::string& text, const char* pattern) {
    return std::regex_match(text, compiled(pattern));
  };
  for (const Known& cell : known())
    if (outcome.ending == Ending::astray && fits(row.name, cell.row) && fits(integrator.name, cell.integrator) &&
        fits(condition.name, cell.condition))
      return cell.reason;
  return nullptr;
}

/// FNV-1a: the same sample with every standard library.
std::size_t hashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619u;
  return hash;
}

/// Without STROMA_WHOLE_MATRIX: every condition of a row under one integrator, all integrators in turn; another name
/// of a component has every fourth of them, and a large body every second one: the methods are those of smaller ones.
bool isInSample(const Row& row, std::size_t integrator, std::size_t condition) {
  const std::size_t hash = hashOf(row.name), start = hash + condition;
  return integrator == start % integrators().size() && (!row.is_alias || start % 4 == 0) &&
         (!row.is_large || (hashOf(fmt::format("{} {}", row.name, condition)) >> 7) % 2 == 0);
}

class Matrix : public testing::TestWithParam<Row> {};

TEST_P(Matrix, EveryCellRecoversOrStopsWithASentence) {
  const Row& row = GetParam();
  const bool all = std::getenv("STROMA_WHOLE_MATRIX") != nullptr;
  for (std::size_t c = 0; c < conditions().size(); ++c)
    for (std::size_t i = 0; i < integrators().size(); ++i) {
      const Condition& condition = conditions()[c];
      if ((!all && !isInSample(row, i, c)) || (condition.poisson != 0.4 && !row.has_poisson)) continue;
      const int most_steps = all ? 150'000 : 2500;
      const Outcome outcome = run(row, integrators()[i], condition, most_steps);
      // what no damping holds back may go astray with a word; what an integrator damps may not
      const bool silent = outcome.ending >= Ending::elsewhere ||
                          (outcome.ending == Ending::astray && (integrators()[i].damps || integrators()[i].is_static));
      const char* reason = silent ? reasonOf(row, integrators()[i], condition, outcome) : "";
      fmt::print("cell|{}|{}|{}|{}|{}|{:.2g}|{}|{}|{}\n", row.name, integrators()[i].name, condition.name,
                 wordOf(outcome.ending), outcome.steps, outcome.distance, outcome.inverted, reason ? reason : "",
                 outcome.text);
      EXPECT_TRUE(reason) << fmt::format("{}, {}, {}: {}, {:.2g} sizes away. {}", row.name, integrators()[i].name,
                                         condition.name, wordOf(outcome.ending), outcome.distance, outcome.text);
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
