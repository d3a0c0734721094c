// SPDX-License-Identifier: LGPL-2.1-or-later
// Values of attributes written back into the text of a scene: comments, spaces, quotes and line ends stay as they are.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/xml_scan.h"

namespace stroma {

/// A new value for one attribute.
struct TextChange {
  /// Of the start tag ('<'), or of the attribute itself (the first letter of its name), as in SourceLocation.
  TextPosition where;
  /// Its name as the text writes it. Not read when `where` is that of the attribute.
  std::string attribute;
  std::string value;  ///< as the reader is to understand it: entities are made here
};

/// `text` with the values replaced, each in the quotes that it has. An attribute that its tag does not write is added
/// after the last one of that tag, on the same line. Every other byte is kept, and without changes all of them. Of
/// several changes at one place the last counts. `text` is one that readXml() accepts.
/// Throws std::invalid_argument with a sentence when there is no tag or attribute at a position, or a value holds a
/// byte that is 0.
std::string changedText(std::string_view text, const std::vector<TextChange>& changes);

}  // namespace stroma
