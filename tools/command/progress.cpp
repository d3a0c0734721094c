// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/progress.h"

#include <fmt/format.h>

#include "tools/command/long_work.h"
#include "tools/units/unit_system.h"

namespace stroma::command {
namespace {

constexpr double redrawn_every = 0.1, looked_every = 0.25;  // [s]
constexpr double shortest_told = 1;                         // [s] between two lines, and from the start to the first
constexpr double longest_untold = 30;                       // [s]
constexpr double long_step = 2;                             // [s]

/// Pieces of a line. Those that matter least go first where it is too long.
class Pieces {
 public:
  /// `rank`: 0 matters most.
  void add(int rank, std::string text) { pieces_.push_back({rank, std::move(text)}); }
  std::string joined(std::size_t width) const {
    for (int most = 9;; --most) {
      std::string line;
      for (const auto& [rank, text] : pieces_)
        if (rank <= most) line += (line.empty() ? "" : "  ") + text;
      if (line.size() <= width) return line;
      if (most == 0) return line.substr(0, width);
    }
  }

 private:
  std::vector<std::pair<int, std::string>> pieces_;
};

std::string counted(int count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

}  // namespace

Progress::Progress(std::string scene, bool quiet, std::function<bool()> is_stopping)
    : scene_(std::move(scene)), is_stopping_(std::move(is_stopping)) {
  if (!quiet) thread_ = std::thread([this] { tell(); });
}

void Progress::loaded() {
  const std::lock_guard lock(mutex_);
  stage_ = waits;
  line_.clear();
}

void Progress::begin(const Simulation& simulation, long last) {
  if (!thread_.joinable()) return;
  setStepProgress(&step_);
  const std::lock_guard lock(mutex_);
  first_ = simulation.steps(), last_ = last;
  began_ = std::chrono::duration<double>(Clock::now() - start_).count();
  made_ = first_;
  time_ = simulation.time();
  time_unit_ = unitsOf(simulation.scene()).behind("s");
  stage_ = runs;
}

void Progress::print(const std::string& line) {
  const std::lock_guard lock(mutex_);
  line_.clear();
  fmt::print(stderr, "{}\n", line);
}

void Progress::finish() {
  if (!thread_.joinable()) return;
  setStepProgress(nullptr);
  {
    const std::lock_guard lock(mutex_);
    stage_ = ends;
    line_.clear();
  }
  wake_.notify_one();
  thread_.join();
}

void Progress::tell() {
  std::unique_lock lock(mutex_);
  const std::chrono::duration<double> pause(line_.isOnTerminal() ? redrawn_every : looked_every);
  while (!wake_.wait_for(lock, pause, [this] { return stage_ == ends; })) {
    const double now = std::chrono::duration<double>(Clock::now() - start_).count();
    if (stage_ == loads) lookAtLoad(now);
    if (stage_ == runs) look(now);
  }
}

void Progress::lookAtLoad(double now) {
  if (isTellingLongWork()) {  // the line is another's
    line_.leave();
    return;
  }
  if (now < (line_.isOnTerminal() ? shortest_told : told_ + longest_untold)) return;
  told_ = now;
  line_.tell(fittedLine("loading " + scene_, fmt::format(": {} so far", durationText(now)), line_.width()));
}

void Progress::look(double now) {
  const long made = made_.load(std::memory_order_relaxed);
  pace_.look(now - began_, made - first_);
  newton_pace_.look(now - began_, made, step_.newton_iterations.load(std::memory_order_relaxed),
                    step_.newton_residual.load(std::memory_order_relaxed),
                    step_.newton_goal.load(std::memory_order_relaxed));
  if (line_.isOnTerminal() || isLineDue(now, made - first_)) line_.tell(text(now, line_.width()));
}

/// In a pipe.
bool Progress::isLineDue(double now, long done) {
  const long steps = last_ - first_;
  const int tenths = steps > 0 ? int(10 * double(done) / double(steps)) : 0;
  const double since = now - std::max(told_, began_);
  if (since < longest_untold && (tenths <= tenths_ || since < shortest_told)) return false;
  tenths_ = tenths;
  told_ = now;
  return true;
}

std::string Progress::text(double now, std::size_t width) {
  const long made = made_.load(std::memory_order_relaxed), steps = last_ - first_;
  const double age = pace_.age();
  const bool is_slow = age > long_step && age > 2 * pace_.secondsPerStep();
  Pieces pieces;
  pieces.add(0, fmt::format("step {}/{}", made, last_));
  if (steps > 0) pieces.add(2, fmt::format("{} %", 100 * (made - first_) / steps));
  if (is_slow || !pace_.isKnown()) {
    const int iterations = step_.newton_iterations.load(std::memory_order_relaxed);
    pieces.add(3, fmt::format("step {}: {} so far", made + 1, durationText(age)));
    if (iterations > 0)
      pieces.add(4, fmt::format("Newton iteration {}, residual {:.1g} (goal {:.1g})", iterations,
                                step_.newton_residual.load(std::memory_order_relaxed),
                                step_.newton_goal.load(std::memory_order_relaxed)));
    if (const double to_go = newton_pace_.secondsToGo(); to_go >= 0)
      pieces.add(4, fmt::format("about {} to go in this step", durationText(to_go)));
  }
  pieces.add(5, fmt::format("t = {:.6g}{}", time_.load(std::memory_order_relaxed), time_unit_));
  if (pace_.isKnown()) {
    const int newton = newton_.load(std::memory_order_relaxed), linear = linear_.load(std::memory_order_relaxed);
    pieces.add(6, fmt::format("{:.3g} ms/step", 1e3 * pace_.secondsPerStep()));
    if (newton > 1) pieces.add(9, counted(newton, "Newton iteration"));
    if (linear > 0) pieces.add(8, counted(linear, "linear iteration"));
    pieces.add(7, durationText(now - began_) + " elapsed");
  }
  if (is_stopping_())
    pieces.add(1, "stopping; a second signal exits at once");
  else if (pace_.isSteady())
    pieces.add(1, durationText(pace_.secondsToGo(last_ - made)) + " to go");
  return pieces.joined(width);
}

}  // namespace stroma::command
