// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/shots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "framework/mesh/cell_lists.h"
#include "tools/drawing/contacts.h"
#include "tools/drawing/held_nodes.h"
#include "tools/picture/frames.h"

namespace stroma::picture {
namespace {

using drawing::Body;
using drawing::Field;

bool isOnNodes(const std::string& field) { return field == "displacement" || field == "velocity"; }

/// `visit(cell number, its nodes in the state)` for the cells that fields have values for.
template <class Visit>
void forEachCell(const Body& body, Visit&& visit) {
  const Mesh& mesh = *body.mesh;
  Index number = 0;
  const auto all = [&](const auto& cells) {
    for (const auto& cell : cells) visit(number++, cell);
  };
  const int dimension = highestDimension(mesh) < 3 ? 2 : 3;
  forEachCellList([&](const CellKind& kind, const auto& cells) { kind.dimension == dimension ? all(cells) : void(); }, mesh);
}

/// The part of the values that is left when one in a hundred goes at either end.
Range bulkOf(std::vector<float> values) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const auto at = [&values](double part) {
    const auto place = values.begin() + long(part);
    std::nth_element(values.begin(), place, values.end());
    return double(*place);
  };
  const double last = double(values.size() - 1);
  return {at(std::floor(0.01 * last)), at(std::ceil(0.99 * last))};
}

void widen(Range& range, const Range& by) { range = {std::min(range.low, by.low), std::max(range.high, by.high)}; }

}  // namespace

std::string titleOf(const std::string& field) {
  static const std::map<std::string, std::string> titles{
      {"vonMises", "von Mises stress"}, {"J", "volume ratio J"}, {"strain", "strain (norm)"}, {"stress", "stress (norm)"},
      {"principalStress", "largest principal stress"}, {"principalStrain", "largest principal strain"},
      {"elasticVonMises", "von Mises stress, elastic"}, {"elasticStress", "elastic stress (norm)"},
      {"pressures", "contact pressure"}, {"gaps", "contact gap"}, {"contactAreas", "contact area"},
      {"contactStates", "sticks 1, slides 2"}, {"contactForces", "contact force"}, {"frictionForces", "friction force"}};
  const auto found = titles.find(field);
  if (found != titles.end()) return found->second;
  std::string spaced;
  for (const char c : field)
    spaced += std::isupper(static_cast<unsigned char>(c)) && !spaced.empty() ? std::string(" ") + char(std::tolower(c))
                                                                             : std::string(1, c);
  return spaced;
}

ShotTaker::ShotTaker(const Simulation& simulation, const PictureRequest& request)
    : simulation_(simulation),
      request_(request),
      drawing_(drawing::drawingOf(simulation)),
      field_(request.field),
      units_(unitsOf(simulation.scene())) {
  if (drawing_.bodies.empty()) throw std::runtime_error("nothing in the scene has positions: there is nothing to draw");
  drawn_.assign(drawing_.bodies.size(), true);
  hidden_obstacles_.assign(drawing_.obstacles.size(), false);
  hide(request.hidden);
  choose();
  hideOneOfTwo();
}

ShotTaker::ShotTaker(const Simulation& simulation, const ShotTaker& first)
    : simulation_(simulation),
      request_(first.request_),
      drawing_(drawing::drawingOf(simulation)),
      drawn_(first.drawn_),
      hidden_obstacles_(first.hidden_obstacles_),
      field_(first.field_),
      units_(first.units_) {
  if (drawing_.bodies.size() != drawn_.size() || drawing_.obstacles.size() != hidden_obstacles_.size())
    throw std::runtime_error("meshes have changed so that other bodies are to be drawn: no picture can show both");
  keepOwn();
}

void ShotTaker::keepOwn() {
  own_size_ = restSize();
  std::vector<Points> all;
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b) all.push_back(rest(b));
  own_rest_ = std::move(all);
  for (Body& body : drawing_.bodies)
    if (body.mesh && request_.cut) {
      own_meshes_.push_back(std::make_unique<const Mesh>(*body.mesh));
      body.mesh = own_meshes_.back().get();
    }
}

void ShotTaker::hide(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    bool is_obstacle = false;
    for (std::size_t k = 0; k < drawing_.obstacles.size(); ++k)
      if (drawing_.obstacles[k].owner->path() == path) hidden_obstacles_[k] = is_obstacle = true;
    if (is_obstacle) continue;
    for (const std::size_t b : bodiesAt(path, "hidden")) drawn_[b] = false;
  }
}

bool ShotTaker::isObstacleDrawn(std::size_t obstacle) const {
  constexpr double most = 2;  // times the size of the bodies
  const drawing::Obstacle& of = drawing_.obstacles[obstacle];
  if (hidden_obstacles_[obstacle] || of.solid == 0) return false;
  Box box;
  for (std::size_t t = 0; t < of.solid; ++t)
    for (const Index point : of.triangles[t]) box.add(of.points[std::size_t(point)]);
  return box.size() <= most * restSize().norm();
}

std::vector<std::size_t> ShotTaker::bodiesAt(std::string path, const char* to_be) const {
  while (path.ends_with('/')) path.pop_back();
  std::vector<std::size_t> found;
  std::vector<std::string> known;
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b) {
    const std::string& state = drawing_.bodies[b].state->path();
    known.push_back(drawing_.bodies[b].state->node().path());
    if (state == path || state.starts_with(path + "/")) found.push_back(b);
  }
  if (found.empty())
    throw ComponentError(fmt::format("no body is at {}, which is to be {}", path, to_be),
                         fmt::format("{}", fmt::join(known, ", ")), nearest(path, known));
  return found;
}

namespace {

Box restBox(const Body& body) {
  Box box;
  for (const Index row : body.node) box.add(body.state->rest_position[std::size_t(row)]);
  return box;
}

}  // namespace

Vec3 ShotTaker::restSize() const {
  if (own_size_) return *own_size_;
  Box box;
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b)
    if (drawn_[b]) box.add(restBox(drawing_.bodies[b]));
  return box.sides();
}

/// Two surfaces of the same body, one embedded in the other, would show through each other: that is drawn which has the
/// field, and of two that have it the embedded one.
void ShotTaker::hideOneOfTwo() {
  for (const auto& system : simulation_.systems())
    for (const auto* mappings : {&system->actors().mappings, &system->actors().passive_mappings})
      for (const Mapping* mapping : *mappings) hideOneOfTwo(mapping->input(), mapping->output());
}

void ShotTaker::hideOneOfTwo(const State& parent, const State& child) {
  constexpr double most = 0.8;  // of the parent's sides: a smaller child is a part of it
  const auto bodyOf = [this](const State& state) {
    std::size_t b = 0;
    while (b < drawing_.bodies.size() && drawing_.bodies[b].state != &state) ++b;
    return b;
  };
  const std::size_t p = bodyOf(parent), c = bodyOf(child);
  if (p == drawing_.bodies.size() || c == drawing_.bodies.size() || !drawn_[p] || !drawn_[c]) return;
  if (drawing_.bodies[p].triangles.empty() || drawing_.bodies[c].triangles.empty()) return;
  const Vec3 of_parent = restBox(drawing_.bodies[p]).sides(), of_child = restBox(drawing_.bodies[c]).sides();
  if ((of_child.array() < most * of_parent.array()).any()) return;
  drawn_[valuesAt(c) == ValuesAt::none && valuesAt(p) != ValuesAt::none ? c : p] = false;
}

std::vector<FieldWord> ShotTaker::fieldsOf(const drawing::Drawing& drawing, const UnitSystem& units) {
  std::vector<FieldWord> words{{"displacement", titleOf("displacement"), units.unit("m")}};
  for (const Field& field : drawing.fields)
    if (std::none_of(words.begin(), words.end(), [&](const FieldWord& word) { return word.name == field.name; }))
      words.push_back({field.name, titleOf(field.name), units.unit(drawing::unitOf(field)), field.source != nullptr});
  return words;
}

/// Without a word for it: the stress, where all that has a surface has one; else what every body has.
void ShotTaker::choose() {
  const std::vector<FieldWord> words = fieldsOf(drawing_, units_);
  std::vector<std::string> names{"none"};
  for (const FieldWord& word : words) names.push_back(word.name);
  if (field_.empty()) {
    field_ = "vonMises";
    for (std::size_t b = 0; b < drawing_.bodies.size(); ++b)
      if (drawn_[b] && !drawing_.bodies[b].triangles.empty() && valuesAt(b) == ValuesAt::none) field_ = "displacement";
    if (std::find(names.begin(), names.end(), field_) == names.end()) field_ = "displacement";
  } else if (std::find(names.begin(), names.end(), field_) == names.end()) {
    throw ComponentError(fmt::format("no body has a field '{}'", field_), fmt::format("{}", fmt::join(names, ", ")),
                         nearest(field_, names));
  }
}

ValuesAt ShotTaker::valuesAt(std::size_t body) const {
  if (field_ == "none") return ValuesAt::none;
  if (isOnNodes(field_)) return ValuesAt::nodes;
  const Field* found = fieldOf(body);
  return !found ? ValuesAt::none : request_.flat && !found->data ? ValuesAt::cells : ValuesAt::nodes;
}

const Field* ShotTaker::fieldOf(std::size_t body) const {
  const auto found = std::find_if(drawing_.fields.begin(), drawing_.fields.end(), [&](const Field& field) {
    return std::size_t(field.body) == body && field.name == field_;
  });
  return found == drawing_.fields.end() ? nullptr : &*found;
}

Index ShotTaker::nodesOf(const Body& body) const { return request_.cut ? Index(body.node.size()) : body.surface; }

Points ShotTaker::rest(std::size_t body) const {
  if (!own_rest_.empty()) return own_rest_[body];
  const Body& drawn = drawing_.bodies[body];
  Points out;
  for (Index i = 0; i < nodesOf(drawn); ++i) {
    const Vec3& p = drawn.state->rest_position[std::size_t(drawn.node[std::size_t(i)])];
    for (int k = 0; k < 3; ++k) out.push_back(float(p[k]));
  }
  return out;
}

Shot ShotTaker::take(double time) {
  simulation_.complete();
  Shot shot;
  shot.time = time;
  for (const drawing::Obstacle& obstacle : drawing_.obstacles) shot.moved.push_back(obstacle.drawn->shapesMovedBy());
  const auto holdings = drawing::holdingsOf(simulation_, drawing_, time);
  for (std::size_t b = 0; b < drawing_.bodies.size(); ++b) {
    BodyShot& of_body = shot.bodies.emplace_back();
    if (!drawn_[b]) continue;
    const Body& body = drawing_.bodies[b];
    const ConstRows x = body.x();
    const Index count = nodesOf(body);
    of_body.x.reserve(3 * std::size_t(count));
    for (Index i = 0; i < count; ++i) {
      const Vec3 p = x[body.node[std::size_t(i)]];
      for (int k = 0; k < 3; ++k) of_body.x.push_back(float(p[k]));
      const drawing::Holding how = holdings[b][std::size_t(i)];
      if (how == drawing::Holding::held) of_body.held.push_back(i);
      if (how == drawing::Holding::guided) of_body.guided.push_back(i);
    }
    for (const auto& [place, row] : body.frames)
      for (int k = 0; k < 4; ++k)
        of_body.turns.push_back(float(x.data[std::size_t(row) * row_doubles + std::size_t(k)]));
    addValues(b, of_body);
    measure(b, of_body);
  }
  return shot;
}

void ShotTaker::addValues(std::size_t b, BodyShot& shot) {
  if (valuesAt(b) == ValuesAt::none) return;
  const Body& body = drawing_.bodies[b];
  if (const Field* field = fieldOf(b); field && field->data) {
    if (drawing::nodeValues(*field, body, shot.values)) shot.values.resize(std::size_t(nodesOf(body)));
    return;
  }
  if (!isOnNodes(field_)) return addCellValues(b, shot);
  const ConstRows x = body.x(), v = body.v();
  for (Index i = 0; i < nodesOf(body); ++i) {
    const Index row = body.node[std::size_t(i)];
    shot.values.push_back(
        float(field_ == "velocity" ? v[row].norm() : (x[row] - body.state->rest_position[std::size_t(row)]).norm()));
  }
}

void ShotTaker::addCellValues(std::size_t b, BodyShot& shot) {
  const Body& body = drawing_.bodies[b];
  for (const Field& field : drawing_.fields) {
    if (std::size_t(field.body) != b || field.name != field_) continue;
    if (!cellValues(field, body, work_, cell_values_)) continue;
    shot.values = request_.flat ? cell_values_ : meansAtNodes(body);
    return;
  }
}

/// The mean over the cells around each node that have a value.
std::vector<float> ShotTaker::meansAtNodes(const Body& body) const {
  const auto count = std::size_t(nodesOf(body));
  std::vector<double> sum(count, 0.), weight(count, 0.);
  forEachCell(body, [&](Index number, const auto& cell) {
    const float value = cell_values_[std::size_t(number)];
    if (!std::isfinite(value)) return;
    for (const Index node : cell) {
      const auto page = std::size_t(body.page[std::size_t(node)]);
      if (page < count) sum[page] += value, weight[page] += 1;
    }
  });
  std::vector<float> means(count);
  for (std::size_t i = 0; i < count; ++i)
    means[i] = weight[i] > 0 ? float(sum[i] / weight[i]) : std::numeric_limits<float>::quiet_NaN();
  return means;
}

void ShotTaker::measure(std::size_t b, const BodyShot& shot) {
  if (shot.values.empty()) return;
  const Body& body = drawing_.bodies[b];
  std::vector<float> seen = shot.values;
  if (valuesAt(b) == ValuesAt::cells && !request_.cut) {
    seen.clear();
    for (const Index cell : body.owner) seen.push_back(shot.values[std::size_t(cell)]);
  }
  Range all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const float value : seen)
    if (std::isfinite(value)) all = {std::min(all.low, double(value)), std::max(all.high, double(value))};
  widen(extremes_, all);
  const bool of_few = fieldOf(b) && fieldOf(b)->data;  // few nodes touch: most values are zeros
  widen(bulk_, of_few ? Range{std::min(0., all.low), all.high} : isOnNodes(field_) ? Range{0, all.high} : bulkOf(std::move(seen)));
}

}  // namespace stroma::picture
