// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/run_outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "framework/algebra/parallel.h"
#include "framework/scene/output_file.h"
#include "framework/simulation/expectation.h"
#include "tools/checks/mesh_error.h"
#include "tools/checks/result_doubts.h"
#include "tools/checks/rule_damping.h"
#include "tools/command/statistics.h"
#include "tools/plan/plan.h"
#include "tools/units/unit_system.h"

namespace stroma::command {

const char* Outcome::word() const {
  switch (end) {
    case RunEnd::diverged:
      return "diverged";
    case RunEnd::mesh_refused:
      return "ended by a change of mesh";
    case RunEnd::stopped:
      return "interrupted";
    case RunEnd::not_converged:
      return "not converged";
    case RunEnd::not_replayed:
      return "not replayed";
    case RunEnd::program_failed:
      return "ended by the scene's program";
    case RunEnd::output_failed:
      return "ended by an output";
    case RunEnd::done:
      break;
  }
  return doubted ? "in doubt" : unexpected.empty() ? "done" : "not as expected";
}

int Outcome::exitCode() const {
  constexpr int by_signal = 128;
  if (failed()) return exit_diverged;
  if (!failures.empty()) return exit_output_failed;
  if (end == RunEnd::stopped) return by_signal + signal;
  if (doubted) return exit_diverged;
  return unexpected.empty() ? exit_done : exit_comparison_failed;
}

void tellExpectations(const Simulation& simulation, bool quiet, Outcome& outcome) {
  long met = 0;
  const UnitSystem units = unitsOf(simulation.scene());
  for (const Observer* observer : simulation.observers()) {
    const auto* expectation = dynamic_cast<const Expectation*>(observer);
    if (!expectation) continue;
    const std::string failure = expectation->failure();
    met += failure.empty() && expectation->comparisons() > 0;
    if (failure.empty() && expectation->comparisons() > 0) continue;
    const std::string why = failure.empty() ? "nothing was compared" : units.sentence(failure);
    outcome.unexpected.push_back(observer->path() + ": " + why);
    fmt::print(stderr, "not as expected: {}\n", outcome.unexpected.back());
  }
  if (met > 0 && !quiet) fmt::print(stderr, "note: {} as expected\n", met == 1 ? "1 result is" : fmt::format("{} results are", met));
}

/// A state from which most elements have to unfold first is where the trouble is, not what was there before it.
void tellFailure(const Outcome& outcome, const Simulation& simulation, const std::string& place) {
  fmt::print(stderr, "{}: {}\n", outcome.word(), outcome.reason);
  const auto [inverted, all] = invertedCells(simulation);
  const bool stands =
      outcome.last.diverged || outcome.end == RunEnd::not_replayed || outcome.end == RunEnd::program_failed;
  const bool is_good = stands && 2 * inverted <= all;
  fmt::print(stderr, "the last {}state (t = {:.6g}{}{}{}) {}\n", is_good ? "good " : "", simulation.time(),
             unitsOf(simulation.scene()).behind("s"), all > 0 ? fmt::format(", {} of {} elements inverted", inverted, all) : "",
             outcome.last.diverged && !is_good ? ": no good one" : "", place);
}

bool tellWarnings(const RunStatistics& statistics, const std::vector<std::string>& doubts,
                  std::vector<std::string>& warnings) {
  std::vector<std::string> found = statistics.unconverged.warnings();
  for (const std::string& sentence : doubts)
    if (std::none_of(warnings.begin(), warnings.end(),
                     [&](const std::string& warning) { return warning.find(sentence) != std::string::npos; }))
      found.push_back(sentence);
  for (const std::string& warning : found) {
    fmt::print(stderr, "warning: {}\n", warning);
    warnings.push_back(warning);
  }
  return !doubts.empty();
}

namespace {

std::vector<std::string> told(std::vector<std::string> sentences, bool quiet) {
  for (const std::string& sentence : sentences)
    if (!quiet) fmt::print(stderr, "note: {}\n", sentence);
  return sentences;
}

}  // namespace

std::vector<std::string> tellMeshErrors(const Simulation& simulation, bool quiet) {
  return told(meshErrors(simulation), quiet);
}

std::vector<std::string> tellDampedSwings(const Simulation& simulation, bool quiet) {
  return told(dampedSwings(simulation), quiet);
}

/// Of each integrator whose body has slept, as text.
std::map<std::string, std::string> stepsAsleep(const Simulation& simulation) {
  std::map<std::string, std::string> all;
  for (const auto& system : simulation.systems())
    if (const Data* steps = system->integrator().data().find("stepsAsleep"); steps && steps->print() != "0")
      all[system->integrator().path()] = steps->print();
  return all;
}

/// The node of each state that is farthest from where it started.
nlohmann::ordered_json greatestDisplacements(const Simulation& simulation) {
  auto all = nlohmann::ordered_json::array();
  simulation.complete();
  for (const State* state : simulation.states()) {
    double greatest = 0;
    Index node = 0;
    for (Index i = 0; i < state->size(); ++i) {
      if (state->kindOf(i) != RowKind::place) continue;
      const double distance = (state->x()[i] - state->position[std::size_t(i)]).stableNorm();  // squares overflow
      if (!(distance <= greatest)) greatest = distance, node = i;  // what is no number is farthest
      if (std::isnan(greatest)) break;
    }
    all.push_back({{"state", state->path()}, {"distance", greatest}, {"node", node}});
  }
  return all;
}

nlohmann::ordered_json summary(const RunRequest& request, const Simulation& simulation, const Outcome& outcome) {
  nlohmann::ordered_json json;
  json["scene"] = request.scene;
  json["outcome"] = outcome.word();
  if (!outcome.reason.empty()) json["reason"] = outcome.reason;
  if (!outcome.failures.empty()) json["not_written"] = outcome.failures;
  json["steps"] = simulation.steps();
  json["simulated_time"] = simulation.time() - simulation.root().root_time;
  json["wall_seconds"] = outcome.seconds;
  json["ms_per_step"] = timing(outcome.statistics);
  json["phase_seconds"] = phaseSeconds(simulation);
  json.update(solvers(outcome.statistics));
  for (const auto& [path, steps] : stepsAsleep(simulation)) json["steps_asleep"][path] = std::stol(steps);
  json["threads"] = threads();
  json["state_hash"] = fmt::format("{:016x}", simulation.stateHash());
  const UnitSystem units = unitsOf(simulation.scene());
  json["units"] = units.isKnown() ? nlohmann::ordered_json{{"system", units.name},         {"length", units.unit("m")},
                                                           {"time", units.unit("s")},      {"force", units.unit("N")},
                                                           {"pressure", units.unit("Pa")}, {"energy", units.unit("J")}}
                                  : nlohmann::ordered_json();
  json["greatest_displacements"] = greatestDisplacements(simulation);
  if (outcome.failed()) {
    const auto [inverted, all] = invertedCells(simulation);
    json["inverted_elements"] = {{"inverted", inverted}, {"of", all}};
  }
  return json;
}

/// A choice that a solver has changed in the run, or empty.
std::string changedChoice(const System& system) {
  const LinearSolver* solver = system.linearSolver();
  const Data* given_up = solver ? solver->data().find("precisionChanges") : nullptr;
  if (given_up && given_up->print() != "0")
    return fmt::format("\n{}: {} factorisations in single precision were made again in double, because solutions with them did not "
                       "converge (precision=\"double\" begins with it)",
                       solver->path(), given_up->print());
  const Data* changes = solver ? solver->data().find("changes") : nullptr;
  if (!changes || changes->print() == "0" || choiceOf(*solver).empty()) return {};
  return fmt::format("\n{} changed its choice in the run: {}", solver->path(), choiceOf(*solver));
}

/// The force fields with an approximate tangent that could be exact.
std::string approximateFields(const System& system) {
  std::vector<std::string> paths;
  for (const ForceField* field : system.forceFields()) {
    const Data* tangent = field->data().find("tangent");
    const auto* choice = tangent ? std::get_if<ChoiceRef>(&tangent->pointer()) : nullptr;
    if (choice && tangent->print() != "exact" && std::ranges::find(choice->words, "exact") != choice->words.end())
      paths.push_back(field->path());
  }
  return paths.empty() ? "a force field" : fmt::format("{}", fmt::join(paths, " and "));
}

/// What would make steps with closed gaps cheaper, where they took many iterations; or empty.
std::string closedGaps(const System& system, const RunStatistics& statistics) {
  constexpr double many_iterations = 30;  // in a step
  if (double(statistics.newton_iterations) < many_iterations * double(statistics.step_ms.size())) return {};
  std::string text;
  for (const ForceField* field : system.forceFields()) {
    const Data* stiffness = field->data().find("openStiffness");
    const auto* value = stiffness ? std::get_if<double*>(&stiffness->pointer()) : nullptr;
    if (value && **value > 0)
      text += fmt::format("\ngaps of {} closed to less than a tenth of contactDistance, where steps take many iterations: "
                          "stiffness=\"{:.2g}\" would have kept them at half of it",
                          field->path(), **value);
  }
  return text;
}

void printSummary(const RunRequest& request, const Simulation& simulation, const Outcome& outcome) {
  fmt::print("{}: {} after {} steps, t = {:.6g}{}; {:.3g} s of wall time", request.scene, outcome.word(),
             simulation.steps(), simulation.time(), unitsOf(simulation.scene()).behind("s"), outcome.seconds);
  if (!outcome.statistics.step_ms.empty())
    fmt::print(", {:.3g} ms per step (median {:.3g}, p99 {:.3g})", outcome.statistics.meanMs(),
               outcome.statistics.quantileMs(0.5), outcome.statistics.quantileMs(0.99));
  if (outcome.statistics.divided_steps > 0)
    fmt::print("\n{} of the steps had to be divided, into up to {} parts", outcome.statistics.divided_steps,
               outcome.statistics.most_load_parts);
  for (const auto& system : simulation.systems())
    if (const Data* steps = system->integrator().data().find("exactTangentSteps"); steps && steps->print() != "0")
      fmt::print(
          "\nin {} of the steps {} failed, or got on slowly, with the approximate tangent of {} and went on with "
          "the exact one: tangent=\"exact\" there takes it from the start",
          steps->print(), system->integrator().path(), approximateFields(*system));
  for (const auto& [path, steps] : stepsAsleep(simulation))
    fmt::print("\n{} of the steps {} did not compute: its body slept", steps, path);
  for (const std::string& advice : outcome.advice) fmt::print("\n{}", advice);
  for (const auto& system : simulation.systems())
    fmt::print("{}{}", closedGaps(*system, outcome.statistics), changedChoice(*system));
  fmt::print("\nstate hash {:016x}\n", simulation.stateHash());
}

void writeJson(const nlohmann::ordered_json& json, const std::string& file) {
  // file names need not be UTF-8; a byte that is not is replaced rather than losing the summary of a run
  const std::string text = json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (file == "-")
    fmt::print("{}", text);
  else
    writeWholeFile(file, text);
}

}  // namespace stroma::command
