// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/profile/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace stroma::profile {
namespace {

constexpr std::size_t most_lines = 24;

std::string nameOf(const Kind& kind) { return kind.whose.empty() ? kind.what : kind.what + " " + kind.whose; }

std::string inQuotes(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// "1.23 s", "45.6 ms", "7.8 us"
std::string timeText(double seconds) {
  if (seconds >= 1) return fmt::format("{:.2f} s", seconds);
  if (seconds >= 1e-3) return fmt::format("{:.2f} ms", 1e3 * seconds);
  return fmt::format("{:.2f} us", 1e6 * seconds);
}

/// Nanoseconds since the beginning as Chrome's microseconds. Rounding keeps the order, so that spans stay nested.
struct Micro {
  long nanoseconds;
};
std::string textOf(Micro time) { return fmt::format("{}.{:03}", time.nanoseconds / 1000, time.nanoseconds % 1000); }

/// The parts of an event's line that all of a kind have.
struct Words {
  std::string name, begin, of;

  explicit Words(const Kind& kind) : name(inQuotes(nameOf(kind))) {
    begin = "{\"ph\":\"X\",\"name\":" + name + ",\"cat\":" + inQuotes(kind.what) + ",\"pid\":1,\"tid\":";
    if (!kind.whose.empty()) of = "\"of\":" + inQuotes(kind.whose) + ",";
  }
};

/// In the order in which they begin; those that hold others come first. As heard, they are in the order of their ends.
std::vector<const Event*> byBeginning(const std::vector<Event>& events) {
  std::vector<const Event*> sorted;
  for (const Event& event : events) sorted.push_back(&event);
  std::sort(sorted.begin(), sorted.end(), [](const Event* a, const Event* b) {
    if (a->begin != b->begin) return a->begin < b->begin;
    return a->end != b->end ? a->end > b->end : a > b;
  });
  return sorted;
}

/// Its own time is that of nobody: it holds what has a name.
bool isHolder(const std::string& what) {
  return what == "command" || what == "run" || what == "load" || what == "whole step";
}

struct Line {
  double share, self, total;
  const Sum* sum;
  const Kind* kind;
};

}  // namespace

std::string traceOf(const Profile& profile) {
  std::string text =
      "{\"displayTimeUnit\":\"ns\",\"otherData\":{\"wall_seconds\":" + fmt::format("{:.9f}", profile.wall()) +
      fmt::format(",\"spans_in_the_table_alone\":{},\"steps\":{},\"steps_heard\":{}}},\n\"traceEvents\":[\n", profile.left_out,
                  profile.steps, profile.heard);
  std::vector<Words> all_words;
  for (const Kind& kind : profile.kinds) all_words.emplace_back(kind);
  const auto at = [&](std::uint64_t tick) { return std::lround(1e9 * profile.seconds(tick - profile.begin)); };
  auto out = std::back_inserter(text);
  for (std::size_t t = 0; t < profile.threads.size(); ++t)
    fmt::format_to(out,
                   "{{\"ph\":\"M\",\"name\":\"thread_name\",\"pid\":1,\"tid\":{},\"args\":{{\"name\":\"{}\"}}}},\n",
                   t + 1, t == 0 ? "steps" : fmt::format("worker {}", t));
  for (std::size_t t = 0; t < profile.threads.size(); ++t)
    for (const Event* heard : byBeginning(profile.threads[t].events)) {
      const Event& event = *heard;
      const Kind& kind = profile.kinds[event.kind];
      const Words& words = all_words[event.kind];
      const long begins = at(event.begin), takes = at(event.end) - begins;
      text += words.begin;
      fmt::format_to(out, "{},\"ts\":{}.{:03},\"dur\":{}.{:03}", t + 1, begins / 1000, begins % 1000, takes / 1000, takes % 1000);
      if (event.count || event.allocations || !words.of.empty()) {
        text += ",\"args\":{" + words.of;
        if (event.count) fmt::format_to(out, "\"iterations\":{},", event.count);
        if (event.allocations)
          fmt::format_to(out, "\"allocations\":{},\"bytes\":{},", event.allocations, event.bytes);
        text.back() = '}';
      }
      text += "},\n";
      if (!event.count && !event.allocations && kind.what != "whole step") continue;
      const std::string end = textOf({at(event.end)});
      if (event.count)
        fmt::format_to(
            out, "{{\"ph\":\"C\",\"name\":\"iterations\",\"pid\":1,\"ts\":{},\"args\":{{\"of a solve\":{}}}}},\n", end,
            event.count);
      if (kind.what == "whole step" && profile.has_allocations)
        fmt::format_to(
            out, "{{\"ph\":\"C\",\"name\":\"allocations\",\"pid\":1,\"ts\":{},\"args\":{{\"of a step\":{}}}}},\n", end,
            event.allocations);
    }
  fmt::format_to(out, "{{\"ph\":\"M\",\"name\":\"process_name\",\"pid\":1,\"args\":{{\"name\":\"stroma run\"}}}}]}}\n");
  return text;
}

std::string tableOf(const Profile& profile, const std::string& file) {
  const double wall = profile.wall();
  std::vector<Line> lines;
  double named = 0;
  const Profile::Thread& first = profile.threads.front();
  std::size_t spans = 0;
  for (const Profile::Thread& thread : profile.threads) spans += thread.events.size();
  for (std::size_t k = 0; k < profile.kinds.size(); ++k) {
    const Sum& sum = first.sums[k];
    if (sum.calls == 0) continue;
    const double self = profile.seconds(sum.self);
    if (!isHolder(profile.kinds[k].what)) named += self;
    lines.push_back({self / wall, self, profile.seconds(sum.total), &sum, &profile.kinds[k]});
  }
  std::sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.self > b.self; });
  std::string text = fmt::format("\n{:>7} {:>10} {:>10} {:>9} {:>10}{}  what\n", "share", "itself", "with all", "calls",
                                 "iterations", profile.has_allocations ? fmt::format(" {:>11}", "allocations") : "");
  for (std::size_t k = 0; k < std::min(lines.size(), most_lines); ++k) {
    const Line& line = lines[k];
    text += fmt::format("{:>6.1f}% {:>10} {:>10} {:>9} {:>10}", 100 * line.share, timeText(line.self),
                        timeText(line.total), line.sum->calls, line.sum->count ? std::to_string(line.sum->count) : "");
    if (profile.has_allocations) text += fmt::format(" {:>11}", line.sum->allocations);
    text += "  " + nameOf(*line.kind) + (isHolder(line.kind->what) ? ", what has no name in it" : "") + "\n";
  }
  double rest = 0;
  for (std::size_t k = most_lines; k < lines.size(); ++k) rest += lines[k].share;
  if (lines.size() > most_lines) text += fmt::format("{:>6.1f}% {} others\n", 100 * rest, lines.size() - most_lines);
  for (std::size_t t = 1; t < profile.threads.size(); ++t) {
    std::uint64_t busy = 0;
    for (const Sum& sum : profile.threads[t].sums) busy += sum.self;
    text += fmt::format("{:>6.1f}% of worker {}\n", 100 * profile.seconds(busy) / wall, t);
  }
  text +=
      fmt::format("{} of wall time, {:.1f} % with a name. Trace of {} spans: {} (open it at https://ui.perfetto.dev)\n",
                  timeText(wall), 100 * named / wall, spans, file);
  if (profile.heard < profile.steps)
    text += fmt::format("The steps are short: {} of {} were heard, the first ones and then some at random, and what is in steps is "
                        "estimated from these\n",
                        profile.heard, profile.steps);
  if (profile.left_out > 0) text += fmt::format("{} spans more are in the table alone\n", profile.left_out);
  return text;
}

}  // namespace stroma::profile
