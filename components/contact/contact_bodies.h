// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"
#include "framework/mechanics/state_topology.h"

namespace stroma::contact {

/// `first` and those of `others` that are not there yet. Throws ComponentError for a state whose rows are no points.
std::vector<State*> bodiesInContact(State& first, const std::vector<State*>& others);

/// Adds the surfaces of `bodies`: of the first that of the mesh which `topology` finds for `asker`, of the others that of the mesh
/// beside their state. Throws ComponentError where there is no mesh, or it has no node.
void addSurfaces(Surfaces& surfaces, const std::vector<State*>& bodies, const TopologyLink& topology, const Component& asker);

/// The mesh that addSurfaces() takes of a body. Throws ComponentError where there is none.
const Mesh& meshOfBody(const State& body, bool is_first, const TopologyLink& topology, const Component& asker);

/// Of each body of the surfaces: it is an obstacle, or points of `bodies` that one rigid frame carries.
std::vector<char> areRigid(const Surfaces& surfaces, const std::vector<State*>& bodies);

/// What contactDistance is where it is not given. Throws ComponentError where bodies have no edge.
double partOfMeanEdge(const Surfaces& surfaces, double part);

/// The largest youngModulus of the force fields below the nodes of these states, or of the nearest nodes above that have
/// one below; 0: none has [Pa].
double largestYoungModulus(const std::vector<State*>& bodies);

/// "/a/dofs, /b/dofs (its edges) and 2 obstacles", for what meets what; `self`: each body meets itself too.
std::string namesOf(const BarrierLaw& law, const std::vector<State*>& bodies, bool self);

/// "node 3 of /body/dofs", or "an obstacle". `bodies`: the states of the surfaces, in their order.
std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex);

}  // namespace stroma::contact
