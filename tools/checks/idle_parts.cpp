// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/idle_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"

namespace stroma {
namespace {

/// A mesh whose nodes are those of a state, and the component that has it.
struct OwnedMesh {
  const Component* owner;
  const Mesh* mesh;
};

std::size_t kindsOfVolumeCells(const Mesh& mesh) {
  return std::size_t(!mesh.tetrahedra.empty()) + !mesh.hexahedra.empty() + !mesh.quadratic_tetrahedra.empty();
}

/// The meshes of a state with more than one kind; a loader whose cells nobody has taken over is one too.
std::vector<OwnedMesh> mixedMeshes(const State& state, const Node& root) {
  std::vector<OwnedMesh> found;
  std::vector<MeshLoader*> loaders;
  root.collect(loaders);
  for (const MeshLoader* loader : loaders)
    if (kindsOfVolumeCells(loader->mesh()) > 1 && loader->mesh().position == state.rest_position)
      found.push_back({loader, &loader->mesh()});
  if (!found.empty()) return found;
  for (const Topology* topology : topologiesOf(state))
    if (kindsOfVolumeCells(topology->mesh()) > 1) found.push_back({topology, &topology->mesh()});
  return found;
}

/// Which pairs of rows some force field ties.
class TiedRows {
 public:
  explicit TiedRows(const System& system) : pattern_(system.allRows()) {
    for (const ForceField* field : system.forceFields())
      if (field->traits().forces_balance) field->addPattern(pattern_);
  }
  bool has(Index a, Index b) const {
    const std::vector<Index>& columns = pattern_.columns(a);
    return std::find(columns.begin(), columns.end(), b) != columns.end();
  }

 private:
  BlockPattern pattern_;
};

template <class Cell>
bool edgesAreTied(const CellKind& kind, const Cell& cell, Index first_row, const TiedRows& tied) {
  return std::all_of(kind.edges.begin(), kind.edges.end(), [&](const auto& edge) {
    return tied.has(first_row + cell[std::size_t(edge[0])], first_row + cell[std::size_t(edge[1])]);
  });
}

void warnOfHeldBodies(const System& system, Diagnostics& diagnostics) {
  const ConstraintSet& constraints = system.constraints();
  const auto moves = [](const ProjectiveConstraint* constraint) { return constraint->prescribesMotion(); };
  if (constraints.change() || std::any_of(constraints.all().begin(), constraints.all().end(), moves)) return;
  const auto isHeld = [&constraints](Index row) {
    const Index at = constraints.projectorOf(row);
    return at >= 0 && constraints.projectors()[std::size_t(at)].projector.isZero(0);
  };
  for (const State* state : system.states()) {
    const Index first = state->firstRow(), rows = state->size();
    if (rows == 0 || first + rows > system.independentRows()) continue;
    Index held = 0;
    while (held < rows && isHeld(first + held)) ++held;
    if (held == rows)
      diagnostics.warning(state->where(), state->path(),
                          "every node is held by constraints: nothing of this body can move",
                          "check what the constraints hold: a box that is too large holds all");
  }
}

void warnOfCellsWithoutLaw(const System& system, const Node& root, Diagnostics& diagnostics) {
  std::unique_ptr<TiedRows> tied;
  for (const State* state : system.states())
    for (const auto& [owner, mesh] : mixedMeshes(*state, root)) {
      if (!tied) tied = std::make_unique<TiedRows>(system);
      forEachCellList(
          [&](const CellKind& kind, const auto& cells) {
            if (kind.dimension < 3) return;
            std::size_t idle = 0, first = 0;
            for (std::size_t c = 0; c < cells.size(); ++c)
              if (!edgesAreTied(kind, cells[c], state->firstRow(), *tied) && idle++ == 0) first = c;
            if (idle == 0) return;
            diagnostics.warning(owner->where(), owner->path(),
                                fmt::format("{} of {} {} have no law: no force field acts on them (the first is {} {})",
                                            idle, cells.size(), kind.plural, kind.singular, first),
                                fmt::format("a force field for {} too, or a mesh without them", kind.plural));
          },
          *mesh);
    }
}

}  // namespace

void warnOfIdleParts(const Simulation& simulation, Diagnostics& diagnostics) {
  for (const auto& system : simulation.systems()) {
    warnOfHeldBodies(*system, diagnostics);
    warnOfCellsWithoutLaw(*system, simulation.root(), diagnostics);
  }
}

}  // namespace stroma
