// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/mechanics/force_field.h"
#include "framework/scene/node.h"

namespace stroma::contact {

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
  if (!surfaces.moves(vertex)) return "an obstacle";
  const State& body = *bodies[std::size_t(surfaces.bodyOf(vertex))];
  return fmt::format("node {} of {}", surfaces.rows[std::size_t(vertex)] - body.firstRow(), body.path());
}

}  // namespace stroma::contact
