// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/system_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/mesh/topology.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

bool isAtOrBelow(const Node& node, const Node& top) {
  const Node* at = &node;
  while (at && at != &top) at = at->parent();
  return at != nullptr;
}

template <class Role>
std::vector<Role*> all(const Node& root) {
  std::vector<Role*> found;
  root.collect(found);
  return found;
}

// ---- whether integrators are alike ----

/// What a link names, else what its owner finds in its own node.
Component* partnerOf(const Component& owner, const LinkBase& link) {
  if (link.target() || !link.path.empty()) return link.target();
  for (const auto& component : owner.node().components())
    if (component.get() != &owner && link.accepts(*component) && component->answersLookup()) return component.get();
  return nullptr;
}

/// In which attribute two components differ, or empty. What they use is looked into as well.
std::string differenceOf(const Component& a, const Component& b, int depth = 0) {
  constexpr int deepest = 3;  // integrator, linear solver, preconditioner, its factors
  if (a.type() != b.type()) return fmt::format("{} is a {} and {} a {}", a.path(), a.type(), b.path(), b.type());
  for (std::size_t i = 0; i < a.data().all().size(); ++i) {
    const Data &first = a.data().all()[i], &second = b.data().all()[i];
    if (first.isOutput()) continue;
    if (const LinkBase* link = first.link()) {
      const Component *mine = partnerOf(a, *link), *other = partnerOf(b, *second.link());
      const bool same = mine == other && (mine || link->path == second.link()->path);
      if (same) continue;
      if (!mine || !other || depth == deepest)
        return fmt::format("{} of {} and of {} is not the same", first.name(), a.path(), b.path());
      if (std::string below = differenceOf(*mine, *other, depth + 1); !below.empty()) return below;
    } else if (first.print() != second.print()) {
      const auto shown = [](const Data& data) {
        const std::string text = data.print();
        return text.size() > 40 ? text.substr(0, 40) + "..." : text;
      };
      return fmt::format("{} has {}=\"{}\" and {} \"{}\"", a.path(), first.name(), shown(first), b.path(),
                         shown(second));
    }
  }
  return {};
}

/// "/lower/solver (scene.xml:5)"
std::string placed(const Component& component) {
  return fmt::format("{} ({})", component.path(), component.where().text());
}

// ---- the systems of a scene ----

class SystemSearch {
 public:
  SystemSearch(const Node& root, Diagnostics& diagnostics) : root_(root), diagnostics_(diagnostics) {}

  std::vector<SystemMembers> run() {
    collectIntegrators(root_, nullptr);
    findOwners();
    lookAtAll();
    reportUnusedPartners();
    return systems();
  }

 private:
  static constexpr std::size_t nobody = std::size_t(-1);

  /// An integrator owns everything below it, so on any way from the root to a leaf at most one is allowed.
  void collectIntegrators(const Node& node, Integrator* above) {
    for (const auto& component : node.components()) {
      auto* integrator = dynamic_cast<Integrator*>(component.get());
      if (!integrator) continue;
      if (above) {
        diagnostics_.error(integrator->where(), integrator->path(),
                           fmt::format("this integrator lies below the integrator {}, which already moves every state "
                                       "of {} and below",
                                       above->path(), above->node().path()),
                           "one integrator on the way from the root to a state",
                           "remove one of the two, or make their nodes siblings");
        continue;
      }
      above = integrator;
      integrators_.push_back(integrator);
      leader_.push_back(integrators_.size() - 1);
    }
    for (const auto& child : node.children()) collectIntegrators(*child, above);
  }

  std::size_t integratorAbove(const Node& node) const {
    for (const Node* at = &node; at; at = at->parent())
      for (std::size_t i = 0; i < integrators_.size(); ++i)
        if (&integrators_[i]->node() == at) return i;
    return nobody;
  }

  std::size_t ownerOf(const State* state) const { return owner_.at(state); }

  /// What follows by a mapping goes with what it follows.
  void findOwners() {
    for (const State* state : all<State>(root_)) owner_[state] = integratorAbove(state->node());
    const auto mappings = all<Mapping>(root_);
    for (bool found = true; found;) {
      found = false;
      for (const Mapping* mapping : mappings) {
        std::size_t& owner = owner_.at(&mapping->output());
        if (owner != nobody || ownerOf(&mapping->input()) == nobody) continue;
        owner = ownerOf(&mapping->input());
        found = true;
      }
    }
  }

  std::size_t leaderOf(std::size_t integrator) const {
    while (leader_[integrator] != integrator) integrator = leader_[integrator];
    return integrator;
  }

  void lookAtAll() {
    for (const Component* actor : all<Component>(root_)) {
      const std::vector<State*> states = statesActedOn(*actor);
      const auto moved = std::find_if(states.begin(), states.end(), [this](State* s) { return ownerOf(s) != nobody; });
      if (moved == states.end()) continue;  // nothing moves: the states say so
      for (const State* state : states)
        ownerOf(state) == nobody ? refuseUnmoved(*actor, *state) : couple(*actor, **moved, *state);
    }
  }

  void refuseUnmoved(const Component& actor, const State& state) {
    diagnostics_.error(
        actor.where(), actor.path(),
        fmt::format("the {} {} acts on {}, which no integrator moves", actor.roleText(), actor.path(), state.path()),
        "an integrator in the node of each state it acts on, or above");
  }

  /// One system for both; the integrator that comes first in the scene moves it.
  void couple(const Component& actor, const State& a, const State& b) {
    const std::size_t first = ownerOf(&a), second = ownerOf(&b);
    if (leaderOf(first) == leaderOf(second)) return;
    const Integrator &mine = *integrators_[first], &other = *integrators_[second];
    if (const std::string difference = differenceOf(mine, other); !difference.empty())
      diagnostics_.error(
          actor.where(), actor.path(),
          fmt::format("the {} {} couples {} and {}, which then move in one system, but their integrators "
                      "{} and {} are not alike: {}",
                      actor.roleText(), actor.path(), a.path(), b.path(), placed(mine), placed(other), difference),
          "integrators of one kind with the same attributes and the same linear solvers",
          "one integrator in a node above both bodies");
    const auto [low, high] = std::minmax({leaderOf(first), leaderOf(second)});
    leader_[high] = low;
    because_[high] = actor.path();
  }

  /// Solvers away from all integrators that none of them names would be left out.
  void reportUnusedPartners() {
    std::vector<const Component*> named;
    std::vector<std::pair<const Component*, const LinkBase*>> links;
    const auto components = all<Component>(root_);
    for (const Component* component : components)
      for (const Data& attribute : component->data().all()) {
        if (!attribute.link()) continue;
        if (attribute.link()->target()) named.push_back(attribute.link()->target());
        if (dynamic_cast<const Integrator*>(component)) links.emplace_back(component, attribute.link());
      }
    for (Component* component : components) {
      const auto fits = [component](const auto& link) { return link.second->accepts(*component); };
      const auto user = std::find_if(links.begin(), links.end(), fits);
      if (user == links.end() || std::find(named.begin(), named.end(), component) != named.end()) continue;
      if (dynamic_cast<const State*>(component) || dynamic_cast<const Topology*>(component)) continue;
      const auto beside = [component](const Integrator* each) { return &each->node() == &component->node(); };
      if (std::any_of(integrators_.begin(), integrators_.end(), beside)) continue;
      diagnostics_.error(
          component->where(), component->path(),
          fmt::format("no integrator uses the {} {}: {} takes the one of its own node, {}", component->roleText(),
                      component->path(), user->first->path(), user->first->node().path()),
          fmt::format("the {} in the node of the integrator, or named by it", component->roleText()),
          fmt::format("move it to {}, or remove it", user->first->node().path()));
    }
  }

  template <class Role>
  std::vector<Role*> of(std::size_t leader) const {
    std::vector<Role*> members = all<Role>(root_);
    std::erase_if(members, [&](const Role* actor) { return systemOf(statesActedOn(*actor)) != leader; });
    return members;
  }
  std::size_t systemOf(const std::vector<State*>& states) const {
    for (const State* state : states)
      if (ownerOf(state) != nobody) return leaderOf(ownerOf(state));
    return nobody;
  }

  std::vector<SystemMembers> systems() const {
    std::vector<SystemMembers> systems;
    for (std::size_t i = 0; i < integrators_.size(); ++i) {
      if (leaderOf(i) != i) continue;
      SystemMembers members;
      members.integrator = integrators_[i];
      for (std::size_t j = 0; j < integrators_.size(); ++j)
        if (j != i && leaderOf(j) == i) members.merged.push_back({integrators_[j], because_.at(j)});
      members.states = all<State>(root_);
      std::erase_if(members.states, [&](const State* s) { return ownerOf(s) == nobody || leaderOf(ownerOf(s)) != i; });
      members.force_fields = of<ForceField>(i);
      members.masses = of<Mass>(i);
      members.constraints = of<ProjectiveConstraint>(i);
      members.position_constraints = of<PositionConstraint>(i);
      members.mappings = of<Mapping>(i);
      systems.push_back(std::move(members));
    }
    return systems;
  }

  const Node& root_;
  Diagnostics& diagnostics_;
  std::vector<Integrator*> integrators_;
  std::vector<std::size_t> leader_;             ///< of each integrator: itself, or one before it
  std::map<std::size_t, std::string> because_;  ///< of each integrator that another one moves: what joined them
  std::map<const State*, std::size_t> owner_;   ///< index of its integrator
};

}  // namespace

SystemReach::SystemReach(const SystemMembers& members) : tops_{&members.integrator->node()} {
  for (const MergedIntegrator& each : members.merged) tops_.push_back(&each.integrator->node());
  const auto add = [this](const auto& actors) {
    for (Component* actor : actors)
      if (!holds(*actor)) outside_.push_back(actor);
  };
  add(members.states), add(members.force_fields), add(members.masses), add(members.constraints);
  add(members.position_constraints), add(members.mappings);
}

bool SystemReach::holds(const Node& node) const {
  return std::any_of(tops_.begin(), tops_.end(), [&node](const Node* top) { return isAtOrBelow(node, *top); });
}

bool SystemReach::holds(const Component& component) const {
  return holds(component.node()) || std::find(outside_.begin(), outside_.end(), &component) != outside_.end();
}

bool SystemReach::isBelow(const Node& node) const {
  return std::any_of(tops_.begin(), tops_.end(), [&node](const Node* top) { return isAtOrBelow(*top, node); }) ||
         std::any_of(outside_.begin(), outside_.end(),
                     [&node](const Component* component) { return isAtOrBelow(component->node(), node); });
}

std::vector<Component*> SystemReach::components() const {
  std::vector<Component*> found;
  for (const Node* top : tops_) top->collect(found);
  found.insert(found.end(), outside_.begin(), outside_.end());
  return found;
}

std::vector<State*> statesActedOn(const Component& component) {
  if (const auto* field = dynamic_cast<const ForceField*>(&component)) return field->states();
  if (const auto* mass = dynamic_cast<const Mass*>(&component)) return {&mass->state()};
  if (const auto* constraint = dynamic_cast<const ProjectiveConstraint*>(&component)) return constraint->states();
  if (const auto* constraint = dynamic_cast<const PositionConstraint*>(&component)) return {&constraint->state()};
  if (const auto* mapping = dynamic_cast<const Mapping*>(&component)) return {&mapping->input(), &mapping->output()};
  return {};
}

std::vector<SystemMembers> findSystems(const Node& root, Diagnostics& diagnostics) {
  return SystemSearch(root, diagnostics).run();
}

}  // namespace stroma
