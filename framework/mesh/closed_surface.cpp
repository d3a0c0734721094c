// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/closed_surface.h"

#include <map>

namespace stroma {

std::optional<OpenEdge> firstOpenEdge(const std::vector<Face>& faces) {
  std::map<Edge, OpenEdge> edges;
  for (const Face& face : faces)
    for (const auto& [i, j] : face.kind().edges) {
      const Index a = face.nodes[i], b = face.nodes[j];
      OpenEdge& edge = edges[{std::min(a, b), std::max(a, b)}];
      ++(a < b ? edge.along : edge.back);
    }
  for (auto& [nodes, edge] : edges)
    if (edge.along != edge.back) return OpenEdge{nodes, edge.along, edge.back};
  return {};
}

}  // namespace stroma
