// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/component_tree.h"

#include <fmt/format.h>

#include "tools/units/unit_system.h"

namespace stroma::view {
namespace {

using nlohmann::json;

constexpr std::size_t most_values = 24;  ///< of a list that is shown whole

/// How many values an attribute's list has; 1 for what is no list.
std::size_t lengthOf(const Data& data) {
  return std::visit(
      [](const auto& value) -> std::size_t {
        if constexpr (requires { value->push_back((*value)[0]); } &&
                      !std::is_same_v<std::decay_t<decltype(value)>, std::string*>)
          return value->size();
        else
          return 1;
      },
      data.pointer());
}

const char* wordOf(ChangeEffect effect) {
  constexpr const char* words[] = {"restart", "at_once", "recompile"};
  return words[int(effect)];
}

json describe(const Data& data, const UnitSystem& units) {
  const std::size_t length = lengthOf(data);
  const bool is_long = length > most_values;
  json out{{"name", data.name()},
           {"value", is_long ? fmt::format("{} values", length) : data.print()},
           {"unit", units.unit(data.unitText())},
           {"help", data.helpText()},
           {"type", data.typeText()},
           {"default", data.defaultText()},
           {"range", data.rangeText()},
           {"change", wordOf(data.changeEffect())},
           {"given", data.isSet()},
           {"output", data.isOutput()},
           {"long", is_long}};
  if (const auto* choice = std::get_if<ChoiceRef>(&data.pointer())) out["choices"] = choice->words;
  if (std::holds_alternative<bool*>(data.pointer())) out["choices"] = {"false", "true"};
  return out;
}

json describe(const Component& component, const Factory& factory, const UnitSystem& units) {
  const ComponentEntry* entry = factory.find(component.type());
  json out{{"name", component.name()},     {"path", component.path()},         {"type", component.type()},
           {"role", component.roleText()}, {"help", entry ? entry->help : ""}, {"attributes", json::array()}};
  for (const Data& data : component.data().all())
    if (!data.isShorthand()) out["attributes"].push_back(describe(data, units));
  return out;
}

json nodeAttribute(const char* name, std::string value, std::string unit, const char* help, bool given) {
  return {{"name", name},
          {"value", std::move(value)},
          {"unit", std::move(unit)},
          {"help", help},
          {"type", ""},
          {"default", ""},
          {"range", ""},
          {"change", "at_once"},
          {"given", given},
          {"output", false},
          {"long", false}};
}

json describe(const Node& node, const Factory& factory, const UnitSystem& units) {
  const Vec3 g = node.gravity();
  json out{{"name", node.name()},
           {"path", node.path()},
           {"attributes", json::array()},
           {"components", json::array()},
           {"children", json::array()}};
  out["attributes"].push_back(nodeAttribute("gravity", fmt::format("{} {} {}", g[0], g[1], g[2]), units.unit("m/s^2"),
                                            "acceleration of gravity on this node and those below",
                                            node.own_gravity.has_value()));
  if (!node.parent())
    out["attributes"].push_back(nodeAttribute("dt", fmt::format("{}", node.dt()), units.unit("s"), "time step", true));
  for (const auto& component : node.components()) out["components"].push_back(describe(*component, factory, units));
  for (const auto& child : node.children()) out["children"].push_back(describe(*child, factory, units));
  return out;
}

}  // namespace

json componentTree(Session& session) {
  return describe(session.simulation().root(), session.factory(), unitsOf(session.simulation().scene()));
}

}  // namespace stroma::view
