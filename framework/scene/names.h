// SPDX-License-Identifier: LGPL-2.1-or-later
// The names of nodes and components: as written, otherwise derived from the type. Overrides, links and messages all use
// these functions, so they agree.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/description.h"

namespace stroma {

/// A name for each component of the node. An unnamed one takes its (present) type, the next of that type Type2,
/// Type3...
std::vector<std::string> componentNames(const NodeDescription& node);
/// A name for each child: as written, else Node, Node2, ...
std::vector<std::string> childNames(const NodeDescription& node);

/// "/" + name below "/" and parent + "/" + name elsewhere.
std::string joinPath(const std::string& parent, const std::string& name);

}  // namespace stroma
