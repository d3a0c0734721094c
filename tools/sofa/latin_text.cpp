// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of SOFA's scenes that are no UTF-8: SOFA reads bytes, whatever the declaration of a file says, and those of old editors
// are Latin-1.
#include <algorithm>

#include "framework/scene/dialect.h"
#include "framework/scene/xml_scan.h"

namespace stroma {

namespace {

/// The encoding in <?xml ... encoding="..."?> becomes UTF-8, with blanks for what it is shorter: columns stay.
void declareUtf8(std::string& text) {
  constexpr std::string_view name = "UTF-8";
  const std::size_t end = text.starts_with("<?xml") ? text.find("?>") : std::string::npos;
  const std::size_t word = end == std::string::npos ? end : text.substr(0, end).find("encoding");
  const std::size_t open = word == std::string::npos ? word : text.find_first_of("\"'", word);
  const std::size_t close = open == std::string::npos ? open : text.find(text[open], open + 1);
  if (close == std::string::npos || close > end || close - open - 1 < name.size()) return;
  text.replace(open + 1, name.size(), name);
  text[open + 1 + name.size()] = text[open];
  std::fill(text.begin() + std::ptrdiff_t(open + 2 + name.size()), text.begin() + std::ptrdiff_t(close + 1), ' ');
}

}  // namespace

void decodeForeign(std::string& text, const std::string& file, bool is_foreign, Diagnostics& diagnostics) {
  const std::size_t wrong = firstByteNotUtf8(text);
  if (wrong == text.size() || text.find('\0') != std::string::npos) return;
  const std::string::size_type tag = text.find("<Node");
  const std::string outermost = tag == std::string::npos ? "" : text.substr(tag, text.find('>', tag) - tag);
  const bool says_so = outermost.find("dialect=\"sofa\"") != std::string::npos || outermost.find("dialect='sofa'") != std::string::npos;
  if (!is_foreign && !says_so) return;
  const auto line_start = text.rfind('\n', wrong);
  const int column = int(wrong - (line_start == std::string::npos ? 0 : line_start + 1)) + 1;
  const int line = 1 + int(std::count(text.begin(), text.begin() + std::ptrdiff_t(wrong), '\n'));
  diagnostics.warning({file, line, column}, {}, "the file is no UTF-8: it is read as Latin-1",
                      "'iconv -f latin1 -t utf8' makes a file of UTF-8");
  std::string decoded;
  decoded.reserve(text.size() + text.size() / 16);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80)
      decoded += c;
    else
      decoded += char(0xC0 | (byte >> 6)), decoded += char(0x80 | (byte & 0x3F));
  }
  text = std::move(decoded);
  declareUtf8(text);
}

}  // namespace stroma
