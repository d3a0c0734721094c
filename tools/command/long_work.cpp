// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/long_work.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "framework/simulation/long_work.h"

namespace stroma::command {
namespace {

constexpr double few_operations = 1e11;  // a few seconds
std::atomic<int> telling{0};

std::string twoUnits(long small, long per_large, const char* large, const char* unit) {
  const long rest = small % per_large;
  return fmt::format("{} {}{}", small / per_large, large, rest > 0 ? fmt::format(" {} {}", rest, unit) : "");
}

/// The first bytes of a text, whole characters of UTF-8.
void cut(std::string& text, std::size_t most) {
  if (text.size() <= most) return;
  const auto is_inside = [&text](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
  while (most > 0 && is_inside(most)) --most;
  text.resize(most);
}

}  // namespace

std::size_t terminalWidth() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 79u;
}

std::string fittedLine(std::string head, std::string tail, std::size_t width) {
  cut(tail, width);
  cut(head, width - tail.size());
  return head + tail;
}

bool isTellingLongWork() { return telling > 0; }

std::string durationText(double seconds) {
  if (seconds < 0.95) return fmt::format("{:.1f} s", seconds);
  seconds = std::min(seconds, 1e9);
  const long whole = std::lround(seconds);
  if (whole < 100) return fmt::format("{} s", whole);
  if (whole < 600) return twoUnits(std::lround(seconds / 10) * 10, 60, "min", "s");
  const long minutes = std::lround(seconds / 60);
  if (minutes < 100) return fmt::format("{} min", minutes);
  if (minutes < 48 * 60) return twoUnits(minutes, 60, "h", "min");
  return twoUnits(std::lround(seconds / 3600), 24, "d", "h");
}

namespace {

class ToldWork final : public LongWorkListener {
 public:
  explicit ToldWork(std::string what) : what_(std::move(what)), terminal_(isatty(STDERR_FILENO)) { ++telling; }
  ~ToldWork() override { --telling; }
  void advise(const std::string& sentence) override { fmt::print(stderr, "{}: {}\n", what_, sentence); }
  void say(double share) override;

 private:
  std::string what_;
  bool terminal_;
  int last_ = -1;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void ToldWork::say(double share) {
  share = std::min(share, 1.0);
  const int step = int(share * (terminal_ ? 100 : 4));
  if (step <= last_) return;
  last_ = step;
  const bool ends = share >= 0.999;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  // the first share says little of the rest
  const std::string to_go = ends || share < 0.02 ? "" : durationText(seconds * (1 - share) / share) + " to go";
  const std::string tail = fmt::format(": {:.0f} %{}{}", 100 * share, to_go.empty() ? "" : ", ", to_go);
  if (terminal_)
    fmt::print(stderr, "\r\033[K{}{}", fittedLine(what_, tail, terminalWidth()), ends ? "\n" : "");
  else
    fmt::print(stderr, "{}{}\n", what_, tail);
  std::fflush(stderr);
}

}  // namespace

void tellLongWork(bool wanted) {
  if (!wanted) return listenToLongWork({});
  listenToLongWork([](const std::string& what, double operations) {
    return operations < few_operations ? nullptr : std::make_unique<ToldWork>(what);
  });
}

}  // namespace stroma::command
