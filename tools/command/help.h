// SPDX-License-Identifier: LGPL-2.1-or-later
// What the command says of itself.
#pragma once
#include <cstdio>
#include <string>
#include <utility>

#include "tools/command/command.h"

namespace stroma::command {

/// The groups that are shown, with their titles.
std::span<const std::pair<Group, const char*>> groupNames();

/// Throws UsageError with the nearest name.
const Subcommand& subcommandNamed(const std::string& name);

void printOverview(std::FILE* stream);
void printVersion();

}  // namespace stroma::command
