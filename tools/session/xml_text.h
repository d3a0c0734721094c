// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace stroma {

/// Escapes text for an attribute or an element of XML or HTML. Characters that XML cannot represent become '?'.
std::string xmlText(std::string_view text);
/// Escapes a value for an attribute between these quotes, so that a reader gets it byte for byte. Readers would turn line ends and
/// tabs into spaces.
std::string xmlValue(std::string_view text, char quote);

}  // namespace stroma
