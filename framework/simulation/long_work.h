// SPDX-License-Identifier: LGPL-2.1-or-later
// Progress reports of long work before the first step; nothing is printed here.
#pragma once
#include <functional>
#include <memory>
#include <string>

namespace stroma {

/// Receives the progress of one piece of long work. Called by one thread at a time.
class LongWorkListener {
 public:
  virtual ~LongWorkListener() = default;
  /// The fraction done; it may be lower than an earlier one.
  virtual void say(double share) = 0;
  /// A message for the user.
  virtual void advise(const std::string& sentence) = 0;
};

/// Makes the listener for work of about this many operations, or null if nobody listens.
using MakeLongWorkListener =
    std::function<std::unique_ptr<LongWorkListener>(const std::string& what, double operations)>;

/// Sets the listener to all long work of the process; empty, as initially: none. Not while work is in progress.
void listenToLongWork(MakeLongWorkListener make);

class LongWork {
 public:
  LongWork(const std::string& what, double operations);
  void say(double share) {
    if (listener_) listener_->say(share);
  }
  void advise(const std::string& sentence) {
    if (listener_) listener_->advise(sentence);
  }

 private:
  std::unique_ptr<LongWorkListener> listener_;
};

}  // namespace stroma
