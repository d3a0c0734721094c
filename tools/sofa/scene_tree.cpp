// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sofa/scene_tree.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <set>

#include "framework/scene/change_table.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma::sofa {

namespace {

bool isOneOf(std::string_view text, std::initializer_list<std::string_view> words) {
  const std::string_view given = trimmed(text);
  return std::any_of(words.begin(), words.end(), [given](std::string_view word) {
    return std::equal(given.begin(), given.end(), word.begin(), word.end(),
                      [](unsigned char a, char b) { return std::tolower(a) == b; });
  });
}

}  // namespace

bool saysYes(std::string_view text) { return isOneOf(text, {"1", "true", "t", "yes", "on"}); }
bool saysNo(std::string_view text) { return isOneOf(text, {"0", "false", "f", "no", "off"}); }

// ---- elements and places ----

std::string Element::text(std::string_view attribute) const {
  const AttributeDescription* found = written->find(attribute);
  return found ? std::string(trimmed(found->value)) : std::string();
}

void Element::set(const std::string& attribute, const std::string& value) {
  for (AttributeDescription& each : written->attributes)
    if (each.name == attribute) return void(each.value = value);
  written->attributes.push_back({attribute, value, written->where});
}

void Element::remove(std::string_view attribute) {
  std::erase_if(written->attributes, [&](const AttributeDescription& each) { return each.name == attribute; });
}

std::string Element::path() const { return joinPath(place->path(), name); }

std::string Place::path() const { return parent ? joinPath(parent->path(), name) : "/"; }

Element* Place::firstOf(std::string_view role) const {
  for (const auto& element : elements)
    if (!element->dropped && element->role() == role) return element.get();
  return nullptr;
}

Element* Place::nearest(std::string_view role) const {
  for (const Place* place = this; place; place = place->parent)
    if (Element* found = place->firstOf(role)) return found;
  return nullptr;
}

// ---- the tree ----

SceneTree::SceneTree(NodeDescription& root, Make make) : make_(std::move(make)) { build(root_, root); }

Element& SceneTree::add(Place& place, ComponentDescription component) {
  auto element = std::make_unique<Element>();
  element->made = std::make_unique<ComponentDescription>(std::move(component));
  element->written = element->made.get();
  element->place = &place;
  element->name = element->written->name();
  element->probe = make_(element->written->type);
  place.elements.push_back(std::move(element));
  return *place.elements.back();
}

void SceneTree::retype(Element& element, const std::string& type) const {
  element.written->type = type;
  element.probe = make_(type);
}

/// Names as SOFA gives them: CLASSNAME and a number from 1. Of equal ones the first is found; the others get names of
/// their own, because a native scene has no two.
void SceneTree::build(Place& place, NodeDescription& node) {
  place.node = &node;
  std::map<std::string, int> counts;
  std::set<std::string> taken;
  const auto unique = [&taken](std::string name) {
    const std::string wanted = name;
    for (int i = 2; !taken.insert(name).second; ++i) name = wanted + "_" + std::to_string(i);
    return name;
  };
  for (ComponentDescription& component : node.components) {
    component.type = std::string(presentType(component.type));
    auto element = std::make_unique<Element>();
    element->written = &component;
    element->type_abroad = component.type;
    element->place = &place;
    const std::string given = component.name();
    element->name = unique(given.empty() ? component.type + std::to_string(++counts[component.type]) : given);
    if (!given.empty() && element->name != given) element->set("name", element->name);
    element->probe = make_(component.type);
    place.elements.push_back(std::move(element));
  }
  std::set<std::string> children;
  const std::vector<std::string> names = childNames(node);
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    auto child = std::make_unique<Place>();
    child->parent = &place;
    child->name = names[i];
    for (int k = 2; !children.insert(child->name).second; ++k) child->name = names[i] + "_" + std::to_string(k);
    if (child->name != names[i])
      for (AttributeDescription& attribute : node.children[i].attributes)
        if (attribute.name == "name") attribute.value = child->name;
    build(*child, node.children[i]);
    place.children.push_back(std::move(child));
  }
}

void SceneTree::forEach(const Place& place, const std::function<void(Element&)>& call) {
  if (place.dropped) return;
  for (const auto& element : place.elements)
    if (!element->dropped) call(*element);
  for (const auto& child : place.children) forEach(*child, call);
}

void SceneTree::forEachPlace(Place& place, const std::function<void(Place&)>& call) {
  if (place.dropped) return;
  call(place);
  if (place.dropped) return;
  for (const auto& child : place.children) forEachPlace(*child, call);
}

void SceneTree::finish(Place& place) {
  NodeDescription& node = *place.node;
  std::vector<ComponentDescription> kept;
  for (const auto& element : place.elements)
    if (!element->dropped) kept.push_back(std::move(*element->written));
  for (ComponentDescription& added : place.added_components) kept.push_back(std::move(added));
  std::vector<NodeDescription> children;
  for (const auto& child : place.children) {
    if (child->dropped) continue;
    finish(*child);
    children.push_back(std::move(*child->node));
  }
  for (NodeDescription& added : place.added_children) children.push_back(std::move(added));
  node.components = std::move(kept);
  node.children = std::move(children);
}

// ---- links ----

namespace {

Element* named(const Place& place, std::string_view name) {
  for (const auto& element : place.elements)
    if (element->name == name || element->other_name == name) return element.get();
  for (const auto& element : place.elements)  // the first of a type without a name, called by the bare type
    if (element->written->name().empty() && element->written->type == name) return element.get();
  return nullptr;
}

Place* childNamed(const Place& place, std::string_view name) {
  for (const auto& child : place.children)
    if (child->name == name || child->other_name == name) return child.get();
  return nullptr;
}

/// Where the steps of a path lead from `start`; nowhere: both null.
LinkTarget walk(Place& start, const std::vector<std::string>& steps, std::size_t first) {
  LinkTarget target;
  Place* place = &start;
  for (std::size_t i = first; i < steps.size(); ++i) {
    const std::string& step = steps[i];
    if (step == "." || step.empty()) continue;
    if (i + 1 == steps.size() && step != ".." && (target.element = named(*place, step))) return target;
    place = step == ".." ? place->parent : childNamed(*place, step);
    if (!place) return target;
  }
  target.place = place;
  return target;
}

Element* counted(const Element& from, std::string_view step) {
  int offset = 0;
  const auto [end, code] = std::from_chars(step.data() + 1, step.data() + step.size(), offset);
  const auto& list = from.place->elements;
  const auto here = std::find_if(list.begin(), list.end(), [&](const auto& element) { return element.get() == &from; });
  const long index = (here - list.begin()) + offset;
  return code == std::errc() && index >= 0 && index < long(list.size()) ? list[std::size_t(index)].get() : nullptr;
}

}  // namespace

namespace {

/// A link in its parts.
struct LinkPath {
  bool absolute = false;
  std::vector<std::string> steps;
  std::string data;

  LinkPath(std::string_view link, bool names_data) {
    std::string_view rest = link.substr(link.starts_with("@") ? 1 : 0);
    absolute = rest.starts_with("/");
    for (std::size_t slash = rest.find('/'); slash != rest.npos; slash = rest.find('/')) {
      if (slash > 0) steps.emplace_back(rest.substr(0, slash));
      rest.remove_prefix(slash + 1);
    }
    if (const auto dot = rest.rfind('.'); names_data && dot != rest.npos && rest != "." && rest != "..") {
      data = rest.substr(dot + 1);
      rest = rest.substr(0, dot);
    }
    if (!rest.empty()) steps.emplace_back(rest);
  }

  std::string text() const {
    std::string joined = absolute ? "@/" : "@";
    for (std::size_t i = 0; i < steps.size(); ++i) joined += (i == 0 ? "" : "/") + steps[i];
    return joined + (data.empty() ? "" : "." + data);
  }
};

bool isUpOrHere(const std::string& step) { return step == "." || step == ".."; }

}  // namespace

LinkTarget SceneTree::follow(const Element& from, std::string_view link, bool names_data) const {
  const LinkPath path(link, names_data);
  const std::vector<std::string>& steps = path.steps;
  const auto found = [&path](LinkTarget target) { return target.data = path.data, target; };
  Place& root = const_cast<Place&>(root_);
  if (path.absolute) {
    LinkTarget target = walk(root, steps, 0);
    const bool names_root = !steps.empty() && steps[0] == root.node->name();
    return found(target.element || target.place || !names_root ? target : walk(root, steps, 1));
  }
  if (steps.empty() || isUpOrHere(steps[0])) return found(walk(*from.place, steps, 0));
  if (steps[0].starts_with("[")) return found({counted(from, steps[0]), nullptr, {}});
  for (Place* place = from.place; place; place = place->parent)
    if (LinkTarget target = walk(*place, steps, 0); target.element || target.place) return found(target);
  return found({});
}

std::string SceneTree::nearestLink(const Element& from, std::string_view link) const {
  LinkPath path(link, true);
  std::vector<std::string> names;
  const auto addNames = [&](const Place& place, bool with_elements) {
    for (const auto& child : place.children) names.push_back(child->name);
    for (const auto& element : place.elements)
      if (with_elements && element.get() != &from) names.push_back(element->name);
  };
  const Place* place = path.absolute ? &root_ : from.place;
  for (std::string& step : path.steps) {
    const bool is_last = &step == &path.steps.back(), is_bare = !path.absolute && &step == &path.steps.front();
    if (step == ".." && place) place = place->parent;
    if (!place) break;
    if (isUpOrHere(step)) continue;
    const Place* next = childNamed(*place, step);
    for (const Place* above = place->parent; !next && is_bare && above; above = above->parent) next = childNamed(*above, step);
    if (!next) {
      for (const Place* at = place; at; at = is_bare ? at->parent : nullptr) addNames(*at, is_last);
      step = nearest(step, names);
      if (step.empty()) place = nullptr;
      break;
    }
    place = next;
  }
  if (const LinkTarget found = follow(from, path.text(), true); place && (found.element || found.place)) return path.text();
  // the right names from the wrong place, as with one ../ too many
  std::string end, only;
  for (const std::string& step : LinkPath(link, true).steps) end += isUpOrHere(step) ? "" : "/" + step;
  std::size_t count = 0;
  forEach([&](Element& element) {
    if (end.size() > 1 && element.path().ends_with(end)) only = "@" + element.path(), ++count;
  });
  return count == 1 ? only + (path.data.empty() ? "" : "." + path.data) : "";
}

namespace {

/// The name gets underscores for blanks; true where it had some. `taken`: whether a name is another's.
template <class Taken>
bool fillBlanks(std::string& name, std::string& other_name, Taken&& taken) {
  const auto is_blank = [](unsigned char c) { return std::isspace(c) != 0; };
  if (std::none_of(name.begin(), name.end(), is_blank)) return false;
  other_name = name;
  std::replace_if(name.begin(), name.end(), is_blank, '_');
  while (taken(name)) name += "_";
  return true;
}

}  // namespace

std::string SceneTree::linkTo(Element& element) {
  const auto is_element = [&element](const std::string& name) {
    return std::any_of(element.place->elements.begin(), element.place->elements.end(),
                       [&](const auto& each) { return each.get() != &element && each->name == name; });
  };
  const bool is_filled = fillBlanks(element.name, element.other_name, is_element);
  if (is_filled || element.written->name().empty()) element.set("name", element.name);
  for (Place* place = element.place; place->parent; place = place->parent) {
    const auto is_child = [place](const std::string& name) {
      return std::any_of(place->parent->children.begin(), place->parent->children.end(),
                         [&](const auto& each) { return each.get() != place && each->name == name; });
    };
    const bool had_blanks = fillBlanks(place->name, place->other_name, is_child);
    std::vector<AttributeDescription>& attributes = place->node->attributes;
    const auto name = std::find_if(attributes.begin(), attributes.end(), [](const auto& each) { return each.name == "name"; });
    if (name == attributes.end() || place->node->name().empty())
      attributes.push_back({"name", place->name, place->node->where});
    else if (had_blanks)
      name->value = place->name;
  }
  return "@" + element.path();
}

}  // namespace stroma::sofa
