// SPDX-License-Identifier: LGPL-2.1-or-later
// The heap of a process that simulates: the command, or an interpreter that has loaded the module.
#pragma once
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace stroma {

/// Whether the kernel counts reserved addresses as memory.
inline bool countsAddresses() {
  char setting = 0;
  const int file = open("/proc/sys/vm/overcommit_memory", O_RDONLY | O_CLOEXEC);
  const bool is_read = file >= 0 && read(file, &setting, 1) == 1;
  if (file >= 0) close(file);
  return is_read && setting == '2';
}

/// Places the heap on huge pages, if the kernel grants them, and keeps freed memory in it: touching new memory in small pages
/// costs more than building a matrix in it. Reserved addresses take no memory. At most `most` bytes, half of the
/// machine's memory, and a quarter of the process's limit are reserved; free memory at the end beyond twice that is returned.
inline void reserveHeap(std::size_t most) {
#ifdef M_TOP_PAD
  constexpr std::size_t megabyte = std::size_t{1} << 20, huge_page = 2 * megabyte, large = 2047 * megabyte;  // what an int holds
  std::size_t addresses = std::min(most, std::size_t(sysconf(_SC_PHYS_PAGES)) / 2 * std::size_t(sysconf(_SC_PAGESIZE)));
  if (countsAddresses()) addresses = std::min(addresses, 256 * megabyte);
  if (rlimit limit{}; getrlimit(RLIMIT_AS, &limit) == 0) addresses = std::min<std::size_t>(addresses, limit.rlim_cur / 4);
  mallopt(M_MMAP_THRESHOLD, int(32 * megabyte));  // the most that it takes
  mallopt(M_TRIM_THRESHOLD, int(std::min(2 * addresses, large)));
  mallopt(M_TOP_PAD, int(addresses));
  const auto first = (reinterpret_cast<std::uintptr_t>(sbrk(0)) + huge_page - 1) / huge_page * huge_page;
  void* volatile grown = std::malloc(31 * megabyte);  // more than an interpreter has at hand
  std::free(grown);
  const auto end = reinterpret_cast<std::uintptr_t>(sbrk(0));
  if (end > first) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  mallopt(M_TOP_PAD, int(16 * megabyte));
#endif
}

}  // namespace stroma
