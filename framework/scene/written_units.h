// SPDX-License-Identifier: LGPL-2.1-or-later
// What the engine asks of units that a scene is written in: inside, every value is in the unit that its attribute
// declares, which is SI (but for angles in degrees). tools/units answers.
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

/// Numbers with units as the plain numbers that they are in the unit `declared` of an attribute; none when `text` has
/// neither a unit nor a fraction, or cannot be told from a plain mistake. One unit at the end serves all numbers, else
/// each has its own. `declared` may be two, as "N or N s". Throws ComponentError.
std::optional<std::string> withoutUnits(std::string_view text, std::string_view declared);

/// How many metres one `unit` of length is; 1 for none. Throws ComponentError for what is no unit of length.
double metresOf(const std::string& unit);
/// Lengths in `unit` become metres; none: they are.
void makeMetres(std::vector<Vec3>& lengths, const std::string& unit);

/// What is wrong with the attribute `units` of a node, which says what the numbers of a scene are in.
std::optional<Problem> problemOfUnits(std::string_view text, const NodeDescription& root, bool is_outermost);
/// " [mm]" for "m" in a scene in millimetres; nothing where its units are unknown.
std::string unitInBrackets(const Scene& scene, std::string_view si_unit);

}  // namespace stroma
