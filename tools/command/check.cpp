// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma check: everything that stroma run does before its first step, with nothing written.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/command/run_request.h"
#include "tools/command/session.h"
#include "tools/command/sofa_runs.h"

namespace stroma::command {
namespace {

const Manual check_manual{
    "stroma check SCENE [options]",
    "Does what `stroma run` does before its first step, and writes nothing but the cacheFolder of a condensed solver.\n"
    "Reports every problem found in one run, each with its place, what was expected and the nearest right name.\n"
    "Exit code 2 when there are errors: `stroma run SCENE` would stop at the same.",
    "  stroma check liver.xml\n  stroma check liver.xml --set /liver/fem.method=polar --json\n"
    "  stroma check --sofa sofa/examples --steps 10 --jobs 2    a line for each of SOFA's scenes there\n"};

using Json = nlohmann::ordered_json;

const char* word(Severity severity) {
  return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

Json toJson(const std::vector<Problem>& problems) {
  Json list = Json::array();
  for (const Problem& problem : problems)
    list.push_back({{"severity", word(problem.severity)},
                    {"file", problem.where.file},
                    {"line", problem.where.line},
                    {"column", problem.where.column},
                    {"path", problem.path},
                    {"message", problem.message},
                    {"expected", problem.expected},
                    {"suggestion", problem.suggestion}});
  return list;
}

Json report(const std::string& scene, bool ok, const std::vector<Problem>& problems) {
  return {{"scene", scene}, {"ok", ok}, {"problems", toJson(problems)}};
}

std::string plural(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// "ok: 402 nodes in 1 state, 1 force field, ..."
std::string counts(const Simulation& simulation) {
  std::size_t nodes = 0, states = 0, fields = 0, masses = 0, constraints = 0, integrators = 0;
  for (const auto& system : simulation.systems()) {
    nodes += std::size_t(system->allRows());
    states += system->states().size();
    fields += system->forceFields().size();
    masses += system->masses().size();
    constraints += system->constraints().all().size();
    integrators += 1 + system->merged().size();
  }
  const std::size_t systems = simulation.systems().size();
  const std::string together = systems == integrators ? "" : fmt::format(" for {}", plural(systems, "system"));
  return fmt::format("ok: {} in {}, {}, {}, {}, {}{}, {}", plural(nodes, "node"), plural(states, "state"),
                     plural(fields, "force field"), masses == 1 ? "1 mass" : fmt::format("{} masses", masses),
                     plural(constraints, "constraint"), plural(integrators, "integrator"), together,
                     plural(simulation.observers().size(), "observer"));
}

void print(const Json& json) { fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace)); }

CommandLine checkLine() {
  OptionList options("options");
  options.add_options()("json", "print the problems as JSON")(
      "sofa", "SCENE is a folder of SOFA's scenes, or a list of them: a line for each, and how many each missing component blocks")(
      "steps", po::value<long>()->value_name("N")->default_value(10), "with --sofa: how many steps a scene must make")(
      "jobs", po::value<int>()->value_name("N")->default_value(1), "with --sofa: how many scenes at once")(
      "limit", po::value<double>()->value_name("SECONDS")->default_value(60), "with --sofa: the processor time of one scene");
  addSceneOptions(options);
  return {check_manual, options, {"SCENE"}};
}

int check(const Arguments& arguments) {
  const auto values = parseOptions(checkLine(), arguments);
  if (!values) return exit_done;
  const std::string scene = required(*values, "SCENE", check_manual);
  const bool json = values->count("json") > 0;
  if (values->count("sofa")) return surveySofaScenes(scene, *values);
  Session session;
  configure(session, *values);
  std::vector<Problem> problems;
  try {
    const Simulation& simulation = session.load(scene);
    problems = simulation.scene().diagnostics.problems();
    if (!json) reportProblems(simulation.scene(), false);
    checkOutputs(RunRequest(scene), simulation);
    if (json)
      print(report(scene, true, problems));
    else
      fmt::print("{}\n", counts(simulation));
    return exit_done;
  } catch (const SceneError& error) {
    if (!json) throw;
    const std::vector<Problem>& found = error.diagnostics().problems();
    problems.insert(problems.end(), found.begin(), found.end());
  } catch (const UsageError& error) {
    if (!json) throw;
    Diagnostics refusal;
    refusal.error({scene}, {}, error.what());
    problems.push_back(refusal.problems().front());
  }
  print(report(scene, false, problems));
  return exit_bad_input;
}

}  // namespace

const Subcommand check_command{"check", "report every problem of a scene without running it", Group::scenes, check,
                               checkLine};

}  // namespace stroma::command
