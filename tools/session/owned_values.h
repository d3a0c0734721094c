// SPDX-License-Identifier: LGPL-2.1-or-later
// The values of a checkpoint by owner, for transfer to another simulation.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/archive.h"
#include "framework/scene/component.h"

namespace stroma {

using Entries = std::map<std::string, Archive::Entry>;

/// All values of an owner. Its matrix, system and state are separate owners.
Entries valuesOf(const std::string& owner, const Entries& all);

/// Makes the component read all of these values, which are its own. False: it reads them only when it runs, or they do not match;
/// values read before the mismatch stay.
bool takesAll(Component& component, const Entries& values);

/// The same names and bits.
bool areTheSame(const Entries& a, const Entries& b);

}  // namespace stroma
