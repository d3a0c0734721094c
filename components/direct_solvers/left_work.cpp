// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/left_work.h"

#include <dlfcn.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace stroma {
namespace {

constexpr auto asked_every = std::chrono::milliseconds(20);

/// What the two threads share; the last of them to go frees it.
struct Call {
  std::function<void()> work;
  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false;
  std::exception_ptr error;

  void make() {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    work = nullptr;  // what it owns goes here, and not while somebody holds the lock
    const std::lock_guard lock(mutex);
    error = thrown;
    ended = true;
    changed.notify_one();
  }
};

/// A module that is closed while its code runs would take the ground from under it.
void keepOpen(const void* code) {
  Dl_info info;
  if (dladdr(code, &info) != 0) dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
}

}  // namespace

bool runOrLeave(std::function<void()> work, const void* code, StopToken stop) {
  const auto call = std::make_shared<Call>();
  call->work = std::move(work);
  std::thread thread([call] { call->make(); });
  std::unique_lock lock(call->mutex);
  while (!call->changed.wait_for(lock, asked_every, [&] { return call->ended; }))
    if (stop.isStopAsked()) {
      keepOpen(code);
      thread.detach();
      return false;
    }
  lock.unlock();
  thread.join();
  if (call->error) std::rethrow_exception(call->error);
  return true;
}

}  // namespace stroma
