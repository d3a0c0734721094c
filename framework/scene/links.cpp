// SPDX-License-Identifier: LGPL-2.1-or-later
// The second pass: links by path, when everything that they can name exists. Forms of a path:
//   @name            a component of this node, else of the nearest ancestor that has one of that name
//   @Child/name      the same, starting with a child node
//   @../name  @./Child/name   from the parent, from this node
//   @/Child/name     from the root; the root's own name may come first
//   @[-1]            the component that many places before (or after) this one in its node
//   @..  @.  @../    a node: the component that plays the wanted role there
// and `.data` after it for the value of an attribute; without it the attribute of the same name is meant.
#include <algorithm>
#include <charconv>

#include "framework/scene/instantiation.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {

namespace {

struct LinkPath {
  std::string text;  ///< as written
  bool absolute = false;
  std::vector<std::string> steps;  ///< "..", ".", nodes, and last the component, if any
  std::string data;                ///< after the dot; empty when there is none
};

LinkPath parsePath(const std::string& text, bool may_name_data) {
  LinkPath path;
  path.text = text;
  std::string_view rest = text;
  if (rest.starts_with("@")) rest.remove_prefix(1);
  if (rest.starts_with("/")) path.absolute = true, rest.remove_prefix(1);
  while (true) {
    const auto slash = rest.find('/');
    if (slash == std::string_view::npos) break;
    if (slash > 0) path.steps.emplace_back(rest.substr(0, slash));
    rest.remove_prefix(slash + 1);
  }
  std::string last(rest);
  if (may_name_data && last != "." && last != "..") {
    if (const auto dot = last.rfind('.'); dot != std::string::npos) {
      path.data = last.substr(dot + 1);
      last.resize(dot);
    }
  }
  if (!last.empty()) path.steps.push_back(std::move(last));
  return path;
}

/// Where a path led: a component, or a node whose components the role decides between. Both null: nowhere.
struct Target {
  Component* component = nullptr;
  Node* node = nullptr;
  std::string reason, suggestion;  ///< when it led nowhere
};

bool isRelative(const std::string& step) { return step == "." || step == ".."; }

std::vector<std::string> namesIn(const Node& node) {
  std::vector<std::string> names;
  for (const auto& component : node.components()) names.push_back(component->name());
  for (const auto& child : node.children()) names.push_back(child->name());
  return names;
}

/// The nearest name, put in the place of the wrong one in the text of the link.
std::string suggest(const LinkPath& path, const std::string& wrong, const std::vector<std::string>& names) {
  const std::string name = nearest(wrong, names);
  const auto at = path.text.rfind(wrong);
  return name.empty() || at == std::string::npos ? name : std::string(path.text).replace(at, wrong.size(), name);
}

Target walk(Node& start, const LinkPath& path, std::size_t first) {
  Target target;
  Node* node = &start;
  for (std::size_t i = first; i < path.steps.size(); ++i) {
    const std::string& step = path.steps[i];
    if (step == ".") continue;
    Node* next = step == ".." ? node->parent() : node->findChild(step);
    if (i + 1 == path.steps.size() && step != "..") {
      target.component = node->findByName(step);
      if (target.component) return target;
    }
    if (!next) {
      target.reason = step == ".." ? "it climbs above the root" : "there is no " + inQuotes(step) + " in " + node->path();
      if (step != "..") target.suggestion = suggest(path, step, namesIn(*node));
      return target;
    }
    node = next;
  }
  target.node = node;
  return target;
}

/// "[-1]": counted among the components of the node, from the one that holds the link.
Target countFrom(const Component& self, const std::string& step) {
  Target target;
  int offset = 0;
  const auto [end, code] = std::from_chars(step.data() + 1, step.data() + step.size(), offset);
  const auto& list = self.node().components();
  const auto here = std::find_if(list.begin(), list.end(), [&](const auto& component) { return component.get() == &self; });
  const long index = (here - list.begin()) + offset;
  if (code != std::errc() || *end != ']') {
    target.reason = inQuotes(step) + " is not a number in brackets, such as [-1]";
  } else if (index < 0 || index >= long(list.size())) {
    target.reason = "the node has no component at that place";
  } else {
    target.component = list[index].get();
  }
  return target;
}

Target follow(const Component& self, const LinkPath& path) {
  Node& node = self.node();
  if (path.absolute) {
    Node& root = node.root();
    const bool names_root = !path.steps.empty() && path.steps[0] == root.name() && !root.findChild(path.steps[0]) &&
                            !root.findByName(path.steps[0]);
    return walk(root, path, names_root ? 1 : 0);
  }
  if (path.steps.empty() || isRelative(path.steps[0])) return walk(node, path, 0);
  if (path.steps[0].starts_with("[")) return countFrom(self, path.steps[0]);
  Target nearest_miss;
  std::vector<std::string> names;
  for (Node* from = &node; from; from = from->parent()) {
    Target target = walk(*from, path, 0);
    if (target.component || target.node) return target;
    if (from == &node || from->findChild(path.steps[0])) nearest_miss = target;
    const std::vector<std::string> here = namesIn(*from);
    names.insert(names.end(), here.begin(), here.end());
  }
  if (path.steps.size() == 1) {
    nearest_miss.reason = "there is no " + inQuotes(path.steps[0]) + " in " + node.path() + " or above";
    nearest_miss.suggestion = suggest(path, path.steps[0], names);
  }
  return nearest_miss;
}

}  // namespace

void Instantiation::resolveLinks() {
  for (const PendingLink& link : pending_) {
    if (!link.data) continue;
    if (link.data->link()) {
      resolveComponentLink(link);
    } else {
      resolveDataLink(link);
    }
  }
  // `src` fills what nothing else gave, so it comes last.
  for (const PendingLink& link : pending_)
    if (!link.data) resolveSrc(link);
}

namespace {

/// The components of `node` that satisfy `wanted`.
template <class Wanted>
std::vector<Component*> candidates(const Node& node, const Component* self, Wanted wanted) {
  std::vector<Component*> found;
  for (const auto& component : node.components())
    if (component.get() != self && wanted(*component)) found.push_back(component.get());
  return found;
}

/// Turns a node into the one component meant there; a reason when there is none or more than one.
template <class Wanted>
void chooseIn(Target& target, const Component* self, const std::string& what, Wanted wanted) {
  if (!target.node) return;
  const std::vector<Component*> found = candidates(*target.node, self, wanted);
  if (found.size() == 1) {
    target.component = found[0];
    return;
  }
  target.reason = "node " + target.node->path() + (found.empty() ? " holds no " : " holds more than one ") + what;
  for (const Component* one : found) target.reason += (one == found[0] ? ": " : ", ") + one->name();
}

Problem broken(const SourceLocation& where, const std::string& path, const std::string& text, const Target& target) {
  return {Severity::error,  where, path, "the link " + inQuotes(text) + " leads nowhere: " + target.reason, {}, target.suggestion};
}

bool isUnknown(const Component& component) { return dynamic_cast<const UnknownComponent*>(&component) != nullptr; }

}  // namespace

void Instantiation::resolveComponentLink(const PendingLink& link) {
  LinkBase& role = *link.data->link();
  if (role.takesMany() && link.text.find(' ') != std::string::npos) {
    PendingLink one = link;
    Words words(link.text);
    for (std::string_view word = words.next(); !word.empty() && !link.component->hasFailed(); word = words.next()) {
      one.text = word;
      resolveComponentLink(one);
    }
    return;
  }
  const std::string path = link.component->path() + "." + link.data->name();
  Target target = follow(*link.component, parsePath(link.text, false));
  chooseIn(target, link.component, role.roleText(), [&](Component& component) { return role.accepts(component); });
  if (!target.component) {
    const LinkPath with_data = parsePath(link.text, true);
    if (const Target other = follow(*link.component, with_data); other.component && !with_data.data.empty())
      target.reason = link.data->name() + " names a component, not an attribute of one", target.suggestion.clear();
    return fail(*link.component, broken(link.where, path, link.text, target));
  }
  if (isUnknown(*target.component)) return link.component->markFailed();
  if (!role.accepts(*target.component))
    return fail(*link.component, {Severity::error, link.where, path,
                                  target.component->path() + " is a " + target.component->roleText() + " (" +
                                      target.component->type() + ")", role.roleText(),
                                  {}});
  role.add(target.component);
}

void Instantiation::resolveDataLink(const PendingLink& link) {
  LinkPath path = parsePath(link.text, true);
  Target target = follow(*link.component, path);
  if (path.data.empty()) path.data = link.data->name();
  chooseIn(target, link.component, "component with an attribute " + inQuotes(path.data),
           [&](Component& component) { return component.data().find(path.data) != nullptr; });
  const std::string own_path = link.component->path() + "." + link.data->name();
  if (!target.component) return fail(*link.component, broken(link.where, own_path, link.text, target));
  if (isUnknown(*target.component)) return link.component->markFailed();
  const Data* from = target.component->data().find(path.data);
  if (from && from->link()) from = nullptr;
  if (from) return linkData(link, *target.component, *from);
  fail(*link.component, {Severity::error, link.where, own_path,
                         "the link " + inQuotes(link.text) + " leads nowhere: " + target.component->path() + " (" +
                             target.component->type() + ") has no attribute " + inQuotes(path.data), {},
                         suggest(path, path.data, target.component->data().names())});
}

void Instantiation::linkData(const PendingLink& link, Component& source, const Data& from) {
  link.component->data_links_.push_back({link.data, &source, &from, link.where, false});
}

void Instantiation::resolveSrc(const PendingLink& link) {
  // What places or prepares the source's mesh has been applied to its values: taking it over would apply it twice.
  static const std::vector<std::string> own_business = {
      "filename",    "translation",       "rotation",           "scale3d", "scale", "transformation", "flipNormals",
      "triangulate", "createSubelements", "onlyAttachedPoints", "unit"};
  Component& component = *link.component;
  const std::string path = component.path() + ".src";
  Target target = follow(component, parsePath(link.text, false));
  if (target.node) target.reason = "it names a node", target.node = nullptr;
  if (!target.component) return fail(component, broken(link.where, path, link.text, target));
  if (isUnknown(*target.component)) return component.markFailed();
  const auto isGiven = [&](const Data& data) {
    return data.isSet() || std::any_of(component.data_links_.begin(), component.data_links_.end(),
                                       [&](const Component::DataLink& other) { return other.target == &data; });
  };
  int count = 0;
  for (Data& data : component.data().all()) {
    if (data.link() || data.isOutput() || data.isShorthand()) continue;
    if (std::find(own_business.begin(), own_business.end(), data.name()) != own_business.end()) continue;
    const Data* from = target.component->data().find(data.name());
    for (const std::string& alias : data.aliases())
      if (!from) from = target.component->data().find(alias);
    if (!from || from->link() || from->isShorthand()) continue;
    ++count;
    if (!isGiven(data)) component.data_links_.push_back({&data, target.component, from, link.where, true});
  }
  if (count == 0)
    fail(component, {Severity::error, link.where, path,
                     target.component->path() + " (" + target.component->type() + ") has no attribute in common with " +
                         component.type(), "a source such as a mesh loader",
                     {}});
}

}  // namespace stroma
