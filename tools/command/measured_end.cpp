// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/measured_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/output_file.h"
#include "framework/scene/text.h"
#include "framework/scene/value_lists.h"
#include "tools/session/file_uses.h"
#include "tools/units/unit_system.h"

namespace stroma::command {
namespace {

constexpr std::string_view state_quantities[] = {"displacement", "position", "velocity"};

Component& componentAt(const Simulation& simulation, const std::string& path) {
  if (Component* found = findComponent(simulation.root(), path)) return *found;
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<std::string> paths;
  for (const Component* component : all) paths.push_back(component->path());
  throw ComponentError(fmt::format("the scene has no component {}", path), "PATH.NAME of a quantity",
                       nearest(path, paths));
}

/// A list of numbers, or a link to one.
std::vector<int> chosenIn(const Simulation& simulation, const std::string& text) {
  std::vector<int> chosen;
  Data list("nodes", DataPointer(&chosen));
  const auto refuse = [&](const std::optional<Problem>& problem) {
    if (problem) throw ComponentError(fmt::format("{}: {}", text, problem->message), problem->expected);
  };
  if (!text.starts_with("@")) {
    refuse(list.parse(text, DataOrigin::written));
  } else {
    const auto dot = text.rfind('.');
    if (dot == std::string::npos) throw ComponentError(text + " names no list", "@PATH.indices");
    const Component& owner = componentAt(simulation, text.substr(1, dot - 1));
    const Data* from = owner.data().find(text.substr(dot + 1));
    if (!from)
      throw ComponentError(fmt::format("{} has no attribute {}", owner.path(), text.substr(dot + 1)), "",
                           nearest(text.substr(dot + 1), owner.data().names()));
    refuse(list.copyFrom(*from));
  }
  if (chosen.empty()) throw ComponentError(text + " is an empty list", "nodes or cells to take the mean of");
  return chosen;
}

/// Weighted mean over `chosen`, or over all. Throws ComponentError for a number that there is not.
template <class At, class Weight>
std::vector<double> meanOf(std::size_t count, std::size_t width, const std::vector<int>& chosen, At&& at,
                           Weight&& weight) {
  std::vector<double> sum(width, 0.0);
  double all = 0;
  const auto add = [&](std::size_t i) {
    const double share = weight(i);
    all += share;
    for (std::size_t c = 0; c < width; ++c) sum[c] += share * at(i, c);
  };
  for (const int i : chosen) {
    if (i < 0 || std::size_t(i) >= count)
      throw ComponentError(fmt::format("there is no entry {}", i), fmt::format("0 to {}", count - 1));
    add(std::size_t(i));
  }
  for (std::size_t i = 0; chosen.empty() && i < count; ++i) add(i);
  for (double& value : sum) value /= all;
  return sum;
}

constexpr auto equally = [](std::size_t) { return 1.0; };

/// The mesh with volume cells that a force on the state works in, else the state's own.
const Mesh* volumeMeshOf(const Simulation& simulation, const State& state) {
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields()) {
      if (&field->state() != &state) continue;
      const Data* link = field->data().find("topology");
      const auto* given = link && link->link() ? dynamic_cast<const Topology*>(link->link()->target()) : nullptr;
      if (!given) try {
          given = findTopology(*field, state, Link<Topology>("topology"));
        } catch (const ComponentError&) {  // none fits: the field needs none
        }
      if (given && given->mesh().nodes() == state.size() && highestDimension(given->mesh()) == 3) return &given->mesh();
    }
  const Topology* own = topologyOf(state);
  return own && highestDimension(own->mesh()) == 3 ? &own->mesh() : nullptr;
}

template <class Point>
Reals flat(std::size_t count, Point&& point) {
  Reals numbers;
  numbers.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto p = point(i);
    numbers.insert(numbers.end(), {p[0], p[1], p[2]});
  }
  return numbers;
}

template <class Cell>
Integers flat(const std::vector<Cell>& cells) {
  Integers numbers;
  for (const Cell& cell : cells) numbers.insert(numbers.end(), cell.begin(), cell.end());
  return numbers;
}

}  // namespace

MeasuredQuantity::MeasuredQuantity(const Simulation& simulation, const std::string& text) : text_(text) {
  if (const auto colon = text.find(':'); colon != std::string::npos) chosen_ = chosenIn(simulation, text.substr(colon + 1));
  find(simulation);
  evaluate_();  // what it refuses, it refuses before the run
}

void MeasuredQuantity::follow(const Simulation& simulation, const NodesNow& now) {
  const auto numbers = now.find(state_);
  if (!chosen_.empty() && numbers != now.end()) {
    for (int& node : chosen_) node = std::size_t(node) < numbers->second.size() ? int(numbers->second[std::size_t(node)]) : -1;
    std::erase(chosen_, -1);
    are_gone_ = chosen_.empty();  // which is not all
  }
  try {
    if (are_gone_) throw ComponentError(fmt::format("all nodes of {} have gone with their cells", text_));
    find(simulation);
  } catch (const ComponentError& error) {
    evaluate_ = [error]() -> std::vector<double> { throw error; };
  }
}

void MeasuredQuantity::find(const Simulation& simulation) {
  const std::string &text = text_, name = text.substr(0, text.find(':'));
  const auto dot = name.rfind('.');
  if (dot == std::string::npos || dot == 0)
    throw ComponentError(inQuotes(text) + " names no quantity", "PATH.NAME or PATH.NAME:NODES");
  const Component& component = componentAt(simulation, name.substr(0, dot));
  const std::string attribute = name.substr(dot + 1);
  const auto* state = dynamic_cast<const State*>(&component);
  const auto* field = dynamic_cast<const ForceField*>(&component);
  const auto fields = field ? field->cellFields() : std::vector<std::string>{};
  if (state && std::ranges::find(state_quantities, attribute) != std::end(state_quantities))
    state_ = state->path(), ofState(*state, attribute);
  else if (std::ranges::find(fields, attribute) != fields.end())
    ofCells(simulation, *field, attribute);
  else if (const Data* data = component.data().find(attribute))
    ofData(*data, text);
  else
    failName(component, attribute);
}

void MeasuredQuantity::failName(const Component& component, const std::string& name) {
  std::vector<std::string> names = component.data().names();
  if (const auto* field = dynamic_cast<const ForceField*>(&component))
    for (const std::string& cell_field : field->cellFields()) names.push_back(cell_field);
  if (dynamic_cast<const State*>(&component))
    names.insert(names.end(), std::begin(state_quantities), std::end(state_quantities));
  const std::string near = nearest(name, names);
  throw ComponentError(fmt::format("{} has no quantity {}{}", component.path(), name,
                                   near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
}

void MeasuredQuantity::ofState(const State& state, const std::string& name) {
  evaluate_ = [this, &state, name] {
    return meanOf(
        std::size_t(state.nodes()), 3, chosen_,
        [&](std::size_t node, std::size_t c) {
          const auto k = Index(c);
          const std::size_t i = node * std::size_t(state.rows_per_node);  // of a frame the centre
          if (name == "velocity") return state.v()[Index(i)][k];
          return state.x()[Index(i)][k] - (name == "displacement" ? state.rest_position[i][k] : 0.0);
        },
        equally);
  };
}

void MeasuredQuantity::ofData(const Data& data, const std::string& text) {
  evaluate_ = [this, &data, text] {
    const auto list = [&](const auto& values) {
      if (values.empty()) throw ComponentError(text + " has no value");
      using Entry = std::decay_t<decltype(values[0])>;
      if constexpr (std::is_same_v<Entry, Vec3>)
        return meanOf(
            values.size(), 3, chosen_, [&](std::size_t i, std::size_t c) { return values[i][Index(c)]; }, equally);
      else
        return meanOf(
            values.size(), 1, chosen_, [&](std::size_t i, std::size_t) { return double(values[i]); }, equally);
    };
    if (const auto* reals = std::get_if<std::vector<double>*>(&data.pointer())) return list(**reals);
    if (const auto* points = std::get_if<std::vector<Vec3>*>(&data.pointer())) return list(**points);
    if (const auto* real = std::get_if<double*>(&data.pointer())) return std::vector<double>{**real};
    if (const auto* number = std::get_if<int*>(&data.pointer())) return std::vector<double>{double(**number)};
    if (const auto* point = std::get_if<Vec3*>(&data.pointer()))
      return std::vector<double>{(**point)[0], (**point)[1], (**point)[2]};
    throw ComponentError(fmt::format("{} is no quantity: it is {}", text, data.typeText()), "numbers");
  };
}

/// Large cells weigh more, so that the mean does not depend on how a mesh is graded.
void MeasuredQuantity::ofCells(const Simulation& simulation, const ForceField& field, const std::string& name) {
  const System* system = nullptr;
  for (const auto& candidate : simulation.systems())
    if (std::ranges::find(candidate->forceFields(), &field) != candidate->forceFields().end()) system = candidate.get();
  if (!system) throw ComponentError(field.path() + " acts in no system that moves");
  const auto shape = field.cellFieldShape(name);
  const Mesh* mesh = volumeMeshOf(simulation, field.state());
  std::vector<double> volumes;
  const auto measure = [&](const CellKind& kind, const auto& cells) {
    if (!shape.kind || kind.type != shape.kind->type) return;
    for (const auto& cell : cells) volumes.push_back(kind.size(cornersOf(cell, field.state().rest_position).data()));
  };
  if (mesh) forEachCellList(measure, *mesh);
  evaluate_ = [this, system, volumes, &field, name, width = shape.width] {
    std::vector<double> values;
    field.cellField(name, system->x, values);
    const std::size_t count = values.size() / width;
    return meanOf(
        count, width, chosen_, [&](std::size_t i, std::size_t c) { return values[width * i + c]; },
        [&](std::size_t i) { return volumes.size() == count ? volumes[i] : 1.0; });
  };
}

void checkMeasurable(const Simulation& simulation) {
  for (const State* state : simulation.states())
    if (const Mesh* mesh = volumeMeshOf(simulation, *state); mesh && !(mesh->prisms.empty() && mesh->pyramids.empty()))
      throw ComponentError(state->path() + " has prisms or pyramids: errors are measured in tetrahedra and hexahedra",
                           "a mesh of tetrahedra or hexahedra, to measure with --measure or to sweep over");
}

void writeMeasuredEnd(const Simulation& simulation, const MeasuredQuantity* quantity, const std::string& file) {
  simulation.complete();
  ValueLists values;
  values.add("times", Reals{simulation.time(), simulation.dt()});
  if (quantity) values.add("quantity", Reals(quantity->now()));
  Texts inputs, paths;
  for (const FileUse& use : inputsOf(simulation.scene())) inputs.push_back(use.path);
  const UnitSystem units = unitsOf(simulation.scene());
  values.add("units", Texts{units.unit("m"), units.unit("s")});
  values.add("inputs", inputs);
  for (const State* state : simulation.states()) {
    const std::string& path = paths.emplace_back(state->path());
    const auto count = std::size_t(state->size());
    values.add("rest " + path, flat(count, [&](std::size_t i) { return state->rest_position[i]; }));
    values.add("x " + path, flat(count, [&](std::size_t i) { return state->x()[Index(i)]; }));
    values.add("v " + path, flat(count, [&](std::size_t i) { return state->v()[Index(i)]; }));
    if (const Mesh* mesh = volumeMeshOf(simulation, *state)) {
      values.add("tetrahedra " + path, flat(mesh->tetrahedra));
      values.add("hexahedra " + path, flat(mesh->hexahedra));
    }
  }
  values.add("states", paths);
  writeWholeFile(file, values.bytes());
}

}  // namespace stroma::command
