// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/results_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tools/sweep/chart.h"

namespace stroma::sweep {
namespace {

using Row = std::vector<std::string>;

constexpr std::size_t most_rows = 60;

std::string valueText(const std::vector<double>& value) {
  Row numbers;
  for (const double number : value) numbers.push_back(fmt::format("{:.4g}", number));
  return fmt::format("{}", fmt::join(numbers, " "));
}

/// Of UTF-8.
std::size_t letters(const std::string& text) {
  return std::size_t(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

class Results {
 public:
  explicit Results(const Findings& findings) : findings_(findings) {
    for (const Entry& entry : findings.entries) {
      has_values_ = has_values_ || !entry.value.empty();
      has_times_ = has_times_ || hasTime(entry);
      has_front_ = has_front_ || entry.on_front;
    }
  }

  std::string text() const {
    std::vector<Row> rows{heads()};
    const bool all = findings_.entries.size() <= most_rows;
    for (const Entry& entry : findings_.entries)
      if (all || entry.on_front) rows.push_back(rowOf(entry));
    std::vector<std::size_t> widths(rows[0].size(), 0);
    for (const Row& row : rows)
      for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], letters(row[c]));
    std::string text;
    for (const Row& row : rows) {
      std::string line;
      for (std::size_t c = 0; c < row.size(); ++c) line += fmt::format("{}{:>{}}", c ? "  " : "", row[c], widths[c]);
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    if (has_front_) text += "* the front: nothing is both faster and more accurate\n";
    if (!all) text += fmt::format("{} configurations more are in table.csv\n", findings_.entries.size() + 1 - rows.size());
    return text;
  }

 private:
  bool hasTime(const Entry& entry) const {
    return findings_.request.timed && entry.runs.isGood() && entry.runs.hasTimes();
  }

  Row heads() const {
    Row row{" "};
    for (const Axis& axis : findings_.axes) row.push_back(axis.label());
    if (has_values_) {
      const std::string& measure = findings_.request.error;
      row.push_back(measure.starts_with('/') ? shortName(measure.substr(0, measure.find(':'))) : measure);
    }
    row.push_back("error");
    if (has_times_) row.push_back("time");
    return row;
  }

  Row rowOf(const Entry& entry) const {
    const std::vector<std::size_t>& choice = entry.configuration.choice;
    const Numbers numbers = findings_.assessment.is_relative ? Numbers::share : Numbers::plain;
    Row row{entry.on_front ? "*" : " "};
    for (std::size_t a = 0; a < findings_.axes.size(); ++a)
      row.push_back(choice.empty() ? (a == 0 ? nameOf(findings_.axes, entry.configuration) : "")
                                   : findings_.axes[a].valueText(choice[a]));
    if (has_values_) row.push_back(valueText(entry.value));
    row.push_back(!entry.error ? entry.runs.outcome : (entry.is_reference ? "about " : "") + numberText(*entry.error, numbers));
    if (has_times_) row.push_back(hasTime(entry) ? numberText(entry.runs.medianOf(&Repetition::seconds), Numbers::seconds) : "");
    return row;
  }

  const Findings& findings_;
  bool has_values_ = false, has_times_ = false, has_front_ = false;
};

}  // namespace

std::string resultsText(const Findings& findings) { return Results(findings).text(); }

}  // namespace stroma::sweep
