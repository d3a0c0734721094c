// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes against the states that SOFA stored for them. SOFA writes at the start of a step: the last of n instants is at
// (n - 1) h. A case passes when, at every stored instant, |x - x_ref|_2 is at most the tolerance times the largest
// |x_ref(t) - x_ref(0)|_2. One that does not is run again from positions moved by 1e-9 of the body: where the two runs
// differ by more than the tolerance, no other program can do better, and the case is neither passed nor failed.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/mechanics/mapping.h"
#include "framework/scene/output_file.h"
#include "tools/command/job_limits.h"
#include "tools/command/junit.h"
#include "tools/command/session.h"
#include "tools/command/sofa_references.h"
#include "tools/command/sofa_runs.h"
#include "tools/session/children.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;
using Instants = std::map<double, std::vector<double>>;

/// The numbers that SOFA writes of a state.
std::vector<double> numbersOf(const State& state) {
  std::vector<double> numbers;
  const ConstRows rows = state.x();
  for (Index i = 0; i < state.size(); ++i) {
    const double* row = rows.data + std::size_t(i) * row_doubles;
    const RowKind kind = state.kindOf(i);
    const int count = kind == RowKind::place ? 3 : kind == RowKind::turn ? 4 : 1;
    for (int c = 0; c < count; ++c) numbers.push_back(row[c]);
  }
  return numbers;
}

bool isName(const std::string& name, const std::string& wanted) { return name == wanted || name + "1" == wanted; }

/// The state that a reference is of: by its number among all states or those that nothing places, else by its name.
const State& stateOf(const SofaReference& reference, const Node& root) {
  std::vector<State*> all;
  std::vector<Mapping*> mappings;
  root.collect(all);
  root.collect(mappings);
  std::vector<State*> unmapped = all;
  std::erase_if(unmapped, [&](const State* state) {
    return std::any_of(mappings.begin(), mappings.end(), [state](const Mapping* m) { return &m->output() == state; });
  });
  const auto number = std::size_t(reference.number);
  for (const auto* list : {&unmapped, &all})
    if (number < list->size() && isName((*list)[number]->name(), reference.state)) return *(*list)[number];
  const State* found = nullptr;
  for (const State* state : all) {
    if (!isName(state->name(), reference.state)) continue;
    if (found) throw std::runtime_error("several states are called " + reference.state);
    found = state;
  }
  if (!found) throw std::runtime_error("no state is called " + reference.state);
  return *found;
}

/// Every place by another way, up to this share of the body's distance from the origin.
void moveALittle(Simulation& simulation, double shift) {
  for (const auto& system : simulation.systems()) {
    double size = 0;
    for (Index i = 0; i < system->independentRows(); ++i) size = std::max(size, Vec3(system->x[i]).norm());
    for (Index i = 0; i < system->independentRows(); ++i)
      if (system->motion().kindOf(i) == RowKind::place)
        system->x[i] += shift * size / 3 * Vec3((i * 7 + 3) % 5 - 2, (i * 11 + 5) % 7 - 3, (i * 13 + 4) % 5 - 2);
  }
}

/// Runs as far as the references go. `shift`: how far positions are moved at the start, as a share of the body; `step`: set to
/// the scene's.
std::vector<Instants> run(const SofaCase& test, const std::vector<SofaReference>& references, double shift, double& step) {
  Session session;
  Simulation& simulation = session.load(test.scene, {{"/", "dialect", "sofa"}});
  dropWriters(simulation);
  session.followMeshChanges();
  double last = 0;
  for (const SofaReference& reference : references) {
    stateOf(reference, simulation.root());  // or there is none
    last = std::max(last, reference.positions.rbegin()->first);
  }
  if (shift != 0) moveALittle(simulation, shift);
  std::vector<Instants> found(references.size());
  step = simulation.dt();
  const double h = step, begin = simulation.time();
  for (long k = 0;; ++k) {
    const double t = double(k) * h;
    for (std::size_t r = 0; r < references.size(); ++r)
      for (const auto& [time, values] : references[r].positions)
        if (std::abs(time - begin - t) < 0.01 * h || std::abs(time - t) < 0.01 * h)
          if (const State& state = stateOf(references[r], simulation.root()); state.isBound()) found[r][time] = numbersOf(state);
    if (t > last - 0.5 * h) return found;
    const StepReport report = session.step();
    if (report.failed())
      throw std::runtime_error(fmt::format("ended at t = {:g} of {:g}: {}", simulation.time(), last, report.reason));
  }
}

/// What the list asks for and a reference lacks, or empty: a stored instant in the last period. A period that the list does not
/// give is taken for the least time between two instants.
std::string earlyEnd(const SofaCase& test, const std::vector<SofaReference>& references, double h) {
  const double end = double(test.steps - 1) * h;
  for (const SofaReference& reference : references) {
    double period = test.period;
    if (period == 0 && !test.last_only && reference.positions.size() > 2) {
      period = std::numeric_limits<double>::infinity();
      for (auto at = std::next(reference.positions.begin()); at != reference.positions.end(); ++at)
        period = std::min(period, at->first - std::prev(at)->first);
    }
    const double last = reference.positions.rbegin()->first;
    if (last < end - std::max(period, h) + 0.5 * h)
      return fmt::format("the reference of {} ends at t = {:g}, and {} steps at t = {:g}: nothing is compared after it",
                         reference.state, last, test.steps, end);
  }
  return {};
}

struct Difference {
  double largest = 0;   ///< of a number [m]
  double relative = 0;  ///< in L2, of the largest displacement
  double sofa = 0;      ///< SOFA's own: the mean of all numbers over the number of points
};

Difference differenceOf(const Instants& reference, const Instants& actual, const std::string& name) {
  Difference worst;
  double size = 0, body = 0;
  const std::vector<double>& start = reference.begin()->second;
  for (const auto& [time, values] : reference) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += (values[i] - start[i]) * (values[i] - start[i]);
    size = std::max(size, std::sqrt(sum));
  }
  for (const double value : start) body += value * value;
  size = std::max({size, 1e-9 * std::sqrt(body), 1e-300});
  for (const auto& [time, values] : reference) {
    const auto found = actual.find(time);
    if (found == actual.end()) throw std::runtime_error(fmt::format("{} has no instant at t = {:g}", name, time));
    if (found->second.size() != values.size())
      throw std::runtime_error(fmt::format("{} has {} numbers, and its reference {}", name, found->second.size(), values.size()));
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double difference = std::abs(found->second[i] - values[i]);
      if (!std::isfinite(difference)) throw std::runtime_error(fmt::format("{} is not finite at t = {:g}", name, time));
      squares += difference * difference, sum += difference;
      worst.largest = std::max(worst.largest, difference);
    }
    worst.relative = std::max(worst.relative, std::sqrt(squares) / size);
    const auto count = double(values.size());
    worst.sofa = std::max(worst.sofa, sum / count / std::max(1., count / 3));
  }
  return worst;
}

Difference worstOf(const std::vector<SofaReference>& references, const std::vector<Instants>& wanted,
                   const std::vector<Instants>& actual) {
  Difference worst;
  for (std::size_t r = 0; r < references.size(); ++r) {
    const Difference one = differenceOf(wanted[r], actual[r], references[r].state);
    worst.largest = std::max(worst.largest, one.largest);
    worst.relative = std::max(worst.relative, one.relative);
    worst.sofa = std::max(worst.sofa, one.sofa);
  }
  return worst;
}

/// In a process of its own: JSON of the verdict.
std::string judge(const SofaCase& test, double tolerance) {
  const auto start = std::chrono::steady_clock::now();
  Json result{{"name", test.name}, {"verdict", "failed"}};
  try {
    if (!std::filesystem::exists(test.scene))
      throw std::runtime_error(test.scene + " is not there, nor in a folder of REGRESSION_SCENES_DIR or STROMA_DATA_PATH");
    if (test.references.empty()) throw std::runtime_error("there is no reference");
    std::vector<SofaReference> references;
    std::vector<Instants> wanted;
    for (const std::string& file : test.references) {
      references.push_back(readSofaReference(file));
      wanted.push_back(references.back().positions);
    }
    double h = 0;
    const std::vector<Instants> actual = run(test, references, 0, h);
    if (const std::string early = earlyEnd(test, references, h); !early.empty()) result["remark"] = early;
    const Difference found = worstOf(references, wanted, actual);
    result["largest"] = found.largest;
    result["relative"] = found.relative;
    result["sofa"] = found.sofa;
    result["sofa_passes"] = found.sofa <= test.epsilon;
    if (found.relative <= tolerance) {
      result["verdict"] = "passed";
    } else {
      constexpr double nothing = 1e-9;
      const double sensitivity = worstOf(references, actual, run(test, references, nothing, h)).relative;
      result["sensitivity"] = sensitivity;
      if (sensitivity > tolerance) result["verdict"] = "undecided";
    }
  } catch (const SceneError& error) {
    result["reason"] = "does not load: " + error.diagnostics().text();
  } catch (const std::exception& error) {
    result["reason"] = error.what();
  }
  result["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string sentence(const Json& result, double epsilon) {
  std::string text;
  if (result.contains("relative"))
    text = fmt::format("relative {:.3g}, largest {:.3g} m, SOFA's test {:.3g} of {:g} ({})", result["relative"].get<double>(),
                       result["largest"].get<double>(), result["sofa"].get<double>(), epsilon,
                       result["sofa_passes"].get<bool>() ? "passes" : "fails");
  if (result.contains("sensitivity"))
    text += fmt::format(", a start moved by 1e-9 changes {:.3g}", result["sensitivity"].get<double>());
  for (const char* more : {"remark", "reason"})
    if (result.contains(more)) text += (text.empty() ? "" : "; ") + result[more].get<std::string>();
  return text;
}

}  // namespace

int regressSofaLists(const std::string& where, const Values& values) {
  for (const char* other : {"update", "bits", "set", "threads"})
    if (values.count(other))
      throw UsageError(fmt::format("--{} is of the project's own lists: what {} compares are states that SOFA stored", other, where));
  std::vector<SofaCase> cases;
  for (const std::string& list : isSofaList(where) ? std::vector<std::string>{where} : sofaListsIn(where))
    for (SofaCase& one : readSofaList(list)) cases.push_back(std::move(one));
  const std::string filter = textOf(values, "filter");
  std::erase_if(cases, [&](const SofaCase& test) { return test.name.find(filter) == std::string::npos; });
  if (cases.empty()) throw UsageError(fmt::format("--filter {}: no case of the list has that in its name", filter));
  const double tolerance = values["tolerance"].as<double>();
  const JobLimits limits = jobLimitsOf(values);
  int passed = 0, failed = 0, undecided = 0;
  Json all = Json::array();
  std::vector<JunitCase> junit;
  runJobs(
      int(cases.size()), limits, [&](int i) { return judge(cases[std::size_t(i)], tolerance); },
      [&](int i, const ChildEnd& end) {
        const SofaCase& test = cases[std::size_t(i)];
        Json result = end.failure.empty() ? Json::parse(end.text)
                                          : Json{{"name", test.name}, {"verdict", "failed"}, {"reason", end.failure}};
        const std::string verdict = result["verdict"];
        ++(verdict == "passed" ? passed : verdict == "failed" ? failed : undecided);
        const std::string text = sentence(result, test.epsilon);
        fmt::print("{:9} {}: {}\n", verdict, test.name, text);
        std::fflush(stdout);
        if (verdict != "undecided")
          junit.push_back({test.name, result.value("seconds", 0.), verdict == "failed" ? text : std::string()});
        all.push_back(std::move(result));
      });
  fmt::print("{} passed, {} failed, {} undecided: no other program can match them\n", passed, failed, undecided);
  if (values.count("json"))
    writeWholeFile(textOf(values, "json"), all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  if (values.count("junit")) writeJunit("stroma regress", junit, textOf(values, "junit"));
  return failed == 0 ? exit_done : exit_comparison_failed;
}

}  // namespace stroma::command
