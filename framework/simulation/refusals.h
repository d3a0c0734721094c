// SPDX-License-Identifier: LGPL-2.1-or-later
// Checks of a complete scene for combinations that are not supported. The engine decides when each check runs; tools/faults
// implements the checks and their messages.
#pragma once
#include <vector>

#include "framework/simulation/actors.h"

namespace stroma {

class ConstraintSet;

// ---- of one system: each throws ComponentError ----
/// Several masses or mappings on one state, and constraints on a mapped state.
void checkActors(const Actors& actors);
/// Position constraints that are incompatible with their states, the integrator or linear relations.
void checkPositionConstraints(const Actors& actors, const Integrator& integrator, const ConstraintSet& constraints);
/// Nodes moved by a constraint whose inertia would have to reach their neighbours.
void checkMassesUnderMotion(const Actors& actors);
/// Rows of `state` that may move (not `held`) and have no mass [kg]; both lists have shape (independent rows).
void checkMassOf(const State& state, const Actors& actors, const std::vector<char>& held, const std::vector<double>& mass);

// ---- of the integrators of a scene: reported to `diagnostics` ----
/// `integrator` is below `above`, which already moves its bodies.
void refuseNested(const Integrator& integrator, const Integrator& above, Diagnostics& diagnostics);
/// `actor` acts on `state`, which no integrator moves, and on other states.
void refuseUnmoved(const Component& actor, const State& state, Diagnostics& diagnostics);
/// No integrator moves `state`. `actor`: what acts on it, or null: the state may then be a marker, and gets only a note.
void tellUnmoved(const State& state, const Component* actor, Diagnostics& diagnostics);
/// `actor` couples `a` and `b`, so `mine` also moves the bodies of `other`: reports differences between the two.
void tellDifference(const Component& actor, const State& a, const State& b, const Integrator& mine, const Integrator& other,
                    Diagnostics& diagnostics);
/// Solvers that no integrator uses.
void refuseUnused(const Node& root, const std::vector<Integrator*>& integrators, Diagnostics& diagnostics);

}  // namespace stroma
