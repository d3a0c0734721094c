// SPDX-License-Identifier: LGPL-2.1-or-later
// The words that people look for and what they lead to. The tables are text files in words/, built into the command and
// read when somebody asks.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stroma::command {

/// A subject in the words of its users: "contact", "statics".
struct Topic {
  std::string name, text;         ///< text: a paragraph, lines of at most 120 characters
  bool is_missing = false;        ///< "not yet"
  std::vector<std::string> also;  ///< other words for it
  std::vector<std::string> components, commands, pages;
};

/// In the order of the file.
const std::vector<Topic>& topics();

/// The topic that goes by `word`, or null. Upper and lower case, hyphens and a plural s do not count.
const Topic* findTopic(std::string_view word);

/// The names and other words of all topics.
std::vector<std::string> topicWords();

/// Whether `text` contains `pattern`; upper and lower case are the same.
bool containsWord(std::string_view text, std::string_view pattern);

/// What to say of a component of SOFA that Stroma does not have.
struct SofaAnswer {
  std::string topic, advice;
};
std::optional<SofaAnswer> sofaAnswer(std::string_view type);

/// The same as a sentence beside "there is no component"; empty: nothing is known of the type.
std::string sofaAdvice(const std::string& type);

/// docs/scene.md, the page of the file format.
std::string_view scenePage();

}  // namespace stroma::command
