// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/xml_text.h"

namespace stroma {
namespace {

void addEscaped(char c, std::string& out) {
  if (c == '&')
    out += "&amp;";
  else if (c == '<')
    out += "&lt;";
  else if (c == '>')
    out += "&gt;";
  else if (c == '"')
    out += "&quot;";
  else if (c == '\'')
    out += "&apos;";
  else
    out += c;
}

bool isSpace(char c) { return c == '\n' || c == '\t' || c == '\r'; }

}  // namespace

std::string xmlText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20 && !isSpace(c);
    if (is_control || c == '\'')
      out += is_control ? '?' : c;
    else
      addEscaped(c, out);
  }
  return out;
}

std::string xmlValue(std::string_view text, char quote) {
  std::string out;
  for (const char c : text) {
    if (isSpace(c))
      out += "&#" + std::to_string(int(c)) + ";";
    else if (c == '&' || c == '<' || c == quote)
      addEscaped(c, out);
    else
      out += c;
  }
  return out;
}

}  // namespace stroma
