// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/state_topology.h"

namespace stroma::contact {

/// `first` followed by `others`, without duplicates. Throws ComponentError for a state whose rows are not points.
std::vector<State*> bodiesInContact(State& first, const std::vector<State*>& others);

/// The mesh of a body: for the first one that which `topology` finds for `asker`, otherwise the one beside its state. Throws
/// ComponentError if there is none.
const Mesh& meshOfBody(const State& body, bool is_first, const TopologyLink& topology, const Component& asker);

/// Per body of the surfaces: whether it is rigid, as an obstacle or as points of `bodies` on one rigid frame.
std::vector<char> areRigid(const Surfaces& surfaces, const std::vector<State*>& bodies);

/// The default of contactDistance: a part of the mean edge, or of the mean radius of balls. Throws ComponentError if bodies have neither.
double partOfMeanEdge(const Surfaces& surfaces, double part);

/// The largest youngModulus of the force fields below the nodes of these states, or below the nearest ancestors that have
/// one; 0: none has [Pa].
double largestYoungModulus(const std::vector<State*>& bodies);

/// "/a/dofs, /b/dofs (its edges) and 2 obstacles", the list of bodies in contact; `self`: including self-contact.
std::string namesOf(const BarrierLaw& law, const std::vector<State*>& bodies, bool self);

/// "node 3 of /body/dofs", or "an obstacle". `bodies`: the states of the surfaces, in their order.
std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex);

}  // namespace stroma::contact
