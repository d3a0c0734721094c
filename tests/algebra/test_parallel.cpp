// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

using namespace stroma;

TEST(Parallel, EveryPieceRunsOnceForAnyNumberOfThreads) {
  for (const int count : {1, 2, 5, 1}) {
    setThreads(count);
    EXPECT_EQ(threads(), count);
    std::vector<std::atomic<int>> runs(1000);
    parallelFor(1000, [&](int i) { ++runs[i]; });
    for (const auto& run : runs) ASSERT_EQ(run, 1);
  }
}

TEST(Parallel, SeveralThreadsTakePartAndNoMoreThanAsked) {
  setThreads(2);
  std::mutex mutex;
  std::set<std::thread::id> seen;
  std::atomic<int> at_once{0}, most{0};
  // two pieces that wait for each other can only end when two threads run them
  std::atomic<int> arrived{0};
  parallelFor(2, [&](int) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(seen.size(), 2u);
  // another thread may take the place of one of them, and no third one works beside them
  parallelFor(200, [&](int) {
    for (int now = ++at_once, before = most; now > before && !most.compare_exchange_weak(before, now);) {
    }
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    --at_once;
  });
  setThreads(1);
  EXPECT_LE(most, 2);
}

TEST(Parallel, LessThanOneThreadIsOne) {
  setThreads(0);
  EXPECT_EQ(threads(), 1);
}
