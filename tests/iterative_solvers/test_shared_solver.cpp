// SPDX-License-Identifier: LGPL-2.1-or-later
// Two integrators that link one linear solver: each body moves as with a solver of its own, bit for bit. The solvers,
// their choices and the preconditioners are those of the factory, so that a new one is tested without a word here.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "framework/algebra/direct_solver.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace {

constexpr int steps = 6;

/// Elements in the node that holds the solver, which is named "solver"; and what stands for it in the bodies' nodes when
/// both have a solver of their own but share something else.
struct Case {
  std::string name, elements;
  std::string own = {};  ///< not empty: this stands in each body's node, and `elements` in one node or in both
};

/// A type's element with one attribute more.
std::string element(const std::string& type, const std::string& attributes) {
  return fmt::format("<{} {}/>", type, attributes);
}

struct Offered {
  std::vector<std::string> solvers, direct, preconditioners;
};
const Offered& offered() {
  static const Offered all = [] {
    modules().openAll();
    Offered found;
    for (const ComponentEntry* entry : factory().entries()) {
      const auto component = factory().make(entry->type);
      if (dynamic_cast<LinearSolver*>(component.get())) found.solvers.push_back(entry->type);
      if (dynamic_cast<DirectSolver*>(component.get())) found.direct.push_back(entry->type);
      if (component->roleText() == "preconditioner") found.preconditioners.push_back(entry->type);
    }
    return found;
  }();
  return all;
}

/// A word of an attribute that gives other results in each run has no bits to compare.
bool isByTheClock(const std::string& word) { return word == "clock"; }

/// "attribute='word'" for every word of every choice, and every switch turned.
std::vector<std::string> settingsOf(const std::string& type) {
  std::vector<std::string> settings;
  const auto component = factory().make(type);
  for (const Data& data : component->data().all()) {
    std::vector<std::string> words;
    if (const auto* choice = std::get_if<ChoiceRef>(&data.pointer())) words = choice->words;
    if (const auto* turned = std::get_if<bool*>(&data.pointer())) words = {**turned ? "false" : "true"};
    if (data.link()) words = data.link()->words;
    for (const std::string& word : words)
      if (!isByTheClock(word)) settings.push_back(fmt::format("{}='{}'", data.name(), word));
    if (data.name() == "template") settings.push_back("template='CompressedRowSparseMatrixMat3x3'");
    // its end is by the preconditioner's norm, which may not change
    if (data.name() == "endsBySquares") settings.back() += " preconditioner='block_jacobi'";
  }
  return settings;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  const std::string factors = "<SparseLDLSolver name='factors'/>";
  for (const std::string& type : offered().solvers) {
    all.push_back({type, element(type, "name='solver'")});
    for (const std::string& setting : settingsOf(type))
      all.push_back({type + " " + setting, element(type, "name='solver' " + setting) +
                                               (setting.find("warped") != std::string::npos ? factors : "")});
  }
  for (const std::string& type : offered().preconditioners) {
    std::vector<std::string> settings = settingsOf(type);
    settings.emplace_back();
    const bool takes_factors = factory().make(type)->data().find("linearSolver");
    for (const std::string& setting : settings) {
      const std::string shared = element(type, "name='b' " + setting) + (takes_factors ? factors : "");
      all.push_back(
          {fmt::format("{} {}", type, setting), "<PCGLinearSolver name='solver' preconditioner='@b'/>" + shared});
      all.push_back({fmt::format("{} {} of two solvers", type, setting), shared,
                     "<PCGLinearSolver name='solver' preconditioner='@{}b'/>"});
    }
  }
  for (const std::string& type : offered().direct)
    all.push_back({"turned factors of " + type,
                   "<PCGLinearSolver name='solver' preconditioner='@b'/>"
                   "<WarpPreconditioner name='b' linearSolver='@factors'/>" +
                       element(type, "name='factors'")});
  return all;
}

/// A beam that bends: `method` small has one matrix for ever, polar another one in each step.
std::string body(const std::string& grid, const std::string& method, double young, const std::string& where,
                 const std::string& elements) {
  return fmt::format(
      "<Node name='{}'><EulerImplicitSolver linearSolver='@{}solver'/>{}<RegularGridTopology name='grid' {}/>"
      "<MechanicalObject/><DiagonalMass massDensity='1000'/><HexahedronFEMForceField method='{}' youngModulus='{}' "
      "poissonRatio='0.3'/><BoxROI name='held' box='-1 -1 -1 0.001 1 1'/>"
      "<FixedProjectiveConstraint indices='@held.indices'/></Node>",
      method + std::to_string(int(young)), where, elements, grid, method, young);
}

std::string scene(const Case& tested, bool is_shared, bool equal_grids) {
  const std::string where = is_shared && tested.own.empty() ? "../" : "";
  std::string own = is_shared ? "" : tested.elements;
  if (!tested.own.empty()) own += fmt::format(fmt::runtime(tested.own), is_shared ? "../" : "");
  const std::string first = "n='4 2 2' min='0 0 0' max='0.3 0.1 0.1'";
  // with equal grids nothing but their numbers tells the matrices apart, and both change as often
  const std::string bodies = equal_grids
                                 ? body(first, "polar", 2e4, where, own) +
                                       body("n='4 2 2' min='0 0 0' max='0.2 0.1 0.05'", "polar", 1e5, where, own)
                                 : body(first, "polar", 2e4, where, own) +
                                       body("n='3 3 2' min='0 0 0' max='0.2 0.1 0.05'", "small", 1e5, where, own);
  return fmt::format("<Node name='root' dt='0.02' gravity='0 0 -9.81'>{}{}</Node>", is_shared ? tested.elements : "",
                     bodies);
}

bool sameBits(const Vector& a, const Vector& b) {
  return a.count() == b.count() && std::memcmp(a.rows().data, b.rows().data, a.rows().doubles() * sizeof(double)) == 0;
}

class SharedSolver : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Grids, SharedSolver, testing::Bool(),
                         [](const auto& tested) { return tested.param ? "equal" : "different"; });

TEST_P(SharedSolver, TwoBodiesMoveAsWithASolverEach) {
  ASSERT_GT(offered().solvers.size(), 10u);
  ASSERT_GT(offered().direct.size(), 6u);
  ASSERT_GT(offered().preconditioners.size(), 4u);
  for (const Case& tested : cases()) {
    SCOPED_TRACE(tested.name);
    Simulation shared = simulationFromText(scene(tested, true, GetParam()));
    Simulation apart = simulationFromText(scene(tested, false, GetParam()));
    ASSERT_EQ(shared.systems().size(), 2u);
    ASSERT_EQ(apart.systems().size(), 2u);
    for (int step = 1; step <= steps; ++step) {
      ASSERT_FALSE(shared.step().diverged);
      ASSERT_FALSE(apart.step().diverged);
      for (std::size_t i : {0u, 1u}) {
        const System &a = *shared.systems()[i], &b = *apart.systems()[i];
        ASSERT_TRUE(sameBits(a.x, b.x) && sameBits(a.v, b.v)) << "body " << i << " in step " << step;
      }
    }
    const System& bent = *shared.systems()[0];
    EXPECT_LT(bent.x[3].z(), -1e-4) << "the beam has not moved";
  }
}

TEST(SharedSolver, EachHasOnlyTheLinearSystemsOfItsOwnMatrix) {
  // one matrix for ever: factored once for each body, however often they take turns
  const std::string grid = "n='4 2 2' min='0 0 0' max='0.3 0.1 0.1'";
  Simulation simulation =
      simulationFromText("<Node name='root' dt='0.02'><SparseLDLSolver name='solver'/>" +
                         body(grid, "small", 2e4, "../", "") + body(grid, "small", 1e5, "../", "") + "</Node>");
  for (int step = 1; step <= steps; ++step) simulation.step();
  std::vector<LinearSolver*> solvers;
  simulation.root().collect(solvers);
  EXPECT_EQ(*std::get<int*>(solvers.at(0)->data().find("factorisations")->pointer()), 2);
}

}  // namespace
}  // namespace stroma::test
