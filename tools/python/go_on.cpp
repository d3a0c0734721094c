// SPDX-License-Identifier: LGPL-2.1-or-later
// What a run remembers, handed to the simulation that takes its place. A scene may change while it runs in ways that only
// loading it again can take: a component comes or goes. All that is as before goes on to the bit: positions and velocities,
// times, what actuators and constraints have measured, histories of materials and integrators, files of observers.
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <set>
#include <variant>

#include "framework/scene/archive.h"
#include "framework/simulation/observer.h"
#include "tools/python/engine.h"
#include "tools/session/owned_values.h"

namespace stroma::python {
namespace {

/// Numbers that the new simulation has already are as many.
bool isAsMany(const Archive::Entry& fresh, const Archive::Entry& kept) {
  if (fresh.kind != kept.kind) return false;
  return fresh.kind == Archive::Kind::text || fresh.bytes.empty() || fresh.bytes.size() == kept.bytes.size();
}

bool isAsMany(const Entries& fresh, const Entries& kept) {
  return std::all_of(fresh.begin(), fresh.end(), [&kept](const auto& entry) {
    const auto found = kept.find(entry.first);
    return found == kept.end() || isAsMany(entry.second, found->second);
  });
}

/// A path of the heir for one of the simulation before; one that has no heir keeps its own with a mark.
std::string nameIn(const std::map<std::string, std::string>& renamed, const std::string& path) {
  const auto found = renamed.find(path);
  return found == renamed.end() ? "gone " + path : found->second;
}

/// States and their sizes, in order: what numbers of rows mean.
std::string layoutOf(const System& system, const std::map<std::string, std::string>& renamed) {
  std::string text;
  for (const State* state : system.states()) text += nameIn(renamed, state->path()) + " " + std::to_string(state->size()) + "\n";
  return text;
}

/// Components below a node, in order.
std::string contentsOf(const Node& node, const std::map<std::string, std::string>& renamed) {
  std::vector<Component*> components;
  node.collect(components);
  std::string text;
  for (const Component* component : components) text += nameIn(renamed, component->path()) + " " + component->type() + "\n";
  return text;
}

/// Says which rows, cells and partners a component is of, and not what it does there.
bool isOfMeaning(const Data& data) {
  return data.changeEffect() == ChangeEffect::restart && !data.isOutput() && !std::holds_alternative<ChoiceRef>(data.pointer());
}

class Heir {
 public:
  /// `same`: the path before and the path now of every node and component that is the same. `owned`: of those in the heir that
  /// are somebody's in Python.
  Heir(Simulation& heir, Simulation& before, const std::map<std::string, std::string>& same, const std::set<std::string>& owned)
      : heir_(heir), before_(before), same_(same), owned_(owned) {}

  /// Returns the paths of components that remembered something and begin anew. Throws std::runtime_error when the run cannot
  /// go on from there; `heir` is then as it was.
  std::vector<std::string> takeAll() {
    before_.end();  // its files are whole, and the heir goes on with them
    findSame();
    values_ = heir_.checkpoint().entries(), kept_ = renamed(before_.checkpoint().entries());
    for (const char* owner : {"simulation", "inputs"}) replace(owner);
    takeStates();
    takeSystems();
    std::vector<Component*> components;
    heir_.root().collect(components);
    for (Component* component : components) takeComponent(*component);
    heir_.restore(Archive(values_));
    heir_.root().root_time = before_.root().root_time;  // the run began there: what goes by the start of a step knows
    return anew_;
  }

 private:
  /// Completes what is the same by components that are of nobody in Python, in nodes that are the same.
  void findSame() {
    std::map<std::string, std::string> present;
    for (const auto& [old, now] : same_) present[now] = old;
    std::map<std::string, Component*> olds;
    for (Component* component : componentsOf(before_)) olds[component->path()] = component;
    for (const Component* component : componentsOf(heir_)) {
      const std::string path = component->path();
      auto old = present.find(path);
      const auto node = present.find(component->node().path());
      if (old == present.end() && node != present.end() && owned_.count(path) == 0)
        old = present.emplace(path, (node->second == "/" ? "" : node->second) + "/" + component->name()).first;
      if (old == present.end()) continue;
      if (const auto found = olds.find(old->second); found != olds.end()) same_[old->second] = path, olds_[path] = found->second;
    }
  }

  static std::vector<Component*> componentsOf(Simulation& simulation) {
    std::vector<Component*> components;
    simulation.root().collect(components);
    return components;
  }

  /// Values of the simulation before under the paths of this one; those of nobody here are left out.
  Entries renamed(const Entries& entries) const {
    Entries found;
    for (const auto& [name, entry] : entries)
      if (!name.starts_with('/')) found.emplace(name, entry);
    for (const auto& [old, now] : same_)
      for (auto at = entries.lower_bound(old + ":"); at != entries.end() && at->first.starts_with(old + ":"); ++at)
        found.emplace(now + at->first.substr(old.size()), at->second);
    return found;
  }

  void replace(const std::string& owner) {
    for (const auto& entry : valuesOf(owner, values_)) values_.erase(entry.first);
    values_.merge(valuesOf(owner, kept_));
  }

  void takeStates() {
    for (const State* state : heir_.states())
      for (const char* name : {":state:x", ":state:v"}) {
        const auto fresh = values_.find(state->path() + name), kept = kept_.find(state->path() + name);
        if (kept != kept_.end() && fresh->second.bytes.size() == kept->second.bytes.size()) fresh->second = kept->second;
      }
  }

  /// Matrices and solvers remember the whole system, so that nothing in it may be another one.
  void takeSystems() {
    std::map<std::string, std::string> own;
    for (const Component* component : componentsOf(heir_)) own[component->path()] = component->path();
    is_same_everywhere_ = contentsOf(heir_.root(), own) == contentsOf(before_.root(), same_);
    for (const auto& system : heir_.systems()) {
      const std::string path = system->integrator().path();
      for (const auto& old : before_.systems()) {
        if (nameIn(same_, old->integrator().path()) != path || layoutOf(*old, same_) != layoutOf(*system, own)) continue;
        for (const State* state : system->states()) same_rows_.insert(state->path());
        if (contentsOf(old->integrator().node(), same_) != contentsOf(system->integrator().node(), own)) continue;
        replace(path + ":system"), replace(path + ":linear solver");
      }
    }
  }

  void takeComponent(Component& component) {
    const std::string path = component.path();
    const auto old = olds_.find(path);
    const Entries kept = valuesOf(path, kept_), fresh = valuesOf(path, values_);
    if (old == olds_.end() || kept.empty()) return;
    if (old->second->type() != component.type() || !means(component, *old->second) || !reads(component, kept, fresh)) {
      if (old->second->type() == component.type() && !isContact(component)) anew_.push_back(path);
      return;
    }
    replace(path);
    // forces to start from, of constraints that have become more or fewer
    for (const auto& [name, entry] : fresh)
      if (!isAsMany(entry, values_[name])) values_[name] = entry;
  }

  /// Whether numbers that the component remembers are of the same rows, cells and partners.
  bool means(const Component& component, const Component& old) const {
    if (dynamic_cast<const Observer*>(&component)) return isOfTheSame(component, old);
    if (dynamic_cast<const Integrator*>(&component)) {  // of the system's, or one whose bodies another one moves too
      std::vector<State*> states;
      component.node().collect(states);
      return std::any_of(states.begin(), states.end(), [this](const State* state) { return same_rows_.count(state->path()) > 0; });
    }
    if (isContact(component))  // pairs of all bodies, by number: they are found again
      return is_same_everywhere_;
    return sizeNear(component) == sizeNear(old) && isOfTheSame(component, old);
  }

  /// Indices, cells and partners are what they were.
  bool isOfTheSame(const Component& component, const Component& old) const {
    for (const Data& data : component.data().all()) {
      const Data* former = isOfMeaning(data) ? old.data().find(data.name()) : nullptr;
      if (!former || (!data.isSet() && !former->isSet())) continue;  // what is not written a component may measure itself
      if (data.link()) {
        const Component *now = data.link()->target(), *then = former->link() ? former->link()->target() : nullptr;
        if ((now ? now->path() : "") != (then ? nameIn(same_, then->path()) : "")) return false;
      } else if (data.print() != former->print()) {
        return false;
      }
    }
    return true;
  }

  static bool isContact(const Component& component) {
    return component.roleText() == "contact" || component.type() == "CollisionResponse";
  }

  /// Of the state that a component of a node acts on.
  static Index sizeNear(const Component& component) {
    for (const Node* node = &component.node(); node; node = node->parent())
      for (const auto& near : node->components())
        if (const auto* state = dynamic_cast<const State*>(near.get())) return state->size();
    return 0;
  }

  static bool reads(Component& component, const Entries& kept, const Entries& fresh) {
    if (dynamic_cast<Integrator*>(&component)) return true;
    if (!isAsMany(fresh, kept)) return false;
    return takesAll(component, kept);  // else it begins anew
  }

  Simulation& heir_;
  Simulation& before_;
  Entries values_, kept_;
  std::map<std::string, std::string> same_;  ///< paths now by paths before
  std::set<std::string> owned_;
  std::map<std::string, Component*> olds_;   ///< by paths now
  std::set<std::string> same_rows_;  ///< states of systems whose rows are what they were
  std::vector<std::string> anew_;
  bool is_same_everywhere_ = false;
};

}  // namespace

void bindGoOn(py::module_& module) {
  module.def("go_on", [](const std::shared_ptr<Engine>& heir, const std::shared_ptr<Engine>& before,
                         const std::map<std::string, std::string>& same, const std::set<std::string>& owned) {
    if (before->simulation().hasChangedMeshes())
      throw std::runtime_error("meshes have changed in the run: it cannot go on in a scene that is made anew of its tree");
    std::vector<std::string> anew = Heir(heir->between(), before->between(), same, owned).takeAll();
    heir->forcesAreOld();
    return anew;
  });
}

}  // namespace stroma::python
