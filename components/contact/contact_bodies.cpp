// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

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
    double here = 0;
    for (const Node* node = &body->node(); node && here == 0; node = node->parent()) {
      std::vector<ForceField*> fields;
      node->collect(fields);
      for (const ForceField* field : fields)
        if (const Data* modulus = field->data().find("youngModulus")) {
          std::istringstream values(modulus->print());  // one, or one for each cell
          for (double value = 0; values >> value;) here = std::max(here, value);
        }
    }
    largest = std::max(largest, here);
  }
  return largest;
}

std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex) {
  const auto [body, node] = nodeOf(bodies, surfaces.rows[std::size_t(vertex)]);
  return body ? fmt::format("node {} of {}", node, body->path()) : "an obstacle";
}

}  // namespace stroma::contact
