// SPDX-License-Identifier: LGPL-2.1-or-later
// Which states move together: the bodies of one integrator, and those of several integrators that are coupled.
//
// A state belongs to the integrator in its node or the nearest one above; a mapped state without one belongs to that of
// its parent. A component that acts on states of one integrator is in its system, wherever it is in the tree. One that
// acts on states of several integrators couples them: its derivatives involve both bodies, so both are solved in one
// system, and the first integrator in the scene moves them all, just like one integrator above all
// bodies. A warning says where the integrators differ; different damping, and statics beside dynamics, are errors.
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

/// An integrator whose bodies are moved by another one.
struct MergedIntegrator {
  Integrator* integrator = nullptr;
  std::string because;  ///< the path of the component that couples its bodies to others
};

/// The members of one system.
struct SystemMembers {
  Integrator* integrator = nullptr;
  std::vector<MergedIntegrator> merged;
  std::vector<Component*> acting;  ///< its states and everything that acts on them, in document order
};

/// Assigns every acting component to exactly one system, or reports it: it acts on states that nothing moves, couples
/// incompatible integrators, or is a solver without an integrator. Systems are in the order of their integrators.
std::vector<SystemMembers> findSystems(const Node& root, Diagnostics& diagnostics);

/// The states used by a force field, a mass, a constraint or a mapping; none for any other component.
std::vector<State*> statesActedOn(const Component& component);

}  // namespace stroma
