// SPDX-License-Identifier: LGPL-2.1-or-later
// Long work before the first step reports its progress to a listener; nothing is printed here.
#pragma once
#include <functional>
#include <memory>
#include <string>

namespace stroma {

/// Receives the progress of one piece of long work. Called by one thread at a time.
class LongWorkListener {
 public:
  virtual ~LongWorkListener() = default;
  /// The fraction that is done; it may decrease.
  virtual void say(double share) = 0;
  /// A sentence for the user who is waiting.
  virtual void advise(const std::string& sentence) = 0;
};

/// Makes the listener for work of about so many operations, or null if there is none.
using MakeLongWorkListener =
    std::function<std::unique_ptr<LongWorkListener>(const std::string& what, double operations)>;

/// Sets the listener of the whole process; empty, as at the start: nobody. Must not be called during long work.
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
