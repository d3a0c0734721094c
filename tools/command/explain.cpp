// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma explain: the compiled plan.
#include <fmt/format.h>

#include "framework/scene/dialect.h"
#include "tools/command/plan_json.h"
#include "tools/command/quirk_effects.h"
#include "tools/command/session.h"
#include "tools/plan/plan.h"
#include "tools/session/thread_choice.h"

namespace stroma::command {
namespace {

const Manual explain_manual{"stroma explain SCENE [options]",
                    "Prints the compiled plan of a scene: what runs each step and how often, what was skipped and why, "
                    "which modules were\nopened and which were not needed.\nWith --quirks it runs a scene in SOFA's dialect "
                    "with all of SOFA's ways and "
                    "once without each, and prints what each changes\nat the end, largest first.",
                    "  stroma explain liver.xml\n  stroma explain liver.xml --set /liver/solver.iterations=50\n"
                    "  stroma explain liver.scn --quirks -n 200\n"};

std::string names(const std::vector<std::string>& list) {
  return list.empty() ? "none" : fmt::format("{}", fmt::join(list, ", "));
}

CommandLine explainLine() {
  OptionList options("options");
  options.add_options()("json", "print the plan, or what --quirks finds, as JSON")  //
      ("quirks", "run the scene, and once without each of SOFA's ways that it has, and print what each changes")  //
      ("steps,n", po::value<long>()->value_name("STEPS")->default_value(100), "of each run of --quirks");
  addSceneOptions(options);
  return {explain_manual, options, {"SCENE"}};
}

int explain(const Arguments& arguments) {
  const auto values = parseOptions(explainLine(), arguments);
  if (!values) return exit_done;
  if (values->count("quirks")) return explainQuirks(required(*values, "SCENE", explain_manual), *values);
  if (!(*values)["steps"].defaulted()) throw UsageError("-n is the number of steps of --quirks");
  Session session;
  configure(session, *values);
  const Simulation& simulation = session.load(required(*values, "SCENE", explain_manual));
  reportProblems(simulation.scene(), true);
  for (const Problem& problem : simulation.scene().diagnostics.problems())
    if (problem.path == dialect_note) fmt::print("{}\n", problem.message);
  if (values->count("json")) return printJson(planJson(session));
  for (const std::string& line : planOf(simulation).lines()) fmt::print("{}\n", line);
  fmt::print("modules opened: {} (instructions: {})\n", names(session.modules().opened()), instructionLevel());
  fmt::print("modules not opened, the scene names nothing in them: {}\n", names(session.modules().notOpened()));
  fmt::print("threads: {}\n", threadsText(simulation));
  return exit_done;
}

}  // namespace

const Subcommand explain_command{"explain", "print the compiled plan: what each step does, what was skipped and why",
                                 Group::scenes, explain, explainLine};

}  // namespace stroma::command
