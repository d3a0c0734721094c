// SPDX-License-Identifier: LGPL-2.1-or-later
// Tags and attributes of an XML text and where each stands: for messages, and for who rewrites a part of a scene.
#include "framework/scene/xml_scan.h"

#include <algorithm>

#include "framework/scene/text.h"

namespace stroma {

/// RFC 3629: no overlong forms, surrogates or code points above 10FFFF.
std::size_t firstByteNotUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) -> unsigned { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0; };
    const unsigned first = byte(i), second = byte(i + 1);
    const std::size_t length = first < 0x80                     ? 1
                               : first >= 0xC2 && first <= 0xDF ? 2
                               : (first & 0xF0) == 0xE0         ? 3
                               : first >= 0xF0 && first <= 0xF4 ? 4
                                                                : 0;
    if (length == 0) return i;
    for (std::size_t k = 1; k < length; ++k)
      if ((byte(i + k) & 0xC0) != 0x80) return i;
    const bool is_overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
    const bool is_beyond = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
    if (is_overlong || is_beyond) return i;
    i += length;
  }
  return text.size();
}

namespace {

class Scanner {
 public:
  Scanner(std::string_view text, const std::string& file, const ReadLimits& limits, XmlPositions& positions,
          Diagnostics& diagnostics)
      : text_(text), file_(file), limits_(limits), positions_(positions), diagnostics_(diagnostics) {}

  bool run() {
    if (text_.starts_with("\xEF\xBB\xBF")) counted_ = at_ = 3;
    const auto zero = text_.find('\0');  // ends a text for the parser
    if (zero != std::string_view::npos && text_.find('<') != std::string_view::npos) {
      at_ = zero;
      return fail(here(), "a byte that is 0 stands in the text", "XML in UTF-8");
    }
    if (const std::size_t wrong = firstByteNotUtf8(text_); wrong < text_.size()) {
      at_ = wrong;
      const auto byte = static_cast<unsigned char>(text_[wrong]);
      constexpr std::string_view digits = "0123456789ABCDEF";
      return fail(here(), std::string("the byte ") + digits[byte >> 4] + digits[byte & 15] + " is not part of a UTF-8 text",
                  "UTF-8; of a file in Latin-1, 'iconv -f latin1 -t utf8' makes one");
    }
    while ((at_ = text_.find('<', at_)) != std::string_view::npos) {
      const std::string_view rest = text_.substr(at_);
      bool good = true;
      if (rest.starts_with("<!--")) {
        good = skip("-->", "a comment");
      } else if (rest.starts_with("<![CDATA[")) {
        good = skip("]]>", "a CDATA section");
      } else if (rest.starts_with("<?")) {
        const bool is_declaration = rest.size() > 5 && rest.starts_with("<?xml") && isXmlSpace(rest[5]);
        const std::size_t start = at_;
        good = skip("?>", is_declaration ? "a declaration" : "a processing instruction");
        if (!is_declaration) positions_.instructions.emplace_back(start, at_);
      } else if (rest.starts_with("<!DOCTYPE") && isBare(rest)) {
        good = skip(">", "a document type");
      } else if (rest.starts_with("<!")) {
        return fail(here(), "a document type definition is not part of a scene", "elements only");
      } else {
        good = rest.starts_with("</") ? endTag() : startTag();
      }
      if (!good) return false;
    }
    if (!open_.empty())
      return fail(open_.back().where, "the file ends before <" + std::string(open_.back().name) + "> is closed",
                  "</" + std::string(open_.back().name) + ">");
    if (positions_.tags.empty()) return fail({1, 1}, "the file holds no element", "<Node name=\"root\"> ... </Node>");
    return true;
  }

 private:
  struct Open {
    std::string_view name;
    TextPosition where;
  };

  /// Line and column of at_. Positions only move forward, so the whole text is counted once; a column counts
  /// characters, not the bytes of UTF-8.
  TextPosition here() {
    for (; counted_ < at_; ++counted_) {
      const char c = text_[counted_];
      if (c == '\n') {
        ++position_.line, position_.column = 1;
      } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
        ++position_.column;
      }
    }
    return position_;
  }

  bool fail(TextPosition where, std::string message, std::string expected = {}) {
    diagnostics_.error({file_, where.line, where.column}, {}, std::move(message), std::move(expected));
    return false;
  }

  /// A document type that names a file at most, before the outermost element, and defines nothing itself.
  bool isBare(std::string_view rest) const {
    const auto end = rest.find_first_of("[>");
    return positions_.tags.empty() && end != std::string_view::npos && rest[end] == '>';
  }

  bool skip(std::string_view end, const std::string& what) {
    const TextPosition start = here();
    const auto found = text_.find(end, at_ + 2);
    if (found == std::string_view::npos) return fail(start, "the file ends inside " + what, std::string(end));
    at_ = found + end.size();
    return true;
  }

  std::string_view name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && !endsXmlName(text_[at_])) ++at_;
    return text_.substr(start, at_ - start);
  }

  void spaces() {
    while (at_ < text_.size() && isXmlSpace(text_[at_])) ++at_;
  }

  bool startTag() {
    const TextPosition where = here();
    positions_.tags.push_back({where, positions_.attributes.size()});
    ++at_;
    const std::string_view tag = name();
    names_.clear();
    if (tag.empty()) return fail(where, "'<' is not followed by the name of an element", "&lt; inside a text");
    while (true) {
      spaces();
      if (at_ >= text_.size()) return fail(where, "the file ends inside the tag <" + std::string(tag) + ">", "'>'");
      const bool closes = text_[at_] == '>';
      if (closes || text_.substr(at_, 2) == "/>") {
        at_ += closes ? 1 : 2;
        if (!namesDiffer()) return false;
        if (!closes) return true;
        open_.push_back({tag, where});
        return int(open_.size()) <= limits_.depth ||
               fail(where, "elements are nested more than " + std::to_string(limits_.depth) + " deep");
      }
      if (!attribute(tag)) return false;
    }
  }

  bool attribute(std::string_view tag) {
    const TextPosition where = here();
    const std::string_view attribute_name = name();
    if (attribute_name.empty())
      return fail(where, "unexpected " + inQuotes(text_.substr(at_, 1)) + " in the tag <" + std::string(tag) + ">",
                  "name=\"value\", '/>' or '>'");
    spaces();
    if (at_ >= text_.size() || text_[at_] != '=')
      return fail(where, "attribute " + inQuotes(attribute_name) + " has no value",
                  std::string(attribute_name.substr(0, 60)) + "=\"...\"");
    ++at_;
    spaces();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'')
      return fail(where, "the value of attribute " + inQuotes(attribute_name) + " is not in quotes", "\"...\"");
    const std::size_t end = text_.find(quote, at_ + 1);
    const std::size_t length = (end == std::string_view::npos ? text_.size() : end) - at_ - 1;
    if (length > limits_.attribute_bytes || attribute_name.size() > limits_.attribute_bytes)
      return fail(where,
                  "the value of attribute " + inQuotes(attribute_name) + " is longer than " +
                      std::to_string(limits_.attribute_bytes) + " bytes",
                  "a mesh loader and a file for data of this size");
    if (end == std::string_view::npos)
      return fail(where, "the file ends inside the value of attribute " + inQuotes(attribute_name), std::string(1, quote));
    at_ = end + 1;
    positions_.attributes.push_back(where);
    names_.emplace_back(attribute_name, positions_.attributes.size() - 1);
    return true;
  }

  /// No attribute is written twice in the tag just read.
  bool namesDiffer() {
    std::sort(names_.begin(), names_.end());
    const auto twin =
        std::adjacent_find(names_.begin(), names_.end(), [](const auto& a, const auto& b) { return a.first == b.first; });
    return twin == names_.end() || fail(positions_.attributes[(twin + 1)->second],
                                        "attribute " + inQuotes(twin->first) + " is written twice in one element");
  }

  bool endTag() {
    const TextPosition where = here();
    at_ += 2;
    const std::string_view tag = name();
    spaces();
    if (at_ >= text_.size() || text_[at_] != '>')
      return fail(where, "the end tag </" + std::string(tag.substr(0, 60)) + " is cut off", "'>'");
    ++at_;
    if (open_.empty()) return fail(where, "</" + std::string(tag.substr(0, 60)) + "> closes nothing");
    if (open_.back().name != tag)
      return fail(where,
                  "</" + std::string(tag.substr(0, 60)) + "> does not close <" + std::string(open_.back().name) + "> of line " +
                      std::to_string(open_.back().where.line),
                  "</" + std::string(open_.back().name) + ">");
    open_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& file_;
  const ReadLimits& limits_;
  XmlPositions& positions_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0, counted_ = 0;
  TextPosition position_{1, 1};
  std::vector<Open> open_;
  std::vector<std::pair<std::string_view, std::size_t>> names_;  ///< of the tag being read, with their positions
};

}  // namespace

bool scanXml(std::string_view text, const std::string& file, const ReadLimits& limits, XmlPositions& positions,
             Diagnostics& diagnostics) {
  return Scanner(text, file, limits, positions, diagnostics).run();
}

}  // namespace stroma
