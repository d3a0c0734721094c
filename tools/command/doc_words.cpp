// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/doc_words.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/change_table.h"
#include "tools/command/command.h"
#include "tools/command/doc_sofa.h"
#include "tools/command/markdown.h"
#include "tools/command/words.h"

namespace stroma::command {
namespace {

void print(const Topic& topic, const Modules& modules) {
  fmt::print("{}{}\n{}\n", topic.name, topic.is_missing ? ": not yet" : "", topic.text);
  std::size_t width = 0;
  for (const std::string& name : topic.components) width = std::max(width, name.size());
  if (!topic.components.empty()) fmt::print("components:\n");
  for (const std::string& name : topic.components) {
    const auto entry = std::ranges::find(modules.index(), name, &Modules::IndexEntry::type);
    fmt::print("  {:{}}  {}\n", name, width, entry == modules.index().end() ? "" : entry->help);
  }
  for (const std::string& name : topic.commands)
    if (const Subcommand* subcommand = findSubcommand(name)) fmt::print("stroma {}: {}\n", name, subcommand->purpose);
  if (!topic.pages.empty()) fmt::print("pages: {}\n", fmt::join(topic.pages, ", "));
  fmt::print("also found as: {}\n", fmt::join(topic.also, ", "));
}

/// What became of a component of SOFA; false when nothing is known of it.
bool explainSofa(const std::string& type, const Modules& modules) {
  for (const TypeRemoval& removal : typeRemovals())
    if (removal.type == type) return fmt::print("{} does not exist any more: {}.\n", type, removal.advice), true;
  const auto& idle = acceptedWithoutEffect();
  if (std::ranges::find(idle, type) != idle.end()) {
    fmt::print(
        "{} is a component of SOFA that only draws, loads plugins or schedules. A scene may have it: it is accepted "
        "without effect.\n",
        type);
    return true;
  }
  const std::string present(presentType(type));
  const auto answer = sofaAnswer(present);
  if (!answer) return false;
  const Topic* topic = findTopic(answer->topic);
  fmt::print("{} is a component of SOFA that Stroma does not have. {}\n", type, answer->advice);
  if (topic) fmt::print("\n"), print(*topic, modules);
  return true;
}

/// All of the page, or the sections whose heading has the words.
void printScenePage(const std::string& about) {
  std::vector<Block> kept;
  bool takes = about.empty();
  for (Block& block : readMarkdown(scenePage())) {
    if (block.kind == Block::Kind::heading && !about.empty()) takes = containsWord(block.text, about);
    if (takes) kept.push_back(std::move(block));
  }
  if (kept.empty()) throw UsageError(fmt::format("no section of the page on scenes has '{}' in its heading", about));
  fmt::print("{}", asText(kept));
}

[[noreturn]] void unknown(const std::string& word, const Modules& modules) {
  std::vector<std::string> names;
  for (const auto& entry : modules.index()) names.emplace_back(entry.type);
  std::string near = nearest(word, names);
  if (near.empty()) near = nearest(word, topicWords());
  throw UsageError(fmt::format("there is no component or topic '{}' ({})", word,
                               near.empty() ? "stroma list prints all components" : "did you mean " + near + "?"));
}

}  // namespace

int explainWord(const std::string& word, const Modules& modules) {
  if (word == "scene" || word.starts_with("scene ")) {
    printScenePage(word.substr(std::min<std::size_t>(word.size(), 6)));
    return exit_done;
  }
  if (explainSofa(word, modules) || explainQuirk(word)) return exit_done;
  if (const Topic* topic = findTopic(word)) {
    print(*topic, modules);
    return exit_done;
  }
  if (const Subcommand* subcommand = findSubcommand(word); subcommand && subcommand->group != Group::hidden)
    return subcommand->call({"--help"});
  unknown(word, modules);
}

}  // namespace stroma::command
