// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/figure.h"

#include <algorithm>

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

Bound bound(const Figure& figure, const Limits& limits) {
  const bool cached = figure.working_set <= limits.cache_bytes;
  const double moving = figure.work.bytes / (cached ? limits.cache_read : limits.memory_read);
  const double computing = figure.work.flops / limits.peak;
  if (moving > computing) return {moving, cached ? "cache" : "memory"};
  return {computing, "arithmetic"};
}

benchmark::internal::Benchmark& Catalogue::add(Figure figure, std::function<void(benchmark::State&)> body) {
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
