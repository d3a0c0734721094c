// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma {

/// Reads the attribute gravity of a node [m/s^2]. A single number acts along y, as SOFA's default does, and `note` then
/// says so. On an error `gravity` keeps its value.
[[nodiscard]] std::optional<Problem> readGravity(std::string_view text, Vec3& gravity, std::string& note);

/// The default gravity, 9.81 m/s^2 along -y, in the system of units that a scene declares. Implemented in tools/units.
/// Throws ComponentError for an invalid system.
struct DefaultGravity {
  double value = 9.81;
  std::string unit;  ///< "mm/s^2"; empty in SI
};
DefaultGravity defaultGravity(std::string_view units);

}  // namespace stroma
