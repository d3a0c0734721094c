// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies in a plane: points of SOFA's Vec2 have two numbers, frames of its Rigid2 three, x, y and the angle [rad]. Here they are points
// and frames in space of which a constraint holds what would leave the plane.
#include <algorithm>
#include <cmath>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

enum class Plane { none, points, frames };
using Row = std::vector<double>;

Plane planeOf(const Element& state) {
  const std::string word = state.text("template");
  return word.starts_with("Rigid2") ? Plane::frames : word.starts_with("Vec2") ? Plane::points : Plane::none;
}

Row place(Plane plane, const double* at) {
  if (plane == Plane::points) return {at[0], at[1], 0};
  return {at[0], at[1], 0, 0, 0, std::sin(at[2] / 2), std::cos(at[2] / 2)};
}
/// Velocities, forces, and directions that are held.
Row change(Plane plane, const double* at) {
  if (plane == Plane::points) return {at[0], at[1], 0};
  return {at[0], at[1], 0, 0, 0, at[2]};
}
/// m, V and I/m about the one axis.
Row inertia(Plane, const double* at) { return {at[0], at[1], 1, 0, 0, 0, 1, 0, 0, 0, at[2]}; }

struct List {
  const char *type, *attribute;
  Row (*row)(Plane, const double*);
};
const std::vector<List>& listsOfNodes() {
  static const std::vector<List> lists = {{"MechanicalObject", "position", place},
                                          {"MechanicalObject", "rest_position", place},
                                          {"MechanicalObject", "velocity", change},
                                          {"ConstantForceField", "forces", change},
                                          {"ConstantForceField", "force", change},
                                          {"ConstantForceField", "totalForce", change},
                                          {"LinearForceField", "forces", change},
                                          {"LinearMovementProjectiveConstraint", "movements", change},
                                          {"LinearVelocityProjectiveConstraint", "velocities", change},
                                          {"PartialFixedProjectiveConstraint", "fixedDirections", change},
                                          {"UniformMass", "vertexMass", inertia}};
  return lists;
}

void replaceAll(std::string& text, std::string_view word, std::string_view other) {
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word)) text.replace(at, word.size(), other);
}

}  // namespace

/// The lists of numbers of what acts on a state, and the words for its type, become those of space.
void Rewriting::widen(Element& element, bool has_frames) {
  const Plane plane = has_frames ? Plane::frames : Plane::points;
  if (std::string word = element.text("template"); !word.empty()) {
    for (const char* size : {"d", "f", ""}) {
      replaceAll(word, "Rigid2" + std::string(size), "Rigid3");
      replaceAll(word, "Vec2" + std::string(size), "Vec3");
    }
    element.set("template", word);
  }
  const std::size_t width = has_frames ? 3 : 2;
  for (const List& list : listsOfNodes()) {
    const AttributeDescription* given = element.is(list.type) ? element.find(list.attribute) : nullptr;
    if (!given) continue;
    std::string text = element.text(list.attribute);
    std::replace_if(text.begin(), text.end(), [](char c) { return isAnyOf(std::string_view(&c, 1), {"[", "]", ",", ";"}); }, ' ');
    const std::vector<double> numbers = writtenNumbers(text);
    const bool is_mass = list.row == inertia;
    if (is_mass && (numbers.size() < 3 || !has_frames)) continue;
    if (given->typed || (!numbers.empty() && numbers.size() % width != 0)) {
      diagnostics_.error(given->where, element.path() + "." + list.attribute,
                         given->typed ? "a program gives the values of nodes in a plane"
                                      : std::to_string(numbers.size()) + " numbers for nodes in a plane",
                         has_frames ? "x, y and the angle of each, as text" : "x and y of each, as text");
      continue;
    }
    Row all;
    for (std::size_t i = 0; i + width <= numbers.size(); i += width) {
      const Row row = list.row(plane, numbers.data() + i);
      all.insert(all.end(), row.begin(), row.end());
    }
    if (!all.empty()) element.set(list.attribute, printed(all));
  }
  if (element.role() != "mechanical state") widenVectors(element, has_frames);
}

/// Vectors of what acts in a plane, and of points lists of them, get a z.
void Rewriting::widenVectors(Element& element, bool has_frames) {
  for (AttributeDescription& attribute : element.written->attributes) {
    const Data* data = element.probe->data().find(attribute.name);
    const bool is_one = data && std::holds_alternative<Vec3*>(data->pointer());
    const bool is_list = data && !has_frames && std::holds_alternative<std::vector<Vec3>*>(data->pointer());
    const auto& lists = listsOfNodes();
    const bool is_done = std::any_of(lists.begin(), lists.end(), [&](const List& list) {
      return element.is(list.type) && attribute.name == list.attribute;
    });
    if (is_done || (!is_one && !is_list) || attribute.typed || attribute.value.find('@') != std::string::npos) continue;
    if (trimmed(attribute.value).empty()) continue;
    std::vector<double> numbers = writtenNumbers(attribute.value);
    if (is_one && numbers.size() == 3) numbers.pop_back();  // which SOFA does not read
    if (is_one ? numbers.size() != 2 : numbers.size() % 2 != 0) {
      diagnostics_.error(attribute.where, element.path() + "." + attribute.name, inQuotes(attribute.value) + " is no vector in a plane",
                         "two numbers, x and y");
      continue;
    }
    Row all;
    const double z = attribute.name == "vradius" ? 1 : 0;  // any length across the plane, in which nothing leaves it
    for (std::size_t i = 0; i < numbers.size(); i += 2) all.insert(all.end(), {numbers[i], numbers[i + 1], z});
    attribute.value = printed(all);
  }
}

/// The state from which a mapping leads here; null: none.
const Element* Rewriting::leaderOf(const Element& state) const {
  for (const auto& each : state.place->elements) {
    if (each->dropped || each->role() != "mapping") continue;
    const std::string input = each->text("input");
    const LinkTarget target = input.empty() ? LinkTarget{nullptr, state.place->parent, {}} : tree_->follow(*each, input, false);
    return target.element ? target.element : target.place ? target.place->nearest("mechanical state") : nullptr;
  }
  return nullptr;
}

void Rewriting::liftPlanes() {
  std::map<const Element*, Plane> planes;
  std::vector<Element*> states;
  tree_->forEach([&](Element& element) {
    if (element.role() != "mechanical state" || planeOf(element) == Plane::none) return;
    const bool is_mapped = isMapped(element);
    const Element* leader = is_mapped ? leaderOf(element) : nullptr;
    if (is_mapped && !(leader && planes.count(leader))) return;  // two numbers of something else
    planes[&element] = planeOf(element);
    if (!is_mapped) states.push_back(&element);
  });
  if (planes.empty()) return;
  tree_->forEach([&](Element& element) {
    const bool acts = isAnyOf(element.role(), {"mechanical state", "mass", "force field", "projective constraint", "mapping"});
    const std::string link = element.text("mstate");
    const Element* state = element.role() == "mechanical state" ? &element
                           : link.empty()                      ? element.place->nearest("mechanical state")
                                                               : tree_->follow(element, link, false).element;
    const auto found = acts ? planes.find(state) : planes.end();
    if (found != planes.end()) widen(element, found->second == Plane::frames);
  });
  for (Element* state : states) {
    const SourceLocation& where = state->written->where;
    const bool has_frames = planes[state] == Plane::frames;
    diagnostics_.note(where, state->path(),
                      has_frames ? "its frames stay in a plane: here they have seven numbers each, and what leaves the plane is held"
                                 : "its points stay in a plane: here they have a z, which is held");
    tree_->add(*state->place, {"PartialFixedProjectiveConstraint",
                               {{"name", state->name + "_plane", where},
                                {"mstate", SceneTree::linkTo(*state), where},
                                {"fixAll", "true", where},
                                {"fixedDirections", has_frames ? "0 0 1 1 1 0" : "0 0 1", where}},
                               where,
                               state->written->folder});
  }
}

}  // namespace stroma::sofa
