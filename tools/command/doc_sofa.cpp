// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/doc_sofa.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/command/component_json.h"
#include "tools/sofa/declared_attributes.h"
#include "tools/sofa/quirks.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;

std::string printed(const sofa::QuirkPart& part) {
  const std::string attribute(part.attribute);
  return part.value.empty() ? attribute : fmt::format("{}=\"{}\"", attribute, part.value);
}

struct Lists {
  std::vector<std::string> read, no_effect, refused;
};

Lists listsOf(std::string_view type, const DataTable& here) {
  Lists lists;
  for (const sofa::DeclaredAttribute& attribute : sofa::declaredAttributes(type)) {
    const sofa::Treatment treatment = sofa::treatmentOf(type, attribute.name, here);
    if (treatment == sofa::Treatment::read) lists.read.emplace_back(attribute.name);
    if (treatment == sofa::Treatment::no_effect) lists.no_effect.emplace_back(attribute.name);
    if (treatment == sofa::Treatment::refused)
      lists.refused.push_back(attribute.default_text.empty() ? std::string(attribute.name)
                                                             : fmt::format("{} ({})", attribute.name, attribute.default_text));
  }
  return lists;
}

}  // namespace

void printSofasWays(const std::string& type, const Component& component) {
  bool is_first = true;
  for (const sofa::Quirk& quirk : sofa::allQuirks())
    for (const sofa::QuirkPart& part : quirk.parts) {
      if (!sofa::concerns(part, type, component.data())) continue;
      if (is_first) fmt::print("\nSOFA's way, which scenes in its dialect have unless --without-quirk NAME leaves it out:\n");
      is_first = false;
      fmt::print("  {}: {}\n      {}\n", quirk.name, quirk.what, printed(part));
    }
}

void printSofasAttributes(const std::string& type, const Component& component) {
  const Lists lists = listsOf(type, component.data());
  if (!lists.no_effect.empty())
    fmt::print("\nSOFA's attributes that scenes in its dialect may have without effect:\n  {}\n", fmt::join(lists.no_effect, ", "));
  if (!lists.refused.empty())
    fmt::print("\nSOFA's attributes that are refused unless they have their default:\n  {}\n", fmt::join(lists.refused, ", "));
}

bool explainQuirk(const std::string& name) {
  for (const sofa::Quirk& quirk : sofa::allQuirks()) {
    if (quirk.name != name) continue;
    fmt::print("{}: in SOFA and in its dialect, {}.\n\nAttributes that stand for it:\n", quirk.name, quirk.what);
    for (const sofa::QuirkPart& part : quirk.parts)
      fmt::print("  {} of {}\n", printed(part), part.types == "*" ? "all components that have it" : part.types);
    fmt::print("\nstroma run SCENE --without-quirk {} leaves it out. docs/tutorials/sofa.md says what native scenes do instead.\n", name);
    return true;
  }
  return false;
}

int listSofasAttributes(Session& session, bool as_json) {
  std::size_t types = 0, read = 0, no_effect = 0, refused = 0;
  Json components = Json::object();
  for (const std::string_view type : sofa::declaringTypes()) {
    const std::string here(sofa::componentFor(type));
    if (!session.modules().provide(here)) continue;
    const auto component = session.factory().make(here);
    const Lists lists = listsOf(type, component->data());
    ++types;
    read += lists.read.size(), no_effect += lists.no_effect.size(), refused += lists.refused.size();
    components[std::string(type)] = {{"read", lists.read}, {"no_effect", lists.no_effect}, {"refused", lists.refused}};
  }
  if (as_json)
    return printJson({{"components", types}, {"read", read}, {"no_effect", no_effect}, {"refused", refused}, {"of", components}});
  fmt::print("{} components of SOFA with {} attributes:\n", types, read + no_effect + refused);
  fmt::print("{:6}  read\n{:6}  without effect\n{:6}  refused unless they have their default\n", read, no_effect, refused);
  for (const auto& [type, lists] : components.items())
    if (!lists["refused"].empty()) {
      std::vector<std::string> names = lists["refused"];
      fmt::print("          {}: {}\n", type, fmt::join(names, ", "));
    }
  return exit_done;
}

}  // namespace stroma::command
