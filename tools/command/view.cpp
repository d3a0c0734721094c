// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma view: a scene, or a recorded run, in the browser.
#include <fmt/format.h>
#include <spawn.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "framework/scene/output_file.h"
#include "framework/scene/services.h"
#include "framework/simulation/file_uses.h"
#include "framework/simulation/run_events.h"
#include "tools/command/recorder.h"
#include "tools/command/session.h"
#include "tools/view/viewer.h"

extern char** environ;  // NOLINT: POSIX wants it declared so

namespace po = boost::program_options;
namespace fs = std::filesystem;

namespace stroma::command {
namespace {

const Manual manual{
    "stroma view SCENE|FOLDER [options]",
    "Shows a scene in the browser while it runs: turn, cut and colour it, pull at it, change attributes, plot, "
    "record.\n"
    "A folder that `stroma run --record` wrote is shown as it was recorded. The address is printed; whoever has it "
    "sees the\n"
    "run, and nobody else. Only this machine can, unless --host says otherwise. Ctrl-C ends it.\n\n"
    "--export FILE.html makes a page that plays a run by itself, without a server, and ends.",
    "  stroma view scenes/examples/organ.xml\n"
    "  stroma view organ.xml --paused --set /organ/fem.youngModulus=3000 --record results/pulled\n"
    "  stroma view results/pulled\n"
    "  stroma run organ.xml -n 500 --replay results/pulled/run.actions       the same run without a browser\n"
    "  stroma view organ.xml --export organ.html -n 200 --every 2 --field vonMises\n"};

OptionList viewOptions() {
  OptionList options("options");
  options.add_options()                                                                            //
      ("port", po::value<int>()->value_name("N"), "port to listen on; a free one when not given")  //
      ("host", po::value<std::string>()->value_name("ADDRESS"),
       "address to listen on instead of 127.0.0.1; others can then reach the run, unencrypted")    //
      ("open", "open the address with xdg-open")                                                   //
      ("no-open", "only print the address; without either it is opened where there is a display")  //
      ("paused", "wait until somebody presses run")                                                //
      ("fps", po::value<double>()->value_name("N"), "most pictures a second (60 when not given)")  //
      ("record", po::value<std::string>()->value_name("DIR"),
       "write positions and velocities of every state there, and what was done by hand")                          //
      ("record-every", po::value<long>()->value_name("K"), "record every K steps")                                //
      ("replay", po::value<std::string>()->value_name("FILE"), "do again what was done by hand in a run before")  //
      ("export", po::value<std::string>()->value_name("FILE.html"), "write a page that plays a run, and end")     //
      ("steps,n", po::value<long>()->value_name("STEPS"), "with --export: steps to run (100 when not given)")     //
      ("every", po::value<long>()->value_name("K"), "with --export: a picture every K steps")                     //
      ("field", po::value<std::vector<std::string>>()->value_name("NAME"),
       "with --export: keep this field of the cells, as vonMises; may be repeated")        //
      ("inside", "with --export: keep the inside of bodies too, so that they can be cut")  //
      ("quiet,q", "no notes");
  addSceneOptions(options);
  return options;
}

/// Whether an address can be reached from this machine only.
bool isLoopback(const std::string& host) { return host.starts_with("127.") || host == "localhost" || host == "::1"; }

template <class T>
T inRange(const Values& values, const char* option, T otherwise, T low, T high) {
  if (!values.count(option)) return otherwise;
  const T value = values[option].as<T>();
  if (!(value >= low && value <= high))
    throw UsageError(fmt::format("--{} {}: expected {} to {}", option, value, low, high));
  return value;
}

/// The scene of a recorded run, whose folder was named, and the folder; else the scene alone.
std::pair<std::string, std::string> sceneAndFolder(const std::string& given) {
  if (!fs::is_directory(given)) return {given, ""};
  const std::string checkpoint = (fs::path(given) / "last.checkpoint").string();
  if (!fs::exists(checkpoint))
    throw UsageError(fmt::format(
        "{}: there is no last.checkpoint, which names the scene (expected a folder of stroma run --record)", given));
  return {Checkpoint::read(checkpoint).scene, given};
}

/// Throws std::runtime_error when the folder has no recording that fits.
view::Recording recordingIn(const std::string& folder, const Simulation& simulation) {
  view::Recording recording;
  for (const State* state : simulation.states()) {
    const std::string file = (fs::path(folder) / stateFileName(state->path())).string();
    StateRecording one = readRecording(file);
    if (!one.unfinished.empty()) fmt::print(stderr, "warning: {}\n", one.unfinished);
    if (one.frames.empty()) throw UsageError(file + ": the file holds no instant");
    for (const StateFrame& frame : one.frames)
      if (Index(frame.x.size()) != state->size() || (!frame.v.empty() && frame.v.size() != frame.x.size()))
        throw UsageError(fmt::format("{}: at T = {:g} s there are {} positions (expected {}, as {} has nodes)", file,
                                     frame.time, frame.x.size(), state->size(), state->path()));
    recording.push_back(std::move(one.frames));
  }
  if (recording.empty()) throw UsageError("nothing in the scene moves: there is nothing to show");
  std::size_t least = recording.front().size();
  for (const auto& frames : recording) least = std::min(least, frames.size());
  for (auto& frames : recording) frames.resize(least);
  return recording;
}

/// Says so when it does not work; the address has been printed.
void openBrowser(const std::string& address) {
  std::string program = "xdg-open", text = address;
  char* arguments[] = {program.data(), text.data(), nullptr};
  pid_t child = 0;
  std::signal(SIGCHLD, SIG_IGN);
  if (posix_spawnp(&child, "xdg-open", nullptr, nullptr, arguments, environ) != 0)
    fmt::print(stderr, "note: there is no xdg-open: open the address by hand\n");
}

bool shouldOpen(const Values& values) {
  if (values.count("open") && values.count("no-open")) throw UsageError("--open and --no-open exclude each other");
  if (values.count("open")) return true;
  return !values.count("no-open") && (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY"));
}

/// Positions and actions of a viewed run; a reset starts them afresh.
class ViewRecording {
 public:
  ViewRecording(Session& session, std::string folder, long every)
      : session_(session), folder_(std::move(folder)), every_(every) {
    start();
  }
  void write() { recorder_->write(); }
  void start() {
    recorder_.emplace(session_, folder_, every_);
    recorder_->dropCheckpoint();
    recorder_->write();
  }
  void finish() {
    recorder_->finish(true);
    writeWholeFile((fs::path(folder_) / "run.actions").string(),
                   printActions({fs::path(session_.sceneFile()).filename().string(), session_.simulation().events()}));
  }

 private:
  Session& session_;
  std::string folder_;
  long every_;
  std::optional<Recorder> recorder_;
};

void checkRecording(const std::string& folder, const Simulation& simulation) {
  std::vector<FileUse> outputs = outputsOf(simulation);
  for (const std::string& file : recordedFiles(simulation, folder))
    outputs.push_back({file, "--record", file.ends_with(".checkpoint")});
  if (const auto sentence = overwriting(outputs, inputsOf(simulation.scene()))) throw UsageError(*sentence);
  for (const std::string& file : recordedFiles(simulation, folder)) checkWritable(file, file.ends_with(".checkpoint"));
}

int exportPage(const Values& values, Session& session, const view::Viewer& viewer) {
  view::ExportRequest request;
  request.file = values["export"].as<std::string>();
  request.steps = inRange<long>(values, "steps", 100, 0, 1L << 40);
  request.every = inRange<long>(values, "every", 1, 1, 1L << 40);
  if (values.count("field")) request.fields = values["field"].as<std::vector<std::string>>();
  request.inside = values.count("inside") > 0;
  viewer.writePage(session, request);
  session.finish();
  fmt::print("{} ({:.1f} MB): open it in a browser\n", request.file, double(fs::file_size(request.file)) / 1e6);
  return exit_done;
}

int serve(const Values& values, Session& session, view::ViewRequest& request, const view::Viewer& viewer) {
  const bool opens = shouldOpen(values), quiet = values.count("quiet") > 0;
  std::optional<ViewRecording> recording;
  std::string failure;
  if (values.count("record")) {
    if (!request.recording.empty()) throw UsageError("--record: a recording is not recorded again");
    const std::string folder = values["record"].as<std::string>();
    checkRecording(folder, session.simulation());
    recording.emplace(session, folder, inRange<long>(values, "record-every", 1, 1, 1L << 40));
    request.after_step = [&recording] { recording->write(); };
    request.after_reset = [&] { recording->start(), failure.clear(); };
  } else if (values.count("record-every")) {
    throw UsageError("--record-every needs --record DIR");
  } else {
    request.after_reset = [&failure] { failure.clear(); };
  }
  request.opened = [&](const std::string& address) {
    fmt::print("{}\n", address);
    std::fflush(stdout);
    if (!isLoopback(request.host))
      fmt::print(
          stderr,
          "warning: other machines can reach this run at {}, unencrypted: whoever sees the address on its way can "
          "steer it. A tunnel (ssh -L) is safer\n",
          request.host);
    if (!quiet) fmt::print(stderr, "Ctrl-C ends the view\n");
    if (opens) openBrowser(address);
  };
  request.ended = [&failure](const std::string& sentence) {
    failure = sentence;
    fmt::print(stderr, "the run has ended: {}\n", sentence);
  };
  viewer.view(session, request);
  if (recording) recording->finish();
  session.finish();
  const Simulation& simulation = session.simulation();
  if (request.recording.empty())
    fmt::print("{} steps, t = {:.6g} s, state {:016x}\n", simulation.steps(), simulation.time(),
               simulation.stateHash());
  return failure.empty() ? exit_done : exit_diverged;
}

}  // namespace

int view(const Arguments& arguments) {
  const auto values = parseOptions(manual, viewOptions(), {"SCENE"}, arguments);
  if (!values) return exit_done;
  const auto [scene, folder] = sceneAndFolder(required(*values, "SCENE", manual));
  view::ViewRequest request;
  if (values->count("host")) request.host = (*values)["host"].as<std::string>();
  request.port = inRange<int>(*values, "port", 0, 0, 65535);
  request.fps = inRange<double>(*values, "fps", 60, 0.1, 240);
  request.paused = values->count("paused") > 0;
  request.build = buildIdentity();
  const auto viewer = service<view::Viewer>();
  Session session;
  configure(session, *values);
  Simulation& simulation = session.load(scene);
  reportProblems(simulation.scene(), values->count("quiet") > 0);
  if (!folder.empty()) request.recording = recordingIn(folder, simulation);
  if (!folder.empty()) simulation.dropObservers();  // nothing is run, so nothing is to be written
  simulation.checkOutputs();
  if (values->count("replay")) {
    const std::string file = (*values)["replay"].as<std::string>();
    simulation.replay(readActions(file).events, file);
  }
  return values->count("export") ? exportPage(*values, session, *viewer) : serve(*values, session, request, *viewer);
}

}  // namespace stroma::command
