// SPDX-License-Identifier: LGPL-2.1-or-later
// Error against run time: each problem by each way on each mesh, on one thread, then what that says. Times are the least
// processor time of some solutions from the rest shape.
#include "tools/bench/accuracy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "framework/algebra/parallel.h"
#include "framework/scene/output_file.h"
#include "tools/bench/accuracy_change.h"
#include "tools/bench/accuracy_problems.h"
#include "tools/bench/body.h"
#include "tools/bench/vibration.h"

namespace stroma::bench {
namespace {

constexpr double long_enough = 500;  ///< ms: noise matters no more
constexpr double wanted[] = {0.03, 0.01};

struct Outcome {
  const Way* way = nullptr;
  int cells = 0;
  double value = 0, error = 0;  ///< a share of the reference
  double milliseconds = 0;      ///< least processor time of a solution from the rest shape
  int newton_iterations = 0;
  Index nodes = 0;
  std::string trouble{};  ///< why it did not converge

  bool isWithin(double share) const { return trouble.empty() && std::abs(error) <= share; }
};

/// "column/20,40": a problem, and sizes of it.
struct Choice {
  std::string problem;
  std::vector<int> sizes;
  bool has(const std::string& name) const { return (problem.empty() && sizes.empty()) || name == problem; }
};

Choice choiceOf(const std::string& text) {
  Choice choice;
  std::istringstream words(text);
  std::getline(words, choice.problem, '/');
  for (std::string word; std::getline(words, word, ',');) {
    std::size_t end = 0;
    try {
      choice.sizes.push_back(std::stoi(word, &end));
    } catch (const std::logic_error&) {
    }
    if (end == 0 || end != word.size())
      throw std::invalid_argument(fmt::format("--accuracy={}: '{}' is no size: expected a number, as in column/40", text, word));
  }
  return choice;
}

/// Throws std::invalid_argument where a size is none of `all`.
void checkSizes(const Choice& choice, std::vector<int> all) {
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const std::string expected = all == std::vector{0} ? "no size, because it has one mesh" : fmt::format("{}", fmt::join(all, ", "));
  for (const int size : choice.sizes)
    if (std::ranges::count(all, size) == 0)
      throw std::invalid_argument(fmt::format("--accuracy={}/{}: expected {}", choice.problem, size, expected));
}

Outcome solve(const Problem& problem, const Way& way, int cells, int repetitions) {
  std::vector<std::string> overrides = way.settings;
  for (std::string& setting : problem.mesh(cells)) overrides.push_back(std::move(setting));
  const auto simulation = loadSimulation(way.scene, overrides, way.parts);
  Outcome outcome{&way, cells};
  outcome.milliseconds = INFINITY;
  for (int r = 0; r < repetitions; ++r) {
    simulation->reset();
    outcome.newton_iterations = 0;
    const double start = threadMilliseconds();
    for (int step = 0; step < way.steps && outcome.trouble.empty(); ++step) {
      const StepReport report = simulation->step();
      outcome.newton_iterations += report.newton_iterations;
      if (report.diverged || !report.newton_converged || report.unsolved) outcome.trouble = report.reason;
    }
    outcome.milliseconds = std::min(outcome.milliseconds, threadMilliseconds() - start);
    if (!outcome.trouble.empty() || outcome.milliseconds > long_enough) break;
  }
  outcome.value = problem.measure(*simulation);
  outcome.error = problem.size > 0 ? outcome.value / problem.size : outcome.value / problem.reference - 1;
  outcome.nodes = simulation->states().at(0)->size();
  return outcome;
}

/// What the errors of a way on its two finest meshes tell beside their size, or nothing.
std::string trendOf(const Problem& problem, const std::vector<Outcome>& all, const Way& way) {
  const Outcome *coarse = nullptr, *fine = nullptr;
  for (const Outcome& outcome : all)
    if (outcome.way == &way && outcome.trouble.empty()) coarse = fine, fine = &outcome;
  if (!coarse) return {};
  constexpr double exact = 1e-7;  // what tolerances of solvers leave
  if (std::abs(coarse->error) < exact && std::abs(fine->error) < exact) return "it is exact on every mesh";
  if (std::abs(fine->error) < 2 * problem.uncertainty)
    return fmt::format("with {} cells it is as near to the reference as that is known", fine->cells);
  if (coarse->error * fine->error < 0)
    return fmt::format("its error changes its sign between {} and {} cells, and is small there by cancellation",
                       coarse->cells, fine->cells);
  const double order = std::log(coarse->error / fine->error) / std::log(double(fine->cells) / coarse->cells);
  if (order < 0.5)
    return fmt::format("its error hardly falls: {:.2g} % with {} cells, {:.2g} % with {}", 100 * std::abs(coarse->error),
                       coarse->cells, 100 * std::abs(fine->error), fine->cells);
  return fmt::format("its error falls by the power {:.1f} of the spacing, to {:.2g} % with {} cells", order,
                     100 * std::abs(fine->error), fine->cells);
}

/// What a person would conclude from the table; each sentence follows from its numbers.
void conclude(const Problem& problem, const std::vector<Outcome>& all) {
  for (const double share : wanted) {
    std::vector<const Outcome*> good;
    for (const Way& way : problem.ways) {
      // the quickest mesh from which on the way stays within: a lucky coarse one does not count
      const Outcome* first = nullptr;
      for (const Outcome& outcome : all)
        if (outcome.way == &way) first = !outcome.isWithin(share) ? nullptr : first ? first : &outcome;
      if (first) good.push_back(first);
    }
    std::sort(good.begin(), good.end(), [](const Outcome* a, const Outcome* b) { return a->milliseconds < b->milliseconds; });
    if (good.empty()) {
      fmt::print("- No way stays within {:.0f} % on these meshes.\n", 100 * share);
      continue;
    }
    std::string next;
    if (good.size() > 1) next = fmt::format("; next {} ({:.3g} ms)", good[1]->way->name, good[1]->milliseconds);
    const std::string mesh = good[0]->cells > 0 ? fmt::format(" with {} cells across", good[0]->cells) : "";
    fmt::print("- Within {:.0f} %: {}{} takes {:.3g} ms{}.\n", 100 * share, good[0]->way->name, mesh, good[0]->milliseconds,
               next);
  }
  for (const Way& way : problem.ways)
    if (const std::string sentence = trendOf(problem, all, way); !sentence.empty())
      fmt::print("- {}: {}.\n", way.name, sentence);
}

void compare(const Problem& problem, const Choice& choice, int repetitions, std::string& csv) {
  const std::string reference = problem.size > 0 ? "distance from" : fmt::format("reference {:.6g} by", problem.reference);
  fmt::print("\n{}, {}\n{} {}{}\n\n", problem.name, problem.quantity, reference, problem.source,
             problem.uncertainty > 0 ? fmt::format(", known to {:.2g} %", 100 * problem.uncertainty) : "");
  fmt::print("{:<30} {:>6} {:>8} {:>12} {:>10} {:>8} {:>8}\n", "way", "cells", "nodes", "value", "error %", "ms", "Newton");
  std::vector<Outcome> all;
  for (const Way& way : problem.ways)
    for (const int cells : way.sizes) {
      if (!isAsked(choice.sizes, cells)) continue;
      all.push_back(solve(problem, way, cells, repetitions));
      const Outcome& outcome = all.back();
      fmt::print("{:<30} {:>6} {:>8} {:>12.5g} {:>10.2f} {:>8.3g} {:>8} {}\n", way.name, cells, outcome.nodes,
                 outcome.value, 100 * outcome.error, outcome.milliseconds, outcome.newton_iterations, outcome.trouble);
      std::fflush(stdout);
      csv += fmt::format("{},\"{}\",{},{},{:.8g},{:.8g},{:.6g},{:.5g},{},{}\n", problem.name, way.name, cells,
                         outcome.nodes, outcome.value, problem.reference, outcome.error, outcome.milliseconds,
                         outcome.newton_iterations, outcome.trouble.empty() ? 1 : 0);
    }
  fmt::print("\n");
  conclude(problem, all);
}

}  // namespace

double threadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

bool isAsked(const std::vector<int>& sizes, int size) { return sizes.empty() || std::ranges::count(sizes, size) > 0; }

void compareAccuracy(const AccuracyRequest& request) {
  setThreads(1);
  const Choice choice = choiceOf(request.problem);
  std::vector<Problem> problems = staticProblems(request.beads);
  std::string names;
  for (const Problem& problem : problems) names += problem.name + ", ";
  std::erase_if(problems, [&](const Problem& problem) { return !choice.has(problem.name); });
  if (problems.empty() && !choice.has(vibration))
    throw std::invalid_argument(
        fmt::format("--accuracy={}: expected {}{}, or nothing for all", request.problem, names, vibration));
  std::vector<int> sizes;
  if (choice.has(vibration)) sizes = vibrationSizes();
  for (const Problem& problem : problems)
    for (const Way& way : problem.ways) sizes.insert(sizes.end(), way.sizes.begin(), way.sizes.end());
  if (problems.empty() || problems.front().left_out.empty()) checkSizes(choice, std::move(sizes));
  std::string csv =
      "problem,way,cells_or_steps,nodes,value,reference,relative_error,milliseconds,newton_iterations,converged\n";
  for (const Problem& problem : problems)
    if (problem.left_out.empty())
      compare(problem, choice, request.repetitions, csv);
    else
      fmt::print("\n{}, {}: left out, {}\n", problem.name, problem.quantity, problem.left_out);
  if (choice.has(vibration)) compareVibration(choice.sizes, csv);
  const std::string changes = request.stored_file.empty() ? "" : changesSince(request.stored_file, csv);
  if (!request.csv_file.empty()) writeWholeFile(request.csv_file, csv);
  if (!changes.empty()) fmt::print("\nsince {}, {}", request.stored_file, changes);
}

}  // namespace stroma::bench
