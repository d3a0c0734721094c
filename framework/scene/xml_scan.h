// SPDX-License-Identifier: LGPL-2.1-or-later
// One pass over the text of an XML file before it is parsed. tinyxml2 knows lines only, recurses into nested elements
// and copies attributes: this pass finds line and column of every element and attribute, and rejects files that are too
// deep, too long or cut off, with memory that depends on the number of tags only.
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "framework/scene/diagnostics.h"
#include "framework/scene/load.h"

namespace stroma {

struct TextPosition {
  int line = 0, column = 0;
};

/// White space of XML.
inline bool isXmlSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
/// True for a character that ends the name of an element or an attribute.
inline bool endsXmlName(char c) { return isXmlSpace(c) || c == '=' || c == '/' || c == '>' || c == '<' || c == '"' || c == '\''; }

/// Start tags and their attributes in the order of the file.
struct XmlPositions {
  struct Tag {
    TextPosition where;
    std::size_t first_attribute = 0;  ///< in attributes
  };
  std::vector<Tag> tags;
  std::vector<TextPosition> attributes;
  /// Where processing instructions stand in the text (first byte, end), as <?xml-model ...?> for editors.
  std::vector<std::pair<std::size_t, std::size_t>> instructions;
};

/// The offset of the first byte that is not UTF-8, or the size of the text.
std::size_t firstByteNotUtf8(std::string_view text);
/// False if the file cannot be used: exactly one error was then added to `diagnostics`.
bool scanXml(std::string_view text, const std::string& file, const ReadLimits& limits, XmlPositions& positions,
             Diagnostics& diagnostics);

}  // namespace stroma
