// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/left_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>
#include <stdexcept>

namespace stroma {
namespace {

const void* const here = reinterpret_cast<const void*>(&runOrLeave);

TEST(LeftWork, IsWaitedForWhenNobodyStopsIt) {
  StopRequest request;
  const auto result = std::make_shared<int>(0);
  EXPECT_TRUE(runOrLeave([result] { *result = 7; }, here, StopToken(request)));
  EXPECT_EQ(*result, 7);
  EXPECT_EQ(result.use_count(), 1) << "what it owned has gone";
}

TEST(LeftWork, AStopDoesNotWaitForItsEnd) {
  StopRequest request;
  struct Shared {
    std::latch may_end{1}, has_ended{1};
  };
  const auto shared = std::make_shared<Shared>();
  request.make();
  EXPECT_FALSE(runOrLeave(
      [shared] {
        shared->may_end.wait();
        shared->has_ended.count_down();
      },
      here, StopToken(request)));
  EXPECT_FALSE(shared->has_ended.try_wait());
  shared->may_end.count_down();
  shared->has_ended.wait();
}

TEST(LeftWork, WhatItThrowsIsThrown) {
  StopRequest request;
  EXPECT_THROW(runOrLeave([] { throw std::runtime_error("no memory"); }, here, StopToken(request)), std::runtime_error);
}

}  // namespace
}  // namespace stroma
