// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma::bench {

/// What is slower, quicker, more or less accurate than in a stored table of the standing set, beyond what differs everywhere. How
/// fast the machine is falls out: times are held against the median of all their ratios, and the noise is how far these lie
/// apart. Sentences, one a line. Throws std::runtime_error for a file that is no such table, or has none of these rows.
std::string changesSince(const std::string& stored_file, const std::string& csv);

}  // namespace stroma::bench
