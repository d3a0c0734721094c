// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/system_members.h"

#include <algorithm>
#include <map>

#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/refusals.h"

namespace stroma {
namespace {

template <class Role>
std::vector<Role*> all(const Node& root) {
  std::vector<Role*> found;
  root.collect(found);
  return found;
}

class SystemSearch {
 public:
  SystemSearch(const Node& root, Diagnostics& diagnostics) : root_(root), diagnostics_(diagnostics) {}

  std::vector<SystemMembers> run() {
    collectIntegrators(root_, nullptr);
    findOwners();
    lookAtAll();
    tellUnmovedStates();
    refuseUnused(root_, integrators_, diagnostics_);
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
        refuseNested(*integrator, *above, diagnostics_);
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
        if (owner != nobody) continue;
        for (const State* input : mapping->inputs())
          if (owner == nobody) owner = ownerOf(input);
        found = found || owner != nobody;
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
      for (const State* state : states)
        if (moved == states.end())
          unmoved_.emplace(state, actor);
        else
          ownerOf(state) == nobody ? refuseUnmoved(*actor, *state, diagnostics_) : couple(*actor, **moved, *state);
    }
  }

  void tellUnmovedStates() {
    for (const State* state : all<State>(root_)) {
      if (ownerOf(state) != nobody) continue;
      const auto actor = unmoved_.find(state);
      tellUnmoved(*state, actor == unmoved_.end() ? nullptr : actor->second, diagnostics_);
    }
  }

  /// One system for both, which the first integrator moves, or one with a precomputed matrix: a different time integration causes a
  /// warning, different damping would change the motion.
  void couple(const Component& actor, const State& a, const State& b) {
    const std::size_t first = ownerOf(&a), second = ownerOf(&b);
    if (leaderOf(first) == leaderOf(second)) return;
    auto [leads, follows] = std::minmax({leaderOf(first), leaderOf(second)});
    if (integrators_[follows]->stateOwner() && !integrators_[leads]->stateOwner()) std::swap(leads, follows);
    tellDifference(actor, a, b, *integrators_[leads], *integrators_[follows], diagnostics_);
    leader_[follows] = leads;
    because_[follows] = actor.path();
  }

  /// The integrator that moves a state, or what something acts on; else nobody.
  std::size_t moverOf(Component& component) const {
    std::vector<State*> states = statesActedOn(component);
    if (auto* state = dynamic_cast<State*>(&component)) states.push_back(state);
    for (const State* state : states)
      if (ownerOf(state) != nobody) return leaderOf(ownerOf(state));
    return nobody;
  }

  std::vector<SystemMembers> systems() const {
    std::vector<SystemMembers> of_integrator(integrators_.size()), systems;
    for (Component* component : all<Component>(root_))
      if (const std::size_t mover = moverOf(*component); mover != nobody) of_integrator[mover].acting.push_back(component);
    for (std::size_t i = 0; i < integrators_.size(); ++i) {
      of_integrator[i].integrator = integrators_[i];
      if (leaderOf(i) != i) of_integrator[leaderOf(i)].merged.push_back({integrators_[i], because_.at(i)});
    }
    for (std::size_t i = 0; i < integrators_.size(); ++i)
      if (leaderOf(i) == i) systems.push_back(std::move(of_integrator[i]));
    return systems;
  }

  const Node& root_;
  Diagnostics& diagnostics_;
  std::vector<Integrator*> integrators_;
  std::vector<std::size_t> leader_;                   ///< of each integrator: itself, or one before it
  std::map<std::size_t, std::string> because_;        ///< of each integrator that another one moves: what joined them
  std::map<const State*, std::size_t> owner_;         ///< index of its integrator
  std::map<const State*, const Component*> unmoved_;  ///< what acts on states that nothing moves
};

}  // namespace

std::vector<State*> statesActedOn(const Component& component) {
  if (const auto* field = dynamic_cast<const ForceField*>(&component)) return field->states();
  if (const auto* mass = dynamic_cast<const Mass*>(&component)) return {&mass->state()};
  if (const auto* constraint = dynamic_cast<const ProjectiveConstraint*>(&component)) return constraint->states();
  if (const auto* constraint = dynamic_cast<const PositionConstraint*>(&component)) return {&constraint->state()};
  if (const auto* mapping = dynamic_cast<const Mapping*>(&component)) {
    std::vector<State*> states = mapping->inputs();
    states.push_back(&mapping->output());
    return states;
  }
  if (const auto* constraint = dynamic_cast<const LagrangianConstraint*>(&component)) return constraint->constrainedStates();
  return {};
}

std::vector<SystemMembers> findSystems(const Node& root, Diagnostics& diagnostics) { return SystemSearch(root, diagnostics).run(); }

}  // namespace stroma
