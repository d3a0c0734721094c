// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma {

/// Reads the attribute gravity of a node [m/s^2]. A single number acts along y, like SOFA's default, and sets `note`. If
/// there is a problem, `gravity` keeps its value.
[[nodiscard]] std::optional<Problem> readGravity(std::string_view text, Vec3& gravity, std::string& note);

/// The default gravity of 9.81 m/s^2 along -y, in the unit system declared by the scene. Implemented in tools/units.
/// Throws ComponentError for an unknown system.
struct DefaultGravity {
  double value = 9.81;
  std::string unit;  ///< "mm/s^2"; empty in SI
};
DefaultGravity defaultGravity(std::string_view units);

}  // namespace stroma
