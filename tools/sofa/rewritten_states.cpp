// SPDX-License-Identifier: LGPL-2.1-or-later
// States: how many nodes SOFA makes of what is given, and where they start.
#include <algorithm>
#include <cstdlib>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

/// In positions, or in velocities.
static std::size_t numbersOfNode(const Element& state, bool in_positions) {
  const std::string type = state.text("template");
  if (type.starts_with("Rigid3")) return in_positions ? 7 : 6;
  return type.size() > 3 && type.starts_with("Vec") ? std::size_t(type[3] - '0') : 3;
}

/// A mesh of several nodes counts more than one position that is written.
void Rewriting::leaveOnePosition(Element& state) {
  Element* mesh = state.place->firstOf("topology");
  const AttributeDescription* position = state.find("position");
  if (!mesh || !position || !hasOwnNodes(*mesh) || saysNo(state.text("useTopology")) || state.find("rest_position")) return;
  if (writtenNumbers(position->value).size() != numbersOfNode(state, true)) return;
  warn(position->where, state, "position", "is one node: those of " + mesh->path() + " count, as in SOFA");
  state.remove("position");
}

/// The longer of both lists says how many nodes there are. Nodes without a velocity have the last that is given, and nodes without a
/// place are at the origin.
void Rewriting::evenLists(Element& state) {
  const AttributeDescription* given = state.find("velocity");
  if (!given || !state.writes("velocity")) return;
  const std::size_t turns = numbersOfNode(state, false), places = numbersOfNode(state, true);
  std::vector<double> velocity = writtenNumbers(given->value), position = writtenNumbers(state.text("position"));
  if (velocity.size() <= turns || velocity.size() % turns != 0) return;
  if (!state.writes("position")) return state.set("repeatVelocity", "true");
  const std::size_t moving = velocity.size() / turns, placed = position.size() / places;
  if (position.size() % places != 0 || moving == placed) return;
  if (moving < placed) {
    while (velocity.size() < turns * placed) velocity.push_back(velocity[velocity.size() - turns]);
    warn(given->where, state, "velocity", "has " + std::to_string(moving) + " of " + std::to_string(placed) +
                                              " nodes: the others have the last one, as in SOFA");
    return state.set("velocity", printed(velocity));
  }
  for (std::size_t i = position.size(); i < places * moving; ++i) position.push_back(places == 7 && i % places == 6 ? 1 : 0);
  warn(given->where, state, "velocity", "has " + std::to_string(moving) + " nodes and position " + std::to_string(placed) +
                                            ": the others are at the origin, as in SOFA");
  state.set("position", printed(position));
}

/// Numbers for which nothing is written are the coordinates of the mesh beside them, of a Vec1 the first; a mapping has its own.
void Rewriting::takeNumbersOfMesh(Element& state) {
  const std::string type = state.text("template");
  const bool is_of_numbers = type.starts_with("Vec1") || type.starts_with("Vec6");
  const Element* mesh = state.place->firstOf("topology");
  if (!is_of_numbers || !mesh || !hasOwnNodes(*mesh) || saysNo(state.text("useTopology")) || state.place->has("mapping")) return;
  for (const char* name : {"position", "rest_position", "src", "size"})
    if (state.find(name)) return;
  state.set("valuesFromMesh", "true");
  diagnostics_.note(state.written->where, state.path(), "starts with the coordinates of " + mesh->path() + ", as in SOFA");
}

void Rewriting::meanState(Element& element) {
  leaveOnePosition(element);
  evenLists(element);
  takeNumbersOfMesh(element);
  if (element.find("restScale") && std::atof(element.text("restScale").c_str()) == 1) element.remove("restScale");
  if (element.find("scale")) element.remove("scale3d");
  const bool is_of_numbers = element.find("valuesFromMesh") || element.text("template").starts_with("Vec1");
  const bool has_positions = element.find("position") || element.find("rest_position") || element.find("src") ||
                             (element.place->has("topology") && !is_of_numbers);
  if (element.find("size") && has_positions) {
    element.remove("size");
    noEffect("MechanicalObject.size beside positions");
  }
  // of several meshes of a node the first one that has nodes of its own
  std::size_t meshes = 0;
  Element* first = nullptr;
  for (const auto& each : element.place->elements) {
    if (each->dropped || each->role() != "topology") continue;
    ++meshes;
    const bool has_nodes = each->find("position") || each->find("points") || each->find("src");
    if (!first && (has_nodes || each->written->type.ends_with("GridTopology"))) first = each.get();
  }
  bool is_given = false;
  for (const char* name : {"position", "rest_position", "src", "topology"}) is_given = is_given || element.find(name);
  if (meshes > 1 && first && !is_given)
    element.set("topology", SceneTree::linkTo(*first));
  // one node at the origin, which is then moved: a frame as scenes of rigid bodies write it
  bool is_moved = element.text("template").starts_with("Rigid");
  for (const char* name : {"dx", "dy", "dz", "rx", "ry", "rz", "translation", "rotation", "translation2", "rotation2", "externalForce"})
    is_moved = is_moved || element.find(name);
  const bool is_alone = !is_given && !element.find("size") && !element.place->nearest("topology") && !isMapped(element);
  if (is_moved && is_alone && !element.find("valuesFromMesh")) element.set("size", "1");
}

}  // namespace stroma::sofa
