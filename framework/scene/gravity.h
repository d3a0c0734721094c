// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma {

/// Reads the attribute gravity of a node [m/s^2]. One number alone acts along y, as SOFA's default does: `note` then
/// says so. On a problem `gravity` keeps its value.
[[nodiscard]] std::optional<Problem> readGravity(std::string_view text, Vec3& gravity, std::string& note);

/// The 9.81 m/s^2 that act along -y where a scene writes no gravity, in the system of units that it declares. tools/units
/// answers. Throws ComponentError for what is no system.
struct DefaultGravity {
  double value = 9.81;
  std::string unit;  ///< "mm/s^2"; empty in SI
};
DefaultGravity defaultGravity(std::string_view units);

}  // namespace stroma
