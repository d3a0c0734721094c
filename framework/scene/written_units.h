// SPDX-License-Identifier: LGPL-2.1-or-later
// The units that a scene is written in. Internally every value is in the unit that its attribute declares, which is SI
// (except for angles in degrees). Implemented in tools/units.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

struct NodeDescription;
struct Problem;
struct Scene;

/// Converts numbers with units to plain numbers in the unit `declared` of an attribute; none if `text` has neither a
/// unit nor a fraction, or is indistinguishable from a typing error. One unit at the end applies to all numbers, else
/// each has its own. `declared` may name two units, as "N or N s". Throws ComponentError.
std::optional<std::string> withoutUnits(std::string_view text, std::string_view declared);

/// How many metres one `unit` of length is; 1 for none. Throws ComponentError for what is no unit of length.
double metresOf(const std::string& unit);
/// Lengths in `unit` become metres; none: they are.
void makeMetres(std::vector<Vec3>& lengths, const std::string& unit);

/// What is wrong with the attribute `units` of a node, which declares the units of plain numbers in the scene.
std::optional<Problem> problemOfUnits(std::string_view text, const NodeDescription& root, bool is_outermost);
/// " [mm]" for "m" in a scene in millimetres; nothing where its units are unknown.
std::string unitInBrackets(const Scene& scene, std::string_view si_unit);

}  // namespace stroma
