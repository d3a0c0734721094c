// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/written_bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/text.h"
#include "framework/scene/units.h"

namespace stroma {
namespace {

/// Every layout of units has one behind the last number.
bool endsWithUnit(const AttributeDescription& attribute) {
  constexpr std::size_t longest = 100;
  if (attribute.name == "name") return false;
  if (attribute.name == "unit") return !attribute.value.empty();
  std::string_view end = trimmed(attribute.value);
  if (end.size() > longest) {
    end.remove_prefix(end.size() - longest);
    end.remove_prefix(std::min(end.find_first_of(" ,\t\n"), end.size()));
  }
  return hasUnit(end);
}

/// The elements of the scene that a value may be written in.
struct Written {
  std::vector<const ComponentDescription*> components;
  std::vector<const NodeDescription*> nodes;

  explicit Written(const NodeDescription& root) { collect(root); }

  bool hasUnitOf(const Component& component, std::string_view attribute) const {
    for (const ComponentDescription* each : components)
      if (each->where.line == component.where().line && each->where.column == component.where().column &&
          each->where.file == component.where().file)
        if (const AttributeDescription* found = each->find(attribute)) return endsWithUnit(*found);
    return false;
  }
  bool gravityHasUnit() const {
    return std::any_of(nodes.begin(), nodes.end(), [](const NodeDescription* node) {
      const AttributeDescription* found = node->find("gravity");
      return found && endsWithUnit(*found);
    });
  }

 private:
  void collect(const NodeDescription& node) {
    nodes.push_back(&node);
    for (const ComponentDescription& component : node.components) components.push_back(&component);
    for (const NodeDescription& child : node.children) collect(child);
  }
};

double volumeOf(const Mesh& mesh) {
  double volume = 0;
  const auto& p = mesh.position;
  for (const Tetrahedron& t : mesh.tetrahedra) volume += tetrahedronVolume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
  for (const Hexahedron& h : mesh.hexahedra)  // as if it were a parallelepiped
    volume += (p[h[1]] - p[h[0]]).cross(p[h[3]] - p[h[0]]).dot(p[h[4]] - p[h[0]]);
  return volume / mesh.overlap;
}

/// The moduli of a field that is a body's own, as far as they are attributes; the first that is there.
const Data* moduliOf(const ForceField& field, double& low, double& high) {
  const Data* first = nullptr;
  low = std::numeric_limits<double>::infinity(), high = 0;
  for (const Data& data : field.data().all()) {
    const auto* list = std::get_if<std::vector<double>*>(&data.pointer());
    if (data.unitText() != "Pa" || data.isOutput() || !list || (*list)->empty() || data.name() == "pressure") continue;
    for (const double value : **list)
      if (value > 0) low = std::min(low, value), high = std::max(high, value);
    if (high > 0 && !first) first = &data;
  }
  return first;
}

const Data* massDataOf(const Mass& mass) {
  for (const char* name : {"totalMass", "vertexMass", "massDensity"})
    if (const Data* data = mass.data().find(name); data && data->isSet()) return data;
  const Data* by_density = mass.data().find("massDensity");
  return by_density ? by_density : mass.data().find("totalMass");
}

bool lengthsHaveUnit(const State& state, const Written& written) {
  bool is_file = false;
  const Component& source = sourceOfLengths(state, is_file);
  if (is_file) return written.hasUnitOf(source, "unit");
  return written.hasUnitOf(source, "position") || written.hasUnitOf(source, "max") ||
         written.hasUnitOf(source, "cellWidth");
}

}  // namespace

bool hasAnyUnit(const NodeDescription& node) {
  const auto isAny = [](const auto& element) {
    return std::any_of(element.attributes.begin(), element.attributes.end(), endsWithUnit);
  };
  return isAny(node) || std::any_of(node.components.begin(), node.components.end(), isAny) ||
         std::any_of(node.children.begin(), node.children.end(), hasAnyUnit);
}

const Component& sourceOfLengths(const State& state, bool& is_file) {
  const auto readsFile = [](const Component& component) {
    const Data* file = component.data().find("filename");
    return component.data().find("unit") && file && file->isSet();
  };
  is_file = true;
  for (const Node* node = &state.node(); node; node = node->parent())
    for (const auto& component : node->components())
      if (readsFile(*component)) return *component;
  is_file = false;
  const Topology* topology = topologyOf(state);
  for (const char* name : {"position", "max", "cellWidth"})
    if (const Data* data = topology->data().find(name); data && data->isSet()) return *topology;
  return state;
}

std::vector<WrittenBody> writtenBodies(const Scene& scene) {
  const Written written(scene.description.root);
  std::vector<WrittenBody> bodies;
  std::vector<ForceField*> fields;
  std::vector<Mass*> masses;
  scene.root->collect(fields);
  scene.root->collect(masses);
  for (const ForceField* field : fields) {
    const State& state = field->state();
    const auto mass = std::find_if(masses.begin(), masses.end(), [&](const Mass* m) { return &m->state() == &state; });
    double low = 0, high = 0;
    const Data* moduli = field->traits().forces_balance ? moduliOf(*field, low, high) : nullptr;
    if (!moduli || mass == masses.end()) continue;
    const Topology* topology = topologyOf(state);
    const double volume = topology ? volumeOf(topology->mesh()) : 0, length = restSize(state);
    const Data* mass_data = massDataOf(**mass);
    if (!(volume > 0 && length > 0 && mass_data)) continue;
    bodies.push_back({&state,
                      field,
                      moduli,
                      *mass,
                      mass_data,
                      {length, high, (*mass)->totalMass() / volume, (*mass)->node().gravity().norm()},
                      low,
                      {lengthsHaveUnit(state, written), written.hasUnitOf(*field, moduli->name()),
                       written.hasUnitOf(**mass, mass_data->name()), written.gravityHasUnit()}});
  }
  return bodies;
}

}  // namespace stroma
