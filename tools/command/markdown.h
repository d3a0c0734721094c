// SPDX-License-Identifier: LGPL-2.1-or-later
// The Markdown that pages of docs/ are written in, for a terminal and for `man`.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace stroma::command {

struct Block {
  enum class Kind { heading, paragraph, item, code, table };
  Kind kind = Kind::paragraph;
  int level = 0;                               ///< of a heading, from 1
  std::string text;                            ///< one line, but of code
  std::vector<std::vector<std::string>> rows;  ///< of a table; the first one is its head
};

/// Comments are left out.
std::vector<Block> readMarkdown(std::string_view page);

/// Wrapped for a terminal.
std::string asText(const std::vector<Block>& blocks);

/// The body of a manual page in the man macros: headings of level 2 are its sections.
std::string asMan(const std::vector<Block>& blocks);

/// Escaped text in lines of at most 80 bytes, as far as words allow; troff fills them again.
std::string brokenForTroff(const std::string& text);

/// `text` as it has to be written for troff to print it: hyphens, quotes, backslashes, a point at the start of a
/// line.
std::string escaped(std::string_view text);

}  // namespace stroma::command
