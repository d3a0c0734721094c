// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "framework/simulation/simulation.h"
#include "framework/simulation/step_progress.h"
#include "tools/command/pace.h"
#include "tools/session/told_line.h"

namespace stroma::command {

/// How far a run is, on standard error: on a terminal one line that is redrawn; in a pipe a line each tenth of a run of
/// some seconds, and one every 30 s of a long one. A thread of its own looks at what the steps leave behind, so a step
/// pays for a few stores, and a step or a load of minutes shows life too.
class Progress {
 public:
  /// The scene is being loaded. `quiet`: nothing is printed at all. `is_stopping`: the run is about to end.
  Progress(std::string scene, bool quiet, std::function<bool()> is_stopping);
  ~Progress() { finish(); }
  /// Nothing is printed until begin(): others print.
  void loaded();
  /// The steps up to number `last` follow, made by the calling thread.
  void begin(const Simulation& simulation, long last);
  void stepMade(const Simulation& simulation, const StepReport& report) {
    newton_.store(report.newton_iterations, std::memory_order_relaxed);
    linear_.store(report.linear_iterations, std::memory_order_relaxed);
    time_.store(simulation.time(), std::memory_order_relaxed);
    made_.store(simulation.steps(), std::memory_order_relaxed);
  }
  /// Prints a line of its own from the thread that makes the steps.
  void print(const std::string& line);
  /// Nothing more is printed, and the terminal's line is empty: before anything else is printed.
  void finish();

 private:
  void tell();
  void look(double now);
  void lookAtLoad(double now);
  bool isLineDue(double now, long done);
  std::string text(double now, std::size_t width);

  using Clock = std::chrono::steady_clock;
  const std::string scene_;
  const std::function<bool()> is_stopping_;
  const Clock::time_point start_ = Clock::now();

  // what the stepping thread leaves behind
  std::atomic<long> made_ = 0;
  std::atomic<int> newton_ = 0, linear_ = 0;
  std::atomic<double> time_ = 0;
  StepProgress step_;

  std::mutex mutex_;  ///< of all below
  std::condition_variable wake_;
  enum { loads, waits, runs, ends } stage_ = loads;
  long first_ = 0, last_ = 0;
  std::string time_unit_;  ///< " s", in a scene in seconds
  double began_ = 0;  ///< when the steps did, since start_ [s]
  double told_ = 0;   ///< when the last line was printed, since start_ [s]
  int tenths_ = 0;    ///< of the run that lines have told of
  ToldLine line_;
  Pace pace_;
  NewtonPace newton_pace_;
  std::thread thread_;
};

}  // namespace stroma::command
