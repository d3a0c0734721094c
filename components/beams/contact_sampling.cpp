// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/beams/contact_sampling.h"

#include <algorithm>

namespace stroma {

int contactEdges(const std::vector<PushedRod>& rods) {
  int most = 0;
  for (const PushedRod& rod : rods) {
    int edges = 0;
    for (const RodStretch& stretch : rod.shape->stretches()) edges += stretch.contact_edges;
    most = std::max(most, edges);
  }
  return most;
}

std::vector<double> contactPlaces(const std::vector<PushedRod>& rods, const RodNodes& nodes) {
  std::vector<double> places;
  std::size_t node = nodes.at.size() - 1;
  if (node == 0) return places;
  std::size_t on = std::size_t(nodes.rods[node].front());
  for (double at = nodes.at[node]; at > 0;) {
    places.push_back(at);
    const PushedRod& rod = rods[on];
    const RodStretch& stretch = rod.shape->stretchAt(at - rod.handle());
    at -= stretch.length / stretch.contact_edges;
    while (node > 0 && at < nodes.at[node - 1]) {
      --node;
      if (nodes.rods[node].empty() || std::size_t(nodes.rods[node].front()) == on) continue;
      on = std::size_t(nodes.rods[node].front()), at = nodes.at[node];
      break;
    }
  }
  return places;
}

}  // namespace stroma
