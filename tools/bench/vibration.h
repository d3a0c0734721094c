// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace stroma::bench {

constexpr const char* vibration = "vibration";  ///< its name

/// What integrators make of a bar that vibrates in its first mode: errors of phase and of energy after five periods. Prints
/// a table and sentences, and adds lines to `csv`. `sizes`: steps a period; none stands for all.
void compareVibration(const std::vector<int>& sizes, std::string& csv);
std::vector<int> vibrationSizes();

}  // namespace stroma::bench
