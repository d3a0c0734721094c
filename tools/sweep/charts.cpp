// SPDX-License-Identifier: LGPL-2.1-or-later
// Which charts a sweep has.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "tools/sweep/report.h"

namespace stroma::sweep {
namespace {

using Choice = std::vector<std::size_t>;

/// Which colour and label an entry has: by its words, or by a second size where there are none.
class Grouping {
 public:
  /// `along`: the axis that lines follow.
  Grouping(const Findings& findings, std::size_t along) : axes_(findings.axes), along_(along) {
    for (std::size_t a = 0; a < axes_.size(); ++a)
      if (a != along && !axes_[a].isOrdered()) by_.push_back(a);
    for (std::size_t a = 0; a < axes_.size() && by_.empty(); ++a)
      if (a != along) by_.push_back(a);
  }
  std::size_t colourOf(const Choice& choice) const {
    std::size_t colour = 0;
    for (const std::size_t a : by_) colour = colour * axes_[a].size() + choice[a];
    return colour;
  }
  std::string labelOf(const Choice& choice) const {
    std::string text;
    for (const std::size_t a : by_) text += (text.empty() ? "" : " · ") + valueOf(axes_[a], choice[a]);
    return text;
  }

 private:
  /// A word speaks for itself; a number needs its name.
  static std::string valueOf(const Axis& axis, std::size_t value) {
    const std::string text = axis.valueText(value);
    const bool is_word = std::isalpha(static_cast<unsigned char>(text[0])) && text != "true" && text != "false";
    if (is_word) return text;
    const std::string name = axis.label();
    const auto dot = name.rfind('.');
    return name.substr(dot == std::string::npos || axis.attributes.size() > 1 ? 0 : dot + 1) + " " + text;
  }

  const std::vector<Axis>& axes_;
  std::size_t along_;
  std::vector<std::size_t> by_;
};

/// The axis that lines of the work-precision chart follow: a mesh before a time step before the rest.
std::size_t mainAxis(const std::vector<Axis>& axes) {
  std::size_t best = 0;
  for (std::size_t a = 1; a < axes.size(); ++a)
    if (int(axes[a].kind) < int(axes[best].kind)) best = a;
  return best;
}

const Choice* choiceOf(const Entry& entry) {
  return entry.configuration.isExtraReference() ? nullptr : &entry.configuration.choice;
}

/// Lines along an axis, with the x that `x` gives an entry.
template <class X>
std::vector<ChartLine> linesAlong(const Findings& findings, std::size_t axis, X&& x) {
  const Grouping grouping(findings, axis);
  std::map<Choice, ChartLine> lines;
  for (std::size_t i = 0; i < findings.entries.size(); ++i) {
    const Entry& entry = findings.entries[i];
    const Choice* choice = choiceOf(entry);
    if (!choice || !entry.error) continue;
    Choice others = *choice;
    others[axis] = 0;
    ChartLine& line = lines[others];
    line.colour = grouping.colourOf(*choice), line.label = grouping.labelOf(*choice);
    line.points.push_back({x(entry), *entry.error, i, entry.on_front, entry.is_reference});
  }
  std::vector<ChartLine> result;
  std::vector<std::string> labelled;
  for (auto& [others, line] : lines) {
    if (findings.axes[axis].isOrdered())
      std::ranges::stable_sort(line.points, [&](const ChartPoint& a, const ChartPoint& b) {
        return findings.axes[axis].isFiner((*choiceOf(findings.entries[b.entry]))[axis],
                                           (*choiceOf(findings.entries[a.entry]))[axis]);
      });
    // lines of one colour have one label
    if (std::ranges::find(labelled, line.label) != labelled.end())
      line.label.clear();
    else
      labelled.push_back(line.label);
    result.push_back(std::move(line));
  }
  return result;
}

/// Words along the main axis are no line: each is a point of its own, in its own colour.
std::vector<ChartLine> singlePoints(const Findings& findings, double Repetition::*time, double unit) {
  std::vector<ChartLine> lines;
  for (std::size_t i = 0; i < findings.entries.size(); ++i) {
    const Entry& entry = findings.entries[i];
    const Choice* choice = choiceOf(entry);
    if (!choice || !entry.error) continue;
    ChartLine line;
    line.colour = lines.size();
    for (std::size_t a = 0; a < choice->size(); ++a)
      line.label += (a == 0 ? "" : " · ") + findings.axes[a].valueText((*choice)[a]);
    line.points = {{unit * entry.runs.medianOf(time), *entry.error, i, entry.on_front, entry.is_reference}};
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string capitalised(std::string text) {
  text[0] = char(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

Chart emptyChart(const Findings& findings) {
  Chart chart;
  chart.y_label = ErrorMeasure::parse(findings.request.error).title();
  chart.y_label = capitalised(chart.y_label);
  chart.y_numbers = findings.assessment.is_relative ? Numbers::share : Numbers::plain;
  chart.uncertainty = findings.assessment.uncertainty;
  chart.uncertainty_text =
      "the reference: " + knownTo(findings.assessment, numberText(chart.uncertainty, chart.y_numbers));
  constexpr double below = 3;  // runs that share the reference's own error may come arbitrarily near to it
  chart.least = findings.assessment.expected / below;
  return chart;
}

Chart workPrecision(const Findings& findings, const char* id, const char* title, const char* label,
                    double Repetition::*time, double unit) {
  Chart chart = emptyChart(findings);
  chart.id = id;
  chart.title = title;
  chart.x_label = label;
  chart.x_numbers = Numbers::seconds;
  const std::size_t along = mainAxis(findings.axes);
  chart.lines = findings.axes[along].isOrdered()
                    ? linesAlong(findings, along, [&](const Entry& entry) { return unit * entry.runs.medianOf(time); })
                    : singlePoints(findings, time, unit);
  return chart;
}

Chart errorAgainst(const Findings& findings, std::size_t axis) {
  Chart chart = emptyChart(findings);
  const Axis& along = findings.axes[axis];
  const char* what = along.kind == AxisKind::mesh         ? "spacing of the mesh h"
                     : along.kind == AxisKind::time_step  ? "time step dt"
                     : along.kind == AxisKind::iterations ? "number of iterations"
                                                          : "tolerance";
  chart.id = fmt::format("error_{}", axis + 1);
  chart.title = fmt::format("Error against the {}", what);
  chart.x_label = along.label() == "dt" ? what : fmt::format("{} ({})", what, along.label());
  chart.x_label = capitalised(chart.x_label);
  const bool is_mesh = along.kind == AxisKind::mesh;
  if (is_mesh || along.kind == AxisKind::time_step) {
    const std::string& unit = is_mesh ? findings.assessment.length_unit : findings.assessment.time_unit;
    if (unit == "m" || unit == "s")
      chart.x_numbers = is_mesh ? Numbers::metres : Numbers::seconds;
    else if (!unit.empty())
      chart.x_label += fmt::format(" [{}]", unit);
  }
  const auto size = [&](const Entry& entry) { return along.sizes[entry.configuration.choice[axis]]; };
  chart.lines = linesAlong(findings, axis, size);
  for (ChartLine& line : chart.lines) {
    // small sizes are on the left, but for iterations: the label stands at the right end
    if (along.kind != AxisKind::iterations) std::ranges::reverse(line.points);
    for (const Series& series : seriesOf(findings))
      if (series.axis == axis && series.order &&
          std::ranges::find(series.entries, &findings.entries[line.points[0].entry]) != series.entries.end() &&
          !line.label.empty())
        line.label += fmt::format(": order {:.2f}", *series.order);
      else if (series.axis == axis && series.order && findings.axes.size() == 1)
        line.label = fmt::format("order {:.2f}", *series.order);
  }
  for (std::size_t i = 0; i < findings.entries.size(); ++i) {
    const Entry& entry = findings.entries[i];
    if (choiceOf(entry) && !entry.error && std::isfinite(size(entry)))
      chart.without.push_back({size(entry), 0, i, false, false});
  }
  return chart;
}

}  // namespace

std::vector<Chart> chartsOf(const Findings& findings) {
  std::vector<Chart> charts;
  const bool any = std::ranges::any_of(findings.entries, [](const Entry& entry) { return entry.error.has_value(); });
  if (!any) return charts;
  if (findings.request.timed) {
    charts.push_back(workPrecision(findings, "work_precision", "Error against run time", "Time to the end",
                                   &Repetition::seconds, 1));
    for (const ChartLine& line : charts[0].lines)
      for (const ChartPoint& point : line.points)
        if (point.on_front) charts[0].front.push_back(point);
    std::ranges::sort(charts[0].front, {}, &ChartPoint::x);
    const bool dt_varies =
        std::ranges::any_of(findings.axes, [](const Axis& axis) { return axis.kind == AxisKind::time_step; });
    if (dt_varies)
      charts.push_back(workPrecision(findings, "time_per_step", "Error against the time per step",
                                     "Time per step (median)", &Repetition::step_ms, 1e-3));
  }
  for (std::size_t a = 0; a < findings.axes.size(); ++a)
    if (findings.axes[a].isOrdered() && findings.axes[a].size() > 1) charts.push_back(errorAgainst(findings, a));
  return charts;
}

}  // namespace stroma::sweep
