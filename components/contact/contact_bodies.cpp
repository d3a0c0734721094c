// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mapping.h"
#include "framework/scene/node.h"

namespace stroma::contact {

std::vector<State*> bodiesInContact(State& first, const std::vector<State*>& others) {
  if (std::find(others.begin(), others.end(), &first) != others.end())
    throw ComponentError(fmt::format("other names {}, which is mstate itself", first.path()), "states of other bodies",
                         "selfContact=\"true\" for what it meets of its own");
  std::vector<State*> bodies{&first};
  for (State* body : others)
    if (std::find(bodies.begin(), bodies.end(), body) == bodies.end()) bodies.push_back(body);
  for (const State* body : bodies)
    if (!body->row_kinds.empty())
      throw ComponentError(fmt::format("{} has rows that are no points", body->path()), "a state of points",
                           body->hasFrames() ? "points below it that a RigidMapping carries" : "");
  return bodies;
}

const Mesh& meshOfBody(const State& body, bool is_first, const TopologyLink& topology, const Component& asker) {
  const Topology* found = is_first ? topology.find(asker, body) : nullptr;
  if (!found && !(found = topologyOf(body)))
    throw ComponentError(fmt::format("{} has no mesh, so no surface", body.path()), "a topology beside it");
  return found->mesh();
}

std::vector<char> areRigid(const Surfaces& surfaces, const std::vector<State*>& bodies) {
  std::vector<Mapping*> mappings;
  bodies.front()->node().root().collect(mappings);
  std::vector<char> rigid;
  for (const Surfaces::Body& body : surfaces.bodies()) {
    const State* state = body.moves && body.vertices > 0 ? bodies[std::size_t(surfaces.bodyOf(body.first_vertex))] : nullptr;
    rigid.push_back(!body.moves || std::ranges::any_of(mappings, [state](const Mapping* mapping) {
      return &mapping->output() == state && mapping->inputs().size() == 1 && mapping->input().hasFrames() && mapping->input().nodes() == 1;
    }));
  }
  return rigid;
}

double partOfMeanEdge(const Surfaces& surfaces, double part) {
  if (surfaces.meanEdge() > 0) return part * surfaces.meanEdge();
  double sum = 0;
  int count = 0;
  for (std::size_t f = 0; f < surfaces.faces.size(); ++f)
    if (surfaces.moves(surfaces.faces[f][0]) && surfaces.radius[f] > 0) sum += surfaces.radius[f], ++count;
  if (count > 0) return part * sum / count;
  throw ComponentError("points have no edges of which contactDistance would be a part", "contactDistance=\"...\"");
}

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

std::string namesOf(const BarrierLaw& law, const std::vector<State*>& bodies, bool self) {
  const auto& all = law.surfaces.bodies();
  const auto obstacles =
      long(law.planes.size()) + std::count_if(all.begin(), all.end(), [](const Surfaces::Body& body) { return !body.moves; });
  std::string text;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    text += (i == 0 ? "" : ", ") + bodies[i]->path();
    if (i >= all.size() || all[i].faces == 0) continue;
    const auto& [a, b, c] = law.surfaces.faces[std::size_t(all[i].first_face)];
    if (a == b) text += b != c ? " (its edges)" : law.surfaces.vertex_radius[std::size_t(a)] > 0 ? " (its balls)" : " (its points)";
  }
  if (obstacles > 0) text += fmt::format(" and {} obstacle{}", obstacles, obstacles == 1 ? "" : "s");
  if (self) text += bodies.size() == 1 && obstacles == 0 ? " with itself" : ", each body with itself too";
  return text;
}

std::string nameOfVertex(const Surfaces& surfaces, const std::vector<State*>& bodies, int vertex) {
  if (!surfaces.moves(vertex)) return "an obstacle";
  const State& body = *bodies[std::size_t(surfaces.bodyOf(vertex))];
  return fmt::format("node {} of {}", surfaces.rows[std::size_t(vertex)] - body.firstRow(), body.path());
}

}  // namespace stroma::contact
