// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma doc: the manual page of a component, from the comment of its source and its attribute table.
#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/change_table.h"
#include "tools/command/session.h"

namespace po = boost::program_options;

namespace stroma::command {
namespace {

const Manual manual{
    "stroma doc NAME",
    "Prints the manual page of a component: what it computes, an example scene, and its attributes with "
    "type, unit, default\nand range.",
    "  stroma doc TetrahedronFEMForceField\n  stroma doc CGLinearSolver | less\n"};

/// The present name of a component; says so when the scene format renamed it.
std::string presentName(const std::string& name) {
  for (const TypeChange& change : typeChanges())
    if (name == change.old_type) {
      fmt::print("{} is now called {} (since {} of SOFA); the old name works.\n\n", name, change.new_type,
                 change.since);
      return std::string(change.new_type);
    }
  return name;
}

[[noreturn]] void unknown(const std::string& name, const Modules& modules) {
  std::vector<std::string> names;
  for (const auto& entry : modules.index()) names.push_back(entry.type);
  const std::string near = nearest(name, names);
  throw UsageError(fmt::format("there is no component '{}' ({})", name,
                               near.empty() ? "stroma list prints them all" : "did you mean " + near + "?"));
}

std::string traits(const Data& data) {
  std::string text = data.typeText();
  if (!data.unitText().empty() && data.unitText() != "-") text += " [" + data.unitText() + "]";
  if (data.isOutput()) return text + ", computed";
  if (data.isRequired()) {
    text += ", required";
  } else {
    text += data.defaultText().empty() ? ", empty by default" : ", default " + data.defaultText();
  }
  if (!data.rangeText().empty()) text += ", in " + data.rangeText();
  if (data.changeEffect() == ChangeEffect::at_once) text += ", may change in a run";
  if (data.changeEffect() == ChangeEffect::recompile) text += ", may change in a run (the component is made anew)";
  return text;
}

void printAttributes(const Component& component) {
  fmt::print("Attributes:\n");
  for (const Data& data : component.data().all()) {
    if (data.isShorthand()) continue;
    fmt::print("  {} ({})\n      {}{}\n", data.name(), traits(data), data.helpText(),
               data.aliases().empty() ? "" : fmt::format("; also called {}", fmt::join(data.aliases(), ", ")));
  }
  std::vector<std::string> shorthands;
  for (const Data& data : component.data().all())
    if (data.isShorthand()) shorthands.push_back(data.name());
  if (!shorthands.empty()) fmt::print("  shorthands: {}\n", fmt::join(shorthands, ", "));
}

CommandLine line() {
  OptionList options("options");
  options.add_options()("module", po::value<std::vector<std::string>>()->value_name("FILE.so"),
                        "open a module of components by its path; may be repeated");
  return {manual, options, {"NAME"}};
}

int doc(const Arguments& arguments) {
  const auto values = parseOptions(line(), arguments);
  if (!values) return exit_done;
  const std::string given = required(*values, "NAME", manual);
  Session session;
  configure(session, *values);
  const std::string name = presentName(given);
  if (!session.modules().provide(name)) unknown(given, session.modules());
  const auto component = session.factory().make(name);
  const ComponentEntry* entry = session.factory().find(name);
  if (!component || !entry) unknown(given, session.modules());
  fmt::print("{} ({}, module {})\n{}\n\n", name, component->roleText(), entry->module, entry->help);
  const std::string page = session.modules().manual(name);
  if (!page.empty()) fmt::print("{}{}\n", page, page.ends_with('\n') ? "" : "\n");
  printAttributes(*component);
  return exit_done;
}

}  // namespace

const Subcommand doc_command{"doc", "print the manual page of a component", Group::scenes, doc, line};

}  // namespace stroma::command
