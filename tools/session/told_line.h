// SPDX-License-Identifier: LGPL-2.1-or-later
// A progress line on standard error.
#pragma once
#include <cstddef>
#include <string>

namespace stroma {

/// A terminal line that is updated in place. If standard error does not support that, each update is a separate
/// line.
class ToldLine {
 public:
  ToldLine();
  ~ToldLine() { clear(); }
  bool isOnTerminal() const { return is_on_terminal_; }
  /// Bytes that fit; the last column of a terminal stays empty.
  std::size_t width() const;
  void tell(const std::string& text);
  /// Clears the line, before anything else is printed.
  void clear();
  /// Something else has been printed on it: nothing is left to clear.
  void leave() { is_open_ = false; }

 private:
  const bool is_on_terminal_;
  bool is_open_ = false;
};

/// "0.4 s", "12 s", "3 min 20 s", "2 h 5 min", "3 d 4 h".
std::string durationText(double seconds);
/// `head` and `tail` in a line of at most `width` bytes: `head` is truncated first. Characters are never split.
std::string fittedLine(std::string head, std::string tail, std::size_t width);

}  // namespace stroma
