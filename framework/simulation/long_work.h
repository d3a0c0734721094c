// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <string>

namespace stroma {

/// False: nothing is told of long work. True when nothing was said.
void tellLongWork(bool wanted);

/// "0.4 s", "12 s", "3 min 20 s", "2 h 5 min", "3 d 4 h".
std::string durationText(double seconds);

/// Bytes of one line of the terminal on standard error; the last column stays empty.
std::size_t terminalWidth();
/// `head` and `tail` in a line of at most `width` bytes: the end of `head` goes first. No character is cut in two.
std::string fittedLine(std::string head, std::string tail, std::size_t width);

/// Whether long work is telling how far it is: nobody else then writes on the terminal's line.
bool isTellingLongWork();

/// Tells on standard error how far long work before the first step is: in place on a terminal, else a line each
/// quarter, with the time that the rest will take.
class LongWork {
 public:
  /// Work of few operations is not told of.
  LongWork(std::string what, double operations);
  LongWork(const LongWork&) = delete;
  ~LongWork();
  /// The share that is done; one that is below an earlier one says nothing.
  void say(double share);
  /// A sentence for who waits: said where the work itself is told of.
  void advise(const std::string& sentence) const;

 private:
  std::string what_;
  bool terminal_, silent_;
  int last_ = -1;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace stroma
