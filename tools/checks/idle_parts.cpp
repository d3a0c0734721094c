// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/idle_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/simulation/integrator.h"
#include "tools/checks/cells_across.h"

namespace stroma {
namespace {

/// A mesh whose nodes are those of a state, and the component that has it.
struct OwnedMesh {
  const Component* owner;
  const Mesh* mesh;
};

std::size_t kindsOfVolumeCells(const Mesh& mesh) {
  return std::size_t(!mesh.tetrahedra.empty()) + !mesh.hexahedra.empty() + !mesh.prisms.empty() + !mesh.pyramids.empty() +
         !mesh.quadratic_tetrahedra.empty();
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

/// By no scene: the dialect holds what no integrator moves, and a note tells.
bool isByDialect(const ProjectiveConstraint& constraint) { return constraint.name().starts_with("held_by_the_scene_"); }

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
    const bool by_dialect = std::ranges::any_of(constraints.all(), [state](const ProjectiveConstraint* constraint) {
      return &constraint->state() == state && isByDialect(*constraint);
    });
    if (held == rows && state->nodes() > 1 && !by_dialect)
      diagnostics.warning(state->where(), state->path(),
                          "every node is fixed by constraints: this body cannot move",
                          "check the selections of the constraints: a box that is too large selects all nodes");
  }
}

/// The directions that a constraint holds, or moves: I - P by row, of rows that move as one by the first of them.
std::map<Index, Mat3> heldDirections(const ProjectiveConstraint& constraint, const NodeGroups& groups, double t) {
  std::vector<NodeProjector> projectors;
  constraint.addProjectors(t, projectors);
  std::map<Index, Mat3> held;
  for (const NodeProjector& each : projectors) {
    const Index group = groups.of(each.row);
    held.try_emplace(group < 0 ? each.row : *groups.begin(group), Mat3::Zero()).first->second += Mat3::Identity() - each.projector;
  }
  return held;
}

/// Whether it may move points along these directions: where it lists its displacements or velocities, these say so.
bool movesAlong(const ProjectiveConstraint& moving, const Mat3& held) {
  constexpr double round_off = 1e-12;
  const Data* relative = moving.data().find("relativeMovements");
  if (moving.state().rows_per_node != 1 || (relative && relative->print() == "false")) return true;
  for (const char* name : {"movements", "velocities"}) {
    const Data* data = moving.data().find(name);
    const auto* numbers = data ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
    if (!numbers || (*numbers)->size() % 3 != 0) continue;
    for (std::size_t i = 0; i < (*numbers)->size(); i += 3)
      if (const Eigen::Map<const Vec3> way((*numbers)->data() + i); (held * way).norm() > round_off * way.norm()) return true;
    return false;
  }
  return true;
}

/// Of a node that is held by one and moved by another in a direction that both have, one has no effect.
void warnOfContradictions(const System& system, double t, double dt, Diagnostics& diagnostics) {
  const auto moves = [](const ProjectiveConstraint* constraint) { return constraint->prescribesMotion(); };
  if (std::ranges::none_of(system.constraints().all(), moves)) return;
  constexpr double parallel = 1e-7;  // as where projectors are merged
  const NodeGroups& groups = system.constraints().groups();
  std::vector<std::pair<const ProjectiveConstraint*, std::map<Index, Mat3>>> held;
  for (const ProjectiveConstraint* constraint : system.constraints().all())
    if (!constraint->prescribesMotion() && constraint->activeIn(t, t + dt) && !isByDialect(*constraint))
      held.emplace_back(constraint, heldDirections(*constraint, groups, t));
  for (const ProjectiveConstraint* moving : system.constraints().all()) {
    if (!moving->prescribesMotion() || !moving->activeIn(t, t + dt)) continue;
    const std::map<Index, Mat3> moved = heldDirections(*moving, groups, t);
    for (const auto& [constraint, rows] : held) {
      const auto both = std::ranges::count_if(rows, [&](const auto& row) {
        const auto at = moved.find(row.first);
        if (at == moved.end() || (row.second * at->second).norm() < parallel) return false;
        return row.second.isIdentity(0) || movesAlong(*moving, row.second);
      });
      if (both > 0)
        diagnostics.warning(moving->where(), moving->path(),
                            fmt::format("{} of its nodes are also fixed by {}: they move, and the other constraint has no effect "
                                        "meanwhile", both,
                                        constraint->path()),
                            "one of the two, or orthogonal directions");
    }
  }
}

/// Nodes that attachments have brought out of the place in which something holds them, to nodes that are held elsewhere.
void warnOfHeldApart(const System& system, double t, double dt, Diagnostics& diagnostics) {
  const NodeGroups& groups = system.constraints().groups();
  if (groups.empty()) return;
  constexpr double round_off = 1e-9;
  const auto broughtAway = [&](const NodeProjector& each) {
    if (groups.of(each.row) < 0 || system.motion().kindOf(each.row) != RowKind::place) return false;
    for (const State* state : system.states()) {
      const Index own = each.row - state->firstRow();
      if (own < 0 || own >= state->size()) continue;
      const Vec3 now = system.x[each.row], before = state->position[std::size_t(own)];
      return ((Mat3::Identity() - each.projector) * (now - before)).norm() > round_off * std::max(now.norm(), before.norm());
    }
    return false;
  };
  for (const ProjectiveConstraint* constraint : system.constraints().all()) {
    if (constraint->prescribesMotion() || !constraint->activeIn(t, t + dt)) continue;
    std::vector<NodeProjector> projectors;
    constraint->addProjectors(t, projectors);
    if (const auto count = std::ranges::count_if(projectors, broughtAway); count > 0)
      diagnostics.warning(constraint->where(), constraint->path(),
                          fmt::format("{} of its nodes are attached to nodes that are fixed at another position: they are fixed "
                                      "there", count),
                          "attached nodes at the same position, or one of the two free");
  }
}

/// Loads whose nodes are all held. Springs and laws have ends that are not.
void warnOfLoadsOnHeldNodes(const System& system, Diagnostics& diagnostics) {
  const ConstraintSet& constraints = system.constraints();
  if (constraints.change()) return;
  for (const ForceField* field : system.forceFields()) {
    const Data* data = field->data().find("indices");
    const auto* indices = data ? std::get_if<std::vector<int>*>(&data->pointer()) : nullptr;
    if (field->traits().forces_balance || field->traits().has_stiffness || !indices || (*indices)->empty()) continue;
    const State& state = field->state();
    if (state.rows_per_node != 1 || state.firstRow() >= system.independentRows()) continue;
    const bool all = std::ranges::all_of(**indices, [&](int node) {
      const Index at = constraints.projectorOf(state.firstRow() + node);
      return at >= 0 && constraints.projectors()[std::size_t(at)].projector.isZero(0);
    });
    if (all)
      diagnostics.warning(field->where(), field->path(),
                          "every node that it acts on is fixed or moved by a constraint: it has no effect");
  }
}

/// A gravity that somebody wrote, and statics without a mass: what moves in time is refused without one.
void warnOfGravityWithoutMass(const System& system, Diagnostics& diagnostics) {
  if (!system.masses().empty() || system.integrator().movesInTime() || system.states().empty()) return;
  const Node* writer = &system.states().front()->node();
  while (writer && !writer->own_gravity) writer = writer->parent();
  if (!writer || writer->own_gravity->isZero(0)) return;
  const Vec3& g = *writer->own_gravity;
  diagnostics.warning(system.states().front()->where(), system.states().front()->path(),
                      fmt::format("it has no mass: the gravity ({:g} {:g} {:g}) of {} has no effect on it", g.x(), g.y(), g.z(),
                                  writer->path()),
                      "a mass, such as MeshMatrixMass massDensity, or gravity=\"0 0 0\"");
}

/// A weight that nobody wrote, and the fall of a body that nothing holds or meets.
void noteWhatGravityDoes(const System& system, Diagnostics& diagnostics) {
  if (system.masses().empty() || system.states().empty() || !system.integrator().movesInTime()) return;
  const State& state = *system.states().front();
  const Node* writer = &state.node();
  while (writer && !writer->own_gravity) writer = writer->parent();
  const Vec3 g = state.node().gravity();
  if (g.isZero(0)) return;
  if (!writer)
    diagnostics.note(state.where(), state.path(),
                     fmt::format("gravity is not given: the default ({:g} {:g} {:g}) m/s^2 is used; set gravity=\"0 0 0\" on the "
                                 "root for none", g.x(),
                                 g.y(), g.z()));
  const auto isInternal = [](const ForceField* field) { return field->traits().forces_balance; };
  const Actors& actors = system.actors();
  const bool meets_nothing = actors.constraints.empty() && actors.position_constraints.empty() &&
                             actors.lagrangian_constraints.empty() && !system.inputs() && !system.forceFields().empty() &&
                             std::ranges::all_of(system.forceFields(), isInternal);
  if (meets_nothing)
    diagnostics.note(state.where(), state.path(), "nothing fixes or supports it: it falls forever");
}

/// Fields with a law of their own for the same cells.
void noteLawsThatAddUp(const System& system, Diagnostics& diagnostics) {
  const auto hasLaw = [](const ForceField& field) { return kindOfLaw(field) != nullptr; };
  constexpr Index most_rows = 100000;  // the patterns of larger bodies take time
  if (system.forceFields().size() < 2 || system.allRows() > most_rows) return;
  struct Law {
    const ForceField* field;
    std::optional<BlockPattern> ties{};  ///< made when another law of the same state comes
  };
  const auto tiesOf = [&](Law& law) -> const BlockPattern& {
    if (!law.ties) law.field->addPattern(law.ties.emplace(system.allRows()));
    return *law.ties;
  };
  std::vector<Law> before;
  for (const ForceField* field : system.forceFields()) {
    if (!hasLaw(*field)) continue;
    Law law{field};
    const auto same = std::ranges::find_if(before, [&](Law& other) {
      if (&other.field->state() != &field->state()) return false;
      const BlockPattern &one = tiesOf(other), &two = tiesOf(law);
      for (Index row = 0; row < system.allRows(); ++row)
        if (one.columns(row) != two.columns(row)) return false;
      return true;
    });
    if (same != before.end())
      diagnostics.note(field->where(), field->path(),
                       fmt::format("it connects the same nodes as {}: their stiffnesses add up", same->field->path()));
    before.push_back(std::move(law));
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
                                fmt::format("{} of {} {} have no material: no force field acts on them (the first is {} {})",
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
    warnOfContradictions(*system, simulation.time(), simulation.dt(), diagnostics);
    warnOfHeldApart(*system, simulation.time(), simulation.dt(), diagnostics);
    warnOfLoadsOnHeldNodes(*system, diagnostics);
    warnOfGravityWithoutMass(*system, diagnostics);
    noteWhatGravityDoes(*system, diagnostics);
    noteLawsThatAddUp(*system, diagnostics);
    warnOfCellsWithoutLaw(*system, simulation.root(), diagnostics);
  }
}

}  // namespace stroma
