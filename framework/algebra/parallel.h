// SPDX-License-Identifier: LGPL-2.1-or-later
// Threads. Work is cut in pieces that do not depend on the number of threads, so neither does any result.
#pragma once
#include <type_traits>

namespace stroma {

/// The number of threads that parallelFor may use; 1 unless setThreads() was called.
int threads();
/// For the whole process. Simulations of several threads may share the pool, and running loops finish on the old one.
void setThreads(int count);

namespace detail {
/// body(data, i) for i in [0, count) on the pool; returns when all are done.
void runParallel(int count, void (*body)(void*, int), void* data);
}  // namespace detail

/// body(0) ... body(count - 1), in any order and at once; with one thread a plain loop. The pieces must be large
/// (tens of microseconds) and write to places of their own.
template <class Body>
void parallelFor(int count, Body&& body) {
  if (threads() == 1 || count < 2) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  using Plain = std::remove_reference_t<Body>;
  detail::runParallel(
      count, [](void* data, int i) { (*static_cast<Plain*>(data))(i); },
      const_cast<void*>(static_cast<const void*>(&body)));
}

}  // namespace stroma
