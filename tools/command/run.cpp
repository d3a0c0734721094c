// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma run: load, step, record, report.
#include <cstdio>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iterator>

#include "framework/scene/output_file.h"
#include "framework/scene/spans.h"
#include "tools/checks/result_doubts.h"
#include "tools/command/closed_pipes.h"
#include "tools/command/default_recording.h"
#include "tools/command/long_work.h"
#include "tools/command/measured_end.h"
#include "tools/command/progress.h"
#include "tools/command/recorder.h"
#include "tools/command/results.h"
#include "tools/command/run_outcome.h"
#include "tools/command/session.h"
#include "tools/command/solver_advice.h"
#include "tools/command/statistics.h"
#include "tools/command/termination.h"
#include "tools/profile/report.h"
#include "tools/session/action_file.h"
#include "tools/session/drop_readers.h"
#include "tools/session/file_uses.h"
#include "tools/session/replay.h"

namespace stroma::command {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// The session that signals stop, and the signal that did. The same signal a second time ends the process at once.
std::atomic<Session*> interruptible = nullptr;
volatile std::sig_atomic_t stopped_by = 0;

void stop(int number) {
  if (stopped_by == number) endBy(number);
  stopped_by = number;
  interruptible.load()->requestStop();
}

void stopOnSignals(Session& session) {
  interruptible = &session;
  onTermination([] { stop(SIGTERM); });
  std::signal(SIGINT, stop);
  if (std::signal(SIGHUP, stop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
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

  std::size_t made(const Simulation& simulation) const { return replayed(simulation) - before; }
  std::size_t later(const Simulation& simulation) const { return all - replayed(simulation); }
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
  stroma::replay(simulation, std::move(actions.events), request.replay_file);
  replay.before = replayed(simulation);
  return replay;
}

/// What the run keeps of its instants: --record, or what every run leaves.
struct Recordings {
  std::optional<Recorder> named;
  std::optional<DefaultRecording> last;
  bool is_last_written = false;

  Recordings(Session& session, const RunRequest& request, long steps) {
    if (request.recordsIn()) named.emplace(session, request.record_folder, request.record_every);
    if (request.leavesLast()) last.emplace(session, request, steps);
  }
  void begin(bool goes_on) {
    // a new run replaces files that the checkpoint of the previous run depends on: that checkpoint is removed first
    if (named && !goes_on) named->dropCheckpoint();
    if (named) named->write();
    if (last) last->begin();
  }
  void stepMade(const StepReport& report, double seconds) {
    if (named) named->write();
    if (last) last->stepMade(report, seconds);
  }
  std::vector<std::string> files() const {
    if (named) return named->files();
    return is_last_written ? last->files() : std::vector<std::string>{};
  }
  /// A folder that can be looked at, or empty.
  std::string folder(const RunRequest& request) const {
    if (is_last_written) return last->folder();
    return named && !named->files().empty() && named->files().back().ends_with(".checkpoint") ? request.record_folder
                                                                                              : "";
  }
  /// Where the last state is, for tellFailure().
  std::string placeOfState() const {
    const auto all = files();
    if (!all.empty()) return fmt::format("is in {}", fmt::join(all, ", "));
    if (!last) return "is in no file (--no-record)";
    return "is in no file" + (last->reason().empty() ? "" : ": " + last->reason() + last->rest());
  }
};

Outcome loop(Session& session, long steps, const RunRequest& request, Recordings& recordings, Progress& progress,
             bool goes_on) {
  const Simulation& simulation = session.simulation();
  Recorder* recorder = recordings.named ? &*recordings.named : nullptr;
  if (recorder && goes_on) recorder->goOn();
  session.simulation().begin();
  recordings.begin(goes_on);
  CheckpointClock checkpoints(request);
  RunLimits limits;
  limits.steps = std::max(0L, steps - simulation.steps());
  limits.after_step = [&](const StepReport& report, double seconds) {
    recordings.stepMade(report, seconds);
    if (recorder && report.constraints_converged && checkpoints.isDue(simulation.steps())) recorder->writeCheckpoint();
    progress.stepMade(simulation, report);
  };
  progress.begin(simulation, steps);
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

/// Ends all files.
void finish(Session& session, const RunRequest& request, Recordings& recordings, Outcome& outcome) {
  if (outcome.end == RunEnd::output_failed) outcome.failures.push_back(outcome.reason);
  // to go on from a state that is no result would make it look like one
  const bool may_go_on = outcome.failures.empty() && outcome.end != RunEnd::not_converged;
  // the checkpoint comes before what observers write at the very end: a run that goes on does not have it
  if (recordings.named) attempt(outcome, [&] { recordings.named->finish(may_go_on); });
  if (recordings.last) recordings.is_last_written = recordings.last->write(outcome.failed(), may_go_on);
  attempt(outcome, [&] { session.finish(); });
  if (outcome.failed()) return tellFailure(outcome, session.simulation(), recordings.placeOfState());
  if (recordings.last && !recordings.last->reason().empty() && !request.quiet)
    fmt::print(stderr, "note: no recording is left: {}{}\n", recordings.last->reason(),
               recordings.last->rest());
}

/// A scene that is ready for its first step.
struct Run {
  const RunRequest& request;
  Session session{};
  std::string checkpoint{};  ///< that it goes on from, or empty
  std::optional<Replay> replay{};
  std::optional<MeasuredQuantity> measured{};
  std::vector<std::string> warnings{}, coarse{}, damped{};
  long steps = 0;
  double load_seconds = 0;

  ~Run() {
    const Span span("put away");
    session.unload();
  }
  void load(const Values& values, Progress& progress) {
    const auto start = Clock::now();
    configure(session, values);
    Simulation& simulation = session.load(request.scene);
    progress.loaded();
    simulation.computeOnDemand(true);
    std::ranges::move(reportProblems(simulation.scene(), request.quiet), std::back_inserter(warnings));
    if (!request.measure_file.empty()) checkMeasurable(simulation), dropReaders(simulation);
    if (!request.measured_quantity.empty()) measured.emplace(simulation, request.measured_quantity);
    if (!measured) session.followMeshChanges();
    if (measured && measured->mayFollow())
      session.followMeshChanges([this](const NodesNow& now) { measured->follow(session.simulation(), now); });
    checkpoint = request.checkpointToGoOnFrom();
    if (request.resume && checkpoint.empty() && !request.quiet)
      fmt::print(stderr, "note: there is no checkpoint in {} yet: the run starts from the beginning\n", request.record_folder);
    if (!checkpoint.empty())
      for (const std::string& note : session.restore(checkpoint)) fmt::print(stderr, "note: {}\n", note);
    if (!checkpoint.empty() && measured && measured->choosesNodes() && session.simulation().hasChangedMeshes())
      throw UsageError(fmt::format("--measure-value {}: nodes have other numbers in the changed mesh of {} than in the scene's files",
                                   request.measured_quantity, checkpoint));
    replay = beginReplay(request, simulation);
    steps = request.stepsOf(session);
    if (steps < simulation.steps() && !request.quiet)
      fmt::print(stderr,
                 "note: the checkpoint is that of step {}: up to step {} there is nothing to do (-n and --until are those of "
                 "the whole run)\n",
                 simulation.steps(), steps);
    checkOutputs(request, simulation);
    load_seconds = secondsSince(start);
  }
  nlohmann::ordered_json json(const Outcome& outcome, const Energies& at_start, const Recordings& recordings) {
    const Simulation& simulation = session.simulation();
    auto json = summary(request, simulation, outcome);
    json["load_seconds"] = load_seconds;
    json["energies"] = {{"start", toJson(at_start)}, {"end", toJson(energiesOf(simulation))}};
    json["peak_memory_bytes"] = peakMemory();
    json["modules_opened"] = session.modules().opened();
    if (const auto files = recordings.files(); !files.empty()) json["recorded"] = files;
    json["results"] = resultsOf(simulation, recordings.folder(request)).json();
    for (const FileUse& input : inputsOf(simulation.scene())) json["inputs"].push_back(input.path);
    if (replay) json["replayed"] = {{"actions", replay->made(simulation)}, {"later", replay->later(simulation)}};
    json["warnings"] = warnings;
    json["advice"] = outcome.advice;
    if (!outcome.unexpected.empty()) json["not_as_expected"] = outcome.unexpected;
    json["coarse_meshes"] = coarse;
    json["damped_swings"] = damped;
    return json;
  }
  void print(const Outcome& outcome, const Recordings& recordings) const {
    printSummary(request, session.simulation(), outcome);
    if (replay) fmt::print("{}\n", replay->text(session.simulation()));
    resultsOf(session.simulation(), recordings.folder(request)).print();
  }
};

int runScene(const RunRequest& request, const Values& values) {
  hearTermination();
  outliveReaders();
  tellLongWork(!request.quiet);
  Run run{request};
  Progress progress(request.scene, request.quiet, [] { return stopped_by != 0; });
  const LateProblems late([&](const Problem& problem) {
    if (problem.severity == Severity::warning) run.warnings.push_back(problem.text());
    if (problem.severity != Severity::note || !request.quiet) progress.print(problem.text());
  });
  {
    const Span span("load");
    run.load(values, progress);
  }
  const bool wants_json = !request.json_file.empty();
  const Energies at_start = wants_json ? energiesOf(run.session.simulation()) : Energies{};
  Recordings recordings(run.session, request, run.steps);
  stopOnSignals(run.session);
  Outcome outcome = [&] {
    const Span span("run");
    return loop(run.session, run.steps, request, recordings, progress, !run.checkpoint.empty());
  }();
  const Span span("end");
  finish(run.session, request, recordings, outcome);
  if (!request.measure_file.empty())
    attempt(outcome, [&] {
      writeMeasuredEnd(run.session.simulation(), run.measured ? &*run.measured : nullptr, request.measure_file);
    });
  if (outcome.end == RunEnd::done) tellExpectations(run.session.simulation(), request.quiet, outcome);
  std::vector<std::string> found = doubtsOf(run.session.simulation());
  std::ranges::copy(run.session.meshNotes(), std::back_inserter(found));
  if (!outcome.failed()) std::ranges::move(refusedFromHere(run.session.simulation()), std::back_inserter(found));
  const bool doubts = tellWarnings(outcome.statistics, found, run.warnings);
  if (!outcome.failed()) {
    outcome.advice = solverAdvice(run.session.simulation(), outcome.statistics);
    run.coarse = tellMeshErrors(run.session.simulation(), request.quiet);
    run.damped = tellDampedSwings(run.session.simulation(), request.quiet);
  }
  outcome.doubted = request.strict && (doubts || !outcome.statistics.unconverged.none());
  if (wants_json) attempt(outcome, [&] { writeJson(run.json(outcome, at_start, recordings), request.json_file); });
  for (const std::string& failure : outcome.failures) fmt::print(stderr, "error: {}\n", failure);
  if (request.json_file != "-" && !request.quiet) run.print(outcome, recordings);
  std::fflush(stdout);  // a signal from here on ends the process at once
  for (const int signal : {SIGHUP, SIGINT}) std::signal(signal, SIG_DFL);  // the session ends here
  onTermination({});
  return outcome.exitCode();
}

/// The same, heard by a profiler.
int runProfiled(const RunRequest& request, const Values& values) {
  profile::runAgainCounting();
  profile::Profiler profiler;
  int code = exit_done;
  {
    const Span span("command");
    code = runScene(request, values);
  }
  const profile::Profile profile = profiler.stop();
  writeWholeFile(request.profile_file, profile::traceOf(profile));
  if (!request.quiet) fmt::print(stderr, "{}", profile::tableOf(profile, request.profile_file));
  return code;
}

int run(const Arguments& arguments) {
  const auto values = parseRunOptions(arguments);
  if (!values) return exit_done;
  const RunRequest request(*values);
  return request.profile_file.empty() ? runScene(request, *values) : runProfiled(request, *values);
}

}  // namespace

const Subcommand run_command{"run", "simulate a scene", Group::runs, run, runLine};

}  // namespace stroma::command
