// SPDX-License-Identifier: LGPL-2.1-or-later
// Memory for large arrays: cache-line aligned, and on huge pages where the kernel grants them, because a sweep over
// megabytes of small pages is limited by address translation.
#pragma once
#include <sys/mman.h>

#include <cstdlib>
#include <new>
#include <vector>

namespace stroma {

/// `bytes` of memory aligned to 64 bytes, to a huge page from 4 MB on. Freed by std::free. Throws std::bad_alloc.
inline void* allocateArray(std::size_t bytes) {
  constexpr std::size_t huge_page = std::size_t(2) << 20;
  const std::size_t alignment = bytes >= 2 * huge_page ? huge_page : 64;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded);
  if (!memory) throw std::bad_alloc();
  if (alignment == huge_page) madvise(memory, rounded, MADV_HUGEPAGE);  // a wish: refusing it costs nothing
  return memory;
}

/// std::vector's allocator on allocateArray().
template <class T>
struct ArrayAllocator {
  using value_type = T;
  ArrayAllocator() = default;
  template <class U>
  ArrayAllocator(const ArrayAllocator<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(allocateArray(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t) { std::free(memory); }
  bool operator==(const ArrayAllocator&) const { return true; }
};

/// A vector for arrays that loops over elements or blocks sweep.
template <class T>
using Array = std::vector<T, ArrayAllocator<T>>;

}  // namespace stroma
