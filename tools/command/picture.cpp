// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma picture: a scene, or a recorded run, as a PNG file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "tools/command/picture_request.h"
#include "tools/command/run_outcome.h"
#include "tools/command/session.h"
#include "tools/command/shown_scene.h"

namespace stroma::command {
namespace {

constexpr long usual_steps = 100, most_frames = 100;

using picture::PictureMaker;

/// The times that are to be drawn, in their order; each is given away once.
class Wanted {
 public:
  explicit Wanted(std::vector<AskedTime> times) : times_(std::move(times)) {
    if (times_.empty()) times_.push_back({AskedTime::Kind::end, 0});
  }
  bool takeStart(double now) {
    const bool asked =
        std::erase_if(times_, [](const AskedTime& one) { return one.kind == AskedTime::Kind::start; }) > 0;
    return takeReached(now) || asked;
  }
  bool takeReached(double now) {
    return std::erase_if(times_, [now](const AskedTime& one) {
             return one.kind == AskedTime::Kind::time && one.time <= now + 1e-9 * std::max(1., std::abs(now));
           }) > 0;
  }
  bool hasEnd() const {
    return std::any_of(times_.begin(), times_.end(),
                       [](const AskedTime& one) { return one.kind == AskedTime::Kind::end; });
  }
  /// The last time that is asked for by number and has not come; or nothing.
  std::optional<double> last() const {
    std::optional<double> last;
    for (const AskedTime& one : times_)
      if (one.kind == AskedTime::Kind::time) last = std::max(last.value_or(one.time), one.time);
    return last;
  }

 private:
  std::vector<AskedTime> times_;
};

RunLimits limitsOf(const PictureCommand& command, const Session& session) {
  RunLimits limits;
  limits.steps = command.steps.value_or(usual_steps);
  std::optional<double> until = command.until;
  const bool needs_end = command.at.empty() || Wanted(command.at).hasEnd();
  if (!command.steps && !until && !needs_end) until = Wanted(command.at).last().value_or(session.simulation().time());
  if (!until) return limits;
  try {
    limits.steps = session.stepsUntil(*until);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("--{} {}: {}", command.until ? "until" : "at", *until, error.what()));
  }
  return limits;
}

/// Why there is no result, or empty.
std::string run(const PictureCommand& command, Session& session, PictureMaker& maker) {
  const Simulation& simulation = session.simulation();
  RunLimits limits = limitsOf(command, session);
  const long every = command.every.value_or(std::max(1L, (limits.steps + most_frames - 1) / most_frames));
  Wanted wanted(command.at);
  long taken_at = -1;
  const auto take = [&] {
    if (taken_at != simulation.steps()) maker.take(simulation.time());
    taken_at = simulation.steps();
  };
  if (command.animates || wanted.takeStart(simulation.time())) take();
  limits.after_step = [&](const StepReport&, double) {
    if (command.animates ? simulation.steps() % every == 0 : wanted.takeReached(simulation.time())) take();
  };
  const RunReport report = session.run(limits);
  if (command.animates || wanted.hasEnd() || report.end != RunEnd::done) take();
  if (report.end != RunEnd::done) return report.reason;
  std::vector<std::string> warnings;
  tellWarnings(report.statistics, simulation.doubts(), warnings);
  if (const auto time = wanted.last(); time && !command.animates)
    throw UsageError(
        fmt::format("--at {}: the run ended at {:g} s (expected a larger -n or --until)", *time, simulation.time()));
  return {};
}

/// The number of the instant that is nearest to a time.
std::size_t instantAt(const AskedTime& asked, const std::vector<StateFrame>& frames) {
  if (asked.kind == AskedTime::Kind::start) return 0;
  if (asked.kind == AskedTime::Kind::end) return frames.size() - 1;
  const double slack = frames.size() > 1 ? frames[1].time - frames[0].time : 0;
  if (asked.time < frames.front().time - slack || asked.time > frames.back().time + slack)
    throw UsageError(fmt::format("--at {}: the recording goes from {:g} to {:g} s", asked.time, frames.front().time,
                                 frames.back().time));
  const auto nearest = std::min_element(frames.begin(), frames.end(), [&](const StateFrame& a, const StateFrame& b) {
    return std::abs(a.time - asked.time) < std::abs(b.time - asked.time);
  });
  return std::size_t(nearest - frames.begin());
}

void showRecording(const PictureCommand& command, Simulation& simulation, PictureMaker& maker) {
  const drawing::Recording recording = recordingIn(command.recording_folder, simulation);
  const std::vector<StateFrame>& frames = recording.front();
  std::vector<std::size_t> instants;
  if (command.animates) {
    const auto every = std::size_t(command.every.value_or(long(frames.size() + most_frames - 1) / most_frames));
    for (std::size_t i = 0; i < frames.size(); i += every) instants.push_back(i);
  } else {
    for (const AskedTime& asked : command.at) instants.push_back(instantAt(asked, frames));
    if (instants.empty()) instants.push_back(frames.size() - 1);
  }
  for (const std::size_t i : instants) {
    drawing::showInstant(simulation, recording, i);
    maker.take(frames[i].time);
  }
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
  maker->begin(simulation, command.look);
  std::string no_result;
  if (command.isRecording())
    showRecording(command, simulation, *maker);
  else
    no_result = run(command, session, *maker);
  if (!no_result.empty()) {
    fmt::print(
        stderr, "the run has no result to draw: {}{}\n", no_result,
        command.anyway ? "" : fmt::format("; {} was not written (--anyway draws the last good state)", command.file));
    if (!command.anyway) return exit_diverged;
    maker->warn(fmt::format("no result: the run ended at t = {:.4g} s", simulation.time()));
  }
  const int code = write(command, *maker);
  return no_result.empty() ? code : exit_diverged;
}

}  // namespace

const Subcommand picture_command{"picture", "draw a scene, or a recorded run, into a PNG file", Group::runs, picture,
                                 pictureLine};

}  // namespace stroma::command
