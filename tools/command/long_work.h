// SPDX-License-Identifier: LGPL-2.1-or-later
// Lines on standard error that tell how far something is.
#pragma once
#include <cstddef>
#include <string>

namespace stroma::command {

/// Tells on standard error how far long work before the first step is: in place on a terminal, else a line each
/// quarter, with the time that the rest will take. False: nothing is told.
void tellLongWork(bool wanted);

/// Whether long work is telling how far it is: nobody else then writes on the terminal's line.
bool isTellingLongWork();

/// "0.4 s", "12 s", "3 min 20 s", "2 h 5 min", "3 d 4 h".
std::string durationText(double seconds);

/// Bytes of one line of the terminal on standard error; the last column stays empty.
std::size_t terminalWidth();
/// `head` and `tail` in a line of at most `width` bytes: the end of `head` goes first. No character is cut in two.
std::string fittedLine(std::string head, std::string tail, std::size_t width);

}  // namespace stroma::command
