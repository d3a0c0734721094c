// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma picture: a scene, or a recorded run, as a PNG file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/checks/result_doubts.h"
#include "tools/command/picture_request.h"
#include "tools/command/run_outcome.h"
#include "tools/command/session.h"
#include "tools/command/shown_scene.h"
#include "tools/units/unit_system.h"

namespace stroma::command {
namespace {

constexpr long usual_steps = 100, most_intervals = 100;  // of a film, from frame to frame

using picture::PictureMaker;

/// The times that a picture shows, in the order of the panels, and which state each has been given.
class Wanted {
 public:
  explicit Wanted(const std::vector<AskedTime>& times) {
    for (const AskedTime& time : times) times_.push_back({time, {}});
    if (times_.empty()) times_.push_back({});
  }
  /// Gives a state to all that wait for it: those of a kind, and those whose time has come. False when there are none.
  bool give(std::size_t state, double now, double slack, std::optional<AskedTime::Kind> kind = {}) {
    bool given = false;
    for (auto& [asked, of] : times_) {
      const bool came = asked.kind == AskedTime::Kind::time ? asked.time <= now + slack : kind == asked.kind;
      if (of || !came) continue;
      of = state, given = true;
    }
    return given;
  }
  bool hasEnd() const {
    return std::any_of(times_.begin(), times_.end(),
                       [](const Panel& one) { return one.asked.kind == AskedTime::Kind::end; });
  }
  /// The last time that is asked for by number and has not come; or nothing.
  std::optional<double> last() const {
    std::optional<double> last;
    for (const auto& [asked, of] : times_)
      if (asked.kind == AskedTime::Kind::time && !of) last = std::max(last.value_or(asked.time), asked.time);
    return last;
  }
  /// The states that have been given, in the order of the panels.
  std::vector<std::size_t> order() const {
    std::vector<std::size_t> order;
    for (const Panel& one : times_)
      if (one.state) order.push_back(*one.state);
    return order;
  }

 private:
  struct Panel {
    AskedTime asked;
    std::optional<std::size_t> state{};
  };
  std::vector<Panel> times_;
};

long stepsUntil(const Session& session, double time, const char* option) {
  try {
    return session.stepsUntil(time);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("--{} {}: {}", option, time, error.what()));
  }
}

/// The steps to make. Throws UsageError when a time that is asked for lies before the start or behind the end.
RunLimits limitsOf(const PictureCommand& command, const Session& session) {
  RunLimits limits;
  long last = 0;
  for (const AskedTime& asked : command.at)
    if (asked.kind == AskedTime::Kind::time) last = std::max(last, stepsUntil(session, asked.time, "at"));
  const bool needs_end = command.at.empty() || Wanted(command.at).hasEnd();
  limits.steps = command.until ? stepsUntil(session, *command.until, "until")
                               : command.steps.value_or(!command.restart_file.empty() ? 0 : needs_end ? usual_steps : last);
  if (last > limits.steps)
    throw UsageError(fmt::format("--at {}: the run ends at {:g} (expected a larger -n or --until)",
                                 Wanted(command.at).last().value_or(0),
                                 session.simulation().time() + double(limits.steps) * session.simulation().dt()));
  return limits;
}

/// From frame to frame, of `intervals` steps or instants that make at most 100 of a film: 101 frames with the start.
long usualEvery(long intervals) { return std::max(1L, (intervals + most_intervals - 1) / most_intervals); }

/// Leads the picture maker through the changes of meshes.
class Shown {
 public:
  Shown(const PictureCommand& command, Session& session, PictureMaker& maker)
      : session_(session), maker_(maker), changes_(session.meshChanges()) {
    maker.begin(session.simulation(), command.look);
  }

  /// Takes the present state of the run.
  void takeRun() {
    if (changes_ != session_.meshChanges()) maker_.follow(session_.simulation());
    changes_ = session_.meshChanges();
    maker_.take(session_.simulation().time());
  }
  /// Takes an instant of a recording.
  void takeInstant(const drawing::Recording& recording, std::size_t instant, const Checkpoint* meshes) {
    Simulation& simulation = session_.simulation();
    if (meshes != meshes_) {
      if (meshes)
        session_.restore(*meshes, "the recording");
      else
        simulation.reset();
      maker_.follow(simulation);
    }
    meshes_ = meshes;
    drawing::showInstant(simulation, recording, instant);
    maker_.take(recording.front()[instant].time);
  }

 private:
  Session& session_;
  PictureMaker& maker_;
  long changes_ = 0;
  const Checkpoint* meshes_ = nullptr;
};

/// Why there is no result, or empty.
std::string run(const PictureCommand& command, Session& session, PictureMaker& maker, Shown& shown) {
  using Kind = AskedTime::Kind;
  const Simulation& simulation = session.simulation();
  RunLimits limits = limitsOf(command, session);
  const long every = command.every.value_or(usualEvery(limits.steps));
  const double slack = 1e-6 * simulation.dt();
  Wanted wanted(command.at);
  long taken_at = -1;
  const auto take = [&] {
    if (taken_at != simulation.steps()) shown.takeRun();
    taken_at = simulation.steps();
  };
  const auto takeWanted = [&](std::optional<Kind> kind = {}) {
    const std::size_t state = maker.taken() - (taken_at == simulation.steps() ? 1 : 0);
    if (wanted.give(state, simulation.time(), slack, kind)) take();
  };
  command.animates ? take() : takeWanted(Kind::start);
  limits.after_step = [&](const StepReport&, double) {
    if (!command.animates)
      takeWanted();
    else if (simulation.steps() % every == 0)
      take();
  };
  session.followMeshChanges();
  const RunReport report = session.run(limits);
  const bool is_whole = report.end == RunEnd::done;
  command.animates ? take() : takeWanted(Kind::end);
  std::vector<std::size_t> order = wanted.order();
  if (!is_whole && !command.animates && taken_at != simulation.steps()) {  // what --anyway draws
    take();
    order.push_back(maker.taken() - 1);
  }
  maker.arrange(order);
  if (!is_whole) return report.reason;
  std::vector<std::string> warnings;
  std::vector<std::string> doubts = doubtsOf(simulation);
  std::ranges::move(refusedFromHere(simulation), std::back_inserter(doubts));
  std::ranges::copy(session.meshNotes(), std::back_inserter(doubts));
  tellWarnings(report.statistics, doubts, warnings);
  if (const auto time = wanted.last(); time && !command.animates)
    throw UsageError(
        fmt::format("--at {}: the run ended at {:g} (expected a larger -n or --until)", *time, simulation.time()));
  return {};
}

/// The number of the instant that is nearest to a time.
std::size_t instantAt(const AskedTime& asked, const std::vector<StateFrame>& frames) {
  if (asked.kind == AskedTime::Kind::start) return 0;
  if (asked.kind == AskedTime::Kind::end) return frames.size() - 1;
  const double slack = frames.size() > 1 ? frames[1].time - frames[0].time : 0;
  if (asked.time < frames.front().time - slack || asked.time > frames.back().time + slack)
    throw UsageError(fmt::format("--at {}: the recording goes from {:g} to {:g}", asked.time, frames.front().time,
                                 frames.back().time));
  const auto nearest = std::min_element(frames.begin(), frames.end(), [&](const StateFrame& a, const StateFrame& b) {
    return std::abs(a.time - asked.time) < std::abs(b.time - asked.time);
  });
  return std::size_t(nearest - frames.begin());
}

void showRecording(const PictureCommand& command, const Simulation& simulation, const RecordedMeshes& meshes, Shown& shown) {
  const drawing::Recording recording = recordingIn(command.recording_folder, simulation, meshes);
  const std::vector<StateFrame>& frames = recording.front();
  std::vector<std::size_t> instants;
  if (command.animates) {
    const auto every = std::size_t(command.every.value_or(usualEvery(long(frames.size()) - 1)));
    for (std::size_t i = 0; i < frames.size(); i += every) instants.push_back(i);
    if (instants.back() + 1 != frames.size())
      instants.push_back(frames.size() - 1);  // as a run ends with its last state
  } else {
    for (const AskedTime& asked : command.at) instants.push_back(instantAt(asked, frames));
    if (instants.empty()) instants.push_back(frames.size() - 1);
  }
  for (const std::size_t i : instants) shown.takeInstant(recording, i, meshesAt(frames[i].time, meshes));
}

int listFields(const Simulation& simulation, const PictureMaker& maker) {
  for (const picture::FieldWord& field : maker.fields(simulation))
    fmt::print("{:14} {}{}\n", field.name, field.title,
               field.unit.empty() || field.unit == "-" ? "" : fmt::format(" [{}]", field.unit));
  fmt::print("{:14} bodies in colours of their own\n", "none");
  return exit_done;
}

int write(const PictureCommand& command, PictureMaker& maker) {
  const std::string bytes = command.animates ? maker.film(command.fps) : maker.still();
  try {
    writeWholeFile(command.file, bytes);
  } catch (const OutputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return exit_output_failed;
  }
  const std::string frames = command.animates ? fmt::format("{} frames, ", maker.taken()) : "";
  fmt::print("{}: {}, {}{:.0f} kB\n", command.file, maker.summary(), frames, std::ceil(double(bytes.size()) / 1e3));
  if (!command.quiet)
    for (const std::string& note : maker.notes()) fmt::print(stderr, "note: {}\n", note);
  return exit_done;
}

int picture(const Arguments& arguments) {
  const auto values = parsePictureOptions(arguments);
  if (!values) return exit_done;
  const PictureCommand command(*values);
  const auto maker = service<PictureMaker>();
  Session session;
  configureAsRecorded(session, command.recorded, *values);
  Simulation& simulation = session.load(command.scene);
  if (command.lists_fields) return listFields(simulation, *maker);
  reportProblems(simulation.scene(), command.quiet);
  leaveOutputs(simulation, command.quiet || command.isRecording() ? "" : "for a picture");
  checkOutputs(command, simulation);
  if (!command.restart_file.empty())
    for (const std::string& note : session.restore(command.restart_file))
      if (!command.quiet) fmt::print(stderr, "note: {}\n", note);
  RecordedMeshes meshes;
  Shown shown(command, session, *maker);
  std::string no_result;
  if (command.isRecording()) {
    meshes = recordedMeshes(command.recording_folder);
    showRecording(command, simulation, meshes, shown);
  } else {
    no_result = run(command, session, *maker, shown);
  }
  if (!no_result.empty()) {
    fmt::print(
        stderr, "the run has no result to draw: {}{}\n", no_result,
        command.anyway ? "" : fmt::format("; {} was not written (--anyway draws the last good state)", command.file));
    if (!command.anyway) return exit_diverged;
    maker->warn(fmt::format("no result: the run ended at t = {:.4g}{}", simulation.time(),
                            unitsOf(simulation.scene()).behind("s")));
  }
  const int code = write(command, *maker);
  return code != exit_done || no_result.empty() ? code : exit_diverged;
}

}  // namespace

const Subcommand picture_command{"picture", "draw a scene, or a recorded run, into a PNG file", Group::runs, picture,
                                 pictureLine};

}  // namespace stroma::command
