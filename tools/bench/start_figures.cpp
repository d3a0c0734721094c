// SPDX-License-Identifier: LGPL-2.1-or-later
// Whole processes: start-up (load and compile a scene, no step), and a static load step from start to end.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "tools/bench/body.h"
#include "tools/bench/figures.h"
#include "tools/platform/process.h"

namespace stroma::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Command {
  std::string name, scene;
  int steps = 0, processes = 15;
  std::vector<std::string> overrides = {};
  std::optional<double> target = {};
  std::string peers = {};
};

/// Runs `stroma run SCENE -n STEPS --quiet --no-record` in `folder`, silent. Returns its wall time [s], negative when it failed.
double processSeconds(const Command& command, const std::string& scene, const std::string& folder) {
  std::vector<std::string> words{programFolder() + "/stroma",   "run",     scene,        "-n",
                                 std::to_string(command.steps), "--quiet", "--no-record"};
  for (const std::string& text : command.overrides) words.insert(words.end(), {"--set", text});
  const auto start_time = Clock::now();
  const std::string nothing = "/dev/null";
  const int code = exitCodeOf(start({words, folder, {}, nothing, nothing}));
  return code == 0 ? std::chrono::duration<double>(Clock::now() - start_time).count() : -1;
}

/// The factorisations of a command's steps, each of them once: what else it does has no share in the limit.
Work factorWorkOf(const Command& command) {
  const auto simulation = loadSimulation(command.scene, command.overrides);
  Work sum;
  for (int step = 0; step < command.steps; ++step) {
    const StepReport report = simulation->step();
    sum = sum + factorWork(*simulation) * double(report.factorisations);
  }
  return sum;
}

void time(benchmark::State& state, const Command& command, Figure& figure) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / fmt::format("stroma-bench-{}", getpid());
  fs::create_directories(folder);
  const std::string path = fs::absolute(sceneFolder() + "/" + command.scene).string();
  for (auto _ : state) {
    const double seconds = processSeconds(command, path, folder.string());
    if (seconds < 0) {
      state.SkipWithError("the command did not end with exit code 0");
      break;
    }
    state.SetIterationTime(seconds);
  }
  fs::remove_all(folder);
  if (command.steps == 0 || figure.work.flops > 0) return;
  figure.work = factorWorkOf(command);
  figure.working_set = figure.work.bytes;
}

void addProcess(Catalogue& catalogue, const Command& command) {
  Figure figure;
  figure.name = command.name;
  figure.unit = "ms";
  figure.per_second = 1e3;
  figure.target = command.target;
  figure.peers = command.peers;
  figure.wall = true;
  catalogue
      .add(figure, [command, &catalogue](
                       benchmark::State& state) { time(state, command, catalogue.find(command.name)->figure); })
      .UseManualTime()
      ->Iterations(1)
      ->Repetitions(command.processes);
}

}  // namespace

void addStartFigures(Catalogue& catalogue) {
  addProcess(catalogue, {"start of organ.xml", "examples/organ.xml", 0, 15, {}, 30.0});
  addProcess(catalogue, {"start of cube.xml", "benchmarks/cube.xml"});
  const std::string cube = "benchmarks/compressed_cube.xml";
  addProcess(catalogue, {"compressed cube, 16 cells", cube, 1, 5, {}, 450.0, "CalculiX 2300"});
  addProcess(catalogue, {"compressed cube, 24 cells", cube, 1, 5, {"/cube/grid.n=25 25 25"}, 4000.0, "CalculiX 22600"});
}

}  // namespace stroma::bench
