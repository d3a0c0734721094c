// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// Bounds on time steps [s]: their squares, and quotients by these, are finite numbers.
inline constexpr double shortest_time_step = 1e-150, longest_time_step = 1e150;

}  // namespace stroma
