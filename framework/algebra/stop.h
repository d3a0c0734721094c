// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// A request to end the work in progress. The caller of the work owns it; any thread, or a signal handler, may set it.
class StopRequest {
 public:
  void make() { is_made_.store(true, std::memory_order_relaxed); }
  bool isMade() const { return is_made_.load(std::memory_order_relaxed); }
  /// Whether it was set; clears it.
  bool take() { return is_made_.exchange(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> is_made_ = false;
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler makes it");
};

/// Lets long work check for a stop request. A token without a request never stops. A check costs one read of memory: it is
/// made once per matrix product, per trial of a line search, and per supernode of a factorisation.
class StopToken {
 public:
  StopToken() = default;
  explicit StopToken(const StopRequest& request) : request_(&request) {}
  bool isStopAsked() const { return request_ && request_->isMade(); }
  /// Whether a request is attached.
  bool isWatched() const { return request_ != nullptr; }

 private:
  const StopRequest* request_ = nullptr;
};

}  // namespace stroma
