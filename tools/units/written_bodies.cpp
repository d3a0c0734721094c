// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/units/written_bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <unordered_map>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/simplex_size.h"
#include "framework/scene/text.h"
#include "tools/units/unit_system.h"
#include "tools/units/units.h"

namespace stroma {
namespace {

/// Every layout of units has one behind the last number.
bool endsWithUnit(const AttributeDescription& attribute) {
  constexpr std::size_t longest = 100;
  if (attribute.name == "name" || attribute.name == "units") return false;
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
  for (const Prism& t : mesh.prisms)  // as if it were an oblique one
    volume += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).dot(p[t[3]] - p[t[0]]) / 2;
  for (const Pyramid& t : mesh.pyramids)  // as if its base were a parallelogram
    volume += 2 * tetrahedronVolume(p[t[0]], p[t[1]], p[t[3]], p[t[4]]);
  for (const QuadraticTetrahedron& t : mesh.quadratic_tetrahedra)  // as if its edges were straight
    volume += tetrahedronVolume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
  return volume / mesh.overlap;
}

/// Adds the moduli of a field that are attributes to those of its body.
void addModuli(const ForceField& field, WrittenBody& body) {
  double stiffest = 0;
  std::vector<Modulus> found;
  for (const Data& data : field.data().all()) {
    const auto* list = std::get_if<std::vector<double>*>(&data.pointer());
    if (data.unitText() != "Pa" || data.isOutput() || !list || (*list)->empty() || data.name() == "pressure") continue;
    const double largest = *std::max_element((*list)->begin(), (*list)->end());
    if (!(largest > 0)) continue;
    found.insert(largest > stiffest ? found.begin() : found.end(), {&field, &data});
    stiffest = std::max(stiffest, largest);
    for (const double value : **list)
      if (value > 0) body.softest = std::min(body.softest, value);
  }
  const bool is_stiffer = stiffest > body.value[body_modulus];
  body.moduli.insert(is_stiffer ? body.moduli.begin() : body.moduli.end(), found.begin(), found.end());
  if (is_stiffer) body.value[body_modulus] = stiffest;
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

const std::vector<Vec3>* positionsIn(const Component& component) {
  const Data* data = component.data().find("position");
  const auto* list = data ? std::get_if<std::vector<Vec3>*>(&data->pointer()) : nullptr;
  return list ? *list : nullptr;
}

bool readsFile(const Component& component) {
  const Data* file = component.data().find("filename");
  return component.data().find("unit") && file && file->isSet();
}

/// It has its lengths from the scene, not from another component.
bool holdsLengths(const Component& component) {
  const auto isWritten = [&component](const char* name) {
    const Data* data = component.data().find(name);
    return data && data->isSet() && data->origin() != DataOrigin::linked && !data->isOutput();
  };
  return isWritten("position") || isWritten("max") || isWritten("cellWidth");
}

/// The first in this node or below that has exactly these positions as its own.
const Component* findSource(const Node& node, const std::vector<Vec3>& positions) {
  for (const auto& component : node.components()) {
    if (!readsFile(*component) && !holdsLengths(*component)) continue;
    const std::vector<Vec3>* own = positionsIn(*component);
    if (own && *own == positions) return component.get();
  }
  for (const auto& child : node.children())
    if (const Component* found = findSource(*child, positions)) return found;
  return nullptr;
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
  const Topology* topology = topologyOf(state);
  const std::vector<Vec3>& positions = topology ? topology->mesh().position : state.rest_position;
  const Component* source = nullptr;
  for (const Node* node = &state.node(); node && !source; node = node->parent()) source = findSource(*node, positions);
  if (!source) source = topology ? static_cast<const Component*>(topology) : &state;
  is_file = readsFile(*source);
  return *source;
}

namespace {

/// The gravity that is written for a node, which says in what units even where it does not act.
double writtenGravity(const Node& at) {
  for (const Node* node = &at; node; node = node->parent())
    if (node->own_gravity) return node->own_gravity->norm();
  return 0;
}

/// A body of a state without fields yet. `total` [kg]: of all its masses, of which `mass` is the first.
WrittenBody bodyOf(const State& state, const Mass* mass, double total) {
  WrittenBody body{&state, {}, nullptr, nullptr, {restSize(state), 0, 0, 0}, std::numeric_limits<double>::infinity()};
  const Topology* topology = topologyOf(state);
  const double volume = topology ? volumeOf(topology->mesh()) : 0;
  // a mass elsewhere, which nothing pulls, stands for none: nobody wrote it (tools/sofa/rewritten_masses.cpp)
  const bool is_written = mass && (&mass->node() == &state.node() || !mass->node().gravity().isZero(0));
  const Data* data = is_written ? massDataOf(*mass) : nullptr;
  body.value[body_gravity] = writtenGravity(state.node());
  if (data && volume > 0) {
    body.mass = mass, body.mass_data = data;
    body.value[body_density] = total / volume, body.value[body_gravity] = mass->node().gravity().norm();
  }
  return body;
}

}  // namespace

std::vector<WrittenBody> writtenBodies(const Scene& scene) {
  std::vector<WrittenBody> bodies;
  std::vector<ForceField*> fields;
  std::vector<Mass*> masses;
  scene.root->collect(fields);
  scene.root->collect(masses);
  std::unordered_map<const State*, const Mass*> mass_of;
  std::unordered_map<const State*, double> total_of;
  for (const Mass* mass : masses) {
    mass_of.emplace(&mass->state(), mass);
    total_of[&mass->state()] += mass->totalMass();
  }
  std::unordered_map<const State*, std::size_t> body_of;
  for (const ForceField* field : fields) {
    if (!field->traits().forces_balance) continue;
    const State& state = field->state();
    const auto [at, is_new] = body_of.emplace(&state, bodies.size());
    const auto mass = mass_of.find(&state);
    if (is_new) bodies.push_back(bodyOf(state, mass == mass_of.end() ? nullptr : mass->second, total_of[&state]));
    addModuli(*field, bodies[at->second]);
  }
  std::erase_if(bodies, [](const WrittenBody& body) { return body.moduli.empty() || !(body.value[body_size] > 0); });
  return bodies;
}

std::array<bool, body_quantities.size()> quantitiesWithUnit(const Scene& scene, const WrittenBody& body) {
  const Written written(scene.description.root);
  const bool modulus = std::any_of(body.moduli.begin(), body.moduli.end(), [&written](const Modulus& each) {
    return written.hasUnitOf(*each.field, each.data->name());
  });
  return {lengthsHaveUnit(*body.state, written), modulus,
          body.mass && written.hasUnitOf(*body.mass, body.mass_data->name()), written.gravityHasUnit()};
}

}  // namespace stroma
