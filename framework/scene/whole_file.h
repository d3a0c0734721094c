// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma {

/// Writes to another name and renames, so that nobody ever sees half a file. Throws std::runtime_error with a sentence;
/// a file that was there before is then still there.
void writeWholeFile(const std::string& path, const std::string& bytes);

}  // namespace stroma
