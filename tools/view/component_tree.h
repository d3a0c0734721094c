// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <nlohmann/json.hpp>

#include "tools/session/session.h"

namespace stroma::view {

/// Nodes, components and all their attributes as they stand now, with units, help, ranges, and whether they may change while
/// the scene runs. Long lists are given by their length.
nlohmann::json componentTree(Session& session);

}  // namespace stroma::view
