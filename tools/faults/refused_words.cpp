// SPDX-License-Identifier: LGPL-2.1-or-later
// What the reader of a scene refuses: words that it does not know, with the nearest one that it does, names that are taken, and
// values that nobody gave.
#include <algorithm>
#include <unordered_map>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/instantiation.h"
#include "framework/scene/missing_types.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {

// ---- components ----

void Instantiation::reportDuplicates(const NodeDescription& description, const Node& node) {
  const auto check = [&](const auto& list, const char* what) {
    std::unordered_map<std::string, const SourceLocation*> seen;
    for (const auto& item : list) {
      const std::string name = item.name();
      if (name.empty()) continue;
      const auto [first, is_new] = seen.emplace(name, &item.where);
      if (is_new) continue;
      diagnostics_.error(item.find("name")->where, joinPath(node.path(), name),
                         std::string("another ") + what + " of this node has the same name, at " + first->second->text(),
                         "a name of its own");
    }
  };
  check(description.components, "component");
  check(description.children, "child");
}

/// Reports the type. The component most likely meant is made in its place, to be marked as failed: what looks for that
/// role finds it and stays silent.
std::unique_ptr<Component> Instantiation::createUnknown(const ComponentDescription& description, const std::string& path) {
  const std::string present(presentType(description.type));
  if (present != description.type) {
    diagnostics_.error(description.where, path, description.type + ", now called " + present + ", is not available", {},
                       adviceOnMissingType(present));
    return std::make_unique<UnknownComponent>();
  }
  for (const TypeRemoval& removal : typeRemovals()) {
    if (removal.type != description.type) continue;
    diagnostics_.error(description.where, path, description.type + " does not exist any more", {}, std::string(removal.advice));
    return std::make_unique<UnknownComponent>();
  }
  const std::string nothing = "there is no component " + inQuotes(description.type);
  if (std::string advice = adviceOnMissingType(description.type); !advice.empty())
    return diagnostics_.error(description.where, path, nothing, {}, std::move(advice)), std::make_unique<UnknownComponent>();
  std::vector<std::string> names{"Node", "include"};
  names.insert(names.end(), acceptedWithoutEffect().begin(), acceptedWithoutEffect().end());
  for (const Modules::IndexEntry& entry : modules_.index()) names.emplace_back(entry.type);
  for (const ComponentEntry* entry : factory_.entries()) names.push_back(entry->type);
  for (const TypeChange& change : typeChanges()) names.emplace_back(change.old_type);
  const std::string guess(presentType(nearest(description.type, names)));
  diagnostics_.error(description.where, path, nothing, "a name from 'stroma list'", guess);
  if (!guess.empty() && guess != "Node" && guess != "include" && modules_.provide(guess)) return factory_.make(guess);
  return std::make_unique<UnknownComponent>();
}

// ---- attributes ----

void Instantiation::unknownAttribute(const AttributeDescription& attribute, Component& component) {
  if (readCommonAttribute(attribute, component)) return;
  if (isSwitchedOffOrVisual(attribute, component.type(), &component)) return;
  std::vector<std::string> names = component.data().names();
  names.insert(names.end(), commonAttributes().begin(), commonAttributes().end());
  const std::string advice(adviceOn(attribute.name));
  const std::string guess = advice.empty() ? nearest(attribute.name, names) : std::string();
  fail(component,
       {Severity::error, attribute.where, component.path() + "." + attribute.name,
        component.type() + " has no attribute " + inQuotes(attribute.name),
        !advice.empty() || !guess.empty() ? advice : "one of those that 'stroma doc " + component.type() + "' lists", guess});
}

/// A word instead of a path, where the link has words.
void Instantiation::checkWord(const AttributeDescription& attribute, const LinkBase& link, Component& component) {
  if (std::find(link.words.begin(), link.words.end(), link.path) != link.words.end()) return;
  std::string expected = "one of:";
  for (const std::string& word : link.words) expected += (word == link.words[0] ? " " : ", ") + word;
  fail(component,
       {Severity::error, attribute.where, component.path() + "." + attribute.name,
        inQuotes(link.path) + " is not a " + link.roleText(), expected + ", or a link (@name)", nearest(link.path, link.words)});
}

/// There is one set of types: 3-vectors of doubles. SOFA's names for it, and those of its matrices, are accepted.
void Instantiation::checkTemplate(const AttributeDescription& attribute, Component& component) {
  Words words(attribute.value);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (std::ranges::find(templateWords(), word) != templateWords().end() || word.starts_with("CompressedRowSparseMatrix")) continue;
    return fail(component, {Severity::error, attribute.where, component.path() + ".template",
                            "there is no template " + inQuotes(word) + " of " + component.type(),
                            "Vec3 (or nothing: there is one); on linear solvers GraphScattered or "
                            "CompressedRowSparseMatrixMat3x3",
                            {}});
  }
}

/// After the links: what nobody gave, neither written nor linked. A component that was refused is passed over: it may
/// have the attribute under a wrong name or with a wrong value, and one message is enough.
void Instantiation::checkGiven(Component& component) {
  if (component.hasFailed()) return;
  const auto isGiven = [&](const Data& data) {
    return data.isSet() || std::any_of(component.data_links_.begin(), component.data_links_.end(),
                                       [&](const Component::DataLink& link) { return link.target == &data; });
  };
  for (const Data& data : component.data().all()) {
    const std::string path = component.path() + "." + data.name();
    const auto* output_file = data.isInputFile() ? nullptr : std::get_if<FileName*>(&data.pointer());
    if (data.isRequired() && isGiven(data) && output_file && (*output_file)->empty())
      fail(component, {Severity::error, component.where(), path, data.name() + " is empty", "the name of a file", {}});
    if ((!data.isRequired() && !data.isPhysical()) || isGiven(data)) continue;
    if (data.isRequired()) {
      fail(component, {Severity::error, component.where(), path, data.name() + " is not given", data.typeText(), {}});
    } else {
      const std::string unit = data.unitText().empty() || data.unitText() == "-" ? "" : " " + data.unitText();
      diagnostics_.warning(component.where(), path, data.name() + " is not given: the default " + data.defaultText() + unit + " is used");
    }
  }
}

}  // namespace stroma
