// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "framework/mechanics/force_field.h"
#include "framework/scene/node.h"

namespace stroma::contact {

namespace {
/// Of the state that has a row, and the node that it is there.
std::pair<const State*, Index> nodeOf(const std::vector<State*>& bodies, Index row) {
  for (const State* body : bodies)
    if (row >= body->firstRow() && row < body->firstRow() + body->size()) return {body, row - body->firstRow()};
  return {nullptr, -1};
}
}  // namespace

double largestYoungModulus(const std::vector<State*>& bodies) {
  double largest = 0;
  for (const State* body : bodies) {
    std::vector<ForceField*> fields;
    body->node().collect(fields);
    for (const ForceField* field : fields)
      if (const Data* modulus = field->data().find("youngModulus"))
        largest = std::max(largest, std::strtod(modulus->print().c_str(), nullptr));
  }
  return largest;
}

std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex) {
  const auto [body, node] = nodeOf(bodies, surfaces.rows[std::size_t(vertex)]);
  return body ? fmt::format("node {} of {}", node, body->path()) : "an obstacle";
}

std::vector<Vec3> presentPositions(const Surfaces& surfaces, const std::vector<State*>& bodies, const Vec3& moved) {
  std::vector<Vec3> x(surfaces.rows.size());
  for (std::size_t v = 0; v < x.size(); ++v) {
    const auto [body, node] = nodeOf(bodies, surfaces.rows[v]);
    x[v] = body ? Vec3(body->x()[node]) : Vec3(surfaces.rest[v] + moved);
  }
  return x;
}

}  // namespace stroma::contact
