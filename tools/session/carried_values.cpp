// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/carried_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/load.h"
#include "tools/session/owned_values.h"

namespace stroma {
namespace {

using Shares = std::vector<std::vector<std::pair<Index, double>>>;

/// Numbers of `width` doubles each, of which each new one is a sum of old ones; one without shares is zero.
std::string sums(const std::string& bytes, const Shares& shares, std::size_t width) {
  std::vector<double> old(bytes.size() / sizeof(double)), sum(shares.size() * width, 0.);
  std::memcpy(old.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < shares.size(); ++i)
    for (const auto& [from, share] : shares[i])
      for (std::size_t k = 0; k < width; ++k)
        sum[i * width + k] +=
            share == 1 ? old[std::size_t(from) * width + k] : share * old[std::size_t(from) * width + k];
  return {reinterpret_cast<const char*>(sum.data()), sum.size() * sizeof(double)};
}

Shares alone(const std::vector<Index>& origins) {
  Shares shares;
  for (const Index origin : origins)
    shares.push_back(origin < 0 ? Shares::value_type{} : Shares::value_type{{origin, 1.}});
  return shares;
}

class Carrier {
 public:
  Carrier(Simulation& before, Simulation& after, const std::vector<ChangedMesh>& meshes)
      : before_(before), after_(after), meshes_(meshes) {}

  Archive run(std::vector<std::string>& anew) {
    values_ = after_.checkpoint().entries(), kept_ = before_.checkpoint().entries();
    replace("simulation", valuesOf("simulation", kept_));
    takeEdits();
    takeInputs();
    for (const State* state : after_.states()) takeState(*state);
    for (const auto& system : after_.systems()) takeSystem(*system);
    std::vector<Component*> components;
    after_.root().collect(components);
    for (Component* component : components)
      if (!takeComponent(*component)) anew.push_back(component->path());
    return Archive(values_);
  }

 private:
  const ChangedMesh* meshOf(const std::string& state) const {
    for (const ChangedMesh& mesh : meshes_)
      if (std::count(mesh.followed.states.begin(), mesh.followed.states.end(), state) > 0) return &mesh;
    return nullptr;
  }

  void replace(const std::string& owner, Entries entries) {
    for (const auto& entry : valuesOf(owner, values_)) values_.erase(entry.first);
    values_.merge(std::move(entries));
  }

  /// An attribute that the change has written has its value in the description of the scene.
  void takeEdits() {
    const std::vector<Override> all = before_.edits();
    std::vector<Override> left;
    for (const Override& edit : all)
      if (!isWritten(edit)) left.push_back(edit);
    Archive archive;
    archive.enter("edits");
    visitEdits(archive, left);
    replace("edits", archive.entries());
  }
  bool isWritten(const Override& edit) const {
    const Component* component = findComponent(before_.root(), edit.path);
    const Data* data = component ? component->data().find(edit.attribute) : nullptr;
    const std::string name = edit.path + "." + (data ? data->name() : edit.attribute);
    return std::any_of(meshes_.begin(), meshes_.end(), [&](const ChangedMesh& mesh) {
      return mesh.followed.written.count(name) > 0 || mesh.followed.written.count(edit.path + ".") > 0;
    });
  }

  /// Forces from outside act on what is left of their nodes; those of none end.
  void takeInputs() {
    Archive archive(valuesOf("inputs", kept_)), followed;
    archive.enter("inputs"), followed.enter("inputs");
    std::vector<long> numbers, left;
    long next = 0;
    archive.list("numbers", numbers), archive.value("next", next);
    Entries entries = valuesOf("inputs", kept_);
    for (const long number : numbers) {
      const std::string name = std::to_string(number) + " ";
      std::string state;
      archive.value(name + "state", state);
      const ChangedMesh* mesh = meshOf(state);
      std::vector<Index> nodes;
      archive.list(name + "nodes", nodes);
      if (mesh && !nodes.empty() && !followInput(archive, name, mesh->edit.points().now(), nodes, entries)) {
        std::erase_if(entries, [&name](const auto& entry) { return entry.first.starts_with("inputs:" + name); });
      } else {
        left.push_back(number);
      }
    }
    followed.list("numbers", left);
    for (const auto& [name, entry] : followed.entries()) entries[name] = entry;
    replace("inputs", std::move(entries));
  }

  /// False: none of its nodes is left.
  static bool followInput(Archive& archive, const std::string& name, const std::vector<Index>& now,
                          const std::vector<Index>& nodes, Entries& entries) {
    std::vector<Vec3> targets, targets_left;
    archive.list(name + "targets", targets);
    std::vector<Index> left;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Index node = now.at(std::size_t(nodes[i]));
      if (node < 0) continue;
      left.push_back(node);
      if (!targets.empty()) targets_left.push_back(targets.at(i));
    }
    Archive followed;
    followed.enter("inputs");
    followed.list(name + "nodes", left), followed.list(name + "targets", targets_left);
    for (const auto& [key, entry] : followed.entries()) entries[key] = entry;
    return !left.empty();
  }

  /// Rows of a state now, as sums of its rows before; none: it has none of them. But for their places, points that are held
  /// from now on, without cells, have nothing of what they had.
  std::optional<Shares> rowsOf(const State& state, bool of_places) const {
    const auto* old = dynamic_cast<const State*>(findComponent(before_.root(), state.path()));
    if (!old || old->rows_per_node != state.rows_per_node) return {};
    Shares rows;
    const auto each = std::size_t(state.rows_per_node);
    if (const ChangedMesh* mesh = meshOf(state.path())) {
      for (const auto& shares : mesh->edit.points().shares)
        for (std::size_t c = 0; c < each; ++c) {
          rows.emplace_back();
          for (const auto& [point, share] : shares)
            rows.back().push_back({Index(std::size_t(point) * each + c), share});
        }
      for (const Index point : of_places ? std::vector<Index>{} : mesh->edit.loosePoints())
        for (std::size_t c = 0; c < each; ++c) rows.at(std::size_t(point) * each + c).clear();
    } else if (old->size() == state.size()) {
      for (Index row = 0; row < state.size(); ++row) rows.push_back({{row, 1.}});
    }
    return Index(rows.size()) == state.size() ? std::optional(rows) : std::nullopt;
  }

  void takeState(const State& state) {
    for (const std::string name : {":state:x", ":state:v"}) {
      const auto fresh = values_.find(state.path() + name), kept = kept_.find(state.path() + name);
      if (fresh == values_.end() || kept == kept_.end()) continue;
      if (const auto rows = rowsOf(state, name == ":state:x"))
        fresh->second.bytes = sums(kept->second.bytes, *rows, row_doubles);
    }
    if (!rowsOf(state, true) && isIndependent(state))
      throw ComponentError(fmt::format("{} has other points than before, and no mesh says which", state.path()),
                           "a state on the mesh");
  }

  bool isIndependent(const State& state) const {
    for (const auto& system : after_.systems()) {
      const auto& own = system->states();
      if (std::find(own.begin(), own.end(), &state) != own.end()) return state.firstRow() < system->independentRows();
    }
    return false;
  }

  const System* sameSystem(const System& system) const {
    for (const auto& old : before_.systems())
      if (old->integrator().path() == system.integrator().path()) return old.get();
    return nullptr;
  }

  /// Rows of a whole system now, as sums of those before.
  std::optional<Shares> rowsOf(const System& system, const System& old) const {
    Shares rows(std::size_t(system.allRows()));
    for (const State* state : system.states()) {
      const auto* former = dynamic_cast<const State*>(findComponent(before_.root(), state->path()));
      const auto own = rowsOf(*state, false);
      const bool is_there = former && std::count(old.states().begin(), old.states().end(), former) > 0;
      if (!is_there || !own) {
        if (state->firstRow() < system.independentRows()) return {};
        continue;  // it follows others
      }
      for (std::size_t i = 0; i < own->size(); ++i)
        for (const auto& [row, share] : (*own)[i])
          rows[std::size_t(state->firstRow()) + i].push_back({former->firstRow() + row, share});
    }
    return rows;
  }

  void takeSystem(const System& system) {
    const std::string owner = system.integrator().path();
    takeNamed(owner + ":system:");
    takeNamed(owner + ":linear solver:after_mesh_changes");  // what linear solvers keep
  }

  /// Values of the same sizes, whose names begin so.
  void takeNamed(const std::string& start) {
    for (auto at = values_.lower_bound(start); at != values_.end() && at->first.starts_with(start); ++at) {
      const auto kept = kept_.find(at->first);
      if (kept != kept_.end() && kept->second.bytes.size() == at->second.bytes.size()) at->second = kept->second;
    }
  }

  /// False: it had a history, which is reset.
  bool takeComponent(Component& component) {
    const std::string path = component.path();
    Entries kept = valuesOf(path, kept_);
    const Component* old = findComponent(before_.root(), path);
    if (!old || old->type() != component.type() || kept.empty()) return true;
    if (component.roleText() == "contact" || component.type() == "CollisionResponse")
      return true;  // pairs are found again
    for (auto& [name, entry] : kept)
      if (!follow(component, *old, entry)) return false;
    if (!reads(component, kept)) return false;
    replace(path, std::move(kept));
    return true;
  }

  /// Numbers of rows, nodes or cells that have changed become those of the present ones; what is of none of them stays.
  bool follow(const Component& component, const Component& old, Archive::Entry& entry) const {
    const std::size_t count = entry.bytes.size() / sizeof(double);
    if (entry.kind != Archive::Kind::real || count == 0) return true;
    if (const std::vector<EntriesLeft> left = entriesOf(component.path()); !left.empty()) {
      if (left.size() > 1 || count % left[0].before != 0) return false;  // both bodies of a tie have changed
      entry.bytes = sums(entry.bytes, alone(left[0].of), count / left[0].before);
      return true;
    }
    if (count < 2) return true;
    if (dynamic_cast<const Integrator*>(&component)) return followSystem(component, entry, count);
    for (const auto& [shares, size] : tablesOf(component, old)) {
      if (size == 0 || count % size != 0) continue;
      entry.bytes = sums(entry.bytes, shares, count / size);
      return true;
    }
    return true;
  }

  /// What each changed mesh has left of the lists in which a constraint names points.
  std::vector<EntriesLeft> entriesOf(const std::string& path) const {
    std::vector<EntriesLeft> found;
    for (const ChangedMesh& mesh : meshes_)
      if (const auto at = mesh.followed.entries.find(path); at != mesh.followed.entries.end()) found.push_back(at->second);
    return found;
  }

  bool followSystem(const Component& integrator, Archive::Entry& entry, std::size_t count) const {
    for (const auto& system : after_.systems()) {
      const System* old = sameSystem(*system);
      if (&system->integrator() != &integrator || !old) continue;
      std::optional<Shares> rows = rowsOf(*system, *old);
      if (!rows) return false;
      if (count == row_doubles * std::size_t(old->independentRows())) {
        rows->resize(std::size_t(system->independentRows()));
      } else if (count != row_doubles * std::size_t(old->allRows())) {
        return true;
      }
      entry.bytes = sums(entry.bytes, *rows, row_doubles);
    }
    return true;
  }

  /// What the numbers of a component may be of, in the order of likelihood, with how many there were.
  std::vector<std::pair<Shares, std::size_t>> tablesOf(const Component& component, const Component& old) const {
    std::vector<std::pair<Shares, std::size_t>> tables;
    const auto nearest = [](const Component& one) {
      const State* state = nullptr;
      for (const Node* node = &one.node(); node && !state; node = node->parent())
        for (const auto& near : node->components())
          if (!state) state = dynamic_cast<const State*>(near.get());
      return state;
    };
    const State *now = nearest(component), *then = nearest(old);
    if (!now || !then) return tables;
    const Topology *mesh = meshFor(component, *now), *former = meshFor(old, *then);
    if (mesh && former && dynamic_cast<const ForceField*>(&component))
      addCells(component, mesh->mesh(), former->mesh(), *now, tables);
    if (const auto rows = rowsOf(*now, true); rows && meshOf(now->path()))
      tables.emplace_back(*rows, std::size_t(then->size()));
    return tables;
  }

  static const Topology* meshFor(const Component& component, const State& state) {
    const Data* named = component.data().find("topology");
    if (named && named->link() && named->link()->target())
      return dynamic_cast<const Topology*>(named->link()->target());
    const Link<Topology> none("topology");
    try {
      return findTopology(component, state, none);
    } catch (const ComponentError&) {
      return nullptr;
    }
  }

  /// No cell of the body has come: each that a mesh made of it has now was there before.
  static bool isOldOnly(const MeshEdit& edit, const CellKind& kind) {
    bool is_old_only = kind.dimension == highestDimension(edit.mesh());
    forEachCellList(
        [&](const CellKind&, const ListOrigins& origins) {
          is_old_only = is_old_only && std::count(origins.of.begin(), origins.of.end(), Index(-1)) == 0;
        },
        edit.cells());
    return is_old_only;
  }

  /// Cells by their nodes; those of the largest dimension first.
  void addCells(const Component& component, const Mesh& now, const Mesh& then, const State& state,
                std::vector<std::pair<Shares, std::size_t>>& tables) const {
    const ChangedMesh* changed = meshOf(state.path());
    std::vector<Index> points;
    if (changed) points = changed->edit.points().now();
    forEachCellList(
        [&](const CellKind& kind, const auto& cells, const auto& former) {
          if (former.empty()) return;
          const bool none_is_new = changed && isOldOnly(changed->edit, kind);
          std::map<std::vector<Index>, Index> numbers;
          for (std::size_t c = 0; c < former.size(); ++c) {
            std::vector<Index> nodes(former[c].begin(), former[c].end());
            for (Index& node : nodes) node = points.empty() ? node : points.at(std::size_t(node));
            numbers.emplace(std::move(nodes), Index(c));
          }
          std::vector<Index> origins;
          for (const auto& cell : cells) {
            const auto found = numbers.find(std::vector<Index>(cell.begin(), cell.end()));
            origins.push_back(found == numbers.end() ? -1 : found->second);
            if (none_is_new && origins.back() < 0)
              throw ComponentError(component.path() + " remembers cells that are other ones now, though their nodes stay",
                                   "cells that are cut as before, or written out");
          }
          tables.insert(tables.begin(), {alone(origins), former.size()});
        },
        now, then);
  }

  static bool reads(Component& component, const Entries& kept) {
    if (dynamic_cast<Integrator*>(&component)) return true;
    return takesAll(component, kept);  // otherwise it is reset
  }

  Simulation& before_;
  Simulation& after_;
  const std::vector<ChangedMesh>& meshes_;
  Entries values_, kept_;
};

}  // namespace

Archive carriedValues(Simulation& before, Simulation& after, const std::vector<ChangedMesh>& meshes,
                      std::vector<std::string>& anew) {
  return Carrier(before, after, meshes).run(anew);
}

}  // namespace stroma
