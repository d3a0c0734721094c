// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma::bench {

constexpr const char* vibration = "vibration";  ///< its name

/// What integrators make of a bar that vibrates in its first mode: errors of phase and of energy after five periods. Prints
/// a table and sentences, and adds lines to `csv`.
void compareVibration(std::string& csv);

}  // namespace stroma::bench
