// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/scene_writer/scene_text.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "framework/scene/text.h"
#include "tools/session/xml_text.h"

namespace stroma {
namespace {

bool isBefore(TextPosition a, TextPosition b) { return std::pair(a.line, a.column) < std::pair(b.line, b.column); }

/// Where in the text a value stands: from after its opening quote up to the closing one.
struct ValuePlace {
  std::size_t begin = 0, end = 0;
};

class Editor {
 public:
  explicit Editor(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) counted_ = 3;  // counts as no column
  }

  /// Positions must not go back from call to call.
  void change(const TextChange& change) {
    if (change.value.find('\0') != std::string::npos)
      throw std::invalid_argument("the value of " + inQuotes(change.attribute) +
                                  " holds a byte that is 0, and XML has no way to write one");
    const std::size_t at = offsetOf(change.where);
    if (at < text_.size() && text_[at] == '<') {
      changeTag(at, change);
    } else {
      std::size_t end = endOfName(at);
      if (end == at) refuse(change.where, "an element or an attribute");
      replace(readValue(end, change.where), change.value);
    }
  }

  std::string result() const {
    std::string out;
    std::size_t kept = 0;
    for (const auto& [place, piece] : pieces_) {
      out.append(text_.substr(kept, place.first - kept)).append(piece);
      kept = place.second;
    }
    return out.append(text_.substr(kept));
  }

 private:
  [[noreturn]] static void refuse(TextPosition where, const std::string& expected) {
    throw std::invalid_argument("the text has no such place as line " + std::to_string(where.line) + ", column " +
                                std::to_string(where.column) + ": expected " + expected + " there");
  }

  /// A column counts characters, not the bytes of UTF-8, as in the scan of the reader.
  std::size_t offsetOf(TextPosition where) {
    while (counted_ < text_.size() && isBefore(position_, where)) {
      const char c = text_[counted_++];
      if (c == '\n') {
        ++position_.line, position_.column = 1;
      } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
        ++position_.column;
      }
    }
    // the later bytes of a character have the column after it
    while (counted_ < text_.size() && (static_cast<unsigned char>(text_[counted_]) & 0xC0) == 0x80) ++counted_;
    if (isBefore(position_, where) || isBefore(where, position_)) refuse(where, "a line and a column of the text");
    return counted_;
  }

  std::size_t endOfName(std::size_t at) const {
    while (at < text_.size() && !endsXmlName(text_[at])) ++at;
    return at;
  }
  std::size_t skipSpaces(std::size_t at) const {
    while (at < text_.size() && isXmlSpace(text_[at])) ++at;
    return at;
  }

  /// The value after a name that ends at `at`; moves `at` behind the closing quote.
  ValuePlace readValue(std::size_t& at, TextPosition where) const {
    at = skipSpaces(at);
    if (at >= text_.size() || text_[at] != '=') refuse(where, "name=\"value\"");
    at = skipSpaces(at + 1);
    if (at >= text_.size() || (text_[at] != '"' && text_[at] != '\'')) refuse(where, "name=\"value\"");
    const std::size_t begin = at + 1, end = text_.find(text_[at], begin);
    if (end == std::string_view::npos) refuse(where, "a value that ends");
    at = end + 1;
    return {begin, end};
  }

  void changeTag(std::size_t tag, const TextChange& change) {
    std::size_t end = endOfName(tag + 1);  // of the last attribute
    if (end == tag + 1) refuse(change.where, "a start tag");
    for (std::size_t at = skipSpaces(end); at < text_.size() && text_[at] != '>' && text_[at] != '/';
         at = skipSpaces(at)) {
      const std::size_t name_end = endOfName(at);
      if (name_end == at) refuse(change.where, "a start tag");
      const std::string_view name = text_.substr(at, name_end - at);
      const ValuePlace value = readValue(at = name_end, change.where);
      if (name == change.attribute) return replace(value, change.value);
      end = at;
    }
    added_[end][change.attribute] = change.value;
    std::string all;
    for (const auto& [name, value] : added_[end]) all += " " + name + "=\"" + xmlValue(value, '"') + "\"";
    pieces_[{end, end}] = std::move(all);
  }

  void replace(ValuePlace place, const std::string& value) {
    pieces_[{place.begin, place.end}] = xmlValue(value, text_[place.begin - 1]);
  }

  std::string_view text_;
  std::size_t counted_ = 0;
  TextPosition position_{1, 1};
  std::map<std::pair<std::size_t, std::size_t>, std::string> pieces_;  ///< what stands in place of a range
  std::map<std::size_t, std::map<std::string, std::string>> added_;    ///< attributes, by where they go
};

}  // namespace

std::string changedText(std::string_view text, const std::vector<TextChange>& changes) {
  std::vector<const TextChange*> ordered;
  for (const TextChange& change : changes) ordered.push_back(&change);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const TextChange* a, const TextChange* b) { return isBefore(a->where, b->where); });
  Editor editor(text);
  for (const TextChange* change : ordered) editor.change(*change);
  return editor.result();
}

}  // namespace stroma
