// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/processors.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>

namespace stroma {
namespace {

namespace fs = std::filesystem;
constexpr double no_quota = std::numeric_limits<double>::infinity();

/// quota / period of one group; a text for no limit ("max") is no number.
double quotaOf(const fs::path& group) {
  double quota = 0, period = 0;
  if (std::ifstream both(group / "cpu.max"); both >> quota >> period && period > 0) return quota / period;
  std::ifstream first(group / "cpu.cfs_quota_us"), second(group / "cpu.cfs_period_us");
  return first >> quota && second >> period && quota > 0 && period > 0 ? quota / period : no_quota;
}

}  // namespace

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

double processorQuota(const std::string& groups, const fs::path& root) {
  double least = no_quota;
  std::istringstream lines(groups);
  for (std::string line; std::getline(lines, line);) {  // number:controllers:path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && ("," + controllers + ",").find(",cpu,") == std::string::npos) continue;
    const fs::path top = controllers.empty() ? root : root / controllers;
    // a group may use what all groups around it may; a path outside of a container's own folder does not exist here
    fs::path group = top / fs::path(line.substr(second + 1)).relative_path();
    for (; group.string().size() > top.string().size(); group = group.parent_path()) least = std::min(least, quotaOf(group));
    least = std::min(least, quotaOf(top));
  }
  return least;
}

int usableCores() {
  static const int count = [] {
    std::ifstream stream("/proc/self/cgroup");
    const std::string groups{std::istreambuf_iterator<char>(stream), {}};
    return int(std::clamp(processorQuota(groups, "/sys/fs/cgroup"), 1., double(physicalCores().size())));
  }();
  return count;
}

}  // namespace stroma
