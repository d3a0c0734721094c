// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/hands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "framework/mechanics/frames.h"
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

double fractionOf(const std::string& kind) {
  return kind == "pull" ? pull_fraction : kind == "hold" ? hold_fraction : push_fraction;
}

/// Its steps are stable only while dt is short against the periods of what they move.
bool isExplicit(const Integrator& integrator) {
  return integrator.movesInTime() && !integrator.linearSolver() && !integrator.stateOwner();
}

}  // namespace

const Body& Hands::bodyOf(const json& order, Index& number) const {
  number = Index(integer(member(order, "body"), "body", 0, long(drawing_.bodies.size()) - 1));
  const Body& body = drawing_.bodies[std::size_t(number)];
  if (!body.system) throw ComponentError(body.state->path() + " does not move: no integrator is above it");
  return body;
}

double Hands::ownStiffness(const Body& body, const std::vector<Index>& nodes) const {
  const System& system = *body.system;
  std::vector<ForceField*> fields;  // other hands are no part of the body
  for (ForceField* field : system.forceFields())
    if (field->traits().has_stiffness && !dynamic_cast<InputForces*>(field)) fields.push_back(field);
  if (simulation_.steps() == 0) {  // no force has been evaluated yet, which prepares stiffness
    Vector forces;
    forces.resize(system.allRows());
    for (ForceField* field : fields) field->addForce(system.x, system.v, forces);
  }
  std::vector<double> blocks(std::size_t(system.allRows()) * 9, 0.);
  for (const ForceField* field : fields) field->addStiffnessDiagonal(-1, blocks);
  double sum = 0;
  for (const Index node : nodes) sum += trace(blocks, body.state->firstRow() + node) / 3;
  return sum / double(nodes.size());
}

void Hands::chooseStiffness(const Body& body, const std::vector<Index>& nodes, const json& order, const Hand* before,
                            Hand& hand) const {
  double& k = hand.what.stiffness;
  if (order.contains("stiffness")) k = number(order["stiffness"], "stiffness", 1e-12, most);
  const bool same = before && before->kind == hand.kind && before->body == hand.body &&
                    before->what.nodes == hand.what.nodes && (k == 0 || k == before->what.stiffness);
  if (same) {
    k = before->what.stiffness, hand.what.damping = before->what.damping;
    return;
  }
  const System& system = *body.system;
  double mass = 0, least_mass = std::numeric_limits<double>::infinity(), total_mass = 0;
  for (const Mass* owner : system.masses())
    if (&owner->state() == body.state) {
      for (const Index node : nodes) {
        mass += owner->lumped()[std::size_t(node)] / double(nodes.size());
        least_mass = std::min(least_mass, owner->lumped()[std::size_t(node)]);
      }
      total_mass += owner->totalMass();
    }
  if (k == 0) {
    double own = ownStiffness(body, nodes);
    // a frame that nothing holds swings once in 0.6 s; what else nothing holds in shape is lifted as a whole: ten times its
    // weight by its size
    if (!(own > 0) && body.state->hasFrames() && mass > 0)
      own = 100 * mass / fractionOf(hand.kind);
    else if (!(own > 0))
      own = 10 * total_mass * 9.81 / body.size / double(nodes.size());
    k = fractionOf(hand.kind) * (own > 0 ? own : 100);
    if (isExplicit(system.integrator()) && mass > 0)
      k = std::min(k, least_mass / (4 * simulation_.dt() * simulation_.dt()));
  }
  hand.what.damping = mass > 0 ? std::sqrt(k * std::min(mass, least_mass)) : 0;
}

std::vector<Index> Hands::nodesOf(const json& order, const Body& body) const {
  const json& nodes = member(order, "nodes");
  if (!nodes.is_array() || nodes.empty() || long(nodes.size()) > most_nodes)
    throw ComponentError("'nodes' is not a list of 1 to 100000 nodes");
  std::vector<Index> out;
  for (const json& node : nodes)
    out.push_back(body.node[std::size_t(integer(node, "nodes", 0, long(body.node.size()) - 1))]);
  std::vector<Index> sorted = out;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw ComponentError("'nodes' has a node twice");
  return out;
}

/// Rows of orientations.
std::vector<Index> Hands::turnsOf(const json& order, const Body& body) const {
  const json& frames = order["frames"];
  if (!frames.is_array() || frames.empty() || frames.size() > body.frames.size())
    throw ComponentError(fmt::format("'frames' is not a list of 1 to {} frames of the body", body.frames.size()));
  if (order.contains("nodes")) throw ComponentError("a hand has 'frames' and 'nodes'", "one of them");
  std::vector<Index> rows;
  for (const json& frame : frames)
    rows.push_back(body.frames[std::size_t(integer(frame, "frames", 0, long(body.frames.size()) - 1))][1]);
  std::vector<Index> sorted = rows;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw ComponentError("'frames' has a frame twice");
  return rows;
}

Hands::Hand Hands::pulling(const json& order, const Hand* before) const {
  Hand hand;
  const std::string verb = text(member(order, "do"), "do", 10);
  hand.kind = verb == "force" ? "force" : text(order.value("kind", json("pull")), "kind", 10);
  if (hand.kind != "pull" && hand.kind != "hold" && hand.kind != "force")
    throw ComponentError("there is no kind of hand '" + hand.kind + "'", "pull or hold");
  const Body& body = bodyOf(order, hand.body);
  hand.what.state = body.state->path();
  hand.what.nodes = order.contains("frames") ? turnsOf(order, body) : nodesOf(order, body);
  if (hand.kind == "force") {
    hand.what.force = place(member(order, "force"), "force") / double(hand.what.nodes.size());
    return hand;
  }
  const json& targets = member(order, "targets");
  if (!targets.is_array() || targets.size() != hand.what.nodes.size())
    throw ComponentError("'targets' is not a list of one place per node, or one rotation vector per frame");
  for (const json& target : targets) hand.what.targets.push_back(place(target, "targets"));
  chooseStiffness(body, hand.what.nodes, order, before, hand);
  return hand;
}

Hands::Hand Hands::pushing(const json& order, const Hand* before) const {
  Hand hand;
  hand.kind = "push";
  const Body& body = bodyOf(order, hand.body);
  hand.what.state = body.state->path();
  hand.what.ball =
      Ball{place(member(order, "centre"), "centre"), number(member(order, "radius"), "radius", 1e-12, 1e9)};
  const std::vector<Index> surface(body.node.begin(), body.node.begin() + body.surface);
  if (surface.empty()) throw ComponentError("the body has no surface to push");
  chooseStiffness(body, surface, order, before, hand);
  return hand;
}

void Hands::apply(int client, const json& order) {
  const std::string verb = text(member(order, "do"), "do", 10);
  const Key key{client, text(member(order, "hand"), "hand", 40)};
  const long sequence = order.contains("sequence") ? integer(order["sequence"], "sequence", 0, 1L << 52) : -1;
  const auto known = hands_.find(key);
  if (verb == "release") {
    if (known != hands_.end()) {
      simulation_.removeInput(known->second.input);
      hands_.erase(known);
    }
  } else {
    const Hand* before = known == hands_.end() ? nullptr : &known->second;
    if (!before && hands_.size() >= 100) throw ComponentError("there are 100 hands already", "one of them released");
    Hand hand = verb == "push" ? pushing(order, before) : pulling(order, before);
    if (before && before->body == hand.body) {
      simulation_.changeInput(hand.input = before->input, hand.what);
    } else {
      hand.input = simulation_.addInput(hand.what);
      if (before) simulation_.removeInput(before->input);
    }
    hands_[key] = std::move(hand);
  }
  if (sequence >= 0) ordered_[client] = sequence;
}

void Hands::follow(const NodesNow& now) {
  for (auto it = hands_.begin(); it != hands_.end();) {
    Hand& hand = it->second;
    Input& what = hand.what;
    const auto body = std::find_if(drawing_.bodies.begin(), drawing_.bodies.end(),
                                   [&what](const Body& each) { return each.state->path() == what.state; });
    hand.body = Index(body - drawing_.bodies.begin());
    bool is_there = body != drawing_.bodies.end();
    if (const auto numbers = now.find(what.state); is_there && !what.ball && numbers != now.end()) {
      std::size_t left = 0;
      for (std::size_t i = 0; i < what.nodes.size(); ++i) {
        const Index node = numbers->second.at(std::size_t(what.nodes[i]));
        if (node < 0) continue;
        what.nodes[left] = node;
        if (!what.targets.empty()) what.targets[left] = what.targets[i];
        ++left;
      }
      what.nodes.resize(left);
      if (!what.targets.empty()) what.targets.resize(left);
      is_there = left > 0;
    }
    it = is_there ? std::next(it) : hands_.erase(it);
  }
}

void Hands::releaseAll(int client) {
  for (auto it = hands_.begin(); it != hands_.end();) {
    if (it->first.first == client) {
      simulation_.removeInput(it->second.input);
      it = hands_.erase(it);
    } else {
      ++it;
    }
  }
  ordered_.erase(client), drawn_.erase(client);
}

Vec3 Hands::forceOn(const Hand& hand, std::size_t& touched) const {
  const Body& body = drawing_.bodies[std::size_t(hand.body)];
  const ConstRows x = body.x(), v = body.v();
  const Input& what = hand.what;
  Vec3 sum = Vec3::Zero();
  touched = what.nodes.size();
  for (std::size_t i = 0; i < what.nodes.size(); ++i) {
    const Index node = what.nodes[i];
    sum += what.force - what.damping * v[node];
    if (what.targets.empty()) continue;
    if (body.state->kindOf(node) == RowKind::turn)
      sum += what.stiffness * rotationVector(turnedBy(what.targets[i]) * orientationIn(x, node).conjugate());
    else
      sum += what.stiffness * (what.targets[i] - x[node]);
  }
  if (!what.ball) return sum;
  for (const Index node : body.node) {
    const Vec3 from = x[node] - what.ball->centre;
    const double distance = from.norm();
    if (!(distance < what.ball->radius)) continue;
    const Vec3 n = distance > 0 ? Vec3(from / distance) : Vec3(1, 0, 0);  // as the engine has it
    sum += (what.stiffness * (what.ball->radius - distance) - what.damping * v[node].dot(n)) * n;
    ++touched;
  }
  return sum;
}

json Hands::describe() const {
  json out = json::array();
  for (const auto& [key, hand] : hands_) {
    const Body& body = drawing_.bodies[std::size_t(hand.body)];
    const Input& what = hand.what;
    std::size_t touched = 0;
    json one{{"hand", key.second},
             {"client", key.first},
             {"kind", hand.kind},
             {"body", hand.body},
             {"force", list(forceOn(hand, touched))},
             {"stiffness", what.stiffness}};
    if (what.ball) {
      one["centre"] = list(what.ball->centre), one["radius"] = what.ball->radius, one["touched"] = touched;
      out.push_back(std::move(one));
      continue;
    }
    const bool turns = body.state->kindOf(what.nodes.front()) == RowKind::turn;
    one["turns"] = turns;  // then `force` is a torque
    Vec3 to = Vec3::Zero(), at = Vec3::Zero(), rest = Vec3::Zero();
    const double share = 1 / double(what.nodes.size());
    for (const Vec3& target : what.targets) to += share * target;
    for (const Index row : what.nodes) {
      const Index node = turns ? row - 1 : row;  // the centre of a frame
      at += share * Vec3(body.x()[node]), rest += share * body.state->rest_position[std::size_t(node)];
    }
    one["node"] = body.page[std::size_t(what.nodes.front() - (turns ? 1 : 0))], one["nodes"] = what.nodes.size();
    one["at"] = list(at), one["rest_at"] = list(rest);
    if (!what.targets.empty() && !turns) one["to"] = list(to);
    out.push_back(std::move(one));
  }
  return out;
}

}  // namespace stroma::view
