// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/accuracy_change.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace stroma::bench {
namespace {

constexpr double least_time = 1;            ///< ms: less is noise
constexpr double least_factor = 1.2;        ///< of a reported change in time
constexpr double least_difference = 0.001;  ///< of relative errors

struct Row {
  double error = 0, milliseconds = 0;
  bool converged = false;
};
using Table = std::map<std::string, Row>;  ///< by problem, way and size

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

Table tableOf(std::istream& lines, const std::string& name) {
  Table table;
  std::string line;
  std::getline(lines, line);
  for (int number = 2; std::getline(lines, line); ++number) {
    const std::vector<std::string> fields = fieldsOf(line);
    try {
      if (fields.size() != 10) throw std::invalid_argument("");
      table[fmt::format("{}, {}, {}", fields[0], fields[1], fields[2])] = {std::abs(std::stod(fields[6])), std::stod(fields[7]),
                                                                            fields[9] == "1"};
    } catch (const std::logic_error&) {
      throw std::runtime_error(fmt::format("{}:{}: expected a row of a table that --accuracy --csv wrote", name, number));
    }
  }
  return table;
}

double middleOf(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

std::string changesSince(const std::string& stored_file, const std::string& csv) {
  std::ifstream stored(stored_file);
  if (!stored) throw std::runtime_error(fmt::format("{}: it cannot be read", stored_file));
  const Table before = tableOf(stored, stored_file);
  std::istringstream text(csv);
  const Table now = tableOf(text, "this run");
  std::string said;
  std::map<std::string, double> ratios;  // logarithms
  for (const auto& [name, row] : now) {
    const auto found = before.find(name);
    if (found == before.end()) continue;
    const Row& old = found->second;
    ratios[name] = 0;
    if (row.converged != old.converged)
      said += fmt::format("- {}: it {}.\n", name, row.converged ? "converges now" : "does not converge any more");
    if (!row.converged || !old.converged) continue;
    if (std::abs(row.error - old.error) > std::max(least_difference, 0.01 * old.error))
      said += fmt::format("- {}: {} accurate, {:.3g} % where it was {:.3g} %.\n", name, row.error > old.error ? "less" : "more",
                          100 * row.error, 100 * old.error);
    if (row.milliseconds > least_time && old.milliseconds > least_time)
      ratios[name] = std::log(row.milliseconds / old.milliseconds);
  }
  if (ratios.empty()) throw std::runtime_error(fmt::format("{}: it has none of the rows of this run", stored_file));
  std::vector<double> all, apart;
  for (const auto& [name, ratio] : ratios)
    if (ratio != 0) all.push_back(ratio);
  const double machine = middleOf(all);
  for (const double ratio : all) apart.push_back(std::abs(ratio - machine));
  const double noise = 6 * middleOf(apart), limit = std::max(noise, std::log(least_factor));
  for (const auto& [name, ratio] : ratios)
    if (ratio != 0 && std::abs(ratio - machine) > limit)
      said += fmt::format("- {}: {} by a factor of {:.2f}.\n", name, ratio > machine ? "slower" : "quicker",
                          std::exp(std::abs(ratio - machine)));
  return fmt::format("of {} rows that both have; this run took {:.2f} times as long, and factors up to {:.2f} are noise\n{}",
                     ratios.size(), std::exp(machine), std::exp(limit), said.empty() ? "- nothing has changed.\n" : said);
}

}  // namespace stroma::bench
