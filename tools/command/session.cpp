// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/session.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "framework/scene/missing_types.h"
#include "framework/scene/problem_listener.h"
#include "tools/command/words.h"
#include "tools/session/thread_choice.h"

namespace stroma::command {

void addSceneOptions(OptionList& options) {
  options.add_options()  //
      ("set", po::value<std::vector<std::string>>()->value_name("PATH.ATTR=VALUE"),
       "override an attribute of the scene, as --set /liver/fem.method=polar, or a component, as --set "
       "/liver/solver=BDFOdeSolver; may be repeated")  //
      ("dialect", po::value<std::string>()->value_name("sofa|native"),
       "read the scene as SOFA does, or as a native one; a file that ends in .scn is SOFA's")  //
      ("without-quirk", po::value<std::vector<std::string>>()->value_name("NAME"),
       "of a scene in SOFA's dialect: without this way of SOFA; stroma explain lists them; may be repeated")  //
      ("module", po::value<std::vector<std::string>>()->value_name("FILE.so"),
       "open a module of components by its path; may be repeated")  //
      ("threads", po::value<int>()->value_name("N"),
       "threads to use, else as many as pay for the size of the scene; no result depends on it");
}

void setThreadsOf(const Values& values) {
  if (!values.count("threads")) {
    try {
      chooseThreads(true);
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
    return;
  }
  const int count = values["threads"].as<int>();
  if (count < 1 || count > 1024) throw UsageError(fmt::format("--threads {}: expected 1 to 1024", count));
  giveThreads(count);
}

void configure(Session& session, const Values& values) {
  adviseOnMissingTypes(&sofaAdvice);
  if (values.count("module"))
    for (const std::string& file : values["module"].as<std::vector<std::string>>()) session.modules().open(file);
  session.setOverrides(overridesOf(values));
  setThreadsOf(values);
}

std::vector<Override> overridesOf(const Values& values) {
  std::vector<Override> overrides;
  if (values.count("set")) overrides = parseOverrides(values["set"].as<std::vector<std::string>>());
  if (values.count("dialect")) overrides.push_back({"/", "dialect", values["dialect"].as<std::string>()});
  if (values.count("without-quirk"))
    overrides.push_back(
        {"/", "withoutQuirks", fmt::format("{}", fmt::join(values["without-quirk"].as<std::vector<std::string>>(), " "))});
  return overrides;
}

std::vector<Override> parseOverrides(const std::vector<std::string>& texts) {
  std::vector<Override> overrides;
  for (const std::string& text : texts) overrides.push_back(Override::parse(text));
  return overrides;
}

namespace {
std::function<void(const Problem&)> hear_late;
}

LateProblems::LateProblems(std::function<void(const Problem&)> hear) : before_(problem_listener) {
  hear_late = std::move(hear);
  problem_listener = [](const Problem& problem) { hear_late(problem); };
}
LateProblems::~LateProblems() {
  problem_listener = before_;
  hear_late = nullptr;
}

std::vector<std::string> reportProblems(const Scene& scene, bool quiet) {
  std::vector<std::string> warnings;
  for (const Problem& problem : scene.diagnostics.problems()) {
    if (problem.severity == Severity::warning) warnings.push_back(problem.text());
    if (problem.severity != Severity::note || !quiet) fmt::print(stderr, "{}\n", problem.text());
  }
  if (!scene.no_effect.empty() && !quiet)
    fmt::print(stderr, "accepted without effect: {}\n", fmt::join(scene.no_effect, ", "));
  return warnings;
}

}  // namespace stroma::command
