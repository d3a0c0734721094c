// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/solver_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "framework/algebra/direct_solver.h"
#include "framework/algebra/solver_choice.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"
#include "tools/plan/plan.h"

namespace stroma::command {
namespace {

constexpr double worth_saying = 1;  // seconds of solves
constexpr double far_away = 3;      // times the cost of the best; estimates of two ways differ by up to 2 from their times

/// Of a component, as written; empty: it is not.
std::string writtenValue(const Component& component, const char* name) {
  const Data* data = component.data().find(name);
  return data && data->isSet() ? data->print() : "";
}

/// The output `estimates` of the solver that chooses, in seconds.
struct Estimates {
  double iteration = 0;                     ///< of conjugate gradients with blocks of the diagonal
  double cycle = 0, application = 0;        ///< what multigrid and factors add to it
  double hierarchy = 0;                     ///< with the assembly, as factorisation
  double order = 0, factorisation = 0;      ///< of factors, the first once for a pattern
  double with_factors = 0;                  ///< a solve with another matrix
  double slowness = 1;                      ///< how many times as many iterations multigrid takes
  bool factors_fit = true;                  ///< into the memory
};

/// What the run has counted.
struct Counts {
  double solves = 1, iterations = 0, factorisations = 0, steps = 1;
  explicit Counts(const RunStatistics& run)
      : solves(double(std::max({1L, run.newton_iterations, long(run.step_ms.size())}))),
        iterations(double(run.linear_iterations)),
        factorisations(double(run.factorisations)),
        steps(std::max(1.0, double(run.step_ms.size()))) {}
};

struct Best {
  double seconds = 0;
  const char* way = "";
};
/// Of all solves. With `one_matrix` all are of the same.
Best bestOf(const Estimates& each, const Counts& made, bool one_matrix) {
  constexpr double to_tolerance = 15, loosely = 7;  // iterations; those of Newton's method are loose
  const double usual = made.solves > 2 * made.steps ? loosely : to_tolerance;
  const double multigrid = each.hierarchy + made.solves * usual * each.slowness * (each.iteration + each.cycle);
  const double first = each.order + each.factorisation + each.application + each.iteration;
  const double factors = first + (made.solves - 1) * (one_matrix ? each.application + each.iteration : each.with_factors);
  return each.factors_fit && factors < multigrid ? Best{factors, "factors"} : Best{multigrid, "multigrid"};
}

/// Nothing where there is no such solver, or no matrix.
std::optional<Estimates> estimatesOf(SystemMatrix& matrix) {
  try {
    const std::unique_ptr<Component> usual = makeUsual(Part::solver_that_chooses);
    usual->init();
    auto* const choosing = dynamic_cast<SolverChoice*>(usual.get());
    const Data* told = usual->data().find("estimates");
    const auto* list = told ? std::get_if<std::vector<double>*>(&told->pointer()) : nullptr;
    if (!choosing || !list) return {};
    choosing->choose(matrix);
    const std::vector<double>& s = **list;
    if (s.size() != 9) return {};
    return Estimates{s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8] != 0};
  } catch (const std::runtime_error&) {
    return {};
  }
}

/// Estimated seconds of the solves as they were made; 0: not known.
double estimateOf(const LinearSolver& solver, const Counts& made, const Estimates& estimate) {
  if (dynamic_cast<const DirectSolver*>(&solver)) {
    const Data* operations = solver.data().find("factorFlops");
    if (!operations || operations->print() == "0") return 0;  // no Cholesky factors
    return estimate.order + made.factorisations * estimate.factorisation + made.solves * (estimate.iteration + estimate.application);
  }
  const Data* named = solver.data().find("preconditioner");
  const std::string word = named ? named->print() : "none";
  if (word == "multigrid") return estimate.hierarchy + made.iterations * (estimate.iteration + estimate.cycle);
  if (word == "warped")
    return estimate.order + made.factorisations * estimate.factorisation + made.iterations * (estimate.iteration + estimate.application);
  const bool is_swept = word == "ssor" || word == "incomplete_cholesky";
  return made.iterations * (is_swept ? 2 : 1) * estimate.iteration;
}

/// The element or the attribute without which the run chooses, as a clause.
std::string withoutWhat(const System& system, const LinearSolver& solver) {
  const std::string word = writtenValue(solver, "preconditioner");
  const bool chooses_else = system.integrator().movesInTime() && !word.empty() && word[0] != '@' &&
                            writtenValue(solver, "iterations").empty() && writtenValue(solver, "template").empty();
  if (chooses_else) return fmt::format("preconditioner=\"{}\" it chooses one", word);
  return fmt::format("<{}> the run chooses {}", solver.type(), system.integrator().movesInTime() ? "the preconditioner" : "the solver");
}

std::string ofSolver(System& system, const Counts& made, double spent) {
  const LinearSolver* solver = system.linearSolver();
  if (!choiceOf(*solver).empty() || solver->isMadeForAnother()) return {};
  const std::optional<Estimates> estimates = estimatesOf(system.matrix());
  if (!estimates) return {};
  const auto is_constant = [](const ForceField* field) { return !field->traits().has_stiffness || field->traits().constant_stiffness; };
  const bool one_matrix = std::ranges::all_of(system.forceFields(), is_constant) && system.actors().mappings.empty();
  const Best best = bestOf(*estimates, made, one_matrix);
  const double own = estimateOf(*solver, made, *estimates);
  if (!(own > 0) || own < far_away * best.seconds) return {};
  return fmt::format("{:.3g} s went into {}, estimated at {:.0f} times what {} would take: without {}", spent, solver->path(),
                     own / best.seconds, best.way, withoutWhat(system, *solver));
}

/// The tolerance of Newton's method; 0: none is written there.
double toleranceOf(const Integrator& integrator) {
  for (const char* name : {"relative_residual_tolerance_threshold", "newtonTolerance"})
    if (const Data* data = integrator.data().find(name))
      if (auto* const value = std::get_if<double*>(&data->pointer())) return **value;
  return 0;
}

/// Strict solves reduce a residual by all decades in each iteration of Newton's method. Loose ones do so once in all, but for a decade in
/// each that is lost.
std::string ofForcing(const System& system, const Counts& made, double spent) {
  constexpr double least = 2, usual = 0.1, loosest_strict = 1e-2, least_tolerance = 1e-8, few = 4;
  const Integrator& integrator = system.integrator();
  const LinearSolver* solver = system.linearSolver();
  const bool is_chosen = solver->isMadeForAnother() || dynamic_cast<const SolverChoice*>(solver);
  if (!is_chosen || made.iterations < few * made.solves) return {};
  for (const char* name : {"forcing_term", "newtonForcing"}) {
    const std::string written = writtenValue(integrator, name);
    if (written.empty() || std::stod(written) > loosest_strict) continue;
    const double decades = -std::log10(std::max(std::stod(written), least_tolerance));
    const double wanted = -std::log10(std::clamp(toleranceOf(integrator), 1e-12, usual));
    const double newton = made.solves / made.steps, times = newton * decades / (wanted + newton);
    if (times < least) return {};
    return fmt::format("{:.3g} s went into solves, each to {}=\"{}\" of {}: without it early solves are loose, which is estimated to take "
                       "{:.2g} times fewer iterations",
                       spent, name, written, integrator.path(), times);
  }
  return {};
}

/// An approximate tangent that a scene insists on.
std::string ofTangent(const System& system, const Counts& made) {
  constexpr double usual = 8, many = 2;  // iterations of Newton's method in a step with the exact one
  if (made.solves < many * usual * made.steps) return {};
  for (const ForceField* field : system.forceFields()) {
    const Data* tangent = field->data().find("tangent");
    const auto* choice = tangent ? std::get_if<ChoiceRef>(&tangent->pointer()) : nullptr;
    if (!choice || !tangent->isSet() || tangent->print() == "exact" || std::ranges::find(choice->words, "exact") == choice->words.end())
      continue;
    return fmt::format("Newton's method took {:.0f} iterations per step with tangent=\"{}\" of {}, about {:.0f} times as many as usual: "
                       "without the attribute the exact tangent is taken where that is slow",
                       made.solves / made.steps, tangent->print(), field->path(), made.solves / made.steps / usual);
  }
  return {};
}

}  // namespace

std::vector<std::string> solverAdvice(const Simulation& simulation, const RunStatistics& statistics) {
  std::vector<std::string> advice;
  if (simulation.systems().size() != 1) return advice;
  System& system = *simulation.systems().front();
  if (!system.linearSolver()) return advice;
  // products that a solver by products asked for are its time too
  const double spent = system.times.solve + (system.integrator().movesInTime() ? system.times.product : 0);
  if (spent < worth_saying) return advice;
  const Counts made(statistics);
  for (const std::string& sentence : {ofSolver(system, made, spent), ofForcing(system, made, spent), ofTangent(system, made)})
    if (!sentence.empty()) advice.push_back(sentence);
  return advice;
}

}  // namespace stroma::command
