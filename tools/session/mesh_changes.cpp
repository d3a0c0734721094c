// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/mesh_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "framework/scene/load.h"
#include "framework/scene/spans.h"
#include "framework/simulation/mesh_changer.h"
#include "tools/mesh_report/read_meshes.h"
#include "tools/session/carried_values.h"
#include "tools/session/changed_description.h"
#include "tools/session/changed_nodes.h"
#include "tools/session/given_changes.h"
#include "tools/session/owned_values.h"

namespace stroma {
namespace {

std::vector<MeshChanger*> changersOf(const Simulation& simulation) {
  std::vector<MeshChanger*> changers;
  for (Observer* observer : simulation.observers())
    if (auto* changer = dynamic_cast<MeshChanger*>(observer)) changers.push_back(changer);
  return changers;
}

std::string pathOf(const MeshChanger* changer) { return dynamic_cast<const Component&>(*changer).path(); }

/// What is due, and who wants it.
struct Due {
  std::string who;
  MeshChange change;
};

std::vector<Due> dueOf(const Simulation& simulation) {
  std::vector<Due> all;
  const std::vector<MeshChanger*> changers = changersOf(simulation);
  if (!changers.empty()) simulation.complete();
  for (MeshChanger* changer : changers) try {
      for (MeshChange& change : changer->changesAt(simulation.time(), simulation.dt()))
        all.push_back({pathOf(changer), std::move(change)});
    } catch (const ComponentError& error) {
      throw ComponentError(pathOf(changer) + ": " + error.what(), error.expected, error.suggestion);
    }
  return all;
}

std::string firstOf(const SceneError& error) {
  for (const Problem& problem : error.diagnostics().problems())
    if (problem.severity == Severity::error)
      return (problem.path.empty() ? "" : problem.path + ": ") + problem.message +
             (problem.expected.empty() ? "" : " (expected " + problem.expected + ")");
  return error.what();
}

/// The scene with the other meshes, loaded. `scene` is its description, and `root` that of the scene before.
std::unique_ptr<Simulation> loaded(SceneDescription scene, Node& root, Factory& factory, Modules& modules) {
  const ReadMeshes read(root);
  try {
    return std::make_unique<Simulation>(instantiate(std::move(scene), factory, modules));
  } catch (const SceneError& error) {
    throw ComponentError("the changed scene is not valid: " + firstOf(error));
  }
}

/// Warnings that the scene did not have before, one of a component.
void addWarnings(const Simulation& before, const Simulation& after, std::vector<std::string>& notes) {
  std::set<std::string> known;
  for (const Problem& problem : before.scene().diagnostics.problems()) known.insert(problem.path);
  for (const Problem& problem : after.scene().diagnostics.problems())
    if (problem.severity == Severity::warning && known.insert(problem.path).second)
      notes.push_back(
          fmt::format("{}, since its mesh changed at t = {:.6g} s: {}", problem.path, before.time(), problem.message));
}

/// Paths of components in which something is written anew.
std::set<std::string> componentsOf(const Followed& followed) {
  std::set<std::string> paths;
  for (const std::string& each : followed.written) paths.insert(each.substr(0, each.rfind('.')));
  return paths;
}

bool haveOneInCommon(const std::set<std::string>& some, const std::set<std::string>& others) {
  return std::any_of(some.begin(), some.end(), [&](const std::string& each) { return others.count(each) > 0; });
}

/// The meshes that change, each with all its changes. `topologies`: theirs, in the same order.
std::vector<ChangedMesh> changedMeshes(const std::vector<Due>& all, std::vector<const Topology*>& topologies) {
  std::vector<ChangedMesh> meshes;
  for (const Due& due : all) try {
      const Topology* const topology = due.change.topology;
      auto at = std::find(topologies.begin(), topologies.end(), topology) - topologies.begin();
      if (std::size_t(at) == topologies.size()) {
        topologies.push_back(topology);
        meshes.push_back({topology->path(), MeshEdit(topology->mesh()), {}});
      }
      meshes[std::size_t(at)].edit.make(due.change);
    } catch (const ComponentError& error) {
      throw ComponentError(due.who + ": " + error.what(), error.expected, error.suggestion);
    }
  return meshes;
}

void addNotes(const Simulation& simulation, const Followed& followed, std::vector<std::string>& notes) {
  for (const std::string& path : followed.left_out)
    notes.push_back(fmt::format("{}: all nodes that it acts on were removed at t = {:.6g} s, and it is left out from now on", path,
                                simulation.time()));
  for (const auto& [path, left] : followed.entries)
    if (!left.of.empty() && left.of.size() < left.before)
      notes.push_back(fmt::format("{}: {} of its {} points were removed at t = {:.6g} s, and it acts on the others from now on",
                                  path, left.before - left.of.size(), left.before, simulation.time()));
}

/// Puts meshes into `scene`, in order. What names nodes of two of them, as a tie does, has the lists of one scene: the second of these
/// meshes goes from `meshes` and stands in the result, to be changed in the scene that has the first.
std::set<const Topology*> putMeshes(const Simulation& simulation, std::vector<ChangedMesh>& meshes,
                                    const std::vector<const Topology*>& topologies, SceneDescription& scene) {
  std::set<const Topology*> later;
  std::set<std::string> written;
  std::vector<ChangedMesh> put;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    SceneDescription with = scene;
    meshes[i].followed = putMesh(simulation, *topologies[i], meshes[i].edit, with);
    const std::set<std::string> components = componentsOf(meshes[i].followed);
    if (haveOneInCommon(components, written)) {
      later.insert(topologies[i]);
      continue;
    }
    written.insert(components.begin(), components.end());
    scene = std::move(with);
    put.push_back(std::move(meshes[i]));
  }
  meshes = std::move(put);
  return later;
}

/// Makes the changes that can be made at once, and returns the others.
std::vector<Due> makeSome(Simulation& simulation, Factory& factory, Modules& modules, const std::vector<Due>& all, MeshChangesMade& made) {
  std::vector<std::string>& notes = made.notes;
  const Span span("change meshes");
  std::vector<const Topology*> topologies;
  std::vector<ChangedMesh> meshes = changedMeshes(all, topologies);
  SceneDescription scene = simulation.scene().description;
  const std::set<const Topology*> later = putMeshes(simulation, meshes, topologies, scene);
  std::vector<std::pair<std::string, Due>> left;
  for (const Due& due : all)
    if (later.count(due.change.topology) > 0) left.emplace_back(due.change.topology->path(), due);
  for (const ChangedMesh& mesh : meshes) addNotes(simulation, mesh.followed, notes);
  std::unique_ptr<Simulation> changed = loaded(std::move(scene), simulation.root(), factory, modules);
  addWarnings(simulation, *changed, notes);
  std::vector<std::string> anew;
  Archive values = carriedValues(simulation, *changed, meshes, anew);
  for (const std::string& path : anew)
    notes.push_back(fmt::format("{}: its mesh changed at t = {:.6g} s, and its history is reset", path,
                                simulation.time()));
  try {
    simulation.become(std::move(changed), std::move(values));
  } catch (const std::runtime_error& error) {
    throw ComponentError(std::string("the run cannot continue with the new mesh: ") + error.what());
  }
  made.any = true;
  for (const ChangedMesh& mesh : meshes)
    for (const std::string& state : mesh.followed.states) made.nodes[state] = mesh.edit.points().now();
  std::vector<Due> rest;
  for (auto& [path, due] : left) {
    due.change.topology = dynamic_cast<const Topology*>(findComponent(simulation.root(), path));
    if (!due.change.topology) throw ComponentError("the mesh " + path + " is not in the scene any more", "one that stays");
    rest.push_back(std::move(due));
  }
  return rest;
}

MeshChangesMade makeAll(Simulation& simulation, Factory& factory, Modules& modules, std::vector<Due> all) {
  MeshChangesMade made;
  while (!all.empty()) all = makeSome(simulation, factory, modules, all, made);
  return made;
}

}  // namespace

MeshChangesMade makeMeshChanges(Simulation& simulation, Factory& factory, Modules& modules) {
  const std::vector<Due> all = dueOf(simulation);
  if (all.empty()) return {};
  MeshChangesMade done = makeAll(simulation, factory, modules, all);
  for (MeshChanger* changer : changersOf(simulation)) changer->changesMade(simulation.time(), simulation.dt());
  return done;
}

MeshChangesMade makeGivenChanges(Simulation& simulation, Factory& factory, Modules& modules, std::vector<MeshChange> changes,
                                 const std::string& who) {
  simulation.complete();
  std::vector<Due> all;
  for (MeshChange& change : changes) all.push_back({who, std::move(change)});
  return makeAll(simulation, factory, modules, all);
}

void writeChangedScene(const Simulation& simulation, Archive& archive) {
  const Simulation* const first = simulation.first();
  if (!first) return;
  archive.enter(changed_scene_owner);
  std::vector<Override> edits = first->edits();
  visitEdits(archive, edits);
  writeChangedNodes(first->scene().description.root, simulation.scene().description.root, archive);
}

void takeChangedScene(Simulation& simulation, Archive values, Factory& factory, Modules& modules) {
  Archive present;
  writeChangedScene(simulation, present);
  const Entries& wanted = values.entries();
  if (areTheSame(present.entries(), wanted)) return;
  if (simulation.hasChangedMeshes()) simulation.reset();
  if (wanted.empty()) return;
  simulation.takeEditsBack();
  values.enter(changed_scene_owner);
  std::vector<Override> edits;
  visitEdits(values, edits);
  SceneDescription scene = simulation.scene().description;
  readChangedNodes(values, scene.root);
  values.checkAllRead();
  std::unique_ptr<Simulation> changed = loaded(std::move(scene), simulation.root(), factory, modules);
  for (const Override& edit : edits) simulation.setAttribute(edit.path, edit.attribute, edit.value);  // reset() finds them
  Archive start = changed->checkpoint().readable();
  simulation.become(std::move(changed), std::move(start));
}

const Checkpoint* meshesAt(double time, const RecordedMeshes& meshes) {
  const auto later = meshes.upper_bound(time);
  return later == meshes.begin() ? nullptr : &std::prev(later)->second;
}

}  // namespace stroma
