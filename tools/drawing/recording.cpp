// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/drawing/recording.h"

#include <fmt/format.h>

#include <stdexcept>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/system.h"
#include "tools/drawing/contacts.h"

namespace stroma::drawing {
namespace {

/// Calls visit(attribute, its numbers as a list) for what a component computes.
template <class Visit>
void forEachOutput(const Component& component, Visit&& visit) {
  for (const Data& data : component.data().all()) {
    if (!data.isOutput() && !data.isOfNodes()) continue;
    const DataPointer& pointer = data.pointer();
    if (auto* const* number = std::get_if<double*>(&pointer)) visit(data, *number);
    if (auto* const* whole = std::get_if<int*>(&pointer)) visit(data, *whole);
    if (auto* const* point = std::get_if<Vec3*>(&pointer)) visit(data, *point);
    if (auto* const* numbers = std::get_if<std::vector<double>*>(&pointer)) visit(data, *numbers);
    if (auto* const* wholes = std::get_if<std::vector<int>*>(&pointer)) visit(data, *wholes);
    if (auto* const* points = std::get_if<std::vector<Vec3>*>(&pointer)) visit(data, *points);
  }
}

struct Print {
  std::vector<double>& out;
  template <class Number>
  void operator()(const Number* number) const requires std::is_arithmetic_v<Number> { out.push_back(double(*number)); }
  void operator()(const Vec3* point) const { out.insert(out.end(), point->data(), point->data() + 3); }
  template <class Value>
  void operator()(const std::vector<Value>* list) const {
    for (const Value& value : *list) (*this)(&value);
  }
};

struct Read {
  const std::vector<double>& from;
  std::size_t& at;
  template <class Number>
  void operator()(Number* number) const requires std::is_arithmetic_v<Number> {
    if (at < from.size()) *number = Number(from[at++]);
  }
  void operator()(Vec3* point) const {
    for (int k = 0; k < 3 && at < from.size(); ++k) (*point)[k] = from[at++];
  }
  template <class Value>
  void operator()(std::vector<Value>* list) const {
    constexpr std::size_t each = std::is_arithmetic_v<Value> ? 1 : 3;
    list->resize(from.size() / each);
    for (Value& value : *list) (*this)(&value);
  }
};

}  // namespace

std::string valuesFileName(const std::string& component_path) {
  const std::string name = stateFileName(component_path);
  return name.substr(0, name.size() - std::string_view(".state.gz").size()) + ".values.gz";
}

std::map<std::string, std::vector<double>> valuesOf(const Component& component) {
  std::map<std::string, std::vector<double>> values;
  forEachOutput(component, [&](const Data& data, const auto* value) { Print{values[data.name()]}(value); });
  return values;
}

void showInstant(Simulation& simulation, const Recording& recording, std::size_t instant) {
  std::size_t i = 0;
  for (State* state : simulation.states()) {
    const StateFrame& frame = recording[i++][instant];
    if (frame.x.size() != std::size_t(state->size()))
      throw std::runtime_error(fmt::format("the recording of {} has {} rows at {:g} s (expected {})", state->path(), frame.x.size(),
                                           frame.time, state->size()));
    for (Index row = 0; row < state->size(); ++row) {
      placeRow(state->kindOf(row), frame.x[std::size_t(row)], state->x(), row);
      if (!frame.v.empty()) state->v()[row] = frame.v[std::size_t(row)];
    }
  }
  std::vector<DrawnObstacles*> obstacles;
  simulation.root().collect(obstacles);
  for (DrawnObstacles* obstacle : obstacles)
    if (!recording.empty()) obstacle->showShapesAt(recording.front()[instant].time);
  const std::vector<Component*> computing = withNodeValues(simulation);
  for (const Component* component : computing) {
    if (i >= recording.size() || recording.size() != simulation.states().size() + computing.size()) break;
    const std::vector<StateFrame>& frames = recording[i++];
    if (instant >= frames.size()) continue;
    forEachOutput(*component, [&](const Data& data, auto* value) {
      const auto found = frames[instant].values.find(data.name());
      if (std::size_t at = 0; found != frames[instant].values.end()) Read{found->second, at}(value);
    });
  }
  if (!recording.empty())  // loads of the instant
    for (const auto& system : simulation.systems()) system->setTime(recording.front()[instant].time);
}

}  // namespace stroma::drawing
