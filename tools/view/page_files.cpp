// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/page_files.h"

#include <algorithm>
#include <array>

// NAME_begin and NAME_end: the bytes of a file of the bundle.
#define STROMA_PAGE_FILE(name, file)                                                             \
  asm(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n.balign 16\n" #name     \
      "_begin:\n.incbin \"" STROMA_PAGE_FOLDER "/" file "\"\n" #name "_end:\n.byte 0\n.text\n"); \
  extern "C" __attribute__((visibility("hidden"))) const char name##_begin[], name##_end[];

STROMA_PAGE_FILE(stroma_page_index, "index.html")
STROMA_PAGE_FILE(stroma_page_script, "app.js")
STROMA_PAGE_FILE(stroma_page_style, "app.css")
STROMA_PAGE_FILE(stroma_page_licences, "licences.txt")

namespace stroma::view {
namespace {

std::string_view between(const char* begin, const char* end) { return {begin, std::size_t(end - begin)}; }

}  // namespace

const PageFile* pageFile(std::string_view target) {
  static const std::array<PageFile, 4> files{{
      {"/", "text/html; charset=utf-8", between(stroma_page_index_begin, stroma_page_index_end)},
      {"/app.js", "text/javascript; charset=utf-8", between(stroma_page_script_begin, stroma_page_script_end)},
      {"/app.css", "text/css; charset=utf-8", between(stroma_page_style_begin, stroma_page_style_end)},
      {"/licences.txt", "text/plain; charset=utf-8", between(stroma_page_licences_begin, stroma_page_licences_end)},
  }};
  const auto found =
      std::find_if(files.begin(), files.end(), [&](const PageFile& file) { return file.target == target; });
  return found == files.end() ? nullptr : &*found;
}

}  // namespace stroma::view
