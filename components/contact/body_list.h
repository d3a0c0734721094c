// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies of a contact as attributes, shared by the contact components.
#pragma once
#include <array>
#include <vector>

#include "components/contact/contact_start.h"
#include "components/contact/contact_surfaces.h"
#include "framework/mechanics/state_topology.h"

namespace stroma::contact {

/// Bodies are numbered from 0, mstate, and 1, the first of `other`. States that no integrator moves are obstacles.
class BodyList {
 public:
  void declare(DataTable& table, const char* help_of_other);
  /// Returns the states that move, `first` among them and in front. Throws ComponentError.
  std::vector<State*> init(State& first);
  bool areSeveral() const { return states_.size() > 1; }
  /// Adds the surfaces of bodies that move, then of the others, with radii and pairs without contact. `topology`: the mesh of mstate.
  void addTo(Surfaces& surfaces, const TopologyLink& topology, const Component& asker) const;
  /// Those that move, for pushApart(): balls and points may have no mesh.
  std::vector<StartBody> startBodies(const TopologyLink& topology, const Component& asker) const;

 private:
  void check() const;
  void checkBalls(const State& state, const Component& asker) const;
  void addBody(std::size_t body, Surfaces& surfaces, const TopologyLink& topology, const Component& asker) const;

  LinkList<State> other_{"mechanical state"};
  std::vector<double> radii_;
  std::vector<Edge> excluded_;
  std::vector<State*> states_;
  std::vector<char> moves_;  ///< of states_
};

}  // namespace stroma::contact
