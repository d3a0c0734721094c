// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace stroma::command {
namespace {

constexpr auto redraw_every = std::chrono::milliseconds(100);
constexpr long lines_in_a_pipe = 10;

}  // namespace

Progress::Progress(long steps, bool quiet)
    : steps_(steps), quiet_(quiet), terminal_(isatty(STDERR_FILENO)), next_line_((steps + 9) / lines_in_a_pipe) {}

void Progress::show(const Simulation& simulation, const StepReport& report) {
  if (quiet_) return;
  if (terminal_) {
    const auto now = Clock::now();
    if (now - last_drawn_ < redraw_every && simulation.steps() != steps_) return;
    last_drawn_ = now;
    line_open_ = true;
    print(simulation, report, "\r\033[K", "");
  } else if (simulation.steps() >= next_line_) {
    next_line_ += (steps_ + 9) / lines_in_a_pipe;
    print(simulation, report, "", "\n");
  }
}

void Progress::finish() {
  if (line_open_) fmt::print(stderr, "\n");
  line_open_ = false;
}

void Progress::print(const Simulation& simulation, const StepReport& report, const char* before, const char* after) {
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  fmt::print(stderr, "{}step {}/{}  t = {:.6g} s  {:.3g} ms/step", before, simulation.steps(), steps_,
             simulation.time(), ms / double(simulation.steps()));
  if (report.newton_iterations > 1) fmt::print(stderr, "  {} Newton iterations", report.newton_iterations);
  if (report.linear_iterations > 0) fmt::print(stderr, "  {} linear iterations", report.linear_iterations);
  fmt::print(stderr, "{}", after);
  std::fflush(stderr);
}

}  // namespace stroma::command
