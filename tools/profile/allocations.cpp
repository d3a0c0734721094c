// SPDX-License-Identifier: LGPL-2.1-or-later
// A library that is loaded before all others and counts what they take from the heap. Beside it nothing changes: memory comes
// from where it always does.
#include <cerrno>
#include <cstddef>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

struct Taken {
  long count, bytes;
};
__attribute__((tls_model("initial-exec"))) thread_local Taken of_thread{};

void note(std::size_t bytes) { ++of_thread.count, of_thread.bytes += long(bytes); }

}  // namespace

#define STROMA_SEEN extern "C" __attribute__((visibility("default")))

/// Where this thread's count is, as long as it lives.
STROMA_SEEN const volatile void* stroma_allocations_of_thread() { return &of_thread; }

STROMA_SEEN void* malloc(std::size_t size) {
  note(size);
  return __libc_malloc(size);
}
STROMA_SEEN void* calloc(std::size_t count, std::size_t size) {
  note(count * size);
  return __libc_calloc(count, size);
}
STROMA_SEEN void* realloc(void* old, std::size_t size) {
  note(size);
  return __libc_realloc(old, size);
}
STROMA_SEEN void* memalign(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
STROMA_SEEN void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
STROMA_SEEN int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  note(size);
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
