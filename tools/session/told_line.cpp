// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/told_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace stroma {
namespace {

bool isTerminal() {
  const char* kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) && !(kind && std::strcmp(kind, "dumb") == 0);
}

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

ToldLine::ToldLine() : is_on_terminal_(isTerminal()) {}

std::size_t ToldLine::width() const {
  if (!is_on_terminal_) return std::string::npos;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 79u;
}

void ToldLine::tell(const std::string& text) {
  if (is_on_terminal_)
    fmt::print(stderr, "\r\033[K{}", text);
  else
    fmt::print(stderr, "{}\n", text);
  std::fflush(stderr);
  is_open_ = is_on_terminal_;
}

void ToldLine::clear() {
  if (is_open_) fmt::print(stderr, "\r\033[K"), std::fflush(stderr);
  is_open_ = false;
}

std::string fittedLine(std::string head, std::string tail, std::size_t width) {
  cut(tail, width);
  cut(head, width - tail.size());
  return head + tail;
}

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

}  // namespace stroma
