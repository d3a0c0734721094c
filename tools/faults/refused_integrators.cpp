// SPDX-License-Identifier: LGPL-2.1-or-later
// What the integrators of a scene refuse: bodies that none moves, or that several move which cannot be one, and solvers that
// none uses.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "framework/algebra/direct_solver.h"
#include "framework/mesh/topology.h"
#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/refusals.h"

namespace stroma {

namespace {

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
  if (a.movesInTime() != b.movesInTime() || (a.stateOwner() && b.stateOwner())) return ". They cannot make a common step";
  if (a.stateOwner() || b.stateOwner()) return {};  // it moves others beside its own, and rejects what it cannot move
  const auto text = [](const Data* data) { return !data || data->print() == "false" ? std::string("0") : data->print(); };
  for (const char* damping : {"rayleighStiffness", "rayleighMass", "vdamping", "velocityThreshold", "firstOrder"})
    if (text(a.data().find(damping)) != text(b.data().find(damping)))
      return fmt::format(". {} would apply to both: put the damping of one body on its force fields and masses", damping);
  return {};
}

/// A StateOwner moves the bodies of the other one as that would.
bool movesAlike(const Integrator& owner, const Integrator& other) {
  if (!owner.stateOwner() || owner.movesInTime() != other.movesInTime() || other.type() != usualComponent(Part::integrator)) return false;
  return std::ranges::none_of(other.data().all(), [](const Data& each) { return each.isSet() && !each.link() && each.name() != "name"; });
}

/// "/lower/solver (scene.xml:5)"
std::string placed(const Component& component) { return fmt::format("{} ({})", component.path(), component.where().text()); }

}  // namespace

void refuseNested(const Integrator& integrator, const Integrator& above, Diagnostics& diagnostics) {
  diagnostics.error(integrator.where(), integrator.path(),
                    fmt::format("this integrator is below the integrator {}, which already moves every state of {} and below",
                                above.path(), above.node().path()),
                    "one integrator on the way from the root to a state", "remove one of the two, or make their nodes siblings");
}

void tellUnmoved(const State& state, const Component* actor, Diagnostics& diagnostics) {
  if (!actor)
    return diagnostics.note(state.where(), state.path(), "no integrator in this node or above: the state does not move");
  diagnostics.error(state.where(), state.path(), fmt::format("{} acts on this state, but no integrator moves it", actor->path()),
                    "an integrator in the state's node or above",
                    "add <" + usualComponent(Part::integrator) + "/> and a linear solver to " + state.node().path());
}

void refuseUnmoved(const Component& actor, const State& state, Diagnostics& diagnostics) {
  diagnostics.error(actor.where(), actor.path(),
                    fmt::format("the {} {} acts on {}, which no integrator moves", actor.roleText(), actor.path(), state.path()),
                    "an integrator in the node of each state it acts on, or above");
}

void tellDifference(const Component& actor, const State& a, const State& b, const Integrator& mine, const Integrator& other,
                    Diagnostics& diagnostics) {
  const std::string difference = differenceOf(mine, other);
  if (difference.empty() || movesAlike(mine, other)) return;
  const std::string problem =
      fmt::format("the {} {} couples {} and {}, which then move in one system, but their integrators {} and {} differ: {}",
                  actor.roleText(), actor.path(), a.path(), b.path(), placed(mine), placed(other), difference);
  if (const std::string why = whyApart(mine, other); !why.empty())
    diagnostics.error(actor.where(), actor.path(), problem + why, "integrators of the same type with the same attributes",
                      "one integrator in a node above both bodies");
  else
    diagnostics.warning(actor.where(), actor.path(), problem + ". " + mine.path() + " moves all of them");
}

/// Solvers away from all integrators that none of them names would be left out.
void refuseUnused(const Node& root, const std::vector<Integrator*>& integrators, Diagnostics& diagnostics) {
  std::vector<const Component*> named;
  std::vector<std::pair<const Component*, const LinkBase*>> links;
  std::vector<Component*> components;
  root.collect(components);
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
    if (std::any_of(integrators.begin(), integrators.end(), beside)) continue;
    // a direct solver whose factors another component takes from its own node
    const auto takes_factors = [component](const Component* each) {
      const auto* taker = dynamic_cast<const FactorUser*>(each);
      return taker && &each->node() == &component->node() && taker->usesFactorOf(*component);
    };
    if (std::any_of(components.begin(), components.end(), takes_factors)) continue;
    diagnostics.error(
        component->where(), component->path(),
        fmt::format("no integrator uses the {} {}: {} uses the one in its own node, {}", component->roleText(), component->path(),
                    user->first->path(), user->first->node().path()),
        fmt::format("the {} in the node of the integrator, or named by it", component->roleText()),
        partnerOf(*user->first, *user->second) ? std::string("remove it") : fmt::format("move it to {}", user->first->node().path()));
  }
}

}  // namespace stroma
