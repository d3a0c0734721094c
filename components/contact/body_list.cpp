// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/body_list.h"

#include <fmt/format.h>

#include <algorithm>

#include "components/contact/contact_bodies.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/mapping.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma::contact {
namespace {

bool isBelowIntegrator(const State& state) {
  for (const Node* node = &state.node(); node; node = node->parent())
    for (const auto& component : node->components())
      if (dynamic_cast<const Integrator*>(component.get())) return true;
  return false;
}

std::vector<Mapping*> mappingsOf(const Node& root) {
  std::vector<Mapping*> mappings;
  root.collect(mappings);
  for (Mapping* mapping : mappings) mapping->ensureReady();
  return mappings;
}

bool isMapped(const State& state, const std::vector<Mapping*>& mappings) {
  return std::ranges::any_of(mappings, [&](const Mapping* mapping) { return &mapping->output() == &state; });
}

/// An integrator moves a state below it, and what is mapped from such a state.
bool isMoved(const State& state, const std::vector<Mapping*>& mappings) {
  if (isBelowIntegrator(state)) return true;
  return std::ranges::any_of(mappings, [&](const Mapping* mapping) {
    if (&mapping->output() != &state) return false;
    const std::vector<State*> inputs = mapping->inputs();
    return std::ranges::any_of(inputs, [&](const State* input) { return isMoved(*input, mappings); });
  });
}

/// What collision models say of a body.
struct Solids {
  bool has_model = false;
  std::vector<double> radii;  ///< of a ball around each node; empty: no balls [m]
};
Solids solidsOf(const State& state) {
  std::vector<DrawnSolids*> all;
  state.node().root().collect(all);
  Solids found;
  for (DrawnSolids* each : all) {
    if (auto* component = dynamic_cast<Component*>(each)) component->ensureReady();
    std::vector<const State*> bodies;
    std::vector<DrawnSolids::Sphere> spheres;
    each->addSolids(bodies, spheres);
    found.has_model = found.has_model || std::ranges::find(bodies, &state) != bodies.end();
    for (const DrawnSolids::Sphere& sphere : spheres) {
      if (sphere.state != &state) continue;
      found.radii.resize(std::size_t(state.nodes()), 0);
      found.radii[std::size_t(sphere.node)] = sphere.radius;
    }
  }
  return found;
}

}  // namespace

void BodyList::declare(DataTable& table, const char* help_of_other) {
  table.addLink("other", other_).help(help_of_other);
  table.add("excludedPairs", excluded_)
      .help("bodies without contact with each other, two numbers per pair: 0 is mstate, 1 the first of other; twice the same: with itself");
  table.add("radii", radii_)
      .help("half thickness of each body, mstate first: its surface lies this far from its points, edges and triangles")
      .unit("m")
      .min(0);
}

std::vector<State*> BodyList::init(State& first) {
  states_ = bodiesInContact(first, other_.all());
  std::vector<State*> moved{&first};
  moves_.assign(1, true);
  for (std::size_t i = 1; i < states_.size(); ++i) {
    State* state = states_[i];
    const std::vector<Mapping*> mappings = isBelowIntegrator(*state) ? std::vector<Mapping*>() : mappingsOf(first.node().root());
    moves_.push_back(isMoved(*state, mappings));
    if (moves_.back())
      moved.push_back(state);
    else if (isMapped(*state, mappings))
      throw ComponentError(fmt::format("{} is mapped from a state that no integrator moves", state->path()),
                           "an integrator above that state, or an obstacle without a mapping");
  }
  check();
  return moved;
}

void BodyList::check() const {
  const int count = int(states_.size());
  if (!radii_.empty() && int(radii_.size()) != count)
    throw ComponentError(fmt::format("radii has {} numbers for {} bodies", radii_.size(), count), "one for each body, mstate first");
  for (const Edge& pair : excluded_)
    for (const Index body : pair)
      if (body < 0 || body >= count)
        throw ComponentError(fmt::format("excludedPairs names body {}, and there are {}", body, count),
                             fmt::format("numbers from 0 to {}", count - 1));
}

/// Balls in place of a surface leave holes in it. They are wanted where a response describes the contact by its models, and on a state that
/// is mapped from that of a mesh above.
void BodyList::checkBalls(const State& state, const Component& asker) const {
  const Topology* mesh = asker.isMadeForAnother() ? nullptr : topologyOf(state);
  if (!mesh || highestDimension(mesh->mesh()) < 2) return;
  if (&mesh->node() != &state.node() && isMapped(state, mappingsOf(state.node().root()))) return;
  throw ComponentError(fmt::format("{} has the surface of {} and a SphereCollisionModel, and {} takes a body as one of both", state.path(),
                                   mesh->path(), asker.path()),
                       "no SphereCollisionModel, or one on a state of its own below it",
                       "<Node><MechanicalObject/><SphereCollisionModel/><IdentityMapping/></Node> has balls of its own");
}

/// Balls of a collision model, or the mesh of the state, or the points of a collision model that needs no mesh.
void BodyList::addBody(std::size_t body, Surfaces& surfaces, const TopologyLink& topology, const Component& asker) const {
  const State& state = *states_[body];
  const bool moves = moves_[body];
  Solids solids = solidsOf(state);
  const auto hasMesh = [&] { return (body == 0 && topology.find(asker, state)) || topologyOf(state); };
  if (!solids.radii.empty())
    checkBalls(state, asker);
  else if (solids.has_model && !hasMesh())
    solids.radii.assign(std::size_t(state.nodes()), 0);
  const std::size_t before = surfaces.faces.size();
  if (!solids.radii.empty())
    moves ? surfaces.addBalls(state, solids.radii) : surfaces.addObstacles(state.position, solids.radii);
  else if (const Mesh& mesh = meshOfBody(state, body == 0, topology, asker); moves)
    surfaces.addState(state, mesh);
  else
    surfaces.addObstacle(mesh, state.position);
  if (surfaces.faces.size() == before)
    throw ComponentError(fmt::format("the mesh of {} has no node", state.path()), "cells, edges or points");
  for (std::size_t f = before; !radii_.empty() && f < surfaces.faces.size(); ++f) surfaces.radius[f] += radii_[body];
}

std::vector<StartBody> BodyList::startBodies(const TopologyLink& topology, const Component& asker) const {
  static const Mesh none;
  std::vector<StartBody> bodies;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (!moves_[i]) continue;
    const Topology* mesh = i == 0 ? topology.find(asker, *states_[i]) : nullptr;
    if (!mesh) mesh = topologyOf(*states_[i]);
    bodies.push_back({states_[i], mesh ? &mesh->mesh() : &none});
  }
  return bodies;
}

void BodyList::addTo(Surfaces& surfaces, const TopologyLink& topology, const Component& asker) const {
  std::vector<std::vector<int>> numbers(states_.size());  // of the bodies of the surfaces; balls that do not move are one each
  for (const bool moves : {true, false})
    for (std::size_t body = 0; body < states_.size(); ++body) {
      if (bool(moves_[body]) != moves) continue;
      const int first = int(surfaces.bodies().size());
      addBody(body, surfaces, topology, asker);
      for (int i = first; i < int(surfaces.bodies().size()); ++i) numbers[body].push_back(i);
    }
  for (const auto& [a, b] : excluded_)
    for (const int i : numbers[std::size_t(a)])
      for (const int j : numbers[std::size_t(b)]) surfaces.excluded.push_back({std::min(i, j), std::max(i, j)});
}

}  // namespace stroma::contact
