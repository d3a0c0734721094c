// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma doc: the manual page of a component, from the comment of its source and its attribute table.
#include <fmt/format.h>

#include "framework/scene/change_table.h"
#include "tools/command/attribute_text.h"
#include "tools/command/component_json.h"
#include "tools/command/doc_sofa.h"
#include "tools/command/doc_words.h"
#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual doc_manual{
    "stroma doc NAME [options]",
    "Prints the manual page of a component: what it computes, an example scene, and its attributes with type, unit, "
    "default\nand range. `stroma doc scene` prints the file format, and `stroma doc scene links` what it says of "
    "links. Of "
    "a topic, as in\n`stroma doc boundary conditions`, it says what there is and what there is not yet. For a "
    "component of "
    "SOFA that Stroma does\nnot have it says what to do instead, and of a way of SOFA's that scenes in its dialect have, as in\n"
    "`stroma doc cg-threshold`, what it is and which attributes stand for it.",
    "  stroma doc TetrahedronFEMForceField\n  stroma doc CGLinearSolver | less\n  stroma doc scene\n"
    "  stroma doc incompressible\n  stroma doc GenericConstraintSolver\n"};

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

void printAttributes(const Component& component) {
  fmt::print("Attributes, with any unit of the dimension in brackets, as 10 kPa for [Pa] (docs/units.md):\n");
  for (const Data& data : component.data().all()) {
    if (data.isShorthand()) continue;
    fmt::print("  {} ({})\n      {}{}\n", data.name(), traitsOf(data), data.helpText(),
               data.aliases().empty() ? "" : fmt::format("; also called {}", fmt::join(data.aliases(), ", ")));
  }
  std::vector<std::string> shorthands;
  for (const Data& data : component.data().all())
    if (data.isShorthand()) shorthands.push_back(data.name());
  if (!shorthands.empty()) fmt::print("  shorthands: {}\n", fmt::join(shorthands, ", "));
}

CommandLine docLine() {
  OptionList options("options");
  options.add_options()                        //
      ("json", "print it as JSON")             //
      ("all", "every component, with --json")  //
      ("module", po::value<std::vector<std::string>>()->value_name("FILE.so"),
       "open a module of components by its path; may be repeated");
  return {doc_manual, options, {"NAME..."}};
}

int doc(const Arguments& arguments) {
  const auto values = parseOptions(docLine(), arguments);
  if (!values) return exit_done;
  if (values->count("json") || values->count("all")) return docAsJson(*values, doc_manual);
  const std::string given = required(*values, "NAME", doc_manual);
  Session session;
  configure(session, *values);
  if (!session.modules().provide(given)) return explainWord(given, session.modules());
  const std::string name = presentName(given);
  const auto component = session.factory().make(name);
  const ComponentEntry* entry = session.factory().find(name);
  fmt::print("{} ({}, module {})\n{}\n\n", name, component->roleText(), entry->module, entry->help);
  const std::string page = session.modules().manual(name);
  if (!page.empty()) fmt::print("{}{}\n", page, page.ends_with('\n') ? "" : "\n");
  printAttributes(*component);
  printSofasWays(name, *component);
  printSofasAttributes(name, *component);
  return exit_done;
}

}  // namespace

const Subcommand doc_command{"doc", "print the manual page of a component, of the scene file or of a topic",
                             Group::scenes, doc, docLine};

}  // namespace stroma::command
