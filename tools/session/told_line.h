// SPDX-License-Identifier: LGPL-2.1-or-later
// How far something is, as a line on standard error.
#pragma once
#include <cstddef>
#include <string>

namespace stroma {

/// The line of the terminal that is told anew, in place of what it said before. Where standard error is no terminal that
/// can do that, each telling is a line of its own.
class ToldLine {
 public:
  ToldLine();
  ~ToldLine() { clear(); }
  bool isOnTerminal() const { return is_on_terminal_; }
  /// Bytes that fit; the last column of a terminal stays empty.
  std::size_t width() const;
  void tell(const std::string& text);
  /// The terminal's line is empty: before anything else is printed.
  void clear();
  /// Somebody else has written on it: nothing is left to clear.
  void leave() { is_open_ = false; }

 private:
  const bool is_on_terminal_;
  bool is_open_ = false;
};

/// "0.4 s", "12 s", "3 min 20 s", "2 h 5 min", "3 d 4 h".
std::string durationText(double seconds);
/// `head` and `tail` in a line of at most `width` bytes: the end of `head` goes first. No character is cut in two.
std::string fittedLine(std::string head, std::string tail, std::size_t width);

}  // namespace stroma
