// SPDX-License-Identifier: LGPL-2.1-or-later
// The heap of a process that simulates: of the command, and of an interpreter that has opened the module.
#pragma once
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace stroma {

/// The heap goes on with addresses on huge pages, where the kernel gives them, and what is freed stays in it: to touch new memory in
/// small pages costs more than to make a matrix in it. Addresses alone take no memory.
inline void reserveHeap() {
#ifdef M_TOP_PAD
  constexpr int megabyte = 1 << 20, reserve = 256 * megabyte, later = 16 * megabyte;
  constexpr std::uintptr_t huge_page = 2 * megabyte;
  mallopt(M_MMAP_THRESHOLD, 32 * megabyte);  // the most that it takes
  mallopt(M_TRIM_THRESHOLD, 2 * reserve);
  mallopt(M_TOP_PAD, reserve);
  const auto first = (reinterpret_cast<std::uintptr_t>(sbrk(0)) + huge_page - 1) / huge_page * huge_page;
  void* volatile grown = std::malloc(31 * megabyte);  // more than an interpreter has at hand
  std::free(grown);
  const auto end = reinterpret_cast<std::uintptr_t>(sbrk(0));
  if (end > first) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  mallopt(M_TOP_PAD, later);
#endif
}

}  // namespace stroma
