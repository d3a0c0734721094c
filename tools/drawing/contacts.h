// SPDX-License-Identifier: LGPL-2.1-or-later
// What of contact is drawn: obstacles that no state has, the forces on nodes, and sums of them.
#pragma once
#include <optional>

#include "tools/drawing/body.h"

namespace stroma::drawing {

/// The state that a component acts on; null: none, or not one.
const State* stateOf(const Component& component);

/// Components that compute something for each node of their state, or where their obstacles are, in the order of the tree: a
/// recording has all that they compute.
std::vector<Component*> withNodeValues(const Simulation& simulation);

/// Fields of nodes that components compute, for the bodies that there are.
void addNodeFields(const Simulation& simulation, Drawing& drawing);
/// The values of such a field, one for each node of the body by page number; of vectors their norms. False before there are any.
bool nodeValues(const Field& field, const Body& body, std::vector<float>& out);

/// Contacts and obstacles, for the bodies that there are.
void addContacts(const Simulation& simulation, Drawing& drawing);

/// Forces of contact and friction on a body.
struct ContactForces {
  std::vector<Index> pages{};  ///< page numbers of the nodes; empty where they are on places between nodes
  std::vector<Vec3> places{};  ///< [m]
  std::vector<Vec3> forces{};  ///< [N]
};
/// Those that are not zero.
ContactForces forcesOf(const Contact& contact, const Drawing& drawing);

/// An attribute with vectors, or a number; null or empty: there is none.
const std::vector<Vec3>* vectorsOf(const Component& component, const char* attribute);
std::optional<double> numberOf(const Component& component, const char* attribute);

}  // namespace stroma::drawing
