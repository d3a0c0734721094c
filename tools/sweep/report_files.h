// SPDX-License-Identifier: LGPL-2.1-or-later
// What the report is made of, built into the library.
#pragma once
#include <string>
#include <string_view>

namespace stroma::sweep {

std::string_view reportScript();
/// Of the page around the charts.
std::string_view reportStyle();
/// Rules of a chart with its colours; `dark`: also those for readers who prefer dark.
std::string chartStyle(bool dark);

}  // namespace stroma::sweep
