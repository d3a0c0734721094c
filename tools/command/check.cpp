// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma check: everything short of stepping.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual manual{
    "stroma check SCENE [options]",
    "Reads, resolves, instantiates and compiles a scene and reports every problem found in one run, each "
    "with its place,\nwhat was expected and the nearest right name. Exit code 2 when there are errors.",
    "  stroma check liver.xml\n  stroma check liver.xml --set /liver/fem.method=polar --json\n"};

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

std::string plural(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// "ok: 402 nodes in 1 state, 1 force field, ..."
std::string counts(const Simulation& simulation) {
  std::size_t nodes = 0, states = 0, fields = 0, masses = 0, constraints = 0;
  for (const auto& system : simulation.systems()) {
    nodes += std::size_t(system->allRows());
    states += system->states().size();
    fields += system->forceFields().size();
    masses += system->masses().size();
    constraints += system->constraints().all().size();
  }
  return fmt::format("ok: {} in {}, {}, {}, {}, {}, {}", plural(nodes, "node"), plural(states, "state"),
                     plural(fields, "force field"), masses == 1 ? "1 mass" : fmt::format("{} masses", masses),
                     plural(constraints, "constraint"), plural(simulation.systems().size(), "integrator"),
                     plural(simulation.observers().size(), "observer"));
}

void print(const Json& json) { fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace)); }

}  // namespace

int check(const Arguments& arguments) {
  OptionList options("options");
  options.add_options()("json", "print the problems as JSON");
  addSceneOptions(options);
  const auto values = parseOptions(manual, options, {"SCENE"}, arguments);
  if (!values) return exit_done;
  const std::string scene = required(*values, "SCENE", manual);
  const bool json = values->count("json") > 0;
  Session session;
  configure(session, *values);
  try {
    const Simulation& simulation = session.load(scene);
    if (json) {
      print({{"scene", scene}, {"ok", true}, {"problems", toJson(simulation.scene().diagnostics.problems())}});
    } else {
      reportProblems(simulation.scene(), false);
      fmt::print("{}\n", counts(simulation));
    }
    return exit_done;
  } catch (const SceneError& error) {
    if (!json) throw;
    print({{"scene", scene}, {"ok", false}, {"problems", toJson(error.diagnostics().problems())}});
    return exit_bad_input;
  }
}

}  // namespace stroma::command
