// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/figure.h"

#include <algorithm>
#include <cmath>

namespace stroma::bench {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

double least(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::min_element(values.begin(), values.end());
}

double Limits::readRate(double working_set) const {
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (working_set > read[i].bytes) continue;
    if (i == 0) break;
    const Bandwidth &below = read[i - 1], &above = read[i];
    const double part = std::log(working_set / below.bytes) / std::log(above.bytes / below.bytes);
    return below.rate + part * (above.rate - below.rate);
  }
  return working_set <= read.front().bytes ? read.front().rate : read.back().rate;
}

Bound bound(const Figure& figure, const Limits& limits) {
  const double moving = figure.work.bytes / limits.readRate(figure.working_set);
  const double computing = figure.work.flops / limits.peak;
  return moving > computing ? Bound{moving, "memory"} : Bound{computing, "arithmetic"};
}

benchmark::internal::Benchmark& Catalogue::add(const Figure& figure, std::function<void(benchmark::State&)> body) {
  measurements_.push_back({figure, {}, {}, {}, {}});
  auto* registered = benchmark::RegisterBenchmark(figure.name.c_str(), std::move(body));
  registered->Unit(benchmark::kMicrosecond);
  return *registered;
}

Measurement* Catalogue::find(const std::string& name) {
  const auto found = std::find_if(measurements_.begin(), measurements_.end(),
                                  [&](const Measurement& measurement) { return measurement.figure.name == name; });
  return found == measurements_.end() ? nullptr : &*found;
}

}  // namespace stroma::bench
