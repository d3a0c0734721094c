// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/tip_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace stroma {

void TipMotion::read(const FileName& name) {
  rows_.clear();
  std::ifstream file(name.found);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    double time = 0, advance = 0;
    if (!(words >> time >> advance))
      throw ComponentError(fmt::format("{}:{}: '{}' is no time and length", name.given, number, line),
                           "a time [ms] and a length [m] in each row");
    rows_.push_back({time / 1000, advance});
  }
  if (rows_.size() < 2)
    throw ComponentError(fmt::format("{} has {} row{}", name.given, rows_.size(), rows_.size() == 1 ? "" : "s"), "two or more");
}

double TipMotion::next(double tip, double t) const {
  std::size_t row = 0;
  while (row + 1 < rows_.size() && rows_[row + 1][0] < t) ++row;
  return row + 1 == rows_.size() ? 0 : std::max(tip + rows_[row][1], 0.);
}

}  // namespace stroma
