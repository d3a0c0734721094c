// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma::command {

/// Tells on standard error how far long work before the first step is: in place on a terminal, else a line each quarter, with
/// the time that the rest will take. False: nothing is printed.
void tellLongWork(bool wanted);

/// Whether long work is telling how far it is: nobody else then writes on the terminal's line.
bool isTellingLongWork();

}  // namespace stroma::command
