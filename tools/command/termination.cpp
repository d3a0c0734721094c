// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/termination.h"

#include <csignal>
#include <mutex>
#include <thread>

namespace stroma::command {
namespace {

struct Termination {
  std::mutex mutex;
  std::function<void()> act;
};

/// Never destroyed: the thread that waits outlives main().
Termination& termination() {
  static Termination& one = *new Termination;
  return one;
}

sigset_t setOf(int number) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, number);
  return set;
}

}  // namespace

void endBy(int number) {
  std::signal(number, SIG_DFL);
  const sigset_t set = setOf(number);
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  std::raise(number);
}

void onTermination(std::function<void()> act) {
  const std::lock_guard lock(termination().mutex);
  termination().act = std::move(act);
}

void hearTermination() {
  const sigset_t set = setOf(SIGTERM);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  termination();
  std::thread([set] {
    for (int number = 0; sigwait(&set, &number) == 0;) {
      const std::lock_guard lock(termination().mutex);
      if (termination().act)
        termination().act();
      else
        endBy(number);
    }
  }).detach();
}

}  // namespace stroma::command
