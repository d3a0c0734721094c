// SPDX-License-Identifier: LGPL-2.1-or-later
// Addresses that a process reserves for its heap: within what it may have, and not at the cost of what else needs some.
#include "tools/platform/heap.h"

#include <sys/wait.h>

#include <gtest/gtest.h>

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr std::size_t megabyte = std::size_t{1} << 20;

/// Megabytes by which the heap of a new process grows; -1 where it has no memory afterwards. `limit`: of addresses besides those that the
/// process has; 0: none.
int growthOf(std::size_t most, std::size_t limit) {
  const pid_t child = fork();
  if (child == 0) {
    if (limit > 0) {
      long pages = 0;
      FILE* sizes = std::fopen("/proc/self/statm", "r");
      const bool is_read = sizes && std::fscanf(sizes, "%ld", &pages) == 1;
      const rlim_t all = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + limit;
      const rlimit addresses{all, all};
      if (!is_read || setrlimit(RLIMIT_AS, &addresses) != 0) _exit(254);
    }
    const auto before = reinterpret_cast<std::uintptr_t>(sbrk(0));
    reserveHeap(most);
    const auto after = reinterpret_cast<std::uintptr_t>(sbrk(0));
    void* volatile large = std::malloc(40 * megabyte);  // what is mapped for itself
    _exit(large ? int((after - before) / (10 * megabyte)) : 255);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int tens = WEXITSTATUS(status);
  return WIFEXITED(status) && tens < 254 ? 10 * tens : -1;
}

TEST(Heap, HasTheAddressesThatAreAskedFor) {
  EXPECT_GE(growthOf(200 * megabyte, 0), 190);
  EXPECT_LE(growthOf(200 * megabyte, 0), 240);
}

TEST(Heap, LeavesThreeQuartersOfWhatAProcessMayHave) {
  const int growth = growthOf(2000 * megabyte, 400 * megabyte);
  EXPECT_GE(growth, 90);
  EXPECT_LE(growth, 250);  // the test program takes addresses too, which count
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
