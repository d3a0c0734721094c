// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// A wish that the work under way ends. Who runs the work owns it; any thread, or a signal handler, makes it.
class StopRequest {
 public:
  void make() { is_made_.store(true, std::memory_order_relaxed); }
  bool isMade() const { return is_made_.load(std::memory_order_relaxed); }
  /// Whether it was made; from now on it is not.
  bool take() { return is_made_.exchange(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> is_made_ = false;
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler makes it");
};

/// What long work holds to ask whether it shall end. One without a request never says so. Costs a read of memory: it is
/// asked once for each product with a matrix, each trial of a line search, each supernode of a factorisation.
class StopToken {
 public:
  StopToken() = default;
  explicit StopToken(const StopRequest& request) : request_(&request) {}
  bool isStopAsked() const { return request_ && request_->isMade(); }
  /// Whether it can ever be asked.
  bool isWatched() const { return request_ != nullptr; }

 private:
  const StopRequest* request_ = nullptr;
};

}  // namespace stroma
