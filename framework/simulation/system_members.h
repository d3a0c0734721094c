// SPDX-License-Identifier: LGPL-2.1-or-later
// Which states move together: the bodies of one integrator, and those of several that something couples.
//
// A state belongs to the integrator of its node or the nearest above; one without, that a mapping places, to that of
// the state it follows. What acts on states of one integrator is in its system, wherever the scene writes it. What acts
// on states of several couples them: forces, ties and relations between bodies have derivatives with respect to both, so
// both are solved in one system, and the first integrator in the scene moves them all. That is the same as one integrator
// above all bodies. A warning says where the integrators differ; other damping and statics beside motion are refused.
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/position_constraint.h"
#include "framework/mechanics/projective_constraint.h"

namespace stroma {

class Integrator;

/// An integrator whose bodies another one moves.
struct MergedIntegrator {
  Integrator* integrator = nullptr;
  std::string because;  ///< the path of what couples its bodies to others
};

/// What one system is made of.
struct SystemMembers {
  Integrator* integrator = nullptr;
  std::vector<MergedIntegrator> merged;
  std::vector<Component*> acting;  ///< its states and what acts on them, in document order
};

/// Everything in the scene that acts is in exactly one system, or is reported: what acts on states that nothing moves,
/// couples integrators that cannot be one, or solves for no integrator. Systems come in the order of their integrators.
std::vector<SystemMembers> findSystems(const Node& root, Diagnostics& diagnostics);

/// The states that a force field, a mass, a constraint or a mapping has to do with; of any other component none.
std::vector<State*> statesActedOn(const Component& component);

}  // namespace stroma
