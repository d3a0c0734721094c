// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace stroma {

/// The 9.81 m/s^2 that act along -y where a scene writes no gravity, in the system of units that it declares. tools/units
/// answers. Throws ComponentError for what is no system.
struct DefaultGravity {
  double value = 9.81;
  std::string unit;  ///< "mm/s^2"; empty in SI
};
DefaultGravity defaultGravity(std::string_view units);

}  // namespace stroma
