// SPDX-License-Identifier: LGPL-2.1-or-later
// Start-up: the time of a whole process that loads and compiles a scene and makes no step.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>

#include "tools/bench/body.h"
#include "tools/bench/figures.h"

extern char** environ;

namespace stroma::bench {
namespace {

constexpr int processes = 15;
using Clock = std::chrono::steady_clock;

/// Runs `stroma run SCENE -n 0 --quiet` in `folder`, silent. Returns its wall time [s], negative when it failed.
double processSeconds(const std::string& scene, const std::string& folder) {
  std::string words[] = {programFolder() + "/stroma", "run", scene, "-n", "0", "--quiet"};
  char* arguments[std::size(words) + 1] = {};
  for (std::size_t i = 0; i < std::size(words); ++i) arguments[i] = words[i].data();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  for (int stream : {1, 2}) posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  const auto start = Clock::now();
  pid_t child = 0;
  int status = -1;
  if (posix_spawn(&child, arguments[0], &actions, nullptr, arguments, environ) == 0) waitpid(child, &status, 0);
  posix_spawn_file_actions_destroy(&actions);
  return status == 0 ? std::chrono::duration<double>(Clock::now() - start).count() : -1;
}

void time(benchmark::State& state, const std::string& scene) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / fmt::format("stroma-bench-{}", getpid());
  fs::create_directories(folder);
  const std::string path = fs::absolute(sceneFolder() + "/" + scene).string();
  for (auto _ : state) {
    const double seconds = processSeconds(path, folder.string());
    if (seconds < 0) {
      state.SkipWithError("the command did not end with exit code 0");
      break;
    }
    state.SetIterationTime(seconds);
  }
  fs::remove_all(folder);
}

void add(Catalogue& catalogue, const std::string& name, const std::string& scene, std::optional<double> target) {
  Figure figure;
  figure.name = name;
  figure.unit = "ms";
  figure.per_second = 1e3;
  figure.target = target;
  figure.wall = true;
  catalogue.add(figure, [scene](benchmark::State& state) { time(state, scene); })
      .UseManualTime()
      ->Iterations(1)
      ->Repetitions(processes);
}

}  // namespace

void addStartFigures(Catalogue& catalogue) {
  add(catalogue, "start of organ.xml", "examples/organ.xml", 30.0);
  add(catalogue, "start of cube.xml", "benchmarks/cube.xml", {});
}

}  // namespace stroma::bench
