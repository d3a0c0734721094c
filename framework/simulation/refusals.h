// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes that are well-formed but cannot be simulated. The engine says when each check runs; tools/faults makes the checks
// and has the messages.
#pragma once
#include <vector>

#include "framework/simulation/actors.h"

namespace stroma {

class ConstraintSet;

// ---- of one system: each throws ComponentError ----
/// Masses that meet on one state, mappings that place one state, and constraints on what a mapping places.
void checkActors(const Actors& actors);
/// Position constraints that do not fit their states, the integrator or the relations beside them.
void checkPositionConstraints(const Actors& actors, const Integrator& integrator, const ConstraintSet& constraints);
/// Nodes that a constraint moves and whose mass would have to reach their neighbours.
void checkMassesUnderMotion(const Actors& actors);
/// Rows of `state` that may move (not `held`) and have no mass [kg]; both lists of shape (independent rows).
void checkMassOf(const State& state, const Actors& actors, const std::vector<char>& held, const std::vector<double>& mass);

// ---- of the integrators of a scene: reported to `diagnostics` ----
/// `integrator` stands below `above`, which moves its bodies already.
void refuseNested(const Integrator& integrator, const Integrator& above, Diagnostics& diagnostics);
/// `actor` acts on `state`, which no integrator moves, and on others.
void refuseUnmoved(const Component& actor, const State& state, Diagnostics& diagnostics);
/// No integrator moves `state`. `actor`: what acts on it, or null: it may then be a marker, and this is only a note.
void tellUnmoved(const State& state, const Component* actor, Diagnostics& diagnostics);
/// `actor` couples `a` and `b`, so that `mine` moves the bodies of `other` too: reports where the two differ.
void tellDifference(const Component& actor, const State& a, const State& b, const Integrator& mine, const Integrator& other,
                    Diagnostics& diagnostics);
/// Solvers that no integrator uses.
void refuseUnused(const Node& root, const std::vector<Integrator*>& integrators, Diagnostics& diagnostics);

}  // namespace stroma
