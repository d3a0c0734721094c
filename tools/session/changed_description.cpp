// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/changed_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"
#include "framework/simulation/observer.h"
#include "tools/session/followed_lists.h"
#include "tools/session/mesh_chain.h"
#include "tools/session/typed_attribute.h"

namespace stroma {
namespace {

constexpr const char* held_name = "points_without_cells";

/// Leaves a component its name and `template`, so that all else can be written.
void strip(ComponentDescription& written, const std::string& name) {
  std::erase_if(written.attributes, [](const AttributeDescription& each) { return each.name != "template"; });
  written.attributes.push_back({"name", name, written.where});
}

void put(ComponentDescription& written, const Data& data, std::string text) {
  std::erase_if(written.attributes, [&data](const AttributeDescription& each) {
    return each.name == data.name() || std::count(data.aliases().begin(), data.aliases().end(), each.name) > 0;
  });
  written.attributes.push_back({data.name(), std::move(text), written.where});
}

/// Whole numbers, or cells as numbers of nodes. Counts have a unit.
bool listsNumbers(const Data& data) {
  if (!data.unitText().empty()) return false;
  const DataPointer& list = data.pointer();
  return std::holds_alternative<std::vector<int>*>(list) || std::holds_alternative<std::vector<Edge>*>(list) ||
         std::holds_alternative<std::vector<Triangle>*>(list) || std::holds_alternative<std::vector<Quad>*>(list) ||
         std::holds_alternative<std::vector<Hexahedron>*>(list);
}

bool isEngine(const Component& component) {
  const std::string role = component.roleText();
  return role.ends_with("engine") || role == "selection";
}

class ChangedScene {
 public:
  ChangedScene(const Simulation& simulation, const Topology& topology, const MeshEdit& edit, SceneDescription& scene)
      : simulation_(simulation),
        topology_(topology),
        edit_(edit),
        scene_(scene),
        first_(simulation.scene().description.root),
        chain_(topology, simulation.root(), first_),
        lists_(topology, edit, [this](const Topology& part) { return isMadeOf(part); }) {}

  Followed run() {
    std::vector<Component*> components;
    simulation_.root().collect(components);
    for (const Component* component : components)
      if (const auto* state = dynamic_cast<const State*>(component); state && isOnMesh(*state))
        states_.push_back(state);
    for (const Component* component : components) {
      checkCuts(*component);
      if (isEngine(*component)) checkEngine(*component);
    }
    for (const State* state : states_) writeState(*state);
    for (const Component* component : components) writeLists(*component);
    writeMesh();
    for (const State* state : states_) hold(*state);
    for (const State* state : states_) done_.states.push_back(state->path());
    for (const std::string& path : done_.left_out) leaveOut(path);
    std::erase_if(done_.left_out, [](const std::string& path) { return path.ends_with(std::string("/") + held_name); });
    return done_;
  }

 private:
  bool isMadeOf(const Topology& part) const { return chain_.isMadeOf(part); }
  Place place(const Component& component) { return placeOf(scene_.root, component.path()); }

  bool isOnMesh(const State& state) const {
    if (state.nodes() != topology_.mesh().nodes()) return false;
    const std::vector<const Topology*> all = topologiesOf(state);
    return std::any_of(all.begin(), all.end(), [this](const Topology* each) { return isMadeOf(*each); });
  }

  /// A container of lists stands where the mesh came from elsewhere.
  void writeMesh() {
    const Place at = place(topology_);
    if (!at.node) throw ComponentError("nothing in the scene says what " + topology_.path() + " is");
    const std::string type = topology_.type();
    const bool is_container = type == "MeshTopology" || type.ends_with("SetTopologyContainer");
    TopologicalMapping* const filler = fillerOf(topology_);
    const bool is_mapping = dynamic_cast<const TopologicalMapping*>(&topology_) != nullptr;
    if (!is_container && !is_mapping && type != "RegularGridTopology")
      throw ComponentError(fmt::format("cells cannot be removed from {}, a {}", topology_.path(), type),
                           "a container, or a MeshTopology that takes its lists");
    if (topology_.mesh().overlap != 1)
      throw ComponentError("cells cannot be removed from " + topology_.path() + ", whose cells cover the body twice",
                           "another cutting");
    ComponentDescription& written = at.written();
    done_.written.insert(topology_.path() + ".");
    if (!is_container) written.type = "MeshTopology";
    strip(written, topology_.name());
    const Mesh& mesh = edit_.mesh();
    written.attributes.push_back(typedAttribute("position", mesh.position, written.where));
    written.attributes.push_back({"allowEmpty", "true", written.where});
    forEachCellList(
        [&written](const CellKind& kind, const auto& cells) {
          if (!cells.empty()) written.attributes.push_back(typedAttribute(std::string(kind.plural), cells, written.where));
        },
        mesh);
    if (!filler) return;
    const Place of_filler = place(*filler);
    if (of_filler.node)
      of_filler.node->components.erase(of_filler.node->components.begin() + std::ptrdiff_t(of_filler.index));
  }

  /// Positions that a state does not take from this mesh alone are written.
  void writeState(const State& state) {
    if (edit_.points().areTheSame()) return;
    const Place at = place(state);
    if (!at.node) return;
    const std::vector<const Topology*> all = topologiesOf(state);
    bool takes_them =
        std::all_of(all.begin(), all.end(), [this](const Topology* each) { return isMadeOf(*each); });
    for (const char* name : {"position", "rest_position", "velocity", "topology"})
      takes_them = takes_them && !state.data().find(name)->isSet();
    if (takes_them) return;
    ComponentDescription& written = at.written();
    done_.written.insert(state.path() + ".");
    strip(written, state.name());
    for (const char* name : {"position", "rest_position", "velocity"})
      put(written, *state.data().find(name), lists_.valuesOf(state, name));
  }

  const State* stateOf(const Component& component) const {
    for (const Node* node = &component.node(); node; node = node->parent())
      for (const auto& near : node->components())
        if (const auto* state = dynamic_cast<const State*>(near.get())) return state;
    return nullptr;
  }
  bool isOfMesh(const Component* state) const {
    return std::find(states_.begin(), states_.end(), state) != states_.end();
  }

  /// An integrator numbers nodes of the one body below it.
  bool solvesForMesh(const Component& integrator) const {
    return std::any_of(states_.begin(), states_.end(), [&integrator](const State* state) {
      const Node* node = &state->node();
      while (node && node != &integrator.node()) node = node->parent();
      return node != nullptr;
    });
  }

  void writeLists(const Component& component) {
    if (dynamic_cast<const State*>(&component) || dynamic_cast<const Topology*>(&component) ||
        dynamic_cast<const MeshSource*>(&component) || dynamic_cast<const MeshChanger*>(&component))
      return;
    const Place at = place(component);
    if (!at.node) return;
    if (component.roleText() == "selection" && component.data().find("allowEmpty"))
      put(at.written(), *component.data().find("allowEmpty"), "true");  // what it found is in lists now
    if (isEngine(component) || component.roleText() == "collision model") return;
    checkMappings(component);
    checkPairs(component);
    const auto is_of_mesh = [&](const Data& data) {
      const std::string link = linkOf(component.type(), data.name());
      if (link.empty()) return component.roleText() == "integrator" ? solvesForMesh(component) : isOfMesh(stateOf(component));
      const Data* named = component.data().find(link);
      return isOfMesh(named && named->link() && named->link()->target() ? named->link()->target() : stateOf(component));
    };
    EntriesLeft left = lists_.forEachChanged(component, is_of_mesh, [&](const Data& data, std::string text) {
      if (std::holds_alternative<std::vector<int>*>(data.pointer()) && trimmed(text).empty() &&
          std::count(done_.left_out.begin(), done_.left_out.end(), component.path()) == 0) {
        done_.left_out.push_back(component.path());
        done_.written.insert(component.path() + ".");
      }
      noteAndPut(component, at.written(), data, std::move(text));
    });
    if (component.roleText() == "Lagrangian constraint" && left.before > 0) done_.entries[component.path()] = std::move(left);
    if (const State* state = stateOf(component); isOfMesh(state)) writeTotals(component, *state, at.written());
  }

  void noteAndPut(const Component& component, ComponentDescription& written, const Data& data, std::string text) {
    done_.written.insert(component.path() + "." + data.name());
    put(written, data, std::move(text));
  }

  /// Names of the others that nobody wrote stay what they are.
  void leaveOut(const std::string& path) {
    const Place at = placeOf(scene_.root, path);
    if (!at.node) return;
    const std::vector<std::string> names = componentNames(*at.node);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (ComponentDescription& each = at.node->components[i]; each.name().empty())
        each.attributes.push_back({"name", names[i], each.where});
    at.node->components.erase(at.node->components.begin() + std::ptrdiff_t(at.index));
  }

  /// Cells that stay are to be cut as before: not by the number of their hexahedron or quad.
  void checkCuts(const Component& component) const {
    const auto* mapping = dynamic_cast<const TopologicalMapping*>(&component);
    const Topology* input = mapping ? inputOf(*mapping) : nullptr;
    if (!input || !isMadeOf(*input)) return;
    const Data *cutting = component.data().find("cutting"), *swapping = component.data().find("swapping");
    const bool is_by_number = (cutting && cutting->print().starts_with("five")) || (swapping && swapping->print() == "true");
    if (is_by_number && !(edit_.cells().hexahedra.areTheSame() && edit_.cells().quads.areTheSame()))
      throw ComponentError(component.path() + " would cut cells that stay another way than before",
                           "cutting=\"six\" without swapping, or the cells that it makes as lists of a container");
  }

  /// Engines have their lists from the scene as it was written.
  void checkEngine(const Component& component) {
    const Place at = placeOf(first_, component.path());
    if (!at.node || !(isOfMesh(stateOf(component)) || chain_.reaches(component))) return;
    for (const Data& data : component.data().all()) {
      if (!data.isSet() || data.isOutput() || !listsNumbers(data)) continue;
      const ListOrigins* cells = originsOf(edit_, kindOf(data.name()));
      if (edit_.points().areTheSame() && (!cells || cells->areTheSame())) continue;
      for (const AttributeDescription& each : at.written().attributes) {
        const auto& aliases = data.aliases();
        const bool is_it = each.name == data.name() || std::count(aliases.begin(), aliases.end(), each.name) > 0;
        if (is_it && !trimmed(each.value).starts_with("@"))
          throw ComponentError(
              fmt::format("{}.{} may number points or cells of a mesh that loses some", component.path(), data.name()),
              "a region by places, or points that stay (keepsPoints)");
      }
    }
  }

  /// A mass or a load that is given as a whole was divided at the start: what goes takes its part with it.
  void writeTotals(const Component& component, const State& state, ComponentDescription& written) {
    const Data *mass = component.data().find("totalMass"), *force = component.data().find("totalForce");
    const Data* indices = component.data().find("indices");
    double share = double(edit_.points().of.size()) / double(std::max<std::size_t>(1, edit_.points().before));
    if (auto* const* numbers =
            indices && indices->isSet() ? std::get_if<std::vector<int>*>(&indices->pointer()) : nullptr) {
      const std::vector<Index> now = edit_.points().now();
      const auto left = std::count_if((*numbers)->begin(), (*numbers)->end(),
                                      [&now](int point) { return now.at(std::size_t(point)) >= 0; });
      share = double(left) / double((*numbers)->size());
    }
    if (mass && mass->isSet() && component.roleText() == "mass") {
      if (component.type() != "UniformMass") share = shareOfCells(state);
      noteAndPut(component, written, *mass, printReal(*std::get<double*>(mass->pointer()) * share));
    }
    if (auto* const* whole = force && force->isSet() ? std::get_if<std::vector<double>*>(&force->pointer()) : nullptr) {
      std::string text;
      for (const double number : **whole) text += printReal(share * number) + " ";
      noteAndPut(component, written, *force, text);
    }
  }

  /// Of the volume, area or length at rest that the mesh had.
  double shareOfCells(const State& state) const {
    std::vector<Vec3> rest;
    for (const auto& shares : edit_.points().shares) {
      rest.emplace_back(Vec3::Zero());
      for (const auto& [point, share] : shares) rest.back() += share * state.rest_position[std::size_t(point)];
    }
    const auto sizeOf = [](const Mesh& mesh, const std::vector<Vec3>& places) {
      double sum = 0;
      forEachCellList(
          [&](const CellKind& kind, const auto& cells) {
            for (std::size_t c = 0; kind.dimension == highestDimension(mesh) && c < cells.size(); ++c)
              sum += std::abs(kind.size(cornersOf(cells[c], places).data()));
          },
          mesh);
      return sum;
    };
    const double before = sizeOf(topology_.mesh(), state.rest_position);
    return before > 0 ? sizeOf(edit_.mesh(), rest) / before : 1;
  }

  /// Lists of a mapping number the nodes of what it maps from.
  void checkMappings(const Component& component) const {
    const auto* mapping = dynamic_cast<const Mapping*>(&component);
    if (!mapping || edit_.points().areTheSame()) return;
    for (const State* input : mapping->inputs())
      if (isOfMesh(input) && !isOfMesh(&mapping->output()))
        for (const Data& data : component.data().all())
          if (data.isSet() && std::holds_alternative<std::vector<int>*>(data.pointer()))
            throw ComponentError(fmt::format("{} numbers points of a mesh that loses some", component.path()),
                                 "points that stay (keepsPoints)");
    if (mapping->inputs().empty() || !isOfMesh(mapping->inputs().back())) return;
    const bool stays_first = edit_.points().now().at(0) == 0;  // the node of numbers that nobody wrote
    for (const Data& data : component.data().all())
      if (namesOneMapped(component.type(), data.name()) && !(stays_first && !data.isSet()))
        throw ComponentError(fmt::format("{}.{} numbers points of a mesh that loses some", component.path(), data.name()),
                             "points that stay (keepsPoints)");
  }

  /// Of a component elsewhere that links the state, a list is of one of the bodies that it joins: which one is not known of all.
  void checkPairs(const Component& component) const {
    const State* own = stateOf(component);
    if (edit_.points().areTheSame() || isOfMesh(own) || dynamic_cast<const Mapping*>(&component)) return;
    const std::vector<Data>& all = component.data().all();
    const bool joins = std::any_of(all.begin(), all.end(),
                                   [this](const Data& data) { return data.link() && isOfMesh(data.link()->target()); });
    for (const Data& data : all)
      if (joins && data.isSet() && linkOf(component.type(), data.name()).empty() && mayNumberPoints(data))
        throw ComponentError(
            fmt::format("{}.{} may number points of a mesh that loses some", component.path(), data.name()),
            "points that stay (keepsPoints)");
  }

  bool isMapped(const State& state) const {
    std::vector<Mapping*> mappings;
    simulation_.root().collect(mappings);
    return std::any_of(mappings.begin(), mappings.end(), [&state](const Mapping* each) { return &each->output() == &state; });
  }

  /// Points without cells have no mass, and would not be anywhere. One that has a cell again is free.
  void hold(const State& state) {
    const Place at = place(state);
    if (!at.node || topologyOf(state) == nullptr || !state.isBound() || isMapped(state)) return;
    std::vector<Index> held = edit_.loosePoints();
    std::vector<bool> used(edit_.mesh().position.size(), false);
    forEachCellList(
        [&used](const CellKind&, const auto& cells) {
          for (const auto& cell : cells)
            for (const Index node : cell) used[std::size_t(node)] = true;
        },
        edit_.mesh());
    const std::string path = state.path().substr(0, state.path().rfind('/')) + "/" + held_name;
    if (Component* before = findComponent(simulation_.root(), path)) {
      const std::vector<Index> now = edit_.points().now();
      for (const int point : *std::get<std::vector<int>*>(before->data().find("indices")->pointer()))
        if (const Index number = now.at(std::size_t(point)); number >= 0 && !used[std::size_t(number)]) held.push_back(number);
      if (held.empty() && std::count(done_.left_out.begin(), done_.left_out.end(), path) == 0) done_.left_out.push_back(path);
    }
    if (held.empty()) return;
    std::erase(done_.left_out, path);
    std::string text;
    for (const Index point : held) fmt::format_to(std::back_inserter(text), "{} ", point);
    for (ComponentDescription& each : at.node->components)
      if (each.name() == held_name)
        for (AttributeDescription& attribute : each.attributes)
          if (attribute.name == "indices") return void(attribute.value = text);
    ComponentDescription constraint;
    constraint.type = "FixedProjectiveConstraint", constraint.where = at.written().where;
    constraint.folder = at.written().folder;
    constraint.attributes = {{"name", held_name, constraint.where}, {"indices", text, constraint.where}};
    at.node->components.push_back(std::move(constraint));
  }

  const Simulation& simulation_;
  const Topology& topology_;
  const MeshEdit& edit_;
  SceneDescription& scene_;
  NodeDescription first_;  ///< as the scene was written before
  MeshChain chain_;
  FollowedLists lists_;
  Followed done_;
  std::vector<const State*> states_;  ///< on the mesh
};

}  // namespace

Followed putMesh(const Simulation& simulation, const Topology& topology, const MeshEdit& edit, SceneDescription& scene) {
  return ChangedScene(simulation, topology, edit, scene).run();
}

}  // namespace stroma
