// SPDX-License-Identifier: LGPL-2.1-or-later
// The attributes of nodes and components: read, or refused with the nearest right name.
#include <algorithm>
#include <filesystem>
#include <map>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/files.h"
#include "framework/scene/gravity.h"
#include "framework/scene/instantiation.h"
#include "framework/scene/overrides.h"
#include "framework/scene/text.h"
#include "framework/scene/time_step.h"
#include "framework/scene/written_units.h"

namespace stroma {

namespace {

bool contains(const std::vector<std::string>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool isVisualAttribute(std::string_view name) {
  const auto& list = visualAttributes();
  return std::find(list.begin(), list.end(), name) != list.end() || name.starts_with("show") || name.starts_with("draw");
}

void refuse(const AttributeDescription& attribute, const std::string& path, Problem problem, Diagnostics& diagnostics) {
  problem.where = attribute.where;
  problem.path = path + "." + attribute.name;
  diagnostics.add(std::move(problem));
}

/// Reads one value that is not an attribute of a component; reports failure.
template <class T>
bool readInto(T& member, const AttributeDescription& attribute, const std::string& path, Diagnostics& diagnostics,
              const char* unit = "") {
  std::optional<Problem> problem = Data(attribute.name, &member).unit(unit).parse(attribute.value, DataOrigin::written);
  if (!problem) return true;
  refuse(attribute, path, std::move(*problem), diagnostics);
  return false;
}

/// Of a scene that declares its units: numbers of SI would mean a thousandth of it in mm.
void setDefaultGravity(const NodeDescription& description, Node& node, Diagnostics& diagnostics) {
  const AttributeDescription* units = description.find("units");
  if (!units || description.find("gravity")) return;
  try {
    const DefaultGravity gravity = defaultGravity(units->value);
    if (gravity.unit.empty()) return;
    node.own_gravity = Vec3(0, -gravity.value, 0);
    diagnostics.note(node.where(), node.path(),
                     "gravity is not given: the earth's is used along -y, " + printReal(gravity.value) + " " + gravity.unit);
  } catch (const ComponentError&) {  // that of `units` is an error already
  }
}

}  // namespace

bool Instantiation::isSwitchedOffOrVisual(const AttributeDescription& attribute, const std::string& owner, const Component* component) {
  if (attribute.name.starts_with("_") || attribute.name.starts_with("NO")) return true;
  if (!isVisualAttribute(attribute.name) && !(component && component->data().isVisualOnly(attribute.name))) return false;
  noEffect(owner + "." + attribute.name);
  return true;
}

// ---- nodes ----

void Instantiation::readNodeAttributes(const NodeDescription& description, Node& node) {
  for (const AttributeDescription& attribute : description.attributes) {
    if (isSwitchedOffOrVisual(attribute, "Node", nullptr)) continue;
    if (contains(nodeAttributes(), attribute.name)) {
      readNodeAttribute(attribute, node);
    } else {
      diagnostics_.error(attribute.where, node.path() + "." + attribute.name, "a Node has no attribute " + inQuotes(attribute.name),
                         "gravity, dt, time, name or activated", nearest(attribute.name, nodeAttributes()));
    }
  }
  if (!node.parent() && !node.own_gravity) setDefaultGravity(description, node, diagnostics_);
}

void Instantiation::readNodeAttribute(const AttributeDescription& attribute, Node& node) {
  const std::string path = node.path();
  if (attribute.name == "gravity") {
    Vec3 gravity = Vec3::Zero();
    std::string note;
    std::optional<Problem> problem = readGravity(attribute.value, gravity, note);
    if (problem) return refuse(attribute, path, std::move(*problem), diagnostics_);
    node.own_gravity = gravity;
    if (!note.empty()) diagnostics_.note(attribute.where, path + ".gravity", note);
  } else if (attribute.name == "dt") {
    double dt = 0;
    if (!readInto(dt, attribute, path, diagnostics_, "s")) return;
    if (!(dt > 0)) {
      diagnostics_.error(attribute.where, path + ".dt", "the time step is " + printReal(dt), "a value > 0 s");
    } else if (dt < shortest_time_step || dt > longest_time_step) {
      diagnostics_.error(attribute.where, path + ".dt",
                         "the time step is " + printReal(dt) + ": its square is not a finite number",
                         "a value from " + printReal(shortest_time_step) + " to " + printReal(longest_time_step) + " s");
    } else if (!node.parent()) {
      node.root_dt = dt;
    } else if (dt != node.dt()) {
      diagnostics_.error(attribute.where, path + ".dt", "a child node cannot have its own time step",
                         "dt on the root node only, where it is " + printReal(node.dt()) + " s");
    }
  } else if (attribute.name == "time") {
    double time = 0;
    if (readInto(time, attribute, path, diagnostics_, "s") && !node.parent()) node.root_time = time;
  } else if (attribute.name == "units") {
    std::optional<Problem> problem = problemOfUnits(attribute.value, scene_.description.root, !node.parent());
    if (problem) refuse(attribute, path, std::move(*problem), diagnostics_);
  } else if (attribute.name == "activated") {
    bool activated = true;
    if (readInto(activated, attribute, path, diagnostics_) && !activated && !node.parent())
      diagnostics_.error(attribute.where, path, "the root node is not activated: nothing would run");
  }
}

// ---- components ----

void Instantiation::readAttributes(const ComponentDescription& description, Component& component) {
  if (const AttributeDescription* choice = description.find("template")) component.chooseTemplate(choice->value);
  std::map<const Data*, const AttributeDescription*> given;
  for (const AttributeDescription& attribute : description.attributes) {
    const Data* data = findAttribute(attribute.name, component);
    if (data && !data->link()) {
      const auto [first, is_new] = given.emplace(data, &attribute);
      if (!is_new && isOverride(attribute.where)) {
        std::erase_if(pending_, [&](const PendingLink& link) { return link.component == &component && link.data == data; });
      } else if (!is_new) {
        fail(component, {Severity::error, attribute.where, component.path() + "." + attribute.name,
                         attribute.name + " and " + first->second->name + " are the same attribute, given twice", "one of them",
                         {}});
        continue;
      }
    }
    readAttribute(attribute, component);
  }
}

void Instantiation::readAttribute(const AttributeDescription& attribute, Component& component) {
  Data* data = findAttribute(attribute.name, component);
  if (!data) return unknownAttribute(attribute, component);
  if (!component.data().find(attribute.name))
    diagnostics_.note(attribute.where, component.path() + "." + attribute.name,
                      "this attribute is called " + data->name() + " now");

  const std::string_view text = trimmed(attribute.value);
  if (data->link() && text.empty()) return;
  if (!data->link() && text.starts_with("@") && !data->isOutput()) {
    pending_.push_back({&component, data, std::string(text), attribute.where});
    return;
  }
  const DataOrigin origin = isOverride(attribute.where) ? DataOrigin::by_override : DataOrigin::written;
  if (std::optional<Problem> problem =
          attribute.typed && !data->isOutput() ? data->copyFrom(*attribute.typed) : data->parse(attribute.value, origin)) {
    problem->where = attribute.where;
    problem->path = component.path() + "." + attribute.name;
    return fail(component, std::move(*problem));
  }
  if (data->link() && !data->link()->words.empty() && !text.starts_with("@")) return checkWord(attribute, *data->link(), component);
  if (data->link()) pending_.push_back({&component, data, std::string(text), attribute.where});
  if (std::holds_alternative<FileName*>(data->pointer())) findInputFile(attribute, *data, component);
}

/// The attribute by its name, an alias or the name it once had.
Data* Instantiation::findAttribute(const std::string& name, Component& component) {
  if (Data* data = component.data().find(name)) return data;
  for (const AttributeChange& change : attributeChanges())
    if (change.type == component.type() && change.old_attribute == name) return component.data().find(change.new_attribute);
  return nullptr;
}

bool Instantiation::readCommonAttribute(const AttributeDescription& attribute, Component& component) {
  if (!contains(commonAttributes(), attribute.name)) return false;
  if (attribute.name == "name") {
    if (attribute.value.find_first_of("/@.[") != std::string::npos)
      diagnostics_.warning(attribute.where, component.path(), "no link can reach a name that contains one of / @ . [");
  } else if (attribute.name == "src") {
    pending_.push_back({&component, nullptr, std::string(trimmed(attribute.value)), attribute.where});
  } else if (attribute.name == "template") {
    checkTemplate(attribute, component);
  }
  return true;
}

void Instantiation::findInputFile(const AttributeDescription& attribute, Data& data, Component& component) {
  FileName& file = *std::get<FileName*>(data.pointer());
  if (file.empty()) return;
  if (!data.isInputFile()) {
    file.found = std::filesystem::absolute(file.given).lexically_normal().string();
    return;
  }
  std::vector<std::string> searched;
  // Who types a file name in a command means the folder they are in.
  if (isOverride(attribute.where)) file.found = findFileIn(file.given, ".", {}, &searched);
  if (file.found.empty()) file.found = findFileIn(file.given, component.folder_, scene_.description.data_paths, &searched);
  if (file.found.empty())
    fail(component, {Severity::error, attribute.where, component.path() + "." + attribute.name,
                     "the file " + inQuotes(file.given) + " is not found", {},
                     searchedText(searched)});
}

}  // namespace stroma
