// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of SOFA's scenes that are no UTF-8: SOFA reads bytes, whatever the declaration of a file says, and those of old editors
// are Latin-1, with the quotation marks and dashes that Windows puts where Latin-1 has nothing to print (windows-1252).
#include <algorithm>
#include <array>

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

/// What windows-1252 has from 0x80 to 0x9F, as Unicode; what it leaves open stays as it is.
constexpr std::array<unsigned, 32> of_windows = {0x20AC, 0x81,   0x201A, 0x192,  0x201E, 0x2026, 0x2020, 0x2021, 0x2C6,  0x2030, 0x160,
                                                 0x2039, 0x152,  0x8D,   0x17D,  0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
                                                 0x2013, 0x2014, 0x2DC,  0x2122, 0x161,  0x203A, 0x153,  0x9D,   0x17E,  0x178};

void appendUtf8(unsigned code, std::string& out) {
  const auto add = [&out](unsigned byte) { out += static_cast<char>(byte); };
  if (code < 0x80) return add(code);
  if (code < 0x800) return add(0xC0 | (code >> 6)), add(0x80 | (code & 0x3F));
  add(0xE0 | (code >> 12)), add(0x80 | ((code >> 6) & 0x3F)), add(0x80 | (code & 0x3F));
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
  diagnostics.warning({file, line, column}, {}, "the file is no UTF-8: it is read as Latin-1 (windows-1252)",
                      "'iconv -f windows-1252 -t utf8' makes a file of UTF-8");
  std::string decoded;
  decoded.reserve(text.size() + text.size() / 16);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    appendUtf8(byte >= 0x80 && byte < 0xA0 ? of_windows[byte - 0x80u] : byte, decoded);
  }
  text = std::move(decoded);
  declareUtf8(text);
}

}  // namespace stroma
