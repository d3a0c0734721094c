// SPDX-License-Identifier: LGPL-2.1-or-later
// Which states move together: the bodies of one integrator, and those of several that something couples.
//
// A state belongs to the integrator of its node or the nearest above; one without, that a mapping places, to that of
// the state it follows. What acts on states of one integrator is in its system, wherever the scene writes it. What acts
// on states of several couples them: forces, ties and relations between bodies have derivatives with respect to both, so
// both are solved in one system, and the first integrator in the scene moves them all. That is the same as one integrator
// above all bodies, and it means the same only where the integrators are alike: others are refused.
#pragma once
#include <string>
#include <vector>

#include "framework/mechanics/force_field.h"
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

/// What one system is made of, each list in document order.
struct SystemMembers {
  Integrator* integrator = nullptr;
  std::vector<MergedIntegrator> merged;
  std::vector<State*> states;
  std::vector<ForceField*> force_fields;
  std::vector<Mass*> masses;
  std::vector<ProjectiveConstraint*> constraints;
  std::vector<PositionConstraint*> position_constraints;
  std::vector<Mapping*> mappings;
};

/// Where what a system is made of stands: everything below its integrators, and what acts from elsewhere.
class SystemReach {
 public:
  explicit SystemReach(const SystemMembers& members);
  /// Whether a node is that of one of its integrators, or below.
  bool holds(const Node& node) const;
  /// Whether a component is in such a node, or acts in the system from elsewhere.
  bool holds(const Component& component) const;
  /// Whether something of the system is in `node` or below.
  bool isBelow(const Node& node) const;
  /// All that the system holds.
  std::vector<Component*> components() const;

 private:
  std::vector<const Node*> tops_;
  std::vector<Component*> outside_;
};

/// Everything in the scene that acts is in exactly one system, or is reported: what acts on states that nothing moves,
/// couples integrators that are not alike, or solves for no integrator. Systems come in the order of their integrators.
std::vector<SystemMembers> findSystems(const Node& root, Diagnostics& diagnostics);

/// The states that a force field, a mass, a constraint or a mapping has to do with; of any other component none.
std::vector<State*> statesActedOn(const Component& component);

}  // namespace stroma
