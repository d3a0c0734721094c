// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/contacts.h"

#include <algorithm>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma::drawing {
namespace {

template <class Value>
const Value* valueOf(const Component& component, const char* attribute) {
  const Data* data = component.data().find(attribute);
  Value* const* found = data ? std::get_if<Value*>(&data->pointer()) : nullptr;
  return found ? *found : nullptr;
}

std::vector<Component*> componentsOf(const Simulation& simulation) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  return all;
}

Index bodyOf(const Drawing& drawing, const State* state) {
  const auto found =
      std::find_if(drawing.bodies.begin(), drawing.bodies.end(), [&](const Body& body) { return body.state == state && body.system; });
  return state && found != drawing.bodies.end() ? Index(found - drawing.bodies.begin()) : -1;
}

/// The bodies of a contact as its pairs name them, each once; the one that it is on without any.
std::vector<std::string> namesOf(const Component& component, const State& state) {
  std::vector<std::string> names;
  if (const auto* pairs = valueOf<std::vector<std::string>>(component, "pairs"))
    for (const std::string& name : *pairs)
      if (name.starts_with('/') && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  if (names.empty()) names.push_back(state.path());
  return names;
}

}  // namespace

const State* stateOf(const Component& component) {
  const Data* link = component.data().find("mstate");
  if (link && link->link() && link->link()->target()) return dynamic_cast<const State*>(link->link()->target());
  if (const auto* field = dynamic_cast<const ForceField*>(&component)) return &field->state();
  const auto* constraint = dynamic_cast<const LagrangianConstraint*>(&component);
  return constraint ? constraint->constrainedStates().front() : nullptr;
}

const std::vector<Vec3>* vectorsOf(const Component& component, const char* attribute) {
  return valueOf<std::vector<Vec3>>(component, attribute);
}
std::optional<double> numberOf(const Component& component, const char* attribute) {
  if (const double* number = valueOf<double>(component, attribute)) return *number;
  if (const int* whole = valueOf<int>(component, attribute)) return *whole;
  return {};
}

std::vector<Component*> withNodeValues(const Simulation& simulation) {
  std::vector<Component*> found = componentsOf(simulation);
  std::erase_if(found, [](const Component* component) {
    const auto& all = component->data().all();
    const bool is_obstacle = dynamic_cast<const DrawnObstacles*>(component) != nullptr;
    const auto is_kept = [=](const Data& data) { return data.isOfNodes() || (is_obstacle && data.isOutput()); };
    return std::none_of(all.begin(), all.end(), is_kept);
  });
  return found;
}

void addNodeFields(const Simulation& simulation, Drawing& drawing) {
  for (const Component* component : withNodeValues(simulation)) {
    const Index body = bodyOf(drawing, stateOf(*component));
    if (body < 0) continue;
    for (const Data& data : component->data().all()) {
      if (!data.isOfNodes()) continue;
      const bool is_taken = std::any_of(drawing.fields.begin(), drawing.fields.end(), [&](const Field& field) {
        return field.body == body && field.name == data.name();
      });
      const std::string name = is_taken ? data.name() + " of " + component->path() : data.name();
      drawing.fields.push_back({int(drawing.fields.size()) + 1, body, name, nullptr, &data});
    }
  }
}

bool nodeValues(const Field& field, const Body& body, std::vector<float>& out) {
  out.clear();
  const auto take = [&](const auto& list, auto&& number) {
    if (Index(list.size()) != body.state->nodes()) return false;
    for (const Index row : body.node) out.push_back(float(number(list[std::size_t(row / body.state->rows_per_node)])));
    return true;
  };
  const DataPointer& pointer = field.data->pointer();
  const auto same = [](auto value) { return value; };
  if (auto* const* vectors = std::get_if<std::vector<Vec3>*>(&pointer)) return take(**vectors, [](const Vec3& v) { return v.norm(); });
  if (auto* const* numbers = std::get_if<std::vector<double>*>(&pointer)) return take(**numbers, same);
  if (auto* const* whole = std::get_if<std::vector<int>*>(&pointer)) return take(**whole, same);
  return false;
}

void addContacts(const Simulation& simulation, Drawing& drawing) {
  for (const Component* component : componentsOf(simulation)) {
    const Data* of_nodes = component->data().find("contactForces");
    const State* state = of_nodes && of_nodes->isOfNodes() ? stateOf(*component) : nullptr;
    if (const Index body = bodyOf(drawing, state); body >= 0)
      drawing.contacts.push_back({component, body, namesOf(*component, *state)});
    else if (vectorsOf(*component, "secondPoints") && vectorsOf(*component, "forces"))
      drawing.contacts.push_back({component, -1, {}});
  }
  addObstacles(simulation, drawing);
}

ContactForces forcesOf(const Contact& contact, const Drawing& drawing) {
  ContactForces out;
  if (contact.body < 0) {
    const auto &places = *vectorsOf(*contact.owner, "secondPoints"), &forces = *vectorsOf(*contact.owner, "forces");
    for (std::size_t i = 0; i < std::min(places.size(), forces.size()); ++i)
      if (!forces[i].isZero(0)) out.places.push_back(places[i]), out.forces.push_back(forces[i]);
    return out;
  }
  const Body& body = drawing.bodies[std::size_t(contact.body)];
  const auto& normal = *vectorsOf(*contact.owner, "contactForces");
  const std::vector<Vec3>* friction = vectorsOf(*contact.owner, "frictionForces");
  for (std::size_t i = 0; i < normal.size(); ++i) {
    Vec3 force = normal[i];
    if (friction && friction->size() == normal.size()) force += (*friction)[i];
    const Index row = Index(i) * body.state->rows_per_node;
    if (force.isZero(0) || body.page[std::size_t(row)] < 0) continue;
    out.pages.push_back(body.page[std::size_t(row)]), out.places.emplace_back(body.x()[row]), out.forces.push_back(force);
  }
  return out;
}

}  // namespace stroma::drawing
