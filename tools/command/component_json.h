// SPDX-License-Identifier: LGPL-2.1-or-later
// Components and their attributes for programs: what `stroma list --json` and `stroma doc NAME --json` print.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/command/session.h"

namespace stroma::command {

using Json = nlohmann::ordered_json;

/// The kind of an attribute in a word: "real", "choice", "points". The type in words may say more.
std::string kindOf(const Data& data);

/// Attributes of SOFA that a scene may write on this component and that have no effect.
std::vector<std::string> visualOnly(const Component& component);

/// An object for each of `entries`: name, role, module, help. Opens the modules, as components tell their roles.
Json listJson(Session& session, const std::vector<Modules::IndexEntry>& entries);
/// All that is known of one component: its manual, attributes, outputs. `name` is its present one and must exist.
Json docJson(Session& session, const std::string& name);
/// `stroma doc NAME --json`, and of all components with --all. Throws UsageError for a name that is none.
int docAsJson(const Values& values, const Manual& manual);

/// Prints it to standard output, indented. Returns exit_done.
int printJson(const Json& json);

}  // namespace stroma::command
