// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma doc` and `stroma list --sofa` say of SOFA: its ways of computing, and what becomes of its attributes.
#pragma once
#include <string>

#include "tools/command/session.h"

namespace stroma::command {

/// The quirks that change the component, with the attribute that stands for each.
void printSofasWays(const std::string& type, const Component& component);
/// SOFA's attributes that the component has not.
void printSofasAttributes(const std::string& type, const Component& component);
/// False: there is no quirk of that name.
bool explainQuirk(const std::string& name);
/// How many of SOFA's attributes are read, have no effect, and are refused.
int listSofasAttributes(Session& session, bool as_json);

}  // namespace stroma::command
