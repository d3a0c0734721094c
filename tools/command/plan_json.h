// SPDX-License-Identifier: LGPL-2.1-or-later
// The compiled plan for programs: what `stroma explain SCENE --json` prints.
#pragma once
#include "tools/command/component_json.h"
#include "tools/session/session.h"

namespace stroma::command {

/// The plan of the scene that is loaded, with the modules that it opened.
Json planJson(Session& session);

}  // namespace stroma::command
