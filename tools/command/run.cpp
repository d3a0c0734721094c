// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma run: load, step, record, report.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>

#include "framework/scene/output_file.h"
#include "framework/simulation/long_work.h"
#include "tools/command/measured_end.h"
#include "tools/command/progress.h"
#include "tools/command/recorder.h"
#include "tools/command/run_outcome.h"
#include "tools/command/session.h"
#include "tools/command/statistics.h"

namespace stroma::command {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// The session that signals stop, and the signal that did.
std::atomic<Session*> interruptible = nullptr;
volatile std::sig_atomic_t stopped_by = 0;

void stopOnSignals(Session& session) {
  interruptible = &session;
  for (const int signal : {SIGINT, SIGTERM})
    std::signal(signal, [](int number) {
      stopped_by = number;
      interruptible.load()->requestStop();
    });
}

/// When a checkpoint is due.
class CheckpointClock {
 public:
  explicit CheckpointClock(const RunRequest& request) : request_(request) {}
  bool isDue(long steps) {
    const bool by_steps = request_.checkpoint_every > 0 && steps % request_.checkpoint_every == 0;
    const bool by_time = request_.checkpoint_seconds > 0 && secondsSince(last_) >= request_.checkpoint_seconds;
    if (by_time) last_ = Clock::now();
    return by_steps || by_time;
  }

 private:
  const RunRequest& request_;
  Clock::time_point last_ = Clock::now();
};

/// What the run does again.
struct Replay {
  std::size_t before = 0, all = 0;  ///< those that a checkpoint has behind it; all of the file

  std::size_t made(const Simulation& simulation) const { return simulation.replayed() - before; }
  std::size_t later(const Simulation& simulation) const { return all - simulation.replayed(); }
  std::string text(const Simulation& simulation) const {
    const auto actions = [](std::size_t count) { return fmt::format("{} action{}", count, count == 1 ? "" : "s"); };
    std::string text = "replayed " + actions(made(simulation));
    if (before > 0) text += fmt::format("; {} before the checkpoint", before);
    if (later(simulation) > 0) text += fmt::format("; the run ended before {} more", later(simulation));
    return text;
  }
};

std::optional<Replay> beginReplay(const RunRequest& request, Simulation& simulation) {
  if (request.replay_file.empty()) return {};
  RecordedActions actions = readActions(request.replay_file);
  const std::string scene = std::filesystem::path(request.scene).filename().string();
  if (actions.scene != scene && !request.quiet)
    fmt::print(stderr, "note: {} was recorded with the scene {}\n", request.replay_file, actions.scene);
  Replay replay;
  replay.all = actions.events.size();
  simulation.replay(std::move(actions.events), request.replay_file);
  replay.before = simulation.replayed();
  return replay;
}

Outcome loop(Session& session, long steps, const RunRequest& request, Recorder* recorder, bool goes_on) {
  const Simulation& simulation = session.simulation();
  stopOnSignals(session);
  if (recorder && goes_on) recorder->goOn();
  session.simulation().begin();
  // a run that starts anew replaces files that the checkpoint of the run before counts on: that one goes first
  if (recorder && !goes_on) recorder->dropCheckpoint();
  if (recorder) recorder->write();
  Progress progress(steps, request.quiet);
  CheckpointClock checkpoints(request);
  RunLimits limits;
  limits.steps = std::max(0L, steps - simulation.steps());
  limits.after_step = [&](const StepReport& report, double) {
    if (recorder) recorder->write();
    if (recorder && report.constraints_converged && checkpoints.isDue(simulation.steps())) recorder->writeCheckpoint();
    progress.show(simulation, report);
  };
  Outcome outcome;
  static_cast<RunReport&>(outcome) = session.run(limits);
  outcome.signal = stopped_by;
  progress.finish();
  return outcome;
}

/// What can be written is, whatever else cannot.
template <class Write>
void attempt(Outcome& outcome, Write&& write) {
  try {
    write();
  } catch (const OutputError& error) {
    outcome.failures.emplace_back(error.what());
  }
}

nlohmann::ordered_json toJson(const Energies& energies) {
  return {{"kinetic", energies.kinetic}, {"elastic", energies.elastic}, {"gravity", energies.gravity}};
}

/// Ends all files. `recorder` is made for a run without a result when there was none.
void finish(Session& session, const RunRequest& request, std::optional<Recorder>& recorder, Outcome& outcome) {
  if (outcome.end == RunEnd::output_failed) outcome.failures.push_back(outcome.reason);
  attempt(outcome, [&] {
    if (outcome.failed() && !recorder) recorder.emplace(session, divergedFolder(request.scene), 1);
  });
  // the checkpoint comes before what observers write at the very end: a run that goes on does not have it
  // to go on from a state that is no result would make it look like one
  const bool may_go_on = outcome.failures.empty() && outcome.end != RunEnd::not_converged;
  if (recorder) attempt(outcome, [&] { recorder->finish(may_go_on); });
  attempt(outcome, [&] { session.finish(); });
  if (outcome.failed())
    tellFailure(outcome, session.simulation(), recorder ? recorder->files() : std::vector<std::string>{"no file"});
}

int run(const Arguments& arguments) {
  const auto start = Clock::now();
  const auto values = parseRunOptions(arguments);
  if (!values) return exit_done;
  const RunRequest request(*values);
  tellLongWork(!request.quiet);
  Session session;
  configure(session, *values);
  Simulation& simulation = session.load(request.scene);
  simulation.computeOnDemand(true);
  std::vector<std::string> warnings = reportProblems(simulation.scene(), request.quiet);
  if (!request.measure_file.empty()) simulation.dropObservers();
  std::optional<MeasuredQuantity> measured;
  if (!request.measured_quantity.empty()) measured.emplace(simulation, request.measured_quantity);
  const std::string checkpoint = request.checkpointToGoOnFrom();
  if (request.resume && checkpoint.empty() && !request.quiet)
    fmt::print(stderr, "note: there is no checkpoint in {} yet: the run starts anew\n", request.record_folder);
  if (!checkpoint.empty())
    for (const std::string& note : session.restore(checkpoint)) fmt::print(stderr, "note: {}\n", note);
  const std::optional<Replay> replay = beginReplay(request, simulation);
  const long steps = request.stepsOf(session);
  checkOutputs(request, simulation);
  const double load_seconds = secondsSince(start);

  const bool wants_json = !request.json_file.empty();
  const Energies at_start = wants_json ? energiesOf(simulation) : Energies{};
  std::optional<Recorder> recorder;
  if (request.recordsIn()) recorder.emplace(session, request.record_folder, request.record_every);
  Outcome outcome = loop(session, steps, request, recorder ? &*recorder : nullptr, !checkpoint.empty());
  finish(session, request, recorder, outcome);
  if (!request.measure_file.empty())
    attempt(outcome, [&] { writeMeasuredEnd(simulation, measured ? &*measured : nullptr, request.measure_file); });
  const bool doubts = tellWarnings(outcome.statistics, simulation.doubts(), warnings);
  outcome.doubted = request.strict && (doubts || !outcome.statistics.unconverged.none());
  if (wants_json) {
    auto json = summary(request, simulation, outcome);
    json["load_seconds"] = load_seconds;
    json["energies"] = {{"start", toJson(at_start)}, {"end", toJson(energiesOf(simulation))}};
    json["peak_memory_bytes"] = peakMemory();
    json["modules_opened"] = session.modules().opened();
    if (recorder) json["recorded"] = recorder->files();
    if (replay) json["replayed"] = {{"actions", replay->made(simulation)}, {"later", replay->later(simulation)}};
    json["warnings"] = warnings;
    attempt(outcome, [&] { writeJson(json, request.json_file); });
  }
  for (const std::string& failure : outcome.failures) fmt::print(stderr, "error: {}\n", failure);
  if (request.json_file != "-" && !request.quiet) {
    printSummary(request, simulation, outcome);
    if (replay) fmt::print("{}\n", replay->text(simulation));
  }
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);  // the session ends here
  return outcome.exitCode();
}

}  // namespace

const Subcommand run_command{"run", "simulate a scene", Group::runs, run, runLine};

}  // namespace stroma::command
