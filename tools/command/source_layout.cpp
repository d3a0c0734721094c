// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/source_layout.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace stroma::command {
namespace {

/// Walks through a text and knows line and column.
class Cursor {
 public:
  explicit Cursor(const std::string& text) : text_(text) {}
  bool atEnd() const { return at_ >= text_.size(); }
  bool sees(std::string_view word) const { return text_.compare(at_, word.size(), word) == 0; }
  char character() const { return text_[at_]; }
  std::pair<int, int> place() const { return {line_, column_}; }
  void move() {  // a column is a character, not a byte of UTF-8
    const char c = text_[at_++];
    if (c == '\n')
      ++line_, column_ = 1;
    else
      column_ += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }
  /// Behind `word`; returns what lies between.
  std::string passTo(std::string_view word) {
    const std::size_t begin = at_, end = std::min(text_.find(word, at_), text_.size());
    const std::size_t behind = std::min(end + word.size(), text_.size());
    while (at_ < behind) move();
    return text_.substr(begin, end - begin);
  }

 private:
  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 1, column_ = 1;
};

/// Behind the > of a tag, whose values may hold others. Whether the tag is its own end.
bool passTag(Cursor& cursor) {
  char before = 0, quote = 0;
  for (; !cursor.atEnd(); cursor.move()) {
    const char c = cursor.character();
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      cursor.move();
      return before == '/';
    }
    before = c;
  }
  return true;
}

}  // namespace

SourceLayout::SourceLayout(const SceneDescription& scene) {
  for (const SceneFileText& source : scene.texts) scan(source.text, files_[source.file]);
  keep(scene.root);
  for (auto& [name, file] : files_) passOn(file);
}

void SourceLayout::scan(const std::string& text, File& file) {
  Cursor cursor(text);
  std::vector<Place> open{{0, 0}};
  std::vector<std::string> lines;
  int breaks = 0;
  const auto note = [&] {  // a blank line that was passed
    if (breaks > 1 && (lines.empty() || !lines.back().empty())) lines.emplace_back();
    breaks = 0;
  };
  while (!cursor.atEnd()) {
    if (cursor.sees("<!--")) {
      note();
      lines.push_back(cursor.passTo("-->") + "-->");
    } else if (cursor.sees("<?") || cursor.sees("<!")) {
      passTag(cursor);
    } else if (cursor.sees("</")) {
      note();
      if (open.size() > 1) file.ends[open.back()] = std::move(lines), open.pop_back();
      lines.clear();
      passTag(cursor);
    } else if (cursor.character() == '<') {
      note();
      const Place place = cursor.place();
      file.tags[place] = {open.back(), std::move(lines)};
      lines.clear();
      if (!passTag(cursor)) open.push_back(place);
    } else {
      breaks += cursor.character() == '\n';
      cursor.move();
    }
  }
  file.ends[{0, 0}] = std::move(lines);
}

void SourceLayout::keep(const NodeDescription& node) {
  files_[node.where.file].kept.insert({node.where.line, node.where.column});
  for (const ComponentDescription& component : node.components)
    files_[component.where.file].kept.insert({component.where.line, component.where.column});
  for (const NodeDescription& child : node.children) keep(child);
}

/// Comments of what has left the scene go to what follows in the same node, else to its end.
void SourceLayout::passOn(File& file) {
  for (auto tag = file.tags.begin(); tag != file.tags.end(); ++tag) {
    if (file.kept.count(tag->first) || tag->second.lines.empty()) continue;
    auto next = std::next(tag);
    while (next != file.tags.end() && next->second.parent != tag->second.parent) ++next;
    std::vector<std::string>& target = next == file.tags.end() ? file.ends[tag->second.parent] : next->second.lines;
    std::erase(tag->second.lines, std::string());
    target.insert(target.begin(), tag->second.lines.begin(), tag->second.lines.end());
    tag->second.lines.clear();
  }
}

std::vector<std::string> SourceLayout::before(const SourceLocation& where) {
  const auto file = files_.find(where.file);
  if (file == files_.end()) return {};
  const auto tag = file->second.tags.find({where.line, where.column});
  return tag == file->second.tags.end() ? std::vector<std::string>{} : std::exchange(tag->second.lines, {});
}

std::vector<std::string> SourceLayout::atEnd(const SourceLocation& node) {
  const auto file = files_.find(node.file);
  if (file == files_.end()) return {};
  const auto end = file->second.ends.find({node.line, node.column});
  return end == file->second.ends.end() ? std::vector<std::string>{} : std::exchange(end->second, {});
}

}  // namespace stroma::command
