// SPDX-License-Identifier: LGPL-2.1-or-later
// A described scene with what its links mean in SOFA. Elements stand for components that are not made yet; each has one
// beside it, its probe, for the table of its attributes.
#pragma once
#include <algorithm>
#include <cctype>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/load.h"
#include "framework/scene/text.h"

namespace stroma::sofa {

struct Place;

/// A bool as SOFA reads it: 1, true, T, yes, on and their opposites, in any case.
bool saysYes(std::string_view text);
bool saysNo(std::string_view text);
inline bool isAnyOf(std::string_view word, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

/// visit(link) for each link of an attribute: from an @ at the start of a word to the next one, as names may have blanks.
template <class Visit>
void forLinks(const AttributeDescription& attribute, Visit&& visit) {
  const std::string_view text = attribute.value;
  const auto next = [text](std::size_t from) {
    std::size_t at = text.find('@', from);
    while (at != text.npos && at > 0 && !std::isspace(static_cast<unsigned char>(text[at - 1]))) at = text.find('@', at + 1);
    return at;
  };
  for (std::size_t at = next(0), end = 0; at != text.npos; at = end) {
    end = next(at + 1);
    visit(trimmed(text.substr(at, end == text.npos ? end : end - at)));
  }
}

struct Element {
  ComponentDescription* written = nullptr;
  std::unique_ptr<ComponentDescription> made;  ///< what `written` is, where no scene wrote it
  Place* place = nullptr;
  std::string name;                  ///< by which links find it
  std::string other_name;            ///< by which they find it too: as the scene has it, where that has blanks
  std::string type_abroad;           ///< SOFA's, whatever `written` becomes
  std::unique_ptr<Component> probe;  ///< null: there is no such component here
  bool without_effect = false;       ///< accepted: what only draws, schedules or keeps books
  bool dropped = false;

  std::string role() const { return probe ? probe->roleText() : std::string(); }
  bool is(std::string_view type) const { return written->type == type; }
  const AttributeDescription* find(std::string_view attribute) const { return written->find(attribute); }
  std::string text(std::string_view attribute) const;
  /// Given as text, and not as the value of a program, whose text is empty.
  bool writes(std::string_view attribute) const {
    const AttributeDescription* found = find(attribute);
    return found && !found->typed;
  }
  void set(const std::string& attribute, const std::string& value);
  void remove(std::string_view attribute);
  std::string path() const;
};

/// Of the plug-in SoftRobots: it imposes a way or a force.
inline bool isActuator(const Element& element) {
  return isAnyOf(element.written->type, {"CableConstraint", "PositionConstraint", "SurfacePressureConstraint"});
}

struct Place {
  NodeDescription* node = nullptr;
  Place* parent = nullptr;
  std::string name, other_name;  ///< as those of an element
  std::vector<std::unique_ptr<Element>> elements;
  std::vector<std::unique_ptr<Place>> children;
  std::vector<ComponentDescription> added_components;
  std::vector<NodeDescription> added_children;
  bool dropped = false;

  std::string path() const;
  /// The first of a role that is not dropped, or null.
  Element* firstOf(std::string_view role) const;
  bool has(std::string_view role) const { return firstOf(role) != nullptr; }
  /// The same in this place or the nearest above.
  Element* nearest(std::string_view role) const;
};

/// Where a link leads: an element, or a place; both null: nowhere.
struct LinkTarget {
  Element* element = nullptr;
  Place* place = nullptr;
  std::string data;  ///< after the dot
};

class SceneTree {
 public:
  using Make = std::function<std::unique_ptr<Component>(const std::string& type)>;

  SceneTree(NodeDescription& root, Make make);
  Place& root() { return root_; }
  void forEach(const std::function<void(Element&)>& call) const { forEach(root_, call); }
  void forEachPlace(const std::function<void(Place&)>& call) { forEachPlace(root_, call); }
  /// "@../mesh.position" as SOFA reads it: by name here, then upwards; by path; "[-1]" by place in the node.
  LinkTarget follow(const Element& from, std::string_view link, bool names_data) const;
  /// Of one that leads nowhere: what may be meant, or empty.
  std::string nearestLink(const Element& from, std::string_view link) const;
  /// The absolute link to an element, which has a name of its own from then on, without blanks: they part links.
  static std::string linkTo(Element& element);
  /// A component that no scene wrote, with a name that is free in the place; the passes see it from then on. Not to be called
  /// while they go over the place.
  Element& add(Place& place, ComponentDescription component);
  /// The element becomes one of another type.
  void retype(Element& element, const std::string& type) const;
  /// Takes out what is dropped and puts in what was added.
  void finish() { finish(root_); }

 private:
  void build(Place& place, NodeDescription& node);
  static void forEach(const Place& place, const std::function<void(Element&)>& call);
  static void forEachPlace(Place& place, const std::function<void(Place&)>& call);
  static void finish(Place& place);

  Make make_;
  Place root_;
};

}  // namespace stroma::sofa
