// SPDX-License-Identifier: LGPL-2.1-or-later
// A schema in the languages that editors read.
#pragma once
#include <string>

#include "tools/command/schema_model.h"

namespace stroma::command {

/// W3C XML Schema 1.0, without a namespace.
std::string asXsd(const Schema& schema);
/// RELAX NG in its compact syntax. It can say more: which attributes exclude each other, and what `src` stands for.
std::string asRelaxNg(const Schema& schema);

}  // namespace stroma::command
