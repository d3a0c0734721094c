// SPDX-License-Identifier: LGPL-2.1-or-later
// Gives a compiler memory on huge pages. It is preloaded into the compilers of a build (cmake/on_huge_pages.sh).
//
// A compiler touches hundreds of megabytes once. GCC's own heap and its precompiled headers come from mmap in pages of 4 kB, and
// each one is a page fault. On a virtual machine a fault costs 10 to 16 us, and every access that misses the translation buffer
// walks two sets of tables. There a build takes a quarter less time with this: docs/install.md has the numbers.
//
// Large requests for anonymous memory get a piece of one range of addresses that asks for huge pages. Memory that nobody touches
// takes none. A file that is mapped to be written, which is a precompiled header, is read into such memory instead: nobody else
// sees what is written there. Whatever does not fit goes to the system as it is.
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

constexpr std::size_t huge_page = std::size_t{2} << 20;
constexpr std::size_t smallest = std::size_t{64} << 10;
constexpr std::size_t range = std::size_t{8} << 30;

std::atomic<std::uintptr_t> next{0};
std::uintptr_t end = 0;  // 0: there is no range

void* map(void* address, std::size_t size, int protection, int flags, int file, off_t offset) {
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, size, protection, flags, file, offset));
}

__attribute__((constructor)) void reserve() {
  void* memory = map(nullptr, range + huge_page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return;  // little address space: nothing changes
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(memory) + huge_page - 1) / huge_page * huge_page;
  if (madvise(reinterpret_cast<void*>(begin), range, MADV_HUGEPAGE) != 0) return;
  next = begin;
  end = begin + range;
}

// A private copy of the file's bytes, at the address that was asked for.
void* mapCopy(void* address, std::size_t size, int flags, int file, off_t offset) {
  void* memory = map(address, size, PROT_READ | PROT_WRITE, flags | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return memory;
  madvise(memory, size, MADV_HUGEPAGE);
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = pread(file, static_cast<char*>(memory) + done, size - done, offset + static_cast<off_t>(done));
    if (count == 0) break;  // the file ends within its last page
    if (count < 0) {
      munmap(memory, size);
      return MAP_FAILED;
    }
    done += static_cast<std::size_t>(count);
  }
  return memory;
}

}  // namespace

extern "C" void* mmap(void* address, std::size_t size, int protection, int flags, int file, off_t offset) noexcept {
  const bool is_large = end != 0 && size >= smallest && protection == (PROT_READ | PROT_WRITE) && (flags & MAP_PRIVATE);
  if (is_large && flags == (MAP_PRIVATE | MAP_ANONYMOUS) && address == nullptr) {
    const std::size_t pages = (size + 4095) / 4096 * 4096;
    const std::uintptr_t piece = next.fetch_add(pages);
    if (piece <= end && pages <= end - piece) return reinterpret_cast<void*>(piece);
    next = end;  // what is left is too small
  }
  if (is_large && !(flags & MAP_ANONYMOUS) && address != nullptr && size >= huge_page)
    return mapCopy(address, size, flags, file, offset);
  return map(address, size, protection, flags, file, offset);
}

extern "C" void* mmap64(void* address, std::size_t size, int protection, int flags, int file, off_t offset) noexcept
    __attribute__((alias("mmap")));
