// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/machine.h"

#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "framework/algebra/vector.h"
#include "framework/scene/modules.h"
#include "tools/bench/machine_kernels.h"

namespace stroma::bench {
namespace {

constexpr int repetitions = 15;
constexpr std::size_t large_doubles = std::size_t(1) << 24;   // 128 MB: many times a level-2 cache
constexpr std::size_t triad_doubles = std::size_t(1) << 23;   // three arrays of 64 MB
constexpr std::size_t fallback_cache = std::size_t(1) << 20;  // where the system does not tell the size

const MachineKernels& kernelsFor(const std::string& level) {
  if (level == "x86-64-v4") return machine_kernels_v4;
  return level == "x86-64-v3" ? machine_kernels_v3 : machine_kernels_v2;
}

/// Time that this thread had a core [s]: waiting for one does not count.
double threadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// `amount` a call over the time of a call, several times.
template <class Call>
std::vector<double> rates(double amount, int calls, Call&& call) {
  call();
  std::vector<double> result;
  for (int r = 0; r < repetitions; ++r) {
    const double start = threadSeconds();
    for (int i = 0; i < calls; ++i) call();
    result.push_back(amount * calls / (threadSeconds() - start));
  }
  return result;
}

double best(const std::vector<double>& values) { return *std::ranges::max_element(values); }

Vector filled(std::size_t doubles) {
  Vector vector(Index(doubles / row_doubles));
  std::fill_n(vector.rows().data, doubles, 1e-9);
  return vector;
}

std::string processorName() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

}  // namespace

Machine measureMachine() {
  Machine machine;
  machine.processor = processorName();
  machine.level = instructionLevel();
  const MachineKernels& kernels = kernelsFor(machine.level);
  machine.lanes = kernels.lanes;
  const long reported = sysconf(_SC_LEVEL2_CACHE_SIZE);
  const double cache = double(reported > 0 ? std::size_t(reported) : fallback_cache);
  machine.cache_bytes = cache;

  const Vector large = filled(large_doubles);
  for (const double part : {0.5, 1.0, 1.5, 2.0, 4.0, 16.0, 64.0}) {
    const std::size_t doubles = std::min(large_doubles, std::size_t(part * cache / sizeof(double)) / 64 * 64);
    const double bytes = double(doubles) * sizeof(double);
    machine.figures.push_back({fmt::format("read bandwidth, {:.3g} MB", bytes / (1 << 20)), "GB/s",
                               rates(bytes, int(1 + large_doubles / 8 / doubles),
                                     [&] { benchmark::DoNotOptimize(kernels.sum(large.rows().data, doubles)); })});
    machine.limits.read.push_back({bytes, best(machine.figures.back().rates)});
  }
  Vector a = filled(triad_doubles);
  const Vector b = filled(triad_doubles), c = filled(triad_doubles);
  machine.figures.push_back({"triad a = b + s c, 192 MB", "GB/s", rates(3.0 * triad_doubles * sizeof(double), 1, [&] {
                               kernels.triad(a.rows().data, b.rows().data, c.rows().data, 0.5, triad_doubles);
                               benchmark::ClobberMemory();
                             })});
  constexpr std::size_t rounds = 200000;
  machine.figures.push_back({"multiply-add peak", "Gflop/s", rates(double(kernels.round_flops) * rounds, 2, [&] {
                               benchmark::DoNotOptimize(kernels.multiplyAdd(rounds));
                             })});
  machine.limits.peak = best(machine.figures.back().rates);
  for (MachineFigure& figure : machine.figures)
    for (double& rate : figure.rates) rate *= 1e-9;
  return machine;
}

}  // namespace stroma::bench
