// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma::bench {

/// Bends a cantilever to rest with every method on finer and finer meshes; prints the error of the tip against the time
/// of the solution, and writes it to `csv_file` unless that is empty. Throws std::runtime_error.
void compareAccuracy(const std::string& csv_file);

}  // namespace stroma::bench
