// SPDX-License-Identifier: LGPL-2.1-or-later
// The values of a checkpoint by their owners, for those who hand them to another simulation.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/archive.h"
#include "framework/scene/component.h"

namespace stroma {

using Entries = std::map<std::string, Archive::Entry>;

/// All values of an owner. Those of its matrix, its system and its state are other owners.
Entries valuesOf(const std::string& owner, const Entries& all);

/// The component takes all of these values, which are its own. False: it reads them when it runs, or they are others than it has;
/// what it has taken of them until then stays.
bool takesAll(Component& component, const Entries& values);

/// The same names and bits.
bool areTheSame(const Entries& a, const Entries& b);

}  // namespace stroma
