// SPDX-License-Identifier: LGPL-2.1-or-later
// All memory that a test program takes by malloc, modules and libraries included, is counted. One file of a program includes this.
#pragma once
#include <cstdlib>

#if !defined(__SANITIZE_ADDRESS__)  // which has a malloc of its own
#define STROMA_COUNTS_ALLOCATIONS

namespace {
long allocations = 0;
}

extern "C" void* __libc_malloc(std::size_t size);
extern "C" __attribute__((visibility("default"))) void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
#endif
