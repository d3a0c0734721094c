// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma list: what there is, from the index, without opening a module.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual manual{"stroma list [PATTERN]",
                    "Lists components with their module and one line of help: all of them, or those whose name, module "
                    "or help contains\nPATTERN (upper and lower case are the same).",
                    "  stroma list\n  stroma list solver\n  stroma list elasticity\n"};

bool contains(const std::string& text, const std::string& pattern) {
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(text.begin(), text.end(), pattern.begin(), pattern.end(), same) != text.end();
}

CommandLine line() { return {manual, OptionList("options"), {"PATTERN"}}; }

int list(const Arguments& arguments) {
  const auto values = parseOptions(line(), arguments);
  if (!values) return exit_done;
  const std::string pattern = values->count("PATTERN") ? (*values)["PATTERN"].as<std::string>() : "";
  Session session;
  configure(session, *values);
  std::vector<Modules::IndexEntry> found;
  std::vector<std::string> names;
  for (const Modules::IndexEntry& entry : session.modules().index()) {
    names.push_back(entry.type);
    if (contains(entry.type, pattern) || contains(entry.module, pattern) || contains(entry.help, pattern))
      found.push_back(entry);
  }
  if (found.empty()) {
    const std::string near = nearest(pattern, names);
    throw UsageError(
        fmt::format("no component matches '{}'{}", pattern, near.empty() ? "" : "; did you mean " + near + "?"));
  }
  std::ranges::sort(found, {}, &Modules::IndexEntry::type);
  std::size_t type_width = 0, module_width = 0;
  for (const auto& entry : found) {
    type_width = std::max(type_width, entry.type.size());
    module_width = std::max(module_width, entry.module.size());
  }
  for (const auto& entry : found)
    fmt::print("{:{}}  {:{}}  {}\n", entry.type, type_width, entry.module, module_width, entry.help);
  return exit_done;
}

}  // namespace

const Subcommand list_command{"list", "list the components, or those that match a pattern", Group::scenes, list, line};

}  // namespace stroma::command
