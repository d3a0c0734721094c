// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/schema_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "tools/command/attribute_text.h"
#include "tools/command/component_json.h"

namespace stroma::command {
namespace {

constexpr const char* without_effect = "Of SOFA: accepted without effect.";

SchemaAttribute attribute(std::string name, SchemaValue value, std::string help) {
  return {{std::move(name)}, std::move(value), std::move(help)};
}

/// What a scene may write on every component.
SchemaAttribute commonAttribute(const std::string& name) {
  if (name == "name") return attribute(name, textValue(), "The name of the component, for links and --set.");
  if (name == "src")
    return attribute(name, textValue(),
                     "A component whose attributes of the same names are taken over, such as @loader.");
  if (name == "template")
    return attribute(name, templateValue(templateWords()), "Vec3 or nothing: there is one set of types.");
  return attribute(name, textValue(), without_effect);
}

SchemaAttribute nodeAttribute(const std::string& name) {
  static const std::map<std::string, std::pair<SchemaValue, const char*>> known = {
      {"name", {textValue(), "The name of the node, for links and --set."}},
      {"gravity",
       {plainValue("gravity"),
        "Acceleration of all masses in this node and below\n3 reals, or one along y [m/s^2]; that of the node above by "
        "default, 0 -9.81 0 on the outermost one"}},
      {"dt", {plainValue("real", true), "Time step, on the outermost Node only\nreal [s], default 0.01, > 0"}},
      {"time", {plainValue("real"), "Time at the start, on the outermost Node only\nreal [s], default 0"}},
      {"units",
       {textValue(),
        "What the numbers are in, on the outermost Node only: shown beside them, nothing is converted\na length, a "
        "mass "
        "(or pressure, or force) and a time, as mm t s"}},
      {"activated", {plainValue("boolean"), "false: nothing in this node takes part\ntrue or false, default true"}}};
  const auto found = known.find(name);
  if (found == known.end()) return attribute(name, textValue(), without_effect);
  return attribute(name, found->second.first, found->second.second);
}

SchemaAttribute drawingAttribute(const std::string& name) { return attribute(name, textValue(), without_effect); }

using Names = std::set<std::string>;

/// Adds those of `names` that are not in `present` yet.
template <class List, class Make>
void addMissing(std::vector<SchemaAttribute>& attributes, const List& names, Make make, Names& present) {
  for (const auto& name : names)
    if (present.insert(std::string(name)).second) attributes.push_back(make(std::string(name)));
}

void sortByName(std::vector<SchemaAttribute>& attributes) {
  std::ranges::sort(attributes, {}, [](const SchemaAttribute& each) { return each.names.front(); });
}

/// `src` gives what is no link; a file is the business of who reads it.
bool givenBySrc(const Data& data) { return !data.link() && data.name() != "filename"; }

SchemaAttribute attributeOf(const Data& data, const std::string& type) {
  SchemaAttribute out{{data.name()}, valueOf(data), helpOf(data), data.isRequired(), givenBySrc(data)};
  out.names.insert(out.names.end(), data.aliases().begin(), data.aliases().end());
  for (const AttributeChange& change : attributeChanges())
    if (change.type == type && change.new_attribute == data.name()) out.names.emplace_back(change.old_attribute);
  std::sort(out.names.begin() + 1, out.names.end());
  return out;
}

/// Besides what is `shared`.
SchemaType typeOf(const Component& component, const Names& shared) {
  SchemaType type{component.type()};
  Names present = shared;
  for (const Data& data : component.data().all()) {
    if (data.isOutput()) {
      present.insert(data.name());
      continue;
    }
    type.attributes.push_back(attributeOf(data, component.type()));
    present.insert(type.attributes.back().names.begin(), type.attributes.back().names.end());
  }
  addMissing(type.attributes, commonAttributes(), commonAttribute, present);
  addMissing(type.attributes, visualOnly(component), drawingAttribute, present);
  addMissing(type.attributes, visualAttributes(), drawingAttribute, present);
  sortByName(type.attributes);
  return type;
}

SchemaType nodeType() {
  SchemaType type{"Node", SchemaType::Kind::node};
  Names present;
  addMissing(type.attributes, nodeAttributes(), nodeAttribute, present);
  addMissing(type.attributes, visualAttributes(), drawingAttribute, present);
  sortByName(type.attributes);
  return type;
}

std::string helpOf(const Component& component, const ComponentEntry& entry) {
  return fmt::format("{}\n{}, module {}. 'stroma doc {}' has formulas, sources and an example.", entry.help,
                     component.roleText(), entry.module, entry.type);
}

void addComponents(Session& session, Schema& schema) {
  std::vector<std::unique_ptr<Component>> components;
  Names declared, modules;
  for (const ComponentEntry* entry : session.factory().entries()) {
    components.push_back(session.factory().make(entry->type));
    schema.elements.push_back({entry->type, entry->type, helpOf(*components.back(), *entry)});
    modules.insert(entry->module);
    for (const std::string& name : components.back()->data().names()) declared.insert(name);
  }
  // what a component declares is its own: it may be another thing there, or computed
  addMissing(schema.shared, commonAttributes(), commonAttribute, declared);
  addMissing(schema.shared, visualAttributes(), drawingAttribute, declared);
  sortByName(schema.shared);
  Names shared;
  for (const SchemaAttribute& each : schema.shared) shared.insert(each.names.front());
  for (const auto& component : components) schema.types.push_back(typeOf(*component, shared));
  schema.components = components.size(), schema.modules = modules.size();
}

void addOldNames(const Factory& factory, Schema& schema) {
  for (const TypeChange& change : typeChanges()) {
    const std::string old(change.old_type), present(change.new_type);
    if (factory.find(old) || !factory.find(present)) continue;
    schema.elements.push_back(
        {old, present, fmt::format("Renamed to {} since SOFA {}; the old name works.", present, change.since)});
  }
}

/// What is no component and stands where components do.
void addOthers(const Factory& factory, Schema& schema) {
  schema.types.push_back({"any_attributes", SchemaType::Kind::anything});
  for (const std::string_view name : acceptedWithoutEffect())
    if (!factory.find(std::string(name)))
      schema.elements.push_back({std::string(name), "any_attributes", without_effect});
  SchemaAttribute href = attribute("href", textValue(), "The file, beside this one or on the data path.");
  href.required = true;
  schema.types.push_back({"included_file", SchemaType::Kind::anything, {href}});
  schema.elements.push_back({"include", "included_file",
                             "Puts the content of another file here. name=\"...\" names its node; an attribute of all "
                             "its elements or, as element__attribute, of one is replaced."});
  std::vector<std::string> names;
  for (const SchemaElement& element : schema.elements)
    if (element.name != "include") names.push_back(element.name);
  std::ranges::sort(names);
  SchemaAttribute type = attribute("type", wordValue("component_name", names), "The component.");
  type.required = true;
  schema.types.push_back({"typed_object", SchemaType::Kind::anything, {type}});
  schema.elements.push_back({"Object", "typed_object", "A component by its type, as SOFA's older scenes write it."});
}

}  // namespace

Schema makeSchema(Session& session) {
  session.modules().openAll();
  Schema schema;
  schema.version = STROMA_VERSION;
  addComponents(session, schema);
  addOldNames(session.factory(), schema);
  addOthers(session.factory(), schema);
  schema.node = nodeType();
  schema.node_help = "A node of the scene: it holds components and other nodes.";
  schema.roots = {"Group", "Node", "_Group_", "_Merge_"};
  std::ranges::sort(schema.types, {}, &SchemaType::name);
  std::ranges::sort(schema.elements, {}, &SchemaElement::name);
  return schema;
}

}  // namespace stroma::command
