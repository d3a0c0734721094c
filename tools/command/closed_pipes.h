// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma::command {

/// From now on what is printed for a reader who has gone is dropped: `head` has what it wanted, or the terminal was
/// closed. Work whose result is in files goes on to its end. A full disk remains an error.
void outliveReaders();

}  // namespace stroma::command
