// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/words.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <stdexcept>

#include "framework/scene/text.h"
#include "tools/platform/text_file.h"

STROMA_TEXT_FILE(stroma_topics, STROMA_SOURCE "/tools/command/words/topics.txt")
STROMA_TEXT_FILE(stroma_sofa, STROMA_SOURCE "/tools/command/words/sofa.txt")
STROMA_TEXT_FILE(stroma_scene_page, STROMA_SOURCE "/docs/scene.md")

namespace stroma::command {
namespace {

char lower(char letter) { return char(std::tolower(static_cast<unsigned char>(letter))); }

/// What two spellings of a word have in common.
std::string folded(std::string_view word) {
  std::string out;
  for (const char letter : trimmed(word)) out += letter == '-' || letter == '_' ? ' ' : lower(letter);
  if (out.size() > 3 && out.back() == 's') out.pop_back();
  return out;
}

std::vector<std::string> splitAt(char mark, std::string_view text) {
  std::vector<std::string> parts;
  std::istringstream in{std::string(text)};
  for (std::string part; std::getline(in, part, mark);)
    if (const std::string_view word = trimmed(part); !word.empty()) parts.emplace_back(word);
  return parts;
}

void append(std::vector<std::string>& list, std::vector<std::string> more) {
  list.insert(list.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Lines of a table without comments and empty ones. An indented line belongs to the last one that is not.
template <class Head, class Line>
void forLines(std::string_view table, Head&& head, Line&& line) {
  std::istringstream in{std::string(table)};
  for (std::string text; std::getline(in, text);) {
    if (trimmed(text).empty() || text[0] == '#') continue;
    if (text[0] == ' ')
      line(trimmed(text));
    else
      head(std::string_view(text));
  }
}

Topic topicNamed(std::string_view head) {
  constexpr std::string_view mark = " (not yet)";
  Topic topic;
  topic.is_missing = head.ends_with(mark);
  if (topic.is_missing) head.remove_suffix(mark.size());
  topic.name = head;
  return topic;
}

void readLine(std::string_view line, Topic& topic) {
  const auto key = line.substr(0, line.find(": "));
  const auto rest = line.substr(std::min(line.size(), key.size() + 2));
  if (key == "also")
    append(topic.also, splitAt(',', rest));
  else if (key == "components")
    append(topic.components, splitAt(' ', rest));
  else if (key == "commands")
    append(topic.commands, splitAt(' ', rest));
  else if (key == "pages")
    append(topic.pages, splitAt(' ', rest));
  else
    (topic.text += line) += '\n';
}

/// `*` in `pattern` stands for any letters.
bool fits(std::string_view pattern, std::string_view type) {
  if (pattern.empty()) return type.empty();
  if (pattern[0] == '*') return fits(pattern.substr(1), type) || (!type.empty() && fits(pattern, type.substr(1)));
  return !type.empty() && type[0] == pattern[0] && fits(pattern.substr(1), type.substr(1));
}

}  // namespace

const std::vector<Topic>& topics() {
  static const std::vector<Topic> table = [] {
    std::vector<Topic> list;
    forLines(
        stroma_topics(), [&](std::string_view head) { list.push_back(topicNamed(head)); },
        [&](std::string_view line) { readLine(line, list.back()); });
    return list;
  }();
  return table;
}

const Topic* findTopic(std::string_view word) {
  const std::string wanted = folded(word);
  for (const Topic& topic : topics())
    if (folded(topic.name) == wanted) return &topic;
  for (const Topic& topic : topics())
    if (std::ranges::any_of(topic.also, [&](const std::string& other) { return folded(other) == wanted; }))
      return &topic;
  return nullptr;
}

std::vector<std::string> topicWords() {
  std::vector<std::string> words;
  for (const Topic& topic : topics()) {
    words.push_back(topic.name);
    words.insert(words.end(), topic.also.begin(), topic.also.end());
  }
  return words;
}

bool containsWord(std::string_view text, std::string_view pattern) {
  const auto same = [](char a, char b) { return lower(a) == lower(b); };
  return std::search(text.begin(), text.end(), pattern.begin(), pattern.end(), same) != text.end();
}

std::optional<SofaAnswer> sofaAnswer(std::string_view type) {
  SofaAnswer answer;
  bool is_found = false;
  forLines(
      stroma_sofa(),
      [&](std::string_view head) {
        if (is_found) return;
        const auto colon = head.find(": ");
        answer = {std::string(head.substr(0, colon)), std::string(head.substr(colon + 2))};
      },
      [&](std::string_view line) {
        for (const std::string& pattern : splitAt(' ', line)) is_found = is_found || fits(pattern, type);
      });
  if (!is_found) return std::nullopt;
  return answer;
}

std::string sofaAdvice(const std::string& type) {
  const auto answer = sofaAnswer(type);
  return answer ? "a component of SOFA that Stroma does not have. " + answer->advice : std::string();
}

std::string_view scenePage() { return stroma_scene_page(); }

}  // namespace stroma::command
