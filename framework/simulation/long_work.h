// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma {

/// False: nothing is told of long work. True when nothing was said.
void tellLongWork(bool wanted);

/// Tells on standard error how far long work before the first step is: in place on a terminal, else a line each
/// quarter.
class LongWork {
 public:
  /// Work of few operations is not told of.
  LongWork(std::string what, double operations);
  /// The share that is done; one that is below an earlier one says nothing.
  void say(double share);
  /// A sentence for who waits: said where the work itself is told of.
  void advise(const std::string& sentence) const;

 private:
  std::string what_;
  bool terminal_, silent_;
  int last_ = -1;
};

}  // namespace stroma
