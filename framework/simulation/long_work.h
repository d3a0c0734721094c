// SPDX-License-Identifier: LGPL-2.1-or-later
// Long work before the first step says how far it is to who listens; nothing is printed here.
#pragma once
#include <functional>
#include <memory>
#include <string>

namespace stroma {

/// Hears of one piece of long work, until it is done. Called by one thread at a time.
class LongWorkListener {
 public:
  virtual ~LongWorkListener() = default;
  /// The share that is done; one may be below an earlier one.
  virtual void say(double share) = 0;
  /// A sentence for who waits.
  virtual void advise(const std::string& sentence) = 0;
};

/// Makes the listener for work that takes about so many operations, or null when nobody wants to hear of it.
using MakeLongWorkListener =
    std::function<std::unique_ptr<LongWorkListener>(const std::string& what, double operations)>;

/// Who listens to all long work of the process from now on; empty, as at the start: nobody. Not while work goes on.
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
