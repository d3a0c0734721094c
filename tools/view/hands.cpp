// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/hands.h"

#include <algorithm>
#include <cmath>

#include "framework/mechanics/state_positions.h"
#include "tools/view/orders.h"

namespace stroma::view {
namespace {

using nlohmann::json;

constexpr long most_nodes = 100000;
constexpr double most = 1e12;  // a stiffness [N/m] or force [N] beyond it is a mistake
constexpr double pull_fraction = 0.25, hold_fraction = 25, push_fraction = 1;

json list(const Vec3& value) { return {value[0], value[1], value[2]}; }

double trace(const std::vector<double>& blocks, Index row) {
  const double* block = blocks.data() + std::size_t(row) * 9;
  return block[0] + block[4] + block[8];
}

}  // namespace

const Body& Hands::bodyOf(const json& order, Index& number) const {
  number = Index(integer(member(order, "body"), "body", 0, long(drawing_.bodies.size()) - 1));
  return drawing_.bodies[std::size_t(number)];
}

/// Before the first step force fields have no stiffness yet; then, and for bodies without one, a hand lifts the whole body
/// ten times its weight by the body's size.
void Hands::chooseStiffness(const Body& body, const std::vector<Index>& nodes, double factor, Input& input) const {
  const System& system = *body.system;
  double mass = 0, total_mass = 0;
  for (const Mass* owner : system.masses())
    if (&owner->state() == body.state) {
      for (const Index node : nodes) mass += owner->lumped()[std::size_t(node)] / double(nodes.size());
      total_mass += owner->totalMass();
    }
  if (input.stiffness <= 0) {
    double own = 0;
    if (simulation_.steps() > 0) {
      std::vector<double> blocks(std::size_t(system.allRows()) * 9, 0.);
      for (const ForceField* field : system.forceFields())
        if (field->traits().has_stiffness) field->addStiffnessDiagonal(-1, blocks);
      for (const Index node : nodes) own += trace(blocks, body.state->firstRow() + node) / 3 / double(nodes.size());
    }
    const double size = restSize(*body.state);
    if (!(own > 0) && size > 0) own = 10 * total_mass * 9.81 / size / double(nodes.size());
    if (!(own > 0)) own = 100;
    input.stiffness = factor * own;
  }
  input.damping = mass > 0 ? std::sqrt(input.stiffness * mass) : 0;
}

Hands::Hand Hands::pulling(const json& order, const Hand* before) const {
  Hand hand;
  const std::string verb = text(member(order, "do"), "do", 10);
  hand.kind = verb == "force" ? "force" : text(order.value("kind", json("pull")), "kind", 10);
  if (hand.kind != "pull" && hand.kind != "hold" && hand.kind != "force")
    throw ComponentError("there is no kind of hand '" + hand.kind + "'", "pull or hold");
  const Body& body = bodyOf(order, hand.body);
  hand.what.state = body.state->path();
  const json& nodes = member(order, "nodes");
  if (!nodes.is_array() || nodes.empty() || long(nodes.size()) > most_nodes)
    throw ComponentError("'nodes' is not a list of 1 to 100000 nodes");
  for (const json& node : nodes)
    hand.what.nodes.push_back(body.node[std::size_t(integer(node, "nodes", 0, long(body.node.size()) - 1))]);
  std::vector<Index> sorted = hand.what.nodes;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw ComponentError("'nodes' has a node twice");
  if (hand.kind == "force") {
    hand.what.force = place(member(order, "force"), "force") / double(nodes.size());
    return hand;
  }
  const json& targets = member(order, "targets");
  if (!targets.is_array() || targets.size() != nodes.size())
    throw ComponentError("'targets' is not a list of one place per node");
  for (const json& target : targets) hand.what.targets.push_back(place(target, "targets"));
  if (order.contains("stiffness")) hand.what.stiffness = number(order["stiffness"], "stiffness", 1e-12, most);
  // while it is held a hand keeps its stiffness: only the targets move, and no matrix is made again
  const bool same = before && before->kind == hand.kind && before->what.nodes == hand.what.nodes;
  if (same && (hand.what.stiffness == 0 || hand.what.stiffness == before->what.stiffness)) {
    hand.what.stiffness = before->what.stiffness, hand.what.damping = before->what.damping;
  } else {
    chooseStiffness(body, hand.what.nodes, hand.kind == "hold" ? hold_fraction : pull_fraction, hand.what);
  }
  return hand;
}

Hands::Hand Hands::pushing(const json& order, const Hand* before) const {
  Hand hand;
  hand.kind = "push";
  const Body& body = bodyOf(order, hand.body);
  hand.what.state = body.state->path();
  hand.centre = place(member(order, "centre"), "centre");
  hand.radius = number(member(order, "radius"), "radius", 1e-12, 1e9);
  if (order.contains("stiffness")) hand.what.stiffness = number(order["stiffness"], "stiffness", 1e-12, most);
  if (before && before->kind == "push" && hand.what.stiffness == 0) hand.what.stiffness = before->what.stiffness;
  if (before) hand.what.nodes = before->what.nodes;
  std::vector<Index> surface(body.node.begin(), body.node.begin() + body.surface);
  if (surface.empty()) throw ComponentError("the body has no surface to push");
  chooseStiffness(body, surface, push_fraction, hand.what);
  return hand;
}

void Hands::apply(int client, const json& order) {
  const std::string verb = text(member(order, "do"), "do", 10);
  const Key key{client, text(member(order, "hand"), "hand", 40)};
  const auto known = hands_.find(key);
  if (verb == "release") {
    if (known == hands_.end()) return;
    release(known->second);
    hands_.erase(known);
  } else {
    const Hand* before = known == hands_.end() ? nullptr : &known->second;
    if (!before && hands_.size() >= 100) throw ComponentError("there are 100 hands already", "one of them released");
    Hand hand = verb == "push" ? pushing(order, before) : pulling(order, before);
    const bool replaces = before && (before->body != hand.body || before->kind == "push" || hand.kind == "push");
    if (before && !(replaces && before->body != hand.body)) hand.input = before->input;
    const long left_over = before && hand.input == 0 ? before->input : 0;
    if (hand.kind == "push")
      touch(hand);
    else
      set(hand);
    if (left_over != 0) simulation_.removeInput(left_over);
    hands_[key] = std::move(hand);
  }
  if (order.contains("sequence")) ordered_[client] = integer(order["sequence"], "sequence", 0, 1L << 52);
}

void Hands::set(Hand& hand) {
  if (hand.input != 0)
    simulation_.changeInput(hand.input, hand.what);
  else
    hand.input = simulation_.addInput(hand.what);
}

void Hands::release(Hand& hand) {
  if (hand.input != 0) simulation_.removeInput(hand.input);
  hand.input = 0;
}

void Hands::touch(Hand& hand) {
  const Body& body = drawing_.bodies[std::size_t(hand.body)];
  const ConstRows x = body.state->x();
  hand.what.nodes.clear(), hand.what.targets.clear();
  for (Index i = 0; i < body.surface; ++i) {
    const Index node = body.node[std::size_t(i)];
    const Vec3 from = x[node] - hand.centre;
    const double distance = from.norm();
    if (distance >= hand.radius) continue;
    const Vec3 normal = distance > 0 ? Vec3(from / distance) : Vec3(0, 1, 0);
    hand.what.nodes.push_back(node);
    hand.what.targets.push_back(hand.centre + hand.radius * normal);
  }
  if (hand.what.nodes.empty())
    release(hand);
  else
    set(hand);
}

bool Hands::pushes() const {
  return std::any_of(hands_.begin(), hands_.end(), [](const auto& entry) { return entry.second.kind == "push"; });
}

void Hands::updatePushes() {
  for (auto& [key, hand] : hands_)
    if (hand.kind == "push") touch(hand);
}

void Hands::releaseAll(int client) {
  for (auto it = hands_.begin(); it != hands_.end();) {
    if (it->first.first == client) {
      release(it->second);
      it = hands_.erase(it);
    } else {
      ++it;
    }
  }
  ordered_.erase(client), drawn_.erase(client);
}

Vec3 Hands::forceOn(const Hand& hand) const {
  const State& state = *drawing_.bodies[std::size_t(hand.body)].state;
  Vec3 sum = Vec3::Zero();
  if (hand.input == 0) return sum;
  for (std::size_t i = 0; i < hand.what.nodes.size(); ++i) {
    const Index node = hand.what.nodes[i];
    sum += hand.what.force - hand.what.damping * state.v()[node];
    if (!hand.what.targets.empty()) sum += hand.what.stiffness * (hand.what.targets[i] - state.x()[node]);
  }
  return sum;
}

json Hands::describe() const {
  json out = json::array();
  for (const auto& [key, hand] : hands_) {
    const Body& body = drawing_.bodies[std::size_t(hand.body)];
    json one{{"hand", key.second},
             {"client", key.first},
             {"kind", hand.kind},
             {"body", hand.body},
             {"force", list(forceOn(hand))}};
    if (hand.kind == "push") {
      one["centre"] = list(hand.centre), one["radius"] = hand.radius, one["touched"] = hand.what.nodes.size();
    } else {
      Vec3 to = Vec3::Zero();
      for (const Vec3& target : hand.what.targets) to += target / double(hand.what.targets.size());
      one["node"] = body.page[std::size_t(hand.what.nodes.front())];
      one["nodes"] = hand.what.nodes.size();
      if (!hand.what.targets.empty()) one["to"] = list(to);
      one["stiffness"] = hand.what.stiffness;
    }
    out.push_back(std::move(one));
  }
  return out;
}

}  // namespace stroma::view
