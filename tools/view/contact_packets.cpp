// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/contact_packets.h"

#include "tools/drawing/contacts.h"

namespace stroma::view {
namespace {

using nlohmann::json;

json list(const Vec3& v) { return {v[0], v[1], v[2]}; }

json flat(const std::vector<Vec3>& vectors) {
  json out = json::array();
  for (const Vec3& v : vectors)
    for (int k = 0; k < 3; ++k) out.push_back(v[k]);
  return out;
}

std::vector<float> floats(const std::vector<Vec3>& vectors) {
  std::vector<float> out;
  out.reserve(3 * vectors.size());
  for (const Vec3& v : vectors)
    for (int k = 0; k < 3; ++k) out.push_back(float(v[k]));
  return out;
}

/// Null: it has none.
const Vec3* offsetOf(const drawing::Obstacle& obstacle) {
  const Data* data = obstacle.owner->data().find("offset");
  Vec3* const* found = data && data->changeEffect() == ChangeEffect::at_once ? std::get_if<Vec3*>(&data->pointer()) : nullptr;
  return found ? *found : nullptr;
}

json pairsOf(const Component& component) {
  json out = json::array();
  for (const char* attribute : {"pairs", "modelPairs"}) {  // of states, or of collision models
    const Data* data = component.data().find(attribute);
    auto* const* names = data ? std::get_if<std::vector<std::string>*>(&data->pointer()) : nullptr;
    if (!names) continue;
    for (std::size_t i = 0; i + 1 < (*names)->size(); i += 2) out.push_back({(**names)[i], (**names)[i + 1]});
  }
  return out;
}

}  // namespace

void describeContacts(const Drawing& drawing, Packet& packet) {
  json obstacles = json::array(), contacts = json::array();
  for (const drawing::Obstacle& obstacle : drawing.obstacles) {
    const std::string prefix = "o" + std::to_string(obstacles.size()) + ".";
    obstacles.push_back({{"path", obstacle.owner->path()},
                         {"name", obstacle.owner->name()},
                         {"solid", obstacle.solid},
                         {"movable", offsetOf(obstacle) != nullptr}});
    std::vector<std::int32_t> triangles;
    for (const Triangle& t : obstacle.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
    packet.add(prefix + "points", floats(obstacle.points)), packet.add(prefix + "triangles", std::move(triangles));
  }
  for (const drawing::Contact& contact : drawing.contacts)
    contacts.push_back({{"path", contact.owner->path()},
                        {"name", contact.owner->name()},
                        {"type", contact.owner->type()},
                        {"body", contact.body},
                        {"bodies", contact.bodies},
                        {"pairs", pairsOf(*contact.owner)}});
  packet.header()["obstacles"] = std::move(obstacles), packet.header()["contacts"] = std::move(contacts);
}

void addObstaclePlaces(const Drawing& drawing, Packet& packet) {
  if (drawing.obstacles.empty()) return;
  json moved = json::array(), offsets = json::array();
  for (const drawing::Obstacle& obstacle : drawing.obstacles) {
    const Vec3* offset = offsetOf(obstacle);
    moved.push_back(list(obstacle.drawn->shapesMovedBy())), offsets.push_back(list(offset ? *offset : Vec3(Vec3::Zero())));
  }
  packet.header()["moved"] = std::move(moved), packet.header()["offsets"] = std::move(offsets);
}

void addContactForces(const Drawing& drawing, Packet& packet) {
  json sums = json::array();
  for (const drawing::Contact& contact : drawing.contacts) {
    const std::string prefix = "c" + std::to_string(sums.size()) + ".";
    const drawing::ContactForces forces = drawing::forcesOf(contact, drawing);
    packet.add(prefix + "pages", std::vector<std::int32_t>(forces.pages.begin(), forces.pages.end()));
    packet.add(prefix + "places", floats(forces.places)), packet.add(prefix + "forces", floats(forces.forces));
    json sum = json::object();
    for (const char* name : {"wrenches", "pairWrenches"})
      if (const auto* vectors = drawing::vectorsOf(*contact.owner, name)) sum[name] = flat(*vectors);
    for (const char* name : {"smallestGap", "crossings"})
      if (const auto number = drawing::numberOf(*contact.owner, name)) sum[name] = *number;
    sums.push_back(std::move(sum));
  }
  packet.header()["contacts"] = std::move(sums);
}

}  // namespace stroma::view
