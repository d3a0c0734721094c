// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace stroma {

/// As the text of an attribute or an element, of XML and HTML. Characters that XML cannot hold become '?'.
std::string xmlText(std::string_view text);

}  // namespace stroma
