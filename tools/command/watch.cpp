// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma watch: runs a scene again whenever one of its files is saved. Each run is a process of its own, `stroma run`
// with the same options: whatever becomes of it, the watch goes on.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "tools/command/default_recording.h"
#include "tools/command/run_request.h"
#include "tools/command/session.h"
#include "tools/command/watched_files.h"
#include "tools/platform/process.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;
constexpr auto look_every = std::chrono::milliseconds(100), settles_in = std::chrono::milliseconds(60);

const Manual watch_manual{
    "stroma watch SCENE [options of stroma run]",
    "Runs a scene, and again whenever a file that it reads is saved: the scene, what it includes, meshes, tables, and\n"
    "the files of --replay, --restart and --module. Prints what each run says, and how the result differs from that "
    "of\n"
    "the run before. A save in the middle of a run ends it after its step and begins the next one. A scene with\n"
    "mistakes is told of and waited for.\n\n"
    "Ctrl-C, SIGTERM or SIGHUP ends the watch.\n\n"
    "Exit codes:\n"
    "  0    ended by one of these signals, which is how a watch ends\n"
    "  2    the options are wrong, or the scene is not there; nothing was run\n"
    "  With --times that of the last run",
    "  stroma watch liver.xml -n 200\n"
    "  stroma watch liver.xml --until 2 --set /liver/fem.method=polar --quiet\n"};

volatile std::sig_atomic_t ended = 0;

/// A folder of its own for what runs report; goes with it.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "stroma-watch-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error(fmt::format("{}: {}", name, std::strerror(errno)));
    folder_ = name;
  }
  Scratch(const Scratch&) = delete;
  ~Scratch() {
    std::error_code error;
    fs::remove_all(folder_, error);
  }
  std::string report() const { return (folder_ / "run.json").string(); }

 private:
  fs::path folder_;
};

/// One `stroma run`.
class RunningProcess {
 public:
  explicit RunningProcess(const Arguments& arguments) {
    Program program{{program_invocation_name, "run"}};
    program.words.insert(program.words.end(), arguments.begin(), arguments.end());
    program.file = "/proc/self/exe";  // this one, also where another one was put in its place
    program.signal_with_parent = SIGTERM;  // a watch that is killed leaves no run behind
    child_ = start(program);
  }
  RunningProcess(const RunningProcess&) = delete;
  ~RunningProcess() {
    if (code_) return;
    stop();
    ::waitpid(child_, nullptr, 0);
  }
  void stop() const { ::kill(child_, SIGTERM); }
  /// The exit code, as a shell gives it, or nothing while it runs.
  std::optional<int> code() {
    int status = 0;
    if (!code_ && ::waitpid(child_, &status, WNOHANG) == child_)
      code_ = exitCodeOfStatus(status);
    return code_;
  }

 private:
  pid_t child_ = 0;
  std::optional<int> code_;
};

/// JSON has no number for what overflowed: null.
double numberOf(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string measured(double value, const std::string& unit) {
  return std::isfinite(value) ? fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit) : "no finite number";
}

std::string change(double now, double before, const std::string& unit) {
  std::string text = fmt::format("{}, before {}", measured(now, unit), measured(before, unit));
  const double share = 100 * (now / before - 1);
  if (!(before > 0) || !std::isfinite(share)) return text;
  return text + fmt::format(" ({:+.{}f} %)", share, std::abs(share) < 9.95 ? 1 : 0);
}

void compareDisplacements(const Json& now, const Json& before) {
  for (const Json& state : now.at("greatest_displacements")) {
    const double distance = numberOf(state.at("distance"));
    const std::string unit = now.at("units").is_null() ? "" : now.at("units").at("length").get<std::string>();
    std::string text = measured(distance, unit);
    if (!before.is_null())
      for (const Json& other : before.at("greatest_displacements"))
        if (other.at("state") == state.at("state")) text = change(distance, numberOf(other.at("distance")), unit);
    fmt::print("greatest displacement of {}: {} at node {}\n", state.at("state").get<std::string>(), text,
               state.at("node").get<long>());
  }
}

/// What a run has found, beside what the run before it found (null: there is none).
void compare(const Json& now, const Json& before) {
  if (!before.is_null() && now.at("state_hash") == before.at("state_hash"))
    fmt::print("the result is the same, bit for bit\n");
  else
    compareDisplacements(now, before);
  if (before.is_null()) return;
  if (now.at("steps") != before.at("steps"))
    fmt::print("steps: {}, before {}\n", now.at("steps").get<long>(), before.at("steps").get<long>());
  const auto mean = [](const Json& report) { return numberOf(report.at("ms_per_step").at("mean")); };
  fmt::print("time per step: {}\n", change(mean(now), mean(before), "ms"));
}

class Watch {
 public:
  /// `beside`: files that the options name.
  Watch(std::string scene, Arguments arguments, std::vector<std::string> beside, long times)
      : scene_(std::move(scene)), arguments_(std::move(arguments)), beside_(std::move(beside)), times_(times) {
    takeInputs({});
    arguments_.push_back("--json=" + scratch_.report());
  }

  int run() {
    std::string why = "the first run";
    for (;;) {
      const int code = runOnce(why);
      if (ended) return exit_done;
      if (!was_stopped_ && ++made_ == times_) return code;
      why = was_stopped_ ? change_ : waitForChange();
      if (ended) return exit_done;
    }
  }

 private:
  /// Returns its exit code; a save in between stops it.
  int runOnce(const std::string& why) {
    fmt::print("==== {:%H:%M:%S}, {}: {}\n", fmt::localtime(std::time(nullptr)), scene_, why);
    std::fflush(stdout);
    // inputs that nobody knows of yet are among what the scene names
    std::vector<std::string> files = filesNamedBy(scene_);
    const FileStamps named(files), inputs = FileStamps(inputs_);
    was_stopped_ = false;
    std::error_code error;
    fs::remove(scratch_.report(), error);
    RunningProcess process(arguments_);
    bool is_told = false;  // a second signal would end it at once
    while (!process.code()) {
      std::this_thread::sleep_for(look_every);
      if (ended && !was_stopped_ && !std::exchange(is_told, true)) process.stop();
      if (was_stopped_ || ended || inputs.changed().empty()) continue;
      was_stopped_ = true;
      change_ = settled(inputs);
      fmt::print(stderr, "{}: the run ends after its step\n", change_);
      process.stop();
    }
    const int code = *process.code();
    tell(code);
    files.insert(files.end(), inputs_.begin(), inputs_.end());
    seen_ = FileStamps(is_known_ ? inputs_ : files);
    // as they were before the run; but what a run has written that cannot tell is no reason for another
    if (is_known_ || code == exit_bad_input) seen_.takeFrom(named);
    seen_.takeFrom(inputs);
    return code;
  }

  /// Reads the report of the run that has ended.
  void tell(int code) {
    std::ifstream stream(scratch_.report());
    const Json report = Json::parse(stream, nullptr, false);
    is_known_ = !report.is_discarded();
    if (!is_known_) {
      if (code > 128) fmt::print(stderr, "the run was ended by signal {}\n", code - 128);
      return;
    }
    try {
      takeInputs(report.value("inputs", std::vector<std::string>{}));
      if (was_stopped_ || ended) return;
      compare(report, before_);
      before_ = report;
    } catch (const Json::exception& error) {  // a run that tells less than this one understands ends no watch
      fmt::print(stderr, "the run's report cannot be compared: {}\n", error.what());
    }
  }

  void takeInputs(std::vector<std::string> of_run) {
    inputs_ = std::move(of_run);
    inputs_.push_back(scene_);
    inputs_.insert(inputs_.end(), beside_.begin(), beside_.end());
  }

  /// Editors write a file in several goes: what changed, once nothing changes any more.
  static std::string settled(const FileStamps& before) {
    const std::vector<std::string> files = before.files();
    FileStamps last(files);
    for (;;) {
      std::this_thread::sleep_for(settles_in);
      FileStamps now(files);
      if (now == last || ended) return before.changed();
      last = std::move(now);
    }
  }

  std::string waitForChange() {
    const std::size_t others = seen_.files().size() - 1;
    fmt::print("waiting for a save of {}{}; Ctrl-C ends\n", scene_,
               others > 0 ? fmt::format(" or {} other file{}", others, others == 1 ? "" : "s") : "");
    std::fflush(stdout);
    for (;;) {
      if (ended) return {};
      if (!seen_.changed().empty())
        if (std::string what = settled(seen_); !what.empty()) return what;
      std::this_thread::sleep_for(look_every);
    }
  }

  const std::string scene_;
  Arguments arguments_;
  const std::vector<std::string> beside_;
  const long times_;
  Scratch scratch_;
  std::vector<std::string> inputs_;  ///< of the last run that could tell, and those beside
  bool is_known_ = false;            ///< the last run could
  FileStamps seen_;                  ///< what is waited for
  Json before_;                      ///< report of the last whole run
  bool was_stopped_ = false;         ///< the last run, by a save
  std::string change_;               ///< that save
  long made_ = 0;
};

Arguments withoutTimes(const Arguments& arguments) {
  Arguments kept;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--times")
      ++i;
    else if (!arguments[i].starts_with("--times="))
      kept.push_back(arguments[i]);
  }
  return kept;
}

/// Each run is to start from what the first one started from.
void checkRestart(const RunRequest& request) {
  const std::string folder = request.recordsIn() ? request.record_folder : lastFolder(request.scene);
  std::error_code error;
  const bool is_replaced = fs::equivalent(request.restart_file, fs::path(folder) / "last.checkpoint", error);
  if (!is_replaced || request.no_record) return;
  throw UsageError(fmt::format("--restart {}: the first run would replace it (expected a copy with another name)",
                               request.restart_file));
}

CommandLine watchLine() {
  CommandLine line{watch_manual, OptionList("options"), {"SCENE"}};
  line.options.add_options()("times", po::value<long>()->value_name("K"),
                             "end after K runs, not including those stopped by a save");
  addRunOptions(line.options);
  addSceneOptions(line.options);
  return line;
}

int watch(const Arguments& arguments) {
  const auto values = parseOptions(watchLine(), arguments);
  if (!values) return exit_done;
  const std::string scene = required(*values, "SCENE", watch_manual);
  const RunRequest request(*values);
  for (const char* option : {"json", "resume"})
    if (values->count(option))
      throw UsageError(fmt::format("--{}: a watched scene is run from its start, for people to read", option));
  const long times = values->count("times") ? (*values)["times"].as<long>() : -1;
  if (times == 0 || times < -1) throw UsageError(fmt::format("--times {}: expected 1 or more", times));
  if (!fs::exists(scene)) throw UsageError(scene + ": there is no such file");
  checkRestart(request);
  std::vector<std::string> beside = request.modules;
  for (const std::string& file : {request.replay_file, request.restart_file})
    if (!file.empty()) beside.push_back(file);
  struct sigaction action {};
  action.sa_handler = [](int) { ended = 1; };  // not restarted: sleeps end at once
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  struct sigaction before {};
  if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)  // nohup
    ::sigaction(SIGHUP, &action, nullptr);
  return Watch(scene, withoutTimes(arguments), std::move(beside), times).run();
}

}  // namespace

const Subcommand watch_command{"watch", "run a scene again whenever one of its files is saved", Group::runs, watch,
                               watchLine};

}  // namespace stroma::command
