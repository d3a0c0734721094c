// SPDX-License-Identifier: LGPL-2.1-or-later
// The processors that this process may use.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace stroma {

/// One processor of each physical core in the affinity of this process, by their numbers in the system: the second thread of a
/// core would disturb the first.
std::vector<int> physicalCores();

/// Processors that the quotas of control groups allow; infinity if there is no quota. `groups` is the text of /proc/self/cgroup, and
/// `root` the folder of the groups, /sys/fs/cgroup. Versions 1 and 2.
double processorQuota(const std::string& groups, const std::filesystem::path& root);

/// Physical cores within affinity and quota, at least 1. Read once.
int usableCores();

}  // namespace stroma
