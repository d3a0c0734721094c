// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "framework/scene/output_file.h"

namespace stroma::bench {
namespace {

using Json = nlohmann::ordered_json;

/// A figure against its target: by its median, or only by its best repetition.
std::string verdict(double middle, double best, double target, bool at_most) {
  const auto meets = [&](double value) { return at_most ? value <= target : value >= target; };
  return meets(middle) ? "met" : meets(best) ? "best only" : "not met";
}

struct RatioValue {
  double middle = 0, best = 0;
};
/// Of wall times; the best pairs the least time of one thread with the least of two. Nothing when either is missing.
std::optional<RatioValue> valueOf(const Ratio& ratio, const Catalogue& catalogue) {
  RatioValue value;
  double slow[2] = {0, 0}, fast[2] = {0, 0};
  for (const Measurement& m : catalogue.measurements()) {
    if (m.figure.name == ratio.slow) slow[0] = median(m.wall), slow[1] = least(m.wall);
    if (m.figure.name == ratio.fast) fast[0] = median(m.wall), fast[1] = least(m.wall);
  }
  if (slow[0] <= 0 || fast[0] <= 0) return std::nullopt;
  return RatioValue{slow[0] / fast[0], slow[1] / fast[1]};
}

double share(const Measurement& m, const Machine& machine) {
  return bound(m.figure, machine.limits).seconds * m.figure.per_second / median(m.samples());
}

void printRow(const Measurement& m, const Machine& machine) {
  const Figure& figure = m.figure;
  if (!m.error.empty()) {
    fmt::print("{:<40} {}\n", figure.name, m.error);
    return;
  }
  const double middle = median(m.samples()), best = least(m.samples());
  std::string limit = "-", target = "-", judged = "-";
  if (figure.work.flops > 0)
    limit = fmt::format("{:.0f} % {}", 100 * share(m, machine), bound(figure, machine.limits).by);
  if (figure.target) {
    target = fmt::format("{:g}", *figure.target);
    judged = verdict(middle, best, *figure.target, true);
  }
  std::string remarks = figure.peers;
  if (!m.note.empty()) remarks += (remarks.empty() ? "" : "; ") + m.note;
  fmt::print("{:<40} {:>9.3g} {:>9.3g} {:<8} {:<16} {:>7} {:<10} {}\n", figure.name, middle, best, figure.unit, limit,
             target, judged, remarks);
}

Json jsonOf(const Measurement& m, const Machine& machine) {
  const Figure& figure = m.figure;
  Json json{{"name", figure.name}, {"unit", figure.unit}, {"clock", figure.wall ? "wall" : "processor"}};
  if (!m.error.empty()) {
    json["error"] = m.error;
    return json;
  }
  json["median"] = median(m.samples());
  json["least"] = least(m.samples());
  if (figure.work.flops > 0) {
    json["bytes"] = figure.work.bytes, json["flops"] = figure.work.flops;
    json["share_of_limit"] = share(m, machine), json["limited_by"] = bound(figure, machine.limits).by;
  }
  if (figure.target) {
    json["target"] = *figure.target;
    json["verdict"] = verdict(median(m.samples()), least(m.samples()), *figure.target, true);
  }
  if (!figure.peers.empty()) json["peers"] = figure.peers;
  if (!m.note.empty()) json["note"] = m.note;
  json["wall"] = m.wall, json["processor"] = m.processor;
  return json;
}

}  // namespace

void Collector::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    Measurement* m = catalogue_.find(run.run_name.function_name);
    if (!m || run.run_type != Run::RT_Iteration) continue;
    if (run.error_occurred) {
      m->error = run.error_message;
      continue;
    }
    const double scale = m->figure.per_second / double(run.iterations);
    m->wall.push_back(run.real_accumulated_time * scale);
    m->processor.push_back(run.cpu_accumulated_time * scale);
    m->note = run.report_label;
  }
  if (runs.empty()) return;
  const Measurement* m = catalogue_.find(runs.front().run_name.function_name);
  if (m && m->error.empty())
    fmt::print(stderr, "{:<40} {:>9.3g} {}\n", m->figure.name, median(m->samples()), m->figure.unit);
}

void printMachine(const Machine& machine) {
  double load[3] = {0, 0, 0};
  getloadavg(load, 3);
  fmt::print("{}, instruction set {} ({} doubles per register), level-2 cache {:.3g} MB, load {:.1f}\n\n",
             machine.processor, machine.level, machine.lanes, machine.cache_bytes / (1 << 20), load[0]);
  if (load[0] > 0.5)
    fmt::print(
        "Other programs are running: every figure below is an upper bound, and two threads share what is left.\n\n");
  fmt::print("{:<44} {:>9} {:>9}\n", "limits of one core", "median", "best");
  for (const MachineFigure& figure : machine.figures)
    fmt::print("{:<44} {:>9.1f} {:>9.1f} {}\n", figure.name, median(figure.rates),
               *std::ranges::max_element(figure.rates), figure.unit);
  std::fflush(stdout);
}

void printTable(const Catalogue& catalogue, const Machine& machine) {
  fmt::print("\n{:<40} {:>9} {:>9} {:<8} {:<16} {:>7} {:<10} {}\n", "figure", "median", "least", "unit",
             "share of limit", "target", "", "others on the same machine; remarks");
  for (const Measurement& m : catalogue.measurements())
    if (!m.wall.empty() || !m.error.empty()) printRow(m, machine);
  for (const Ratio& ratio : catalogue.ratios())
    if (const auto value = valueOf(ratio, catalogue))
      fmt::print("{:<40} {:>9.3g} {:>9.3g} {:<8} {:<16} {:>7} {}\n", ratio.name, value->middle, value->best, "times",
                 "-", fmt::format(">={:g}", ratio.target), verdict(value->middle, value->best, ratio.target, false));
  fmt::print(
      "\nOne thread: processor time; two threads and start-up: wall time. The limit is the time that the measured read "
      "bandwidth and\nmultiply-add peak allow for the bytes and operations that the method cannot do without.\n");
}

void writeJson(const std::string& file, const Catalogue& catalogue, const Machine& machine) {
  Json json;
  double load[3] = {0, 0, 0};
  getloadavg(load, 3);
  json["seconds_since_1970"] = std::time(nullptr);
  json["load"] = load[0];
  json["machine"] = {{"processor", machine.processor},
                     {"level", machine.level},
                     {"lanes", machine.lanes},
                     {"cache_bytes", machine.cache_bytes}};
  for (const MachineFigure& figure : machine.figures)
    json["limits"].push_back({{"name", figure.name}, {"unit", figure.unit}, {"rates", figure.rates}});
  for (const Measurement& m : catalogue.measurements())
    if (!m.wall.empty() || !m.error.empty()) json["figures"].push_back(jsonOf(m, machine));
  for (const Ratio& ratio : catalogue.ratios())
    if (const auto value = valueOf(ratio, catalogue))
      json["ratios"].push_back({{"name", ratio.name},
                                {"median", value->middle},
                                {"best", value->best},
                                {"target", ratio.target},
                                {"verdict", verdict(value->middle, value->best, ratio.target, false)}});
  writeWholeFile(file, json.dump(2) + "\n");
}

}  // namespace stroma::bench
