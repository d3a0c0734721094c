// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/motion.h"
#include "framework/simulation/system_members.h"

namespace stroma {

/// What a system is made of, as flat lists: the states that it moves and all that acts on them. Independent states
/// come first (rows [0, independent_rows)), mapped ones after them.
struct Actors {
  std::vector<State*> states;
  std::vector<ForceField*> force_fields;
  std::vector<ForceField*> stiff_fields;   ///< those with a stiffness
  std::vector<ForceField*> damped_fields;  ///< those that depend on velocity
  std::vector<ForceField*> timed_fields;   ///< those that depend on time
  std::vector<Mass*> masses;
  std::vector<ProjectiveConstraint*> constraints;
  std::vector<PositionConstraint*> position_constraints;
  std::vector<LagrangianConstraint*> lagrangian_constraints;
  /// Parents before children: those whose child something acts on, and those that place children that nothing acts on.
  /// The latter are applied after each step and nowhere else.
  std::vector<Mapping*> mappings, passive_mappings;
  Index all_rows = 0, independent_rows = 0;
  Motion motion;                  ///< how positions move by increments
  bool derivatives_vary = false;  ///< some K or C may change with x or v

  /// Grows when the blocks that force fields couple change.
  long patternRevision() const;
  /// No mass couples nodes or lies on a mapped state.
  bool massIsDiagonal() const;
  bool massTurns() const;  ///< some inertia tensor turns with its body
  /// "node 3 of /beam/dofs"
  std::string describeRow(Index row) const;
};

/// Gives the states of a system their order; their rows are counted, not yet bound. Throws ComponentError where what acts
/// on a state does not fit it.
Actors collectActors(const SystemMembers& members);

/// Calls compile() of masses, force fields and mappings once states are bound to their rows, and sorts the force fields
/// by their traits.
void compileActors(Actors& actors);

/// Rebuilds the lists that depend on the traits of the force fields.
void sortByTraits(Actors& actors);

}  // namespace stroma
