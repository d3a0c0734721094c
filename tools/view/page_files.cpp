// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/page_files.h"

#include <algorithm>
#include <array>

#include "tools/platform/text_file.h"

STROMA_TEXT_FILE(stroma_page_index, STROMA_PAGE_FOLDER "/index.html")
STROMA_TEXT_FILE(stroma_page_script, STROMA_PAGE_FOLDER "/app.js")
STROMA_TEXT_FILE(stroma_page_style, STROMA_PAGE_FOLDER "/app.css")
STROMA_TEXT_FILE(stroma_page_licences, STROMA_PAGE_FOLDER "/licences.txt")

namespace stroma::view {

const PageFile* pageFile(std::string_view target) {
  static const std::array<PageFile, 4> files{{
      {"/", "text/html; charset=utf-8", stroma_page_index()},
      {"/app.js", "text/javascript; charset=utf-8", stroma_page_script()},
      {"/app.css", "text/css; charset=utf-8", stroma_page_style()},
      {"/licences.txt", "text/plain; charset=utf-8", stroma_page_licences()},
  }};
  const auto found =
      std::find_if(files.begin(), files.end(), [&](const PageFile& file) { return file.target == target; });
  return found == files.end() ? nullptr : &*found;
}

}  // namespace stroma::view
