// SPDX-License-Identifier: LGPL-2.1-or-later
// The page, as it was bundled by the build and put into this library.
#pragma once
#include <string_view>

namespace stroma::view {

struct PageFile {
  std::string_view target, type, content;  ///< "/app.js", "text/javascript; charset=utf-8"
};

/// Null for what is no part of the page. Nothing else is ever served.
const PageFile* pageFile(std::string_view target);

}  // namespace stroma::view
