// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

namespace stroma {

/// A request to end the current work. The caller that runs the work owns it; any thread, or a signal handler, makes it.
class StopRequest {
 public:
  void make() { is_made_.store(true, std::memory_order_relaxed); }
  bool isMade() const { return is_made_.load(std::memory_order_relaxed); }
  /// Whether it was made; clears it.
  bool take() { return is_made_.exchange(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> is_made_ = false;
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler makes it");
};

/// Held by long work to ask whether it should end. Without a request it never says so. Costs one read of memory: it is
/// asked once per matrix product, per trial of a line search, per supernode of a factorisation.
class StopToken {
 public:
  StopToken() = default;
  explicit StopToken(const StopRequest& request) : request_(&request) {}
  bool isStopAsked() const { return request_ && request_->isMade(); }
  /// Whether it has a request at all.
  bool isWatched() const { return request_ != nullptr; }

 private:
  const StopRequest* request_ = nullptr;
};

}  // namespace stroma
