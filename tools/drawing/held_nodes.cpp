// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/held_nodes.h"

#include <algorithm>

namespace stroma::drawing {

std::vector<std::vector<Holding>> holdingsOf(const Simulation& simulation, const Drawing& drawing, double t) {
  std::vector<std::vector<Holding>> holdings;
  for (const Body& body : drawing.bodies) holdings.emplace_back(body.node.size(), Holding::free);
  const auto mark = [&](const System& system, Index row, Holding how) {
    for (std::size_t b = 0; b < drawing.bodies.size(); ++b) {
      const Body& body = drawing.bodies[b];
      const Index node = row - body.state->firstRow();
      if (body.system != &system || node < 0 || node >= body.state->size()) continue;
      const Index page = body.page[std::size_t(node)];
      if (page >= 0) holdings[b][std::size_t(page)] = std::max(holdings[b][std::size_t(page)], how);
    }
  };
  const double t_end = t + simulation.dt();
  std::vector<NodeProjector> projectors;
  for (const auto& system : simulation.systems())
    for (const ProjectiveConstraint* constraint : system->constraints().all()) {
      if (!constraint->activeIn(t, t_end)) continue;
      projectors.clear();
      constraint->addProjectors(t, projectors);
      for (const NodeProjector& projector : projectors)
        mark(*system, projector.row,
             projector.projector.isZero(0) && !constraint->prescribesMotion() ? Holding::held : Holding::guided);
    }
  return holdings;
}

}  // namespace stroma::drawing
