// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/simulation/system.h"

namespace stroma {

/// ForceField::worstElement() at x. Of a field with a rest shape that names none, the two tied nodes whose distance has changed most.
std::string worstElementOf(const ForceField& field, const System& system, ConstRows x);
/// The sentence of a step that failed: which, of what, why, and the worst elements at the system's positions.
std::string whereAndWhy(const System& system, const StepContext& context, const std::string& cause, const std::string& when);

}  // namespace stroma
