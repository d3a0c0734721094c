// SPDX-License-Identifier: LGPL-2.1-or-later
// A figure: something measured, what it must move and compute at least, and what it is compared with.
#pragma once
#include <benchmark/benchmark.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace stroma::bench {

/// What an operation cannot do without: bytes read and written once each, floating-point operations (a multiply-add
/// counts two).
struct Work {
  double bytes = 0, flops = 0;
  Work operator+(const Work& other) const { return {bytes + other.bytes, flops + other.flops}; }
  Work operator*(double factor) const { return {bytes * factor, flops * factor}; }
};

/// Limits of one core.
struct Limits {
  struct Bandwidth {
    double bytes, rate;  ///< an array of this size, read again and again [bytes/s]
  };
  std::vector<Bandwidth> read;  ///< by ascending size
  double peak = 0;              ///< [flops/s]
  /// Between the measured sizes: linear in the logarithm of the size.
  double readRate(double working_set) const;
};

struct Figure {
  std::string name;              ///< "force/polar"
  std::string unit;              ///< "ns/tet", "ms/step"
  double per_second = 1;         ///< seconds of one iteration times this are in `unit`
  std::optional<double> target;  ///< at most this, in `unit`
  std::string peers;             ///< others on the same machine
  Work work;                     ///< of one iteration; zero: no share is printed
  double working_set = 0;        ///< [bytes] the operation goes over again and again
  bool wall = false;             ///< wall time; else the processor time of the one thread
};

/// Repetitions of a figure, in its unit.
struct Measurement {
  Figure figure;
  std::vector<double> wall, processor;
  std::string note;   ///< "5 CG iterations"
  std::string error;  ///< why there is no number
  const std::vector<double>& samples() const { return figure.wall ? wall : processor; }
};

double median(std::vector<double> values);
double least(const std::vector<double>& values);

/// The time that the limits of the machine allow for a figure's work [s], and which of the two binds.
struct Bound {
  double seconds = 0;
  const char* by = "";
};
Bound bound(const Figure& figure, const Limits& limits);

/// Two threads against one: the ratio of two figures' wall times.
struct Ratio {
  std::string name, slow, fast;
  double target = 0;
};

/// All that is measured in a run. `body` runs under Google Benchmark.
class Catalogue {
 public:
  benchmark::internal::Benchmark& add(const Figure& figure, std::function<void(benchmark::State&)> body);
  void addRatio(Ratio ratio) { ratios_.push_back(std::move(ratio)); }
  Measurement* find(const std::string& name);
  const std::vector<Measurement>& measurements() const { return measurements_; }
  const std::vector<Ratio>& ratios() const { return ratios_; }

 private:
  std::vector<Measurement> measurements_;
  std::vector<Ratio> ratios_;
};

}  // namespace stroma::bench
