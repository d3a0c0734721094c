// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/system_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/algebra/direct_solver.h"
#include "framework/mesh/topology.h"
#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

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
  if (a.type() != b.type()) return fmt::format("{} has the type {} and {} the type {}", a.path(), a.type(), b.path(), b.type());
  for (std::size_t i = 0; i < a.data().all().size(); ++i) {
    const Data &first = a.data().all()[i], &second = b.data().all()[i];
    if (first.isOutput()) continue;
    if (const LinkBase* link = first.link()) {
      const Component *mine = partnerOf(a, *link), *other = partnerOf(b, *second.link());
      const bool same = mine == other && (mine || link->path == second.link()->path);
      if (same) continue;
      if (!mine || !other || depth == deepest) return fmt::format("{} of {} and of {} is not the same", first.name(), a.path(), b.path());
      if (std::string below = differenceOf(*mine, *other, depth + 1); !below.empty()) return below;
    } else if (first.print() != second.print()) {
      const auto shown = [](const Data& data) {
        const std::string text = data.print();
        return text.size() > 40 ? text.substr(0, 40) + "..." : text;
      };
      return fmt::format("{} has {}=\"{}\" and {} \"{}\"", a.path(), first.name(), shown(first), b.path(), shown(second));
    }
  }
  return {};
}

/// Why one of them cannot move the bodies of both, to be added to a sentence; empty: it can.
std::string whyApart(const Integrator& a, const Integrator& b) {
  if (a.movesInTime() != b.movesInTime() || a.stateOwner() || b.stateOwner()) return ". They have no step in common";
  const auto text = [](const Data* data) { return !data || data->print() == "false" ? std::string("0") : data->print(); };
  for (const char* damping : {"rayleighStiffness", "rayleighMass", "vdamping", "velocityThreshold", "firstOrder"})
    if (text(a.data().find(damping)) != text(b.data().find(damping)))
      return fmt::format(". {} makes two motions of it: damping of one body belongs to its fields and masses", damping);
  return {};
}

/// "/lower/solver (scene.xml:5)"
std::string placed(const Component& component) { return fmt::format("{} ({})", component.path(), component.where().text()); }

// ---- the systems of a scene ----

class SystemSearch {
 public:
  SystemSearch(const Node& root, Diagnostics& diagnostics) : root_(root), diagnostics_(diagnostics) {}

  std::vector<SystemMembers> run() {
    collectIntegrators(root_, nullptr);
    findOwners();
    lookAtAll();
    reportUnmovedStates();
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
                           "one integrator on the way from the root to a state", "remove one of the two, or make their nodes siblings");
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
          ownerOf(state) == nobody ? refuseUnmoved(*actor, *state) : couple(*actor, **moved, *state);
    }
  }

  /// A state that no integrator reaches stays where it is: fine for a marker, a mistake for a body.
  void reportUnmovedStates() {
    for (const State* state : all<State>(root_)) {
      if (ownerOf(state) != nobody) continue;
      const auto actor = unmoved_.find(state);
      if (actor == unmoved_.end())
        diagnostics_.note(state->where(), state->path(), "no integrator in this node or above: the state does not move");
      else
        diagnostics_.error(state->where(), state->path(),
                           fmt::format("{} acts on this state, but no integrator moves it", actor->second->path()),
                           "an integrator in the state's node or above",
                           "add <" + usualComponent(Part::integrator) + "/> and a linear solver to " + state->node().path());
    }
  }

  void refuseUnmoved(const Component& actor, const State& state) {
    diagnostics_.error(actor.where(), actor.path(),
                       fmt::format("the {} {} acts on {}, which no integrator moves", actor.roleText(), actor.path(), state.path()),
                       "an integrator in the node of each state it acts on, or above");
  }

  /// One system for both, which the first integrator moves: another rule of time is told, another damping is another motion.
  void couple(const Component& actor, const State& a, const State& b) {
    const std::size_t first = ownerOf(&a), second = ownerOf(&b);
    if (leaderOf(first) == leaderOf(second)) return;
    const auto [low, high] = std::minmax({leaderOf(first), leaderOf(second)});
    const Integrator &mine = *integrators_[low], &other = *integrators_[high];
    if (const std::string difference = differenceOf(mine, other); !difference.empty()) {
      const std::string problem =
          fmt::format("the {} {} couples {} and {}, which then move in one system, but their integrators {} and {} are not alike: {}",
                      actor.roleText(), actor.path(), a.path(), b.path(), placed(mine), placed(other), difference);
      if (const std::string why = whyApart(mine, other); !why.empty())
        diagnostics_.error(actor.where(), actor.path(), problem + why, "integrators of one kind with the same attributes",
                           "one integrator in a node above both bodies");
      else
        diagnostics_.warning(actor.where(), actor.path(), problem + ". " + integrators_[low]->path() + " moves all of them");
    }
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
      // a direct solver whose factors another component takes from its own node
      const auto takes_factors = [component](const Component* each) {
        const auto* taker = dynamic_cast<const FactorUser*>(each);
        return taker && &each->node() == &component->node() && taker->usesFactorOf(*component);
      };
      if (std::any_of(components.begin(), components.end(), takes_factors)) continue;
      diagnostics_.error(
          component->where(), component->path(),
          fmt::format("no integrator uses the {} {}: {} takes the one of its own node, {}", component->roleText(), component->path(),
                      user->first->path(), user->first->node().path()),
          fmt::format("the {} in the node of the integrator, or named by it", component->roleText()),
          partnerOf(*user->first, *user->second) ? std::string("remove it") : fmt::format("move it to {}", user->first->node().path()));
    }
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
