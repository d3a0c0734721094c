// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/xml_text.h"

namespace stroma {

std::string xmlText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' && c != '\r';
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += is_control ? '?' : c;
  }
  return out;
}

}  // namespace stroma
