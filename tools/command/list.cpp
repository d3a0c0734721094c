// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma list: what there is, from the index, without opening a module.
#include <fmt/format.h>

#include <algorithm>

#include "tools/command/component_json.h"
#include "tools/command/doc_sofa.h"
#include "tools/command/session.h"
#include "tools/command/words.h"

namespace stroma::command {
namespace {

const Manual list_manual{
    "stroma list [WORD]",
    "Lists components with their module and one line of help: all of them, or those whose name, module "
    "or help contains the\nword, and those that belong to a topic of that name, such as contact, units or "
    "boundary conditions. Upper and lower case are the\nsame. `stroma doc TOPIC` tells more of a topic.",
    "  stroma list\n  stroma list solver\n  stroma list boundary conditions\n  stroma list --sofa\n"};

bool has(const std::vector<std::string>& list, std::string_view word) {
  return std::ranges::find(list, word) != list.end();
}

/// Topics with the word in their name or in another word for them.
std::vector<const Topic*> topicsAbout(const std::string& word) {
  std::vector<const Topic*> found;
  const Topic* exact = findTopic(word);
  for (const Topic& topic : topics()) {
    const auto contains = [&](const std::string& other) { return containsWord(other, word); };
    if (&topic == exact || contains(topic.name) || std::ranges::any_of(topic.also, contains)) found.push_back(&topic);
  }
  return found;
}

[[noreturn]] void nothingFound(const std::string& word, const Modules& modules) {
  std::vector<std::string> names = topicWords();
  for (const Modules::IndexEntry& entry : modules.index()) names.emplace_back(entry.type);
  const std::string near = nearest(word, names);
  throw UsageError(
      fmt::format("no component matches '{}'{}", word, near.empty() ? "" : "; did you mean " + near + "?"));
}

void print(const std::vector<Modules::IndexEntry>& found) {
  std::size_t type_width = 0, module_width = 0;
  for (const auto& entry : found) {
    type_width = std::max(type_width, entry.type.size());
    module_width = std::max(module_width, entry.module.size());
  }
  for (const auto& entry : found)
    fmt::print("{:{}}  {:{}}  {}\n", entry.type, type_width, entry.module, module_width, entry.help);
}

void print(const std::vector<const Topic*>& about) {
  std::vector<std::string> names;
  for (const Topic* topic : about) names.push_back(topic->name + (topic->is_missing ? " (not yet)" : ""));
  fmt::print("topics: {}; `stroma doc {}` tells more\n", fmt::join(names, ", "), about.front()->name);
}

CommandLine listLine() {
  OptionList options("options");
  options.add_options()                                //
      ("json", "print them as JSON, with their roles")  //
      ("sofa", "how many of SOFA's attributes are read, have no effect or are refused in its dialect");
  return {list_manual, options, {"WORD..."}};
}

int list(const Arguments& arguments) {
  const auto values = parseOptions(listLine(), arguments);
  if (!values) return exit_done;
  const std::string word = values->count("WORD") ? (*values)["WORD"].as<std::string>() : "";
  Session session;
  configure(session, *values);
  if (values->count("sofa")) return listSofasAttributes(session, values->count("json") > 0);
  const Topic* topic = word.empty() ? nullptr : findTopic(word);
  std::vector<Modules::IndexEntry> found;
  for (const Modules::IndexEntry& entry : session.modules().index())
    if (containsWord(entry.type, word) || containsWord(entry.module, word) || containsWord(entry.help, word) ||
        (topic && has(topic->components, entry.type)))
      found.push_back(entry);
  const auto about = word.empty() ? std::vector<const Topic*>{} : topicsAbout(word);
  if (found.empty() && about.empty()) nothingFound(word, session.modules());
  std::ranges::sort(found, {}, &Modules::IndexEntry::type);
  if (values->count("json")) return printJson(listJson(session, found));
  print(found);
  if (!about.empty()) print(about);
  return exit_done;
}

}  // namespace

const Subcommand list_command{"list", "list the components, or those that a word leads to", Group::scenes, list, listLine};

}  // namespace stroma::command
