// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/scene_packets.h"

#include <filesystem>

#include "tools/drawing/held_nodes.h"
#include "tools/units/unit_system.h"
#include "tools/view/contact_packets.h"

namespace stroma::view {
namespace {

using nlohmann::json;

template <class Groups>
std::vector<std::int32_t> flat(const Groups& groups) {
  std::vector<std::int32_t> out;
  for (const auto& group : groups) out.insert(out.end(), group.begin(), group.end());
  return out;
}

/// A sentence when no hand reaches the body, or empty.
std::string whyNoHand(const Body& body) {
  if (!body.system) return "nothing moves it: no integrator is above it";
  if (body.state->firstRow() >= body.system->independentRows())
    return "its positions follow from another state by a mapping: pull that one";
  return {};
}

/// The number of the body that carries this one by mappings; -1: none is drawn.
Index carrierOf(const Body& body, const Drawing& drawing) {
  if (!body.system) return -1;
  const State* state = body.state;
  for (bool found = true; found && state->firstRow() >= body.system->independentRows();) {
    found = false;
    for (const auto* mappings : {&body.system->actors().mappings, &body.system->actors().passive_mappings})
      for (const Mapping* mapping : *mappings)
        if (!found && &mapping->output() == state) state = &mapping->input(), found = true;
  }
  for (std::size_t b = 0; b < drawing.bodies.size(); ++b)
    if (state != body.state && drawing.bodies[b].state == state && whyNoHand(drawing.bodies[b]).empty()) return Index(b);
  return -1;
}

/// The page knows prisms and pyramids as hexahedra with edges of no length.
std::vector<Hexahedron> asHexahedra(const Mesh& mesh) {
  std::vector<Hexahedron> all = mesh.hexahedra;
  for (const Prism& p : mesh.prisms) all.push_back({p[0], p[1], p[2], p[2], p[3], p[4], p[5], p[5]});
  for (const Pyramid& p : mesh.pyramids) all.push_back({p[0], p[1], p[2], p[3], p[4], p[4], p[4], p[4]});
  return all;
}

json describe(const Body& body, const Drawing& drawing) {
  const std::string why = whyNoHand(body);
  json out{{"path", body.state->path()},
           {"node", body.state->node().path()},
           {"name", body.state->node().name()},
           {"nodes", body.node.size()},
           {"surface", body.surface},
           {"cells",
            {{"tetrahedra", body.mesh ? body.mesh->tetrahedra.size() + body.mesh->quadratic_tetrahedra.size() : 0},
             {"hexahedra", body.mesh ? asHexahedra(*body.mesh).size() : 0}}},
           {"interactive", why.empty()},
           {"why", why},
           {"carrier", why.empty() ? -1 : carrierOf(body, drawing)},
           {"frames", json::array()},
           {"beams", json::array()},
           {"balls", json::array()},
           {"axis", body.axis},
           {"size", body.size}};
  for (const drawing::Ball& ball : body.balls) out["balls"].push_back({ball.node, ball.radius});
  for (const auto& [place, turn] : body.frames) out["frames"].push_back({place, turn});
  for (const drawing::Beam& beam : body.beams) {  // nodes, frames, radius, chord in the axes of both ends
    const auto& [a, b] = beam.chord;
    out["beams"].push_back({beam.nodes[0], beam.nodes[1], beam.frames[0], beam.frames[1], beam.radius, a[0], a[1], a[2], b[0],
                            b[1], b[2]});
  }
  return out;
}

std::vector<float> restPositions(const Body& body) {
  std::vector<float> out;
  out.reserve(3 * body.node.size());
  for (const Index row : body.node)
    for (int k = 0; k < 3; ++k) out.push_back(float(body.state->rest_position[std::size_t(row)][k]));
  return out;
}

template <class Cells>
std::vector<std::int32_t> renumbered(const Cells& cells, const Body& body) {
  std::vector<std::int32_t> out;
  out.reserve(cells.size() * (cells.empty() ? 0 : cells.front().size()));
  for (const auto& cell : cells)
    for (const Index node : cell) out.push_back(body.page[std::size_t(node)]);
  return out;
}

/// What units of SI are called in the scene; empty when its units are unknown.
json namesIn(const UnitSystem& units) {
  json names = json::object();
  for (const char* si : {"m", "s", "m/s", "N", "J", "N/m", "N m"}) names[si] = units.unit(si);
  return names;
}

}  // namespace

Packet scenePacket(const Simulation& simulation, const Drawing& drawing, int generation, const std::string& mode) {
  const Vec3 g = simulation.root().gravity();
  const UnitSystem units = unitsOf(simulation.scene());
  json header{{"is", "scene"},
              {"generation", generation},
              {"name", std::filesystem::path(simulation.scene().description.file).filename().string()},
              {"mode", mode},
              {"dt", simulation.dt()},
              {"gravity", {g[0], g[1], g[2]}},
              {"units", namesIn(units)},
              {"bodies", json::array()},
              {"fields", json::array()}};
  for (const Body& body : drawing.bodies) header["bodies"].push_back(describe(body, drawing));
  for (const Field& field : drawing.fields)
    header["fields"].push_back({{"id", field.id},
                                {"body", field.body},
                                {"name", field.name},
                                {"on", field.source ? "cells" : "nodes"},
                                {"unit", units.unit(drawing::unitOf(field))},
                                {"source", field.source ? field.source->path() : ""}});
  Packet packet(std::move(header));
  for (std::size_t b = 0; b < drawing.bodies.size(); ++b) {
    const Body& body = drawing.bodies[b];
    const std::string prefix = std::to_string(b) + ".";
    packet.add(prefix + "node", std::vector<std::int32_t>(body.node.begin(), body.node.end()));
    packet.add(prefix + "rest", restPositions(body));
    packet.add(prefix + "triangles", flat(body.triangles));
    packet.add(prefix + "owner", std::vector<std::int32_t>(body.owner.begin(), body.owner.end()));
    packet.add(prefix + "edges", flat(body.edges));
    packet.add(prefix + "points", std::vector<std::int32_t>(body.points.begin(), body.points.end()));
    packet.add(prefix + "springs", flat(body.springs));
  }
  std::vector<std::int32_t> links;
  std::vector<std::uint8_t> kinds;
  for (const BodyLink& link : drawing.links) {
    links.insert(links.end(), {link.body_a, link.node_a, link.body_b, link.node_b});
    kinds.push_back(link.is_tie ? 1 : 0);
  }
  packet.add("links", std::move(links));
  packet.add("link_kind", std::move(kinds));
  describeContacts(drawing, packet);
  return packet;
}

Packet cellsPacket(const Drawing& drawing, int generation) {
  Packet packet({{"is", "cells"}, {"generation", generation}});
  for (std::size_t b = 0; b < drawing.bodies.size(); ++b) {
    const Body& body = drawing.bodies[b];
    if (!body.mesh) continue;
    // the inside of a cut is drawn flat: a quadratic tetrahedron by its corners, numbered like the values of fields
    std::vector<Tetrahedron> flat = body.mesh->tetrahedra;
    const std::vector<Hexahedron> hexahedra = asHexahedra(*body.mesh);
    if (hexahedra.empty())
      for (const QuadraticTetrahedron& t : body.mesh->quadratic_tetrahedra) flat.push_back({t[0], t[1], t[2], t[3]});
    packet.add(std::to_string(b) + ".tetrahedra", renumbered(flat, body));
    packet.add(std::to_string(b) + ".hexahedra", renumbered(hexahedra, body));
  }
  return packet;
}

Packet heldPacket(const Simulation& simulation, const Drawing& drawing, int generation, double t) {
  using drawing::Holding;
  const auto holdings = drawing::holdingsOf(simulation, drawing, t);
  Packet packet({{"is", "held"}, {"generation", generation}});
  for (std::size_t b = 0; b < holdings.size(); ++b)
    for (const Holding how : {Holding::held, Holding::guided}) {
      std::vector<std::int32_t> nodes;
      for (std::size_t i = 0; i < holdings[b].size(); ++i)
        if (holdings[b][i] == how) nodes.push_back(std::int32_t(i));
      packet.add(std::to_string(b) + (how == Holding::held ? ".held" : ".guided"), std::move(nodes));
    }
  return packet;
}

long heldRevision(const Simulation& simulation) {
  long sum = 0;
  for (const auto& system : simulation.systems()) sum += system->constraints().revision();
  return sum;
}

}  // namespace stroma::view
