// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/cores.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace stroma::sweep {

std::vector<int> physicalCores() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return {0};
  std::set<std::string> seen;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &allowed)) continue;
    std::ifstream file(fmt::format("/sys/devices/system/cpu/cpu{}/topology/thread_siblings_list", cpu));
    std::string siblings;
    if (!std::getline(file, siblings)) siblings = std::to_string(cpu);
    if (seen.insert(siblings).second) cores.push_back(cpu);
  }
  return cores;
}

double loadOfMachine() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

double busySecondsIn(const std::string& text, const std::vector<int>& cores, double ticks_a_second) {
  double ticks = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    // user programs, patient ones, the system, idle, waiting for a disk, interrupts of two kinds, taken by a host
    std::array<double, 8> spent{};
    words >> name;
    for (double& one : spent) words >> one;
    const bool is_asked = std::ranges::any_of(cores, [&](int core) { return name == fmt::format("cpu{}", core); });
    if (is_asked) ticks += spent[0] + spent[1] + spent[2] + spent[5] + spent[6] + spent[7];
  }
  return ticks / ticks_a_second;
}

double busySeconds(const std::vector<int>& cores) {
  std::ifstream stream("/proc/stat");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return busySecondsIn(text, cores, double(sysconf(_SC_CLK_TCK)));
}

std::string hostName() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string machineText() {
  std::ifstream stream("/proc/cpuinfo");
  std::string processor = "unknown processor";
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with("model name")) {
      processor = line.substr(std::min(line.size(), line.find(':') + 2));
      break;
    }
  const std::size_t cores = physicalCores().size();
  return fmt::format("{}: {}, {} core{}", hostName(), processor, cores, cores == 1 ? "" : "s");
}

}  // namespace stroma::sweep
