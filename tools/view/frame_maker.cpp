// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/frame_maker.h"

#include <algorithm>

#include "framework/mechanics/local_load.h"
#include "tools/drawing/contacts.h"
#include "tools/view/contact_packets.h"

namespace stroma::view {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double share_of_fields = 0.01;

/// What acts from outside and does not resist: not springs, not dampers.
bool isLoad(const ForceField& field) {
  const ForceTraits traits = field.traits();
  return dynamic_cast<const LocalLoad*>(&field) || (!traits.has_stiffness && !traits.velocity_dependent);
}

std::vector<float> rowsOf(const Body& body, ConstRows rows, bool all) {
  const std::size_t count = all ? body.node.size() : std::size_t(body.surface);
  std::vector<float> out(3 * count);
  float* to = out.data();
  for (std::size_t i = 0; i < count; ++i, to += 3) {
    const double* row = rows.data + std::size_t(body.node[i]) * row_doubles;
    to[0] = float(row[0]), to[1] = float(row[1]), to[2] = float(row[2]);
  }
  return out;
}

}  // namespace

void FrameMaker::addPositions(Packet& packet, std::size_t body, bool all) const {
  const Body& drawn = drawing_.bodies[body];
  const ConstRows x = drawn.x();
  packet.add(std::to_string(body) + ".x", rowsOf(drawn, x, all));
  if (drawn.frames.empty()) return;
  std::vector<float> turns;
  for (const auto& [place, row] : drawn.frames)
    for (int k = 0; k < 4; ++k) turns.push_back(float(x.data[std::size_t(row) * row_doubles + std::size_t(k)]));
  packet.add(std::to_string(body) + ".turn", std::move(turns));
}

void FrameMaker::addVelocities(Packet& packet, const Field& field, bool all) const {
  const Body& body = drawing_.bodies[std::size_t(field.body)];
  const ConstRows v = body.v();
  std::vector<float> speed(all ? body.node.size() : std::size_t(body.surface));
  for (std::size_t i = 0; i < speed.size(); ++i) speed[i] = float(v[body.node[i]].norm());
  packet.add("f" + std::to_string(field.id), std::move(speed));
}

void FrameMaker::addNodeField(Packet& packet, const Field& field, bool all) {
  const Body& body = drawing_.bodies[std::size_t(field.body)];
  if (!drawing::nodeValues(field, body, cell_values_)) return;
  if (!all) cell_values_.resize(std::size_t(body.surface));
  packet.add("f" + std::to_string(field.id), cell_values_);
}

void FrameMaker::addCellField(Packet& packet, const Field& field, bool all) {
  const Body& body = drawing_.bodies[std::size_t(field.body)];
  if (!cellValues(field, body, work_, cell_values_)) return;
  if (all) {
    packet.add("f" + std::to_string(field.id), cell_values_);
    return;
  }
  std::vector<float> of_faces(body.owner.size());
  for (std::size_t i = 0; i < of_faces.size(); ++i) of_faces[i] = cell_values_[std::size_t(body.owner[i])];
  packet.add("f" + std::to_string(field.id), std::move(of_faces));
}

void FrameMaker::addLoads(Packet& packet, bool all) {
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b) {
    const Body& body = drawing_.bodies[b];
    if (!body.system) continue;
    loads_.resize(body.system->allRows());
    bool any = false;
    for (ForceField* field : body.system->forceFields()) {
      if (!isLoad(*field) || &field->state() != body.state) continue;
      field->addForce(body.system->x, body.system->v, loads_);
      any = true;
    }
    if (any) packet.add(std::to_string(b) + ".load", rowsOf(body, body.state->segment(ConstRows(loads_)), all));
  }
}

std::shared_ptr<Packet> FrameMaker::make(const Demand& demand, long number, double time, bool still) {
  simulation_.complete();
  auto packet = std::make_shared<Packet>(nlohmann::json{{"is", "frame"},
                                                        {"frame", number},
                                                        {"step", simulation_.steps()},
                                                        {"time", time},
                                                        {"nodes", demand.all_nodes ? "all" : "surface"},
                                                        {"format", "f32"}});
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b) addPositions(*packet, b, demand.all_nodes);
  addObstaclePlaces(drawing_, *packet);
  if (demand.contacts) addContactForces(drawing_, *packet);
  const auto start = Clock::now();
  const bool with_cells = still || start >= fields_due_ || demand.fields != fields_before_;
  bool computed = false;
  for (const Field& field : drawing_.fields) {
    if (!demand.fields.contains(field.id)) continue;
    if (field.data) {
      addNodeField(*packet, field, demand.all_nodes);
    } else if (!field.source) {
      addVelocities(*packet, field, demand.all_nodes);
    } else if (with_cells) {
      addCellField(*packet, field, demand.all_nodes);
      computed = true;
    }
  }
  if (demand.loads && with_cells) addLoads(*packet, demand.all_nodes), computed = true;
  if (!computed) return packet;
  const auto spent = Clock::now() - start;
  field_seconds_ += std::chrono::duration<double>(spent).count();
  fields_due_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(spent / share_of_fields);
  fields_before_ = demand.fields;
  return packet;
}

}  // namespace stroma::view
