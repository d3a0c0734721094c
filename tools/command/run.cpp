// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma run: load, step, record, report.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>

#include "framework/algebra/parallel.h"
#include "framework/simulation/long_work.h"
#include "tools/command/progress.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/command/statistics.h"

namespace po = boost::program_options;

namespace stroma::command {
namespace {

constexpr long default_steps = 100;

const Manual manual{
    "stroma run SCENE [options]",
    "Simulates a scene: 100 steps unless -n or --until says otherwise. Progress and messages go to standard error,\n"
    "the summary to standard output. Ctrl-C ends the run after a whole step.\n\n"
    "--record leaves a checkpoint, DIR/last.checkpoint. The same command with --restart FILE goes on from one, with "
    "its\n"
    "time, step number and bits: -n and --until are those of the whole run, and the files of observers and recordings\n"
    "are continued where the checkpoint was written.\n\n"
    "Exit codes:\n"
    "  0    done\n"
    "  2    the scene or the options are wrong; nothing was written\n"
    "  3    no result: a step diverged, statics found no equilibrium, or a position constraint did not hold. The last\n"
    "       good state is recorded and named. With --strict also a result in doubt: elements inside out, a body that\n"
    "       burst, energy from nowhere\n"
    "  130  interrupted with Ctrl-C; what was recorded is complete",
    "  stroma run liver.xml -n 200\n"
    "  stroma run liver.xml --until 2 --set /liver/fem.method=polar --record results/liver --record-every 10\n"
    "  stroma run liver.xml -n 5000 --record out --checkpoint-every 100 --restart out/last.checkpoint\n"
    "  stroma run liver.xml -n 50 --json --quiet | python3 -m json.tool\n"};

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

OptionList runOptions() {
  OptionList options("options");
  options.add_options()                                                                                               //
      ("steps,n", po::value<long>()->value_name("STEPS"), "number of steps; 0 loads, compiles and records t = 0")     //
      ("until", po::value<double>()->value_name("T"), "run to this time [s] instead")                                 //
      ("record", po::value<std::string>()->value_name("DIR"), "write positions and velocities of every state there")  //
      ("record-every", po::value<long>()->value_name("K"),
       "record every K steps; the first and last instant always")                                              //
      ("checkpoint-every", po::value<long>()->value_name("K"), "write DIR/last.checkpoint every K steps too")  //
      ("restart", po::value<std::string>()->value_name("FILE"), "go on from a checkpoint of this scene")       //
      ("json", po::value<std::string>()->implicit_value("-")->value_name("FILE"),
       "print the summary as JSON; --json=FILE writes it to a file")    //
      ("strict", "a result in doubt is none: the exit code is then 3")  //
      ("quiet,q", "no progress, no notes");
  addSceneOptions(options);
  return options;
}

/// The run as the user asked for it.
struct Request {
  std::string scene, record_folder, restart_file, json_file;
  std::optional<long> steps;
  std::optional<double> until;
  long record_every = 1, checkpoint_every = 0;  ///< 0: never
  bool quiet = false, strict = false;

  explicit Request(const Values& values)
      : scene(required(values, "SCENE", manual)), quiet(values.count("quiet") > 0), strict(values.count("strict") > 0) {
    if (values.count("steps")) steps = values["steps"].as<long>();
    if (values.count("until")) until = values["until"].as<double>();
    if (values.count("record")) record_folder = values["record"].as<std::string>();
    if (values.count("json")) json_file = values["json"].as<std::string>();
    if (steps && until) throw UsageError("-n and --until exclude each other");
    if (steps && *steps < 0) throw UsageError(fmt::format("-n {}: expected 0 or more steps", *steps));
    if (values.count("restart")) restart_file = values["restart"].as<std::string>();
    readInterval(values, "record-every", record_every);
    readInterval(values, "checkpoint-every", checkpoint_every);
  }
  /// Of the whole run, those before a checkpoint included.
  long stepsOf(const Session& session) const {
    if (!until) return steps.value_or(default_steps);
    try {
      return session.simulation().steps() + session.stepsUntil(*until);
    } catch (const std::invalid_argument& error) {
      throw UsageError(fmt::format("--until {}: {}", *until, error.what()));
    }
  }

 private:
  void readInterval(const Values& values, const std::string& option, long& interval) const {
    if (!values.count(option)) return;
    if (record_folder.empty()) throw UsageError(fmt::format("--{} needs --record DIR", option));
    interval = values[option].as<long>();
    if (interval < 1) throw UsageError(fmt::format("--{} {}: expected 1 or more", option, interval));
  }
};

/// How the run ended, as the command tells it.
struct Outcome : RunReport {
  bool doubted = false;  ///< by a strict run
  bool interrupted() const { return end == RunEnd::stopped; }
  bool failed() const { return end == RunEnd::diverged || end == RunEnd::not_converged; }
  const char* word() const {
    switch (end) {
      case RunEnd::diverged:
        return "diverged";
      case RunEnd::stopped:
        return "interrupted";
      case RunEnd::not_converged:
        return "not converged";
      default:
        return doubted ? "in doubt" : "done";
    }
  }
};

/// The session that SIGINT stops.
std::atomic<Session*> interruptible = nullptr;

Outcome loop(Session& session, long steps, const Request& request, Recorder* recorder) {
  const Simulation& simulation = session.simulation();
  session.simulation().begin();
  if (recorder) recorder->write();
  Progress progress(steps, request.quiet);
  RunLimits limits;
  limits.steps = std::max(0L, steps - simulation.steps());
  limits.after_step = [&](const StepReport& report, double) {
    if (recorder && simulation.steps() % request.record_every == 0) recorder->write();
    if (request.checkpoint_every > 0 && simulation.steps() % request.checkpoint_every == 0) recorder->writeCheckpoint();
    progress.show(simulation, report);
  };
  interruptible = &session;
  std::signal(SIGINT, [](int) { interruptible.load()->requestStop(); });
  Outcome outcome{session.run(limits)};
  progress.finish();
  return outcome;
}

/// Where the recording of a run without a result goes when the user named no folder.
std::string divergedFolder(const std::string& scene) {
  return std::filesystem::path(scene).stem().string() + ".diverged";
}

nlohmann::ordered_json toJson(const Energies& energies) {
  return {{"kinetic", energies.kinetic}, {"elastic", energies.elastic}, {"gravity", energies.gravity}};
}

nlohmann::ordered_json summary(const Request& request, const Simulation& simulation, const Outcome& outcome) {
  nlohmann::ordered_json json;
  json["scene"] = request.scene;
  json["outcome"] = outcome.word();
  if (outcome.failed()) json["reason"] = outcome.reason;
  json["steps"] = simulation.steps();
  json["simulated_time"] = simulation.time() - simulation.root().root_time;
  json["wall_seconds"] = outcome.seconds;
  json["ms_per_step"] = timing(outcome.statistics);
  json["phase_seconds"] = phaseSeconds(simulation);
  json.update(solvers(outcome.statistics));
  json["threads"] = threads();
  json["state_hash"] = fmt::format("{:016x}", simulation.stateHash());
  return json;
}

void printText(const Request& request, const Simulation& simulation, const Outcome& outcome) {
  fmt::print("{}: {} after {} steps, t = {:.6g} s; {:.3g} s of wall time", request.scene, outcome.word(),
             simulation.steps(), simulation.time(), outcome.seconds);
  if (!outcome.statistics.step_ms.empty())
    fmt::print(", {:.3g} ms per step (median {:.3g}, p99 {:.3g})", outcome.statistics.meanMs(),
               outcome.statistics.quantileMs(0.5), outcome.statistics.quantileMs(0.99));
  if (outcome.statistics.divided_steps > 0)
    fmt::print("\n{} of the steps had to be divided, into up to {} parts", outcome.statistics.divided_steps,
               outcome.statistics.most_load_parts);
  fmt::print("\nstate hash {:016x}\n", simulation.stateHash());
}

void writeJson(const nlohmann::ordered_json& json, const std::string& file) {
  // file names need not be UTF-8; a byte that is not is replaced rather than losing the summary of a run
  const std::string text = json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (file == "-") {
    fmt::print("{}", text);
    return;
  }
  std::ofstream stream(file);
  if (!(stream << text).flush()) throw std::runtime_error(fmt::format("{}: cannot write", file));
}

/// Prints what a run's end gives reason to warn of and appends it to `warnings`, but for what the load has warned of
/// already. Whether there are doubts.
bool tellWarnings(const RunStatistics& statistics, const std::vector<std::string>& doubts,
                  std::vector<std::string>& warnings) {
  std::vector<std::string> found = statistics.warnings();
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

}  // namespace

int run(const Arguments& arguments) {
  const auto start = Clock::now();
  const auto values = parseOptions(manual, runOptions(), {"SCENE"}, arguments);
  if (!values) return exit_done;
  const Request request(*values);
  tellLongWork(!request.quiet);
  Session session;
  configure(session, *values);
  Simulation& simulation = session.load(request.scene);
  simulation.computeOnDemand(true);
  std::vector<std::string> warnings = reportProblems(simulation.scene(), request.quiet);
  if (!request.restart_file.empty())
    for (const std::string& note : session.restore(request.restart_file)) fmt::print(stderr, "note: {}\n", note);
  const long steps = request.stepsOf(session);
  const double load_seconds = secondsSince(start);

  const bool wants_json = !request.json_file.empty();
  const Energies at_start = wants_json ? energiesOf(simulation) : Energies{};
  std::optional<Recorder> recorder;
  if (!request.record_folder.empty()) recorder.emplace(session, request.record_folder, !request.restart_file.empty());
  Outcome outcome = loop(session, steps, request, recorder ? &*recorder : nullptr);

  if (outcome.failed()) {
    if (!recorder) recorder.emplace(session, divergedFolder(request.scene));
    fmt::print(stderr, "{}: {}\n", outcome.word(), outcome.reason);
  }
  if (recorder) recorder->finish();
  session.finish();
  if (recorder && outcome.failed())
    fmt::print(stderr, "the last {} (t = {:.6g} s) is in {}\n", outcome.last.diverged ? "good state" : "state",
               simulation.time(), fmt::join(recorder->files(), ", "));
  const bool doubts = tellWarnings(outcome.statistics, simulation.doubts(), warnings);
  outcome.doubted = request.strict && (doubts || !outcome.statistics.allConverged());
  if (wants_json) {
    auto json = summary(request, simulation, outcome);
    json["load_seconds"] = load_seconds;
    json["energies"] = {{"start", toJson(at_start)}, {"end", toJson(energiesOf(simulation))}};
    json["peak_memory_bytes"] = peakMemory();
    json["modules_opened"] = session.modules().opened();
    if (recorder) json["recorded"] = recorder->files();
    json["warnings"] = warnings;
    writeJson(json, request.json_file);
  }
  if (request.json_file != "-" && !request.quiet) printText(request, simulation, outcome);
  return outcome.interrupted() ? exit_interrupted : outcome.failed() || outcome.doubted ? exit_diverged : exit_done;
}

}  // namespace stroma::command
