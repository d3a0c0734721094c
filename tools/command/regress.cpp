// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma regress: runs the scenes of a list and compares every state, positions and velocities, with stored ones.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "framework/mechanics/frames.h"
#include "framework/scene/output_file.h"
#include "framework/simulation/expectation.h"
#include "tools/command/bits.h"
#include "tools/command/comparison.h"
#include "tools/command/job_limits.h"
#include "tools/command/junit.h"
#include "tools/command/regression_list.h"
#include "tools/command/session.h"
#include "tools/command/sofa_references.h"
#include "tools/command/sofa_runs.h"
#include "tools/session/children.h"
#include "tools/session/file_uses.h"
#include "tools/session/statistics.h"
#include "tools/session/thread_choice.h"

namespace stroma::command {
namespace {

const Manual regress_manual{
    "stroma regress LIST [options]",
    "Runs every scene of a list and compares the positions and velocities of every state with stored ones at the "
    "start, "
    "three\ninstants between and the last. A case fails when a node differs by more than the tolerance times the size "
    "of "
    "the body, when\nthe relative L2 error exceeds the tolerance, at a number that is not finite, a missing reference, "
    "another size, name or time.\nOrientations are compared apart, by their angle in radians, and so are numbers, by their range.\n"
    "LIST: the folder of the references on the first line, then lines `SCENE STEPS "
    "TOLERANCE [PATH.ATTR=VALUE ...] [data=PATH.NAME[:TOLERANCE] ...]\n[unconverged]`; # starts a comment; paths are "
    "relative to the list. data: an attribute of numbers, kinetic_energy and its like, cells (how many\nthere are) or volume: "
    "compared too. A case also "
    "fails, and nothing of it is stored, when a solve ends before its\ntolerance, unless its line says `unconverged`, "
    "and when an Expect of the scene is not met. "
    "A reference that this "
    "program "
    "wrote proves only that nothing has changed.\nWith --bits nothing is compared with references: each scene runs "
    "with one thread, once more after a reset, from a\ncheckpoint in the middle and with two threads, and every bit of "
    "every step must be the same; the hash of the last one must be\nthe stored one, where one is stored for this "
    "compiler and instruction set.\nOf SOFA a list NAME.regression-tests is taken, or a folder with such lists, and the "
    "references that SOFA stored.",
    "  stroma regress scenes/regression/list\n  stroma regress scenes/regression/list --filter cantilever --update\n"
    "  stroma regress scenes/regression/list --bits\n"};

using Json = nlohmann::ordered_json;
struct StoredState {
  const State* state = nullptr;
  std::vector<StateFrame> frames;  ///< values as in State::position
};
/// By file name: states, and what a case compares besides them.
struct Recording {
  std::map<std::string, StoredState> states;
  std::map<std::string, DataOverTime> data;
};

struct Result {
  std::string name, failure;
  std::string remark;  ///< what --bits has to say of a case that passed
  double seconds = 0;
  std::map<std::string, Comparison> states;
  std::map<std::string, double> data;  ///< difference as a share of the largest number
};

std::set<long> storedSteps(long steps) { return {0, steps / 4, steps / 2, 3 * steps / 4, steps}; }

void store(const Simulation& simulation, const RegressionCase& test, Recording& recording) {
  for (const WatchedData& data : test.data) recording.data[data.fileName()][simulation.time()] = numbersNow(simulation, data.name);
  for (const State* state : simulation.states()) {
    StateFrame frame{.time = simulation.time(), .x0 = {}, .x = {}, .v = {}, .f = {}};
    for (Index i = 0; i < state->size(); ++i) {
      frame.x.push_back(valueOfRow(state->kindOf(i), state->x(), i));
      frame.v.emplace_back(state->v()[i]);
    }
    StoredState& stored = recording.states[stateFileName(state->path())];
    stored.state = state;
    stored.frames.push_back(std::move(frame));
  }
}

/// Runs the scene without its observers: a regression run leaves no files behind.
Recording runCase(const RegressionCase& test, Session& session) {
  Simulation& simulation = session.load(test.scene, parseOverrides(test.overrides));
  dropWriters(simulation);
  session.followMeshChanges();
  const std::set<long> stored = storedSteps(test.steps);
  Recording recording;
  store(simulation, test, recording);
  RunStatistics statistics;
  while (simulation.steps() < test.steps) {
    const StepReport report = session.step();
    if (report.diverged) throw std::runtime_error("diverged: " + report.reason);
    if (!report.constraints_converged) throw std::runtime_error("not converged: " + report.constraint_reason);
    statistics.add(report, 0);
    if (stored.count(simulation.steps())) store(simulation, test, recording);
  }
  simulation.end();
  for (const Observer* observer : simulation.observers())
    if (const auto* expectation = dynamic_cast<const Expectation*>(observer); expectation && !expectation->failure().empty())
      throw std::runtime_error(observer->path() + ": " + expectation->failure());
  if (!statistics.unconverged.none() && !test.accepts_unconverged)
    throw std::runtime_error(fmt::format("{}; or add unconverged to the case: its result is then accepted",
                                         fmt::join(statistics.unconverged.warnings(), "; ")));
  if (recording.states.empty()) throw std::runtime_error("the scene has no state that moves: there is nothing to compare");
  return recording;
}

/// Says of a reference by what and when it was written.
constexpr const char* origin_file = "origin";

void writeReference(const RegressionCase& test, const fs::path& folder, const Recording& recording) {
  fs::remove_all(folder);
  for (const auto& [file, stored] : recording.states) {
    StateWriter writer((folder / file).string());
    for (const StateFrame& frame : stored.frames) {  // of as many points as there are then
      const Index rows = Index(frame.x.size());
      Vector x(rows), v(rows);
      for (Index i = 0; i < x.count(); ++i)
        placeRow(stored.state->kindOf(i), frame.x[std::size_t(i)], x, i), v[i] = frame.v[std::size_t(i)];
      writer.time(frame.time);
      if (stored.state->hasPointsOnly()) {
        writer.rows("X", x), writer.rows("V", v);
      } else {
        writer.rows("X", *stored.state, x), writer.rows("V", *stored.state, v);
      }
    }
    writer.close();
  }
  for (const auto& [file, values] : recording.data) writeData((folder / file).string(), values);
  const std::time_t now = std::time(nullptr);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  writeWholeFile((folder / origin_file).string(),
                 fmt::format("stroma {} on {}\nstroma regress {} --update: {} steps\n", STROMA_VERSION, date, test.name, test.steps));
}

void compareWithReference(const RegressionCase& test, const fs::path& folder, const Recording& recording,
                          Result& result) {
  if (!fs::is_directory(folder))
    throw std::runtime_error(fmt::format("there is no reference {} (--update writes it)", folder.string()));
  for (const auto& entry : fs::directory_iterator(folder))
    if (const std::string file = entry.path().filename().string();
        file != origin_file && !recording.states.count(file) && !recording.data.count(file))
      throw std::runtime_error(fmt::format("the scene has no state for the reference {}", entry.path().string()));
  for (const auto& [file, stored] : recording.states) {
    if (!fs::exists(folder / file))
      throw std::runtime_error(fmt::format("there is no reference {} (--update writes it)", (folder / file).string()));
    const std::vector<StateFrame> reference = readStateFile((folder / file).string(), stored.state);
    const Comparison& comparison = result.states[file] =
        compare(reference, stored.frames, test.tolerance, *stored.state);
    if (!comparison.passed && result.failure.empty()) result.failure = file + ": " + comparison.failure;
  }
  for (const WatchedData& data : test.data) {
    const std::string file = data.fileName(), path = (folder / file).string();
    if (!fs::exists(path)) throw std::runtime_error(fmt::format("there is no reference {} (--update writes it)", path));
    const std::string failure = compareData(readData(path), recording.data.at(file), data.tolerance, result.data[file]);
    if (!failure.empty() && result.failure.empty()) result.failure = file + ": " + failure;
  }
}

/// `judge` fills the result; what it throws is the failure.
template <class Judge>
Result timed(const RegressionCase& test, Judge&& judge) {
  const auto start = std::chrono::steady_clock::now();
  Result result{.name = test.name, .failure = {}, .remark = {}, .seconds = 0, .states = {}, .data = {}};
  try {
    judge(result);
  } catch (const SceneError& error) {
    result.failure = "the scene does not load:\n" + error.diagnostics().text();
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Result runAndCompare(const RegressionCase& test, const fs::path& folder, Session& session, bool update) {
  return timed(test, [&](Result& result) {
    const Recording recording = runCase(test, session);
    if (update)
      writeReference(test, folder, recording);
    else
      compareWithReference(test, folder, recording, result);
  });
}

Result runForBits(const RegressionCase& test, StoredHashes& stored, Session& session, bool update) {
  return timed(test, [&](Result& result) {
    const Bits bits = bitsOfEveryRun(test, session);
    result.remark = update ? stored.store(test.name, bits) : stored.compare(test.name, bits);
  });
}

double worstError(const Result& result) {
  double worst = 0;
  for (const auto& [file, state] : result.states)
    worst =
        std::max({worst, state.position_error, state.position_l2_error, state.velocity_error, state.velocity_l2_error});
  for (const auto& [file, error] : result.data) worst = std::max(worst, error);
  return worst;
}

void print(const Result& result, bool update) {
  if (!result.failure.empty())
    fmt::print("FAILED  {}: {}\n", result.name, result.failure);
  else if (!result.remark.empty())
    fmt::print("passed  {} ({}, {:.2f} s)\n", result.name, result.remark, result.seconds);
  else if (update)
    fmt::print("updated {} ({:.2f} s)\n", result.name, result.seconds);
  else
    fmt::print("passed  {} (largest difference {:.2g}, {:.2f} s)\n", result.name, worstError(result), result.seconds);
  std::fflush(stdout);
}

Json toJson(const Result& result) {
  Json states = Json::object();
  for (const auto& [file, state] : result.states)
    states[file] = {{"passed", state.passed},
                    {"position_error", state.position_error},
                    {"position_l2_error", state.position_l2_error},
                    {"velocity_error", state.velocity_error},
                    {"velocity_l2_error", state.velocity_l2_error}};
  return {{"name", result.name},     {"passed", result.failure.empty()}, {"failure", result.failure},
          {"remark", result.remark}, {"seconds", result.seconds},        {"states", states},
          {"data", result.data}};
}

/// What a process of its own has found.
Result fromJson(const RegressionCase& test, const ChildEnd& end) {
  Result result{.name = test.name, .failure = end.failure, .remark = {}, .seconds = 0, .states = {}, .data = {}};
  if (!end.failure.empty()) return result;
  const Json json = Json::parse(end.text);
  result.failure = json["failure"], result.remark = json["remark"], result.seconds = json["seconds"];
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : INFINITY; };  // null: none
  for (const auto& [file, state] : json["states"].items())
    result.states[file] = {state["passed"].get<bool>(), {}, number(state["position_error"]),
                           number(state["position_l2_error"]), number(state["velocity_error"]),
                           number(state["velocity_l2_error"])};
  for (const auto& [file, error] : json["data"].items()) result.data[file] = number(error);
  return result;
}

void writeResults(const std::vector<Result>& results, const std::string& file) {
  Json json = Json::array();
  for (const Result& result : results) json.push_back(toJson(result));
  writeWholeFile(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::vector<JunitCase> junitCases(const std::vector<Result>& results) {
  std::vector<JunitCase> cases;
  for (const Result& result : results) cases.push_back({result.name, result.seconds, result.failure});
  return cases;
}

OptionList regressOptions() {
  OptionList options("options");
  options.add_options()  //
      ("update", "write the references (with --bits the hashes) instead of comparing")(
          "filter", po::value<std::string>()->value_name("TEXT"), "only cases whose name contains TEXT")  //
      ("bits",
       "compare every bit between runs with 1 and 2 threads, after a reset and from a checkpoint, and the stored hash")(
          "json", po::value<std::string>()->value_name("FILE"), "write all figures as JSON")  //
      ("tolerance", po::value<double>()->value_name("SHARE")->default_value(1e-3),
       "of SOFA's lists (*.regression-tests): the relative difference that passes")  //
      ("jobs", po::value<int>()->value_name("N")->default_value(1),
       "number of scenes at once, each in a separate process (not with --bits)")  //
      ("limit", po::value<double>()->value_name("SECONDS")->default_value(600),
       "the processor time of one scene in such a process")  //
      ("junit", po::value<std::string>()->value_name("FILE"), "write the results as JUnit's XML, for build servers");
  addSceneOptions(options);
  return options;
}

/// Before the cases take their time.
void checkReports(const RegressionList& list, const Values& values) {
  std::vector<FileUse> inputs{{required(values, "LIST", regress_manual), "the list"}}, outputs;
  for (const RegressionCase& test : list.cases) inputs.push_back({test.scene, "the case " + test.name});
  for (const char* option : {"json", "junit"})
    if (values.count(option)) outputs.push_back({values[option].as<std::string>(), std::string("--") + option, true});
  if (const auto sentence = overwriting(outputs, inputs)) throw UsageError(*sentence);
  for (const FileUse& output : outputs) checkWritable(output.path, output.is_replaced);
}

std::vector<Result> runList(const RegressionList& list, const Values& values) {
  const std::string filter = values.count("filter") ? values["filter"].as<std::string>() : "";
  const bool update = values.count("update") > 0, bits = values.count("bits") > 0;
  std::vector<Result> results;
  std::vector<RegressionCase> cases = list.cases;
  std::erase_if(cases, [&](const RegressionCase& test) { return test.name.find(filter) == std::string::npos; });
  const auto judge = [&](const RegressionCase& test, Session& one) {
    return runAndCompare(test, fs::path(list.reference_folder) / test.name, one, update);
  };
  const JobLimits limits = jobLimitsOf(values);
  if ((limits.at_once > 1 || bits) && !values.count("threads")) giveThreads(1);
  if (limits.at_once > 1 && !bits)
    runJobs(
        int(cases.size()), limits,
        [&](int i) {
          Session one;
          configure(one, values);
          return toJson(judge(cases[std::size_t(i)], one)).dump(-1, ' ', false, Json::error_handler_t::replace);
        },
        [&](int i, const ChildEnd& end) {
          results.push_back(fromJson(cases[std::size_t(i)], end));
          print(results.back(), update);
        });
  Session session;
  configure(session, values);
  std::optional<StoredHashes> stored;
  if (bits) stored.emplace(list.reference_folder + "/hashes");
  for (const RegressionCase& test : cases) {
    if (limits.at_once > 1 && !bits) break;
    results.push_back(bits ? runForBits(test, *stored, session, update) : judge(test, session));
    print(results.back(), update);
  }
  if (results.empty()) throw UsageError(fmt::format("--filter {}: no case of the list has that in its name", filter));
  if (bits && update) stored->write();
  return results;
}

CommandLine regressLine() { return {regress_manual, regressOptions(), {"LIST"}}; }

int regress(const Arguments& arguments) {
  const auto values = parseOptions(regressLine(), arguments);
  if (!values) return exit_done;
  if (const std::string file = required(*values, "LIST", regress_manual); isSofaList(file) || fs::is_directory(file))
    return regressSofaLists(file, *values);
  const RegressionList list = readRegressionList(required(*values, "LIST", regress_manual));
  const bool update = values->count("update") > 0;
  if (update && values->count("set"))
    throw UsageError("--update with --set would store a setting that is not in the list: add it to the list");
  if (values->count("bits") && values->count("threads"))
    throw UsageError("--bits compares runs with one and with two threads: leave --threads out");
  checkReports(list, *values);

  const std::vector<Result> results = runList(list, *values);
  const auto failed = std::ranges::count_if(results, [](const Result& result) { return !result.failure.empty(); });
  fmt::print("{} {}, {} failed\n", std::ssize(results) - failed, update ? "updated" : "passed", failed);
  if (values->count("json")) writeResults(results, (*values)["json"].as<std::string>());
  if (values->count("junit")) writeJunit("stroma regress", junitCases(results), (*values)["junit"].as<std::string>());
  return failed == 0 ? exit_done : exit_comparison_failed;
}

}  // namespace

const Subcommand regress_command{"regress", "run scenes and compare their states with stored ones", Group::checks,
                                 regress, regressLine};

}  // namespace stroma::command
