// SPDX-License-Identifier: LGPL-2.1-or-later
// Work in processes of its own: what is late, what stands still, what crashes, and what is left when the parent is gone.
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tools/session/children.h"

namespace stroma::test {
namespace {

void spin(double seconds) {
  volatile double sum = 0;
  for (const std::clock_t end = std::clock() + std::clock_t(seconds * CLOCKS_PER_SEC); std::clock() < end;)
    for (int i = 0; i < 10000; ++i) sum = sum + i;
}
void sleepFor(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

ChildEnd endOf(Children& children) {
  ChildEnd end;
  for (int k = 0; k < 6000 && !children.wait(end); ++k) {  // ten minutes: only what hangs takes so long
  }
  return end;
}

TEST(StressChildren, GiveBackWhatTheyReturn) {
  Children children;
  const std::string large(300000, 'x');  // more than a pipe holds
  children.start(3, 10, [&] { return large; });
  const ChildEnd end = endOf(children);
  EXPECT_EQ(end.number, 3);
  EXPECT_EQ(end.text, large);
  EXPECT_EQ(end.failure, "");
  EXPECT_EQ(children.running(), 0u);
}

TEST(StressChildren, AreLateByTheirOwnWorkAlone) {
  Children children;
  // waiting for a core is none: as on a machine that others use
  children.start(1, 0.3, [] { return sleepFor(1), std::string("slept"); });
  ChildEnd end = endOf(children);
  EXPECT_EQ(end.text, "slept") << end.failure;
  EXPECT_FALSE(end.is_late);
  children.start(2, 0.3, [] { return spin(100), std::string("worked"); });
  end = endOf(children);
  EXPECT_TRUE(end.is_late);
  EXPECT_EQ(end.failure, "abandoned after 0.3 s of processor time");
}

TEST(StressChildren, ThatStandStillAreNotWaitedFor) {
  Children children(1);
  children.start(1, 100, [] { return sleepFor(1000), std::string("slept"); });
  const ChildEnd end = endOf(children);
  EXPECT_FALSE(end.is_late) << "a standstill is a fault, and no lack of time";
  EXPECT_EQ(end.failure, "it hangs: no processor time used in 1 s");
}

TEST(StressChildren, ThatCrashAreNoSuccess) {
  Children children;
  children.start(1, 10, []() -> std::string { std::abort(); });
  EXPECT_EQ(endOf(children).failure, "it crashes with SIGABRT");
  children.start(2, 10, []() -> std::string { throw 1; });
  EXPECT_EQ(endOf(children).failure, "its process ends with code 0 and no message");
  children.start(3, 10, []() -> std::string { _exit(7); });
  EXPECT_EQ(endOf(children).failure, "its process ends with code 7 and no message");
}

/// What a pipe says within ten minutes: a number, 0 at its end, -1 for nothing.
pid_t numberFrom(int pipe) {
  pollfd ready{pipe, POLLIN, 0};
  if (poll(&ready, 1, 600'000) <= 0) return -1;
  pid_t number = 0;
  return read(pipe, &number, sizeof number) == ssize_t(sizeof number) ? number : 0;
}

TEST(StressChildren, EndWithTheirParentHoweverItEnds) {
  for (const bool is_killed : {false, true}) {
    int pipe[2], heard[2];
    ASSERT_EQ(::pipe(pipe), 0);
    ASSERT_EQ(::pipe(heard), 0);
    const pid_t parent = fork();
    if (parent == 0) {
      close(pipe[0]);
      close(heard[1]);
      {
        Children children;
        children.start(1, 1000, [&] {
          const pid_t self = getpid();
          if (write(pipe[1], &self, sizeof self) < 0) return std::string();
          return sleepFor(1000), std::string();  // holds the pipe as long as it lives
        });
        close(pipe[1]);
        if (is_killed) sleepFor(1000);
        numberFrom(heard[0]);  // its end: somebody has heard the child
      }
      _exit(0);
    }
    close(pipe[1]);
    close(heard[0]);
    EXPECT_GT(numberFrom(pipe[0]), 0);
    if (is_killed) kill(parent, SIGKILL);
    close(heard[1]);
    waitpid(parent, nullptr, 0);
    EXPECT_EQ(numberFrom(pipe[0]), 0) << "its child lives on";
    close(pipe[0]);
  }
}

}  // namespace
}  // namespace stroma::test
