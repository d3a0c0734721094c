// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <system_error>

#include "framework/scene/text.h"
#include "framework/simulation/expectation.h"
#include "framework/simulation/step_guard.h"
#include "tools/command/job_limits.h"
#include "tools/command/session.h"
#include "tools/command/sofa_references.h"
#include "tools/command/sofa_runs.h"
#include "tools/platform/process.h"
#include "tools/session/children.h"
#include "tools/session/scene_program.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;

/// Scenes below a folder, those of SOFA's list, or one a line of a text.
std::vector<std::string> scenesOf(const std::string& where) {
  std::vector<std::string> scenes;
  if (isSceneProgram(where) || where.ends_with(".scn"))
    throw UsageError(where + " is one scene, and --sofa expects a folder or a list of scenes: stroma check " + where);
  if (fs::is_directory(where)) {
    for (const auto& entry : fs::recursive_directory_iterator(where)) {
      const std::string ending = entry.path().extension().string();
      const bool is_program = isSceneProgram(ending);
      if (!entry.is_regular_file() || (!is_program && ending != ".scn" && ending != ".xml")) continue;
      std::ifstream stream(entry.path());
      const std::string text{std::istreambuf_iterator<char>(stream), {}};
      if (text.find(is_program ? "def createScene" : "<Node") != std::string::npos) scenes.push_back(entry.path().string());
    }
    std::sort(scenes.begin(), scenes.end());
  } else if (isSofaList(where)) {
    for (const SofaCase& test : readSofaList(where)) scenes.push_back(test.scene);
  } else {
    std::ifstream stream(where);
    if (!stream) throw UsageError(where + " cannot be opened");
    for (std::string line; std::getline(stream, line);) {
      line = std::string(trimmed(std::string_view(line).substr(0, line.find('#'))));
      if (!line.empty()) scenes.push_back((fs::path(where).parent_path() / line).lexically_normal().string());
    }
  }
  if (scenes.empty()) throw UsageError(where + ": no scene is there");
  return scenes;
}

Json nothingYet(const std::string& scene) {
  return {{"scene", scene}, {"runs", false}, {"reasons", Json::array()}, {"without", Json::array()}, {"warnings", 0}};
}

/// What has been written into a file that has no name.
class Sink {
 public:
  Sink() : file_(memfd_create("answer", MFD_CLOEXEC)) {
    if (file_ < 0) throw std::system_error(errno, std::generic_category(), "no file can be made");
  }
  Sink(const Sink&) = delete;
  ~Sink() { close(file_); }
  std::string name() const { return fmt::format("/proc/self/fd/{}", file_); }
  std::string text() const {
    std::ifstream stream(name());
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  int file_;
};

std::string lastLine(const std::string& text) {
  const std::string_view all = trimmed(text);
  return std::string(all.substr(all.rfind('\n') + 1));
}

/// A scene in Python: what `stroma check` says of it, which makes no steps. The scene may print before that.
Json lookInPython(const std::string& scene) {
  Json result = nothingYet(scene);
  result["loads"] = false;
  const Sink answer, errors;
  const std::string command = fs::read_symlink("/proc/self/exe").string();
  Program program{{command, "check", "--json", scene}, {}, "/dev/null", answer.name(), errors.name()};
  program.signal_with_parent = SIGKILL;  // what is given up leaves nothing behind
  exitCodeOf(start(program));
  const std::string text = answer.text();
  const auto begin = ("\n" + text).rfind("\n{\n"), end = text.rfind("\n}\n");
  const bool is_answer = begin != std::string::npos && end != std::string::npos && begin < end;
  const Json report = is_answer ? Json::parse(text.substr(begin, end + 2 - begin), nullptr, false) : Json();
  if (!report.is_object() || !report.contains("problems")) {
    const std::string last = lastLine(errors.text() + "\n" + (is_answer ? "" : text));
    result["reasons"].push_back(last.empty() ? "stroma check ends without a word" : last);
    return result;
  }
  result["loads"] = report["ok"];
  int warnings = 0;
  for (const Json& problem : report["problems"]) {
    const std::string path = problem["path"], message = problem["message"];
    warnings += problem["severity"] == "warning";
    if (problem["severity"] == "error") result["reasons"].push_back((path.empty() ? "" : path + ": ") + message);
  }
  result["warnings"] = warnings;
  return result;
}

/// In a process of its own: JSON of what became of the scene.
std::string look(const std::string& scene, long steps) {
  if (isSceneProgram(scene)) return lookInPython(scene).dump(-1, ' ', false, Json::error_handler_t::replace);
  Json result = nothingYet(scene);
  try {
    Session session;
    Simulation& simulation = session.load(scene, {{"/", "dialect", "sofa"}});
    dropWriters(simulation);
    session.followMeshChanges();
    result["without"] = simulation.scene().no_effect;
    int warnings = 0;
    for (const Problem& problem : simulation.scene().diagnostics.problems()) warnings += problem.severity == Severity::warning;
    result["warnings"] = warnings;
    StepReport report;
    while (simulation.steps() < steps && !report.failed()) report = session.step();
    result["runs"] = !report.failed();
    if (report.failed()) result["reasons"].push_back(report.reason);
  } catch (const SceneError& error) {
    for (const Problem& problem : error.diagnostics().problems())
      if (problem.severity == Severity::error)
        result["reasons"].push_back((problem.path.empty() ? "" : problem.path + ": ") + problem.message);
  } catch (const std::exception& error) {
    result["reasons"].push_back(error.what());
  }
  return result.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The component that a reason misses, or the reason itself.
std::string causeOf(const std::string& reason) {
  const std::string missing = "there is no component '";
  if (const auto at = reason.find(missing); at != std::string::npos) {
    const auto begin = at + missing.size();
    return reason.substr(begin, reason.find('\'', begin) - begin);
  }
  const auto colon = reason.find(": ");
  std::string text = reason.starts_with("/") && colon != std::string::npos ? reason.substr(colon + 2) : reason;
  return text.size() > 80 ? text.substr(0, 80) + "..." : text;
}

struct Survey {
  int as_is = 0, without = 0, cannot = 0, loads = 0;  ///< of those in Python no steps are made: they load
  std::map<std::string, int> holding, alone;  ///< scenes by cause, and those that it holds back alone

  void add(const std::string& scene, const Json& result) {
    std::vector<std::string> reasons = result["reasons"], left_out = result["without"];
    const int warnings = result["warnings"];
    const std::string warned = warnings == 0 ? std::string() : fmt::format("; {} warnings", warnings);
    if (result.value("loads", false)) {
      ++loads;
      fmt::print("{}: loads{}\n", scene, warned);
    } else if (result["runs"].get<bool>()) {
      ++(left_out.empty() ? as_is : without);
      fmt::print("{}: {}{}\n", scene,
                 left_out.empty() ? std::string("runs as it is")
                                  : fmt::format("runs without {}", fmt::join(left_out, ", ")),
                 warned);
    } else {
      ++cannot;
      fmt::print("{}: cannot run because {}\n", scene, fmt::join(reasons, "; "));
      std::set<std::string> causes;
      for (const std::string& reason : reasons) causes.insert(causeOf(reason));
      for (const std::string& cause : causes) ++holding[cause], alone[cause] += causes.size() == 1;
    }
    std::fflush(stdout);
  }
  void summarise() const {
    const std::string programs = loads == 0 ? "" : fmt::format("{} in Python load (stroma run makes their steps), ", loads);
    fmt::print("\n{} scenes: {} run as they are, {} run without what has no effect, {}{} cannot run\n",
               as_is + without + cannot + loads, as_is, without, programs, cannot);
    std::vector<std::pair<int, std::string>> order;
    for (const auto& [cause, count] : holding) order.emplace_back(-count, cause);
    std::sort(order.begin(), order.end());
    if (!order.empty()) fmt::print("what holds them back (scenes; those that nothing else holds back):\n");
    for (const auto& [count, cause] : order) fmt::print("{:5} {:5}  {}\n", -count, alone.at(cause), cause);
  }
};

}  // namespace

void dropWriters(Simulation& simulation) {
  const std::vector<Observer*> all = simulation.observers();
  for (Observer* observer : all)
    if (!dynamic_cast<StepGuard*>(observer) && !dynamic_cast<Expectation*>(observer)) simulation.removeObserver(*observer);
}

int surveySofaScenes(const std::string& where, const Values& values) {
  const std::vector<std::string> scenes = scenesOf(where);
  const JobLimits limits = jobLimitsOf(values);
  const long steps = within(values, "steps", 0L, 0L, 1'000'000'000L);
  Survey survey;
  Json all = Json::array();
  const bool json = values.count("json") > 0;
  runJobs(
      int(scenes.size()), limits, [&](int i) { return look(scenes[std::size_t(i)], steps); },
      [&](int i, const ChildEnd& end) {
        Json result = end.failure.empty() ? Json::parse(end.text) : nothingYet(scenes[std::size_t(i)]);
        if (!end.failure.empty()) result["reasons"].push_back(end.failure);
        if (json)
          all.push_back(std::move(result));
        else
          survey.add(scenes[std::size_t(i)], result);
      });
  if (json)
    fmt::print("{}\n", all.dump(2, ' ', false, Json::error_handler_t::replace));
  else
    survey.summarise();
  return exit_done;
}

}  // namespace stroma::command
