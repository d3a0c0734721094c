// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/motion.h"
#include "framework/simulation/system_members.h"

namespace stroma {

/// The contents of a system as flat lists: the states that it moves and everything that acts on them. Independent states
/// come first (rows [0, independent_rows)), mapped states after them.
struct Actors {
  std::vector<State*> states;
  std::vector<ForceField*> force_fields;
  std::vector<ForceField*> stiff_fields;   ///< with a stiffness
  std::vector<ForceField*> damped_fields;  ///< velocity-dependent
  std::vector<ForceField*> timed_fields;   ///< time-dependent
  std::vector<Mass*> masses;
  std::vector<ProjectiveConstraint*> constraints;
  std::vector<PositionConstraint*> position_constraints;
  std::vector<LagrangianConstraint*> lagrangian_constraints;
  /// Parents before children: mappings whose child something acts on, and passive ones with no force on their child.
  /// Passive mappings are applied only after each step.
  std::vector<Mapping*> mappings, passive_mappings;
  Index all_rows = 0, independent_rows = 0;
  Motion motion;                  ///< how increments change positions
  bool derivatives_vary = false;  ///< some K or C may change with x or v

  /// Increases when the blocks coupled by force fields change.
  long patternRevision() const;
  /// True if no mass couples nodes or acts on a mapped state.
  bool massIsDiagonal() const;
  bool massTurns() const;  ///< some inertia tensor rotates with its body
  /// "node 3 of /beam/dofs"
  std::string describeRow(Index row) const;
};

/// Orders the states of a system and counts their rows without binding them. Throws ComponentError if a component is
/// incompatible with a state that it acts on.
Actors collectActors(const SystemMembers& members);

/// Calls compile() of masses, force fields and mappings after states are bound to their rows, and sorts the force fields
/// by their traits.
void compileActors(Actors& actors);

/// Rebuilds the lists that depend on the traits of force fields.
void sortByTraits(Actors& actors);

}  // namespace stroma
