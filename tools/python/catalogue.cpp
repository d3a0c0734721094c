// SPDX-License-Identifier: LGPL-2.1-or-later
// The types of components, with their attributes.
#include <pybind11/stl.h>

#include <algorithm>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/missing_types.h"
#include "framework/scene/modules.h"
#include "tools/command/words.h"
#include "tools/python/python.h"

namespace stroma::python {
namespace {

const char* wordFor(ChangeEffect effect) {
  return effect == ChangeEffect::restart ? "restart" : effect == ChangeEffect::at_once ? "at once" : "remade";
}

/// A component of the type with its defaults; null when there is none.
std::unique_ptr<Component> made(const std::string& type) {
  if (!library().modules.provide(type)) return nullptr;
  if (std::unique_ptr<Component> component = library().factory.make(type)) return component;
  return library().factory.make(std::string(presentType(type)));
}

py::object typeInfo(const std::string& type) {
  const std::unique_ptr<Component> component = made(type);
  if (!component) return py::none();
  const ComponentEntry& entry = *library().factory.find(component->type());
  py::dict out;
  out["type"] = component->type();
  out["module"] = entry.module;
  out["help"] = entry.help;
  out["role"] = component->roleText();
  out["manual"] = library().modules.manual(component->type());
  py::list attributes;
  for (const Data& data : component->data().all()) attributes.append(infoOf(data));
  out["attributes"] = attributes;
  py::dict renamed;
  for (const AttributeChange& change : attributeChanges())
    if (change.type == component->type()) renamed[py::str(std::string(change.old_attribute))] = std::string(change.new_attribute);
  out["renamed"] = renamed;
  return out;
}

/// Whether a scene may write this attribute on every component, or on this one without effect.
bool isAccepted(const std::string& type, const std::string& attribute) {
  if (std::find(commonAttributes().begin(), commonAttributes().end(), attribute) != commonAttributes().end()) return true;
  const auto& visual = visualAttributes();
  if (std::find(visual.begin(), visual.end(), attribute) != visual.end()) return true;
  if (attribute.starts_with("show") || attribute.starts_with("draw")) return true;
  const std::unique_ptr<Component> component = made(type);
  return component && component->data().isVisualOnly(attribute);
}

bool hasNoEffect(const std::string& type) {
  return std::find(acceptedWithoutEffect().begin(), acceptedWithoutEffect().end(), type) != acceptedWithoutEffect().end();
}

std::string advice(const std::string& type) {
  for (const TypeRemoval& removal : typeRemovals())
    if (removal.type == type) return std::string(removal.advice);
  return adviceOnMissingType(type);
}

}  // namespace

Library& library() {
  static Library* const all = [] {
    auto* made = new Library;
    registerPlayed(made->factory);
    return made;
  }();
  return *all;
}

py::dict infoOf(const Data& data) {
  py::dict out;
  out["name"] = data.name();
  out["type"] = data.typeText();
  out["unit"] = data.unitText();
  out["default"] = data.defaultText();
  out["range"] = data.rangeText();
  out["help"] = data.helpText();
  out["aliases"] = data.aliases();
  out["required"] = data.isRequired();
  out["output"] = data.isOutput();
  out["link"] = data.link() != nullptr;
  out["file"] = std::holds_alternative<FileName*>(data.pointer());
  const auto* choice = std::get_if<ChoiceRef>(&data.pointer());
  out["words"] = choice ? choice->words : std::vector<std::string>();
  out["change"] = wordFor(data.changeEffect());
  out["value"] = valueOf(data);
  out["given"] = data.isSet();
  return out;
}

void bindCatalogue(py::module_& module) {
  adviseOnMissingTypes(&command::sofaAdvice);
  module.def("instruction_level", &instructionLevel);
  module.def("types", [] {
    py::list out;
    for (const Modules::IndexEntry& entry : library().modules.index())
      out.append(py::make_tuple(entry.type, entry.module, entry.help));
    for (const ComponentEntry* entry : library().factory.entries())
      if (entry->module.empty()) out.append(py::make_tuple(entry->type, "", entry->help));
    return out;
  });
  module.def("type_info", &typeInfo);
  module.def("present_type", [](const std::string& type) { return std::string(presentType(type)); });
  module.def("is_known", [](const std::string& type) { return library().modules.provide(type) || hasNoEffect(type); });
  module.def("has_no_effect", &hasNoEffect);
  module.def("is_accepted", &isAccepted);
  module.def("node_attributes", [] { return nodeAttributes(); });
  module.def("nearest", &nearest);
  module.def("advice", &advice);
}

}  // namespace stroma::python
