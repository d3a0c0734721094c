// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/mesh_container.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/state_positions.h"
#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/cell_faces.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"

namespace stroma {

void MeshContainer::declare(DataTable& table) {
  table.add("position", mesh_.position).alias("points").unit("m").help("nodes");
  table.add("nbPoints", point_count_).min(0).help("number of nodes, checked against the positions");
  table.add("allowEmpty", allow_empty_).help("a container without positions or without cells is no error");
  forEachCellList(
      [&table](const CellKind& kind, auto& cells) {
        addCellList(table, kind, cells)
            .help(fmt::format("{}, {} node numbers each, in VTK's order", kind.plural, kind.nodes));
      },
      mesh_);
  table.add("createTriangleArray", create_triangles_).help("add the faces of the tetrahedra when no triangle is given");
  table.add("createQuadArray", create_quads_).help("add the faces of the hexahedra when no quad is given");
  table.add("createEdgeArray", create_edges_).help("add the edges of all cells when no edge is given");
  for (const char* name : {"drawEdges", "drawTriangles", "drawQuads", "drawTetrahedra", "drawHexahedra", "drawPoints",
                           "uv", "texcoords", "computeAllBuffers", "checkTopology", "checkConnexity"})
    table.addVisualOnly(name);
}

void MeshContainer::takeFromMapping() {
  std::vector<TopologicalMapping*> mappings;
  node().root().collect(mappings);
  TopologicalMapping* mine = nullptr;
  for (TopologicalMapping* mapping : mappings) {
    if (mapping->output() != this) continue;
    if (mine) throw ComponentError(fmt::format("both {} and {} fill this container", mine->path(), mapping->path()));
    mine = mapping;
  }
  if (!mine) return;
  const auto refuse = [&](std::string_view name) {
    throw ComponentError(fmt::format("{} are given, and {} fills this container too", name, mine->path()),
                         "one of them");
  };
  // what a linked loader has is replaced; values given here would be lost silently
  const auto is_written = [this](std::string_view name) {
    const DataOrigin origin = data().find(name)->origin();
    return origin == DataOrigin::written || origin == DataOrigin::by_override;
  };
  if (!mesh_.position.empty() && is_written("position")) refuse("positions");
  forEachCellList(
      [&](const CellKind& each, const auto& cells) {
        if (!cells.empty() && is_written(each.plural)) refuse(each.plural);
      },
      mesh_);
  mine->ensureReady();
  // Hexahedra that came with the positions would count the body a second time.
  mesh_ = mine->mesh();
}

void MeshContainer::finish() {
  if (mesh_.position.empty()) takePositionsFromState();
  if (mesh_.position.empty() && allow_empty_) mesh_.position.assign(std::size_t(point_count_), Vec3::Zero());
  if (mesh_.position.empty() && !allow_empty_)
    throw ComponentError("there are no nodes", "position, or src=\"@loader\"");
  if (point_count_ > 0 && point_count_ != mesh_.nodes())
    throw ComponentError(fmt::format("nbPoints is {}, but there are {} positions", point_count_, mesh_.nodes()));
  if (const std::string error = mesh_.firstError(); !error.empty()) throw ComponentError(error);
  // Linked cells have been checked, and complained of, where they come from.
  bool volume_written = false, volume_linked = false;
  forEachCellList(
      [&](const CellKind& kind, const auto&) {
        const Data& given = *data().find(kind.plural);
        volume_written = volume_written || (kind.dimension == 3 && given.isSet());
        volume_linked = volume_linked || (kind.dimension == 3 && given.origin() == DataOrigin::linked);
      },
      mesh_);
  if (volume_written && !volume_linked) complainOfCells();
}

void MeshContainer::addParts() {
  if (create_triangles_ && mesh_.triangles.empty()) mesh_.triangles = uniqueTriangles(mesh_, false);
  if (create_quads_ && mesh_.quads.empty()) mesh_.quads = uniqueQuads(mesh_, false);
  if (create_edges_ && mesh_.edges.empty()) mesh_.edges = Mesh(mesh_).allEdges();
}

void MeshContainer::complainOfCells() const {
  if (const std::string complaint = meshComplaint(mesh_); !complaint.empty()) warn(complaint);
}

/// Of frames their centres; numbers have no place, and the cells say how many nodes there are.
void MeshContainer::takeNodesOf(Component& state, bool is_given) {
  if (is_given) state.ensureReady();
  const auto& frames = dynamic_cast<const State&>(state);
  if (is_given && frames.hasFrames()) return void(mesh_.position = nodePlaces(frames, frames.position));
  Index last = -1;
  forEachCellList(
      [&last](const CellKind&, const auto& cells) {
        for (const auto& cell : cells) last = std::max(last, *std::max_element(cell.begin(), cell.end()));
      },
      mesh_);
  mesh_.position.assign(std::size_t(last + 1), Vec3::Zero());
}

/// Links of the state are followed then. A state that asks for this topology has followed them, and is left alone.
void MeshContainer::makeReady(Component& state) {
  asks_state_ = true;
  try {
    state.ensureReady();
  } catch (const DependencyFailed&) {
    asks_state_ = false;
    throw;
  } catch (const ComponentError&) {  // it is being initialised
  }
  asks_state_ = false;
}

void MeshContainer::takePositionsFromState() {
  // SOFA's scenes may give the positions to the state only. A state that takes its positions from here has none.
  for (const auto& component : node().components()) {
    if (component->roleText() != "mechanical state") continue;
    const auto is_given = [&component](const char* name) {
      const Data* data = component->data().find(name);
      return data && data->isSet();
    };
    if (!is_given("position") && !is_given("rest_position") && !allow_empty_) makeReady(*component);
    const Data* position = component->data().find(is_given("position") ? "position" : "rest_position");
    auto* const* values = position ? std::get_if<std::vector<Vec3>*>(&position->pointer()) : nullptr;
    if (position && !values) return takeNodesOf(*component, position->isSet());
    if (!position || !position->isSet()) continue;
    if ((*values)->empty()) component->ensureReady();
    mesh_.position = **values;
    return;
  }
}

}  // namespace stroma
