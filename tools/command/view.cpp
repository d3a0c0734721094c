// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma view: a scene, or a recorded run, in the browser.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <system_error>

#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "framework/simulation/run_events.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/command/shown_scene.h"
#include "tools/command/termination.h"
#include "tools/command/view_request.h"
#include "tools/platform/process.h"
#include "tools/session/action_file.h"
#include "tools/session/replay.h"
#include "tools/units/unit_system.h"

namespace stroma::command {
namespace {

/// Whether an address can be reached from this machine only.
bool isLoopback(const std::string& host) { return host.starts_with("127.") || host == "localhost" || host == "::1"; }

/// Says so when it does not work; the address has been printed.
void openBrowser(const std::string& address) try {
  start({{"xdg-open", address}});
} catch (const std::system_error&) {
  fmt::print(stderr, "note: there is no xdg-open: open the address by hand\n");
}

void tellAddress(const ViewCommand& command, const std::string& address) {
  fmt::print("{}\n", address);
  std::fflush(stdout);
  if (!isLoopback(command.live.host))
    fmt::print(stderr,
               "warning: other machines can reach this run at {}, unencrypted: whoever sees the address on its way can "
               "steer it. A tunnel (ssh -L) is safer\n",
               command.live.host);
  if ((command.live.host == "0.0.0.0" || command.live.host == "::") && !command.quiet)
    fmt::print(stderr, "from there, use one of this machine's addresses instead of {}\n",
               command.live.host == "::" ? "[::1]" : "127.0.0.1");
  if (!command.quiet) fmt::print(stderr, "Ctrl-C ends the view\n");
  if (command.opens) openBrowser(address);
}

/// Positions and actions of a viewed run; a reset starts them afresh.
class ViewRecording {
 public:
  /// Throws OutputError.
  ViewRecording(Session& session, const ViewCommand& command) : session_(session), command_(command) { start(); }

  /// An output that failed fails at each step until a reset has begun another one: the run ends.
  void write() {
    if (failure_) throw OutputError(*failure_);
    attempt([this] { recorder_->write(); });
  }
  /// The files of the run before are left as they are when those of this one cannot be opened.
  void start() {
    is_of_this_run_ = false;
    attempt([this] {
      auto next = std::make_unique<Recorder>(session_, command_.record_folder, command_.record_every);
      next->dropCheckpoint();
      fs::remove(command_.actionsFile());  // of the run before: it would repeat another one
      next->write();
      recorder_ = std::move(next);
      is_of_this_run_ = true;
    });
    failure_.reset();
  }
  /// Nothing follows what an output lacks: the files end before it, and have no checkpoint.
  void finish() {
    // what was done is whole whatever else could not be written; beside states of another run it would not belong
    if (is_of_this_run_)
      writeWholeFile(command_.actionsFile(), printActions({fs::path(session_.sceneFile()).filename().string(),
                                                           session_.simulation().events()}));
    if (failure_) throw OutputError(*failure_);
    recorder_->finish(true);
  }
  bool hasFailed() const { return failure_.has_value(); }

 private:
  template <class Act>
  void attempt(Act&& act) {
    try {
      act();
    } catch (const OutputError& error) {
      failure_.emplace(error);
      throw;
    }
  }

  Session& session_;
  const ViewCommand& command_;
  std::unique_ptr<Recorder> recorder_;
  std::optional<OutputError> failure_;
  bool is_of_this_run_ = false;  ///< what the folder has
};

/// How a view ended.
struct Ending {
  std::string no_result;            ///< why the run ended by itself, or empty
  std::vector<std::string> failed;  ///< a sentence for each output that could not be written

  template <class Write>
  void attempt(Write&& write) {
    try {
      write();
    } catch (const OutputError& error) {
      if (std::find(failed.begin(), failed.end(), error.what()) == failed.end()) failed.emplace_back(error.what());
    }
  }
  int exitCode() const {
    for (const std::string& sentence : failed) fmt::print(stderr, "error: {}\n", sentence);
    if (!no_result.empty()) return exit_diverged;
    return failed.empty() ? exit_done : exit_output_failed;
  }
};

int exportPage(const ViewCommand& command, Session& session, const view::Viewer& viewer) {
  Ending ending;
  ending.attempt([&] {
    const RunReport report = viewer.writePage(session, command.page);
    if (report.end == RunEnd::output_failed)
      ending.failed.push_back(report.reason);
    else if (report.end != RunEnd::done)
      ending.no_result = report.reason;
    else
      fmt::print("{} ({:.1f} MB): open it in a browser\n", command.page.file,
                 double(fs::file_size(command.page.file)) / 1e6);
  });
  ending.attempt([&] { session.finish(); });
  if (!ending.no_result.empty())
    fmt::print(stderr, "the run has no result to show: {}; {} was not written\n", ending.no_result, command.page.file);
  return ending.exitCode();
}

int serve(const ViewCommand& command, Session& session, const view::Viewer& viewer) {
  Ending ending;
  std::optional<ViewRecording> recording;
  view::ViewRequest request = command.live;
  if (!command.record_folder.empty()) {
    // not before: a port that is taken leaves the recording that is there
    request.listening = [&] { recording.emplace(session, command); };
    request.after_step = [&recording] { recording->write(); };
  }
  request.after_reset = [&] {
    ending = {};
    if (recording) recording->start();
  };
  request.opened = [&command](const std::string& address) { tellAddress(command, address); };
  request.output_failed = [&ending](const std::string& sentence) { ending.failed.push_back(sentence); };
  request.ended = [&](const std::string& sentence) {
    if (ending.failed.empty() && !(recording && recording->hasFailed())) ending.no_result = sentence;
    fmt::print(stderr, "the run has ended: {}\n", sentence);
  };
  onTermination([] { ::kill(::getpid(), SIGINT); });  // as Ctrl-C does
  viewer.view(session, request);
  onTermination({});
  if (recording) ending.attempt([&] { recording->finish(); });
  ending.attempt([&] { session.finish(); });
  const Simulation& simulation = session.simulation();
  if (!command.isRecording())
    fmt::print("{} steps, t = {:.6g}{}, state {:016x}\n", simulation.steps(), simulation.time(),
               unitsOf(simulation.scene()).behind("s"), simulation.stateHash());
  return ending.exitCode();
}

void beginReplay(const ViewCommand& command, Simulation& simulation) {
  if (command.replay_file.empty()) return;
  RecordedActions actions = readActions(command.replay_file);
  if (actions.scene != fs::path(command.scene).filename().string() && !command.quiet)
    fmt::print(stderr, "note: {} was recorded with the scene {}\n", command.replay_file, actions.scene);
  stroma::replay(simulation, std::move(actions.events), command.replay_file);
}

int view(const Arguments& arguments) {
  const auto values = parseViewOptions(arguments);
  if (!values) return exit_done;
  hearTermination();
  ViewCommand command(*values);
  command.live.build = buildIdentity();
  const auto viewer = service<view::Viewer>();
  Session session;
  configureAsRecorded(session, command.recorded, *values);
  Simulation& simulation = session.load(command.scene);
  reportProblems(simulation.scene(), command.quiet);
  if (command.isRecording()) {
    RecordedMeshes meshes = recordedMeshes(command.recording_folder);
    (command.exports ? command.page.recording : command.live.recording) =
        recordingIn(command.recording_folder, simulation, meshes);
    (command.exports ? command.page.meshes : command.live.meshes) = std::move(meshes);
  }
  // A view has no end of its own: exporters would fill the disk. A recording is not run, so nothing is to be written.
  if (command.isRecording() || !command.outputs)
    leaveOutputs(simulation, command.quiet || command.isRecording() ? "" : "in a view (--outputs)");
  beginReplay(command, simulation);
  checkOutputs(command, simulation);
  return command.exports ? exportPage(command, session, *viewer) : serve(command, session, *viewer);
}

}  // namespace

const Subcommand view_command{"view", "show a scene in the browser while it runs, and reach into it", Group::runs, view,
                              viewLine};

}  // namespace stroma::command
