// SPDX-License-Identifier: LGPL-2.1-or-later
// Addresses that a process reserves for its heap: within what it may have, and not at the cost of what else needs some.
#include "tools/platform/heap.h"

#include <sys/wait.h>

#include <gtest/gtest.h>

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr std::size_t megabyte = std::size_t{1} << 20;

struct Grown {
  bool has_memory;  ///< afterwards, for what is mapped for itself
  std::size_t heap;  ///< bytes by which the heap of a new process grows
  std::size_t all;   ///< addresses that the process may have
};

/// `limit`: of addresses besides those that the process has; 0: none.
Grown grownBy(std::size_t most, std::size_t limit) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    std::size_t all = 0;
    if (limit > 0) {
      long pages = 0;
      FILE* sizes = std::fopen("/proc/self/statm", "r");
      const bool is_read = sizes && std::fscanf(sizes, "%ld", &pages) == 1;
      all = std::size_t(pages) * std::size_t(sysconf(_SC_PAGESIZE)) + limit;
      const rlimit addresses{all, all};
      if (!is_read || setrlimit(RLIMIT_AS, &addresses) != 0) _exit(1);
    }
    const auto before = reinterpret_cast<std::uintptr_t>(sbrk(0));
    reserveHeap(most);
    const auto after = reinterpret_cast<std::uintptr_t>(sbrk(0));
    void* volatile large = std::malloc(40 * megabyte);
    const Grown grown{large != nullptr, after - before, all};
    _exit(write(ends[1], &grown, sizeof grown) == sizeof grown ? 0 : 1);
  }
  close(ends[1]);
  Grown grown{};
  const bool is_told = read(ends[0], &grown, sizeof grown) == sizeof grown;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return is_told ? grown : Grown{};
}

constexpr std::size_t for_growing = 32 * megabyte;  // what reserveHeap() asks for, for the heap to grow

TEST(Heap, HasTheAddressesThatAreAskedFor) {
  const Grown grown = grownBy(200 * megabyte, 0);
  EXPECT_TRUE(grown.has_memory);
  EXPECT_GE(grown.heap, 200 * megabyte);
  EXPECT_LE(grown.heap, 200 * megabyte + for_growing);
}

TEST(Heap, LeavesThreeQuartersOfWhatAProcessMayHave) {
  const Grown grown = grownBy(2000 * megabyte, 400 * megabyte);
  EXPECT_TRUE(grown.has_memory);
  EXPECT_GE(grown.heap, grown.all / 4);
  EXPECT_LE(grown.heap, grown.all / 4 + for_growing);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
