// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma regress: runs the scenes of a list and compares every state, positions and velocities, with stored ones.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "framework/scene/output_file.h"
#include "tools/command/bits.h"
#include "tools/command/comparison.h"
#include "tools/command/junit.h"
#include "tools/command/regression_list.h"
#include "tools/command/session.h"
#include "tools/command/sofa_references.h"
#include "tools/command/sofa_runs.h"
#include "tools/session/file_uses.h"
#include "tools/session/statistics.h"

namespace po = boost::program_options;
namespace fs = std::filesystem;

namespace stroma::command {
namespace {

const Manual regress_manual{
    "stroma regress LIST [options]",
    "Runs every scene of a list and compares the positions and velocities of every state with stored ones at the "
    "start, "
    "three\ninstants between and the last. A case fails when a node differs by more than the tolerance times the size "
    "of "
    "the body, when\nthe relative L2 error exceeds the tolerance, at a number that is not finite, a missing reference, "
    "another size, name or time.\nLIST: the folder of the references on the first line, then lines `SCENE STEPS "
    "TOLERANCE [PATH.ATTR=VALUE ...] [unconverged]`; # starts a\ncomment; paths are relative to the list. A case also "
    "fails, and nothing of it is stored, when a solve ends before its\ntolerance, unless its line says `unconverged`. "
    "A reference that this "
    "program "
    "wrote proves only that nothing has changed.\nWith --bits nothing is compared with references: each scene runs "
    "with one thread, once more after a reset, from a\ncheckpoint in the middle and with two threads, and every bit of "
    "every step must be the same; the hash of the last one must be\nthe stored one, where one is stored for this "
    "compiler and instruction set.",
    "  stroma regress scenes/regression/list\n  stroma regress scenes/regression/list --filter cantilever --update\n"
    "  stroma regress scenes/regression/list --bits\n"};

using Json = nlohmann::ordered_json;
using Recording = std::map<std::string, std::vector<StateFrame>>;  ///< frames by file name of the state

struct Result {
  std::string name, failure;
  std::string remark;  ///< what --bits has to say of a case that passed
  double seconds = 0;
  std::map<std::string, Comparison> states;
};

std::set<long> storedSteps(long steps) { return {0, steps / 4, steps / 2, 3 * steps / 4, steps}; }

std::vector<Vec3> points(ConstRows rows) {
  std::vector<Vec3> out;
  for (Index i = 0; i < rows.count; ++i) out.emplace_back(rows[i]);
  return out;
}

void store(const Simulation& simulation, Recording& recording) {
  for (const State* state : simulation.states())
    recording[stateFileName(state->path())].push_back(
        {.time = simulation.time(), .x0 = {}, .x = points(state->x()), .v = points(state->v()), .f = {}});
}

/// Runs the scene without its observers: a regression run leaves no files behind.
Recording runCase(const RegressionCase& test, Session& session) {
  Simulation& simulation = session.load(test.scene, parseOverrides(test.overrides));
  simulation.dropObservers();
  const std::set<long> stored = storedSteps(test.steps);
  Recording recording;
  store(simulation, recording);
  RunStatistics statistics;
  while (simulation.steps() < test.steps) {
    const StepReport report = simulation.step();
    if (report.diverged) throw std::runtime_error("diverged: " + report.reason);
    if (!report.constraints_converged) throw std::runtime_error("not converged: " + report.constraint_reason);
    statistics.add(report, 0);
    if (stored.count(simulation.steps())) store(simulation, recording);
  }
  if (!statistics.unconverged.none() && !test.accepts_unconverged)
    throw std::runtime_error(fmt::format("{}; or write unconverged behind the case: its answer is then taken as it is",
                                         fmt::join(statistics.unconverged.warnings(), "; ")));
  if (recording.empty()) throw std::runtime_error("the scene has no state that moves: there is nothing to compare");
  return recording;
}

void writeReference(const fs::path& folder, const Recording& recording) {
  fs::remove_all(folder);
  for (const auto& [file, frames] : recording) {
    StateWriter writer((folder / file).string());
    for (const StateFrame& frame : frames) {
      writer.time(frame.time);
      writer.rows("X", frame.x);
      writer.rows("V", frame.v);
    }
    writer.close();
  }
}

void compareWithReference(const RegressionCase& test, const fs::path& folder, const Recording& recording,
                          Result& result) {
  if (!fs::is_directory(folder))
    throw std::runtime_error(fmt::format("there is no reference {} (--update writes it)", folder.string()));
  for (const auto& entry : fs::directory_iterator(folder))
    if (!recording.count(entry.path().filename().string()))
      throw std::runtime_error(fmt::format("the scene has no state for the reference {}", entry.path().string()));
  for (const auto& [file, frames] : recording) {
    const fs::path reference = folder / file;
    if (!fs::exists(reference))
      throw std::runtime_error(fmt::format("there is no reference {} (--update writes it)", reference.string()));
    const Comparison& comparison = result.states[file] =
        compare(readStateFile(reference.string()), frames, test.tolerance);
    if (!comparison.passed && result.failure.empty()) result.failure = file + ": " + comparison.failure;
  }
}

/// `judge` fills the result; what it throws is the failure.
template <class Judge>
Result timed(const RegressionCase& test, Judge&& judge) {
  const auto start = std::chrono::steady_clock::now();
  Result result{.name = test.name, .failure = {}, .remark = {}, .seconds = 0, .states = {}};
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
      writeReference(folder, recording);
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
          {"remark", result.remark}, {"seconds", result.seconds},        {"states", states}};
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
      ("jobs", po::value<int>()->value_name("N")->default_value(1), "of SOFA's lists: how many scenes at once")  //
      ("limit", po::value<double>()->value_name("SECONDS")->default_value(600), "of SOFA's lists: the time of one scene")  //
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
  Session session;
  configure(session, values);
  std::optional<StoredHashes> stored;
  if (bits) stored.emplace(list.reference_folder + "/hashes");
  std::vector<Result> results;
  for (const RegressionCase& test : list.cases) {
    if (test.name.find(filter) == std::string::npos) continue;
    results.push_back(bits ? runForBits(test, *stored, session, update)
                           : runAndCompare(test, fs::path(list.reference_folder) / test.name, session, update));
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
  if (const std::string file = required(*values, "LIST", regress_manual); isSofaList(file))
    return regressSofaList(file, *values);
  const RegressionList list = readRegressionList(required(*values, "LIST", regress_manual));
  const bool update = values->count("update") > 0;
  if (update && values->count("set"))
    throw UsageError("--update with --set would store what the list does not say: write the setting into the list");
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
