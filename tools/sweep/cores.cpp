// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/cores.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

namespace stroma::sweep {

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
