// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/regression_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/load.h"
#include "framework/scene/output_file.h"
#include "framework/scene/text.h"
#include "tools/command/command.h"

namespace stroma::command {
namespace {

double energyNow(const Simulation& simulation, const std::string& name) {
  double sum = 0;
  for (const auto& system : simulation.systems()) {
    if (name == "kinetic_energy" || name == "total_energy") sum += system->kineticEnergy();
    if (name == "elastic_energy") sum += system->elasticEnergy(system->x);
    if (name == "gravity_energy") sum += system->gravityEnergy(system->x);
    if (name == "total_energy") sum += system->potentialEnergy(system->x);
  }
  return sum;
}

bool isEnergy(const std::string& name) {
  return name == "kinetic_energy" || name == "elastic_energy" || name == "gravity_energy" || name == "total_energy";
}

constexpr const char *cells_word = "cells", *volume_word = "volume";
bool isOfMeshes(const std::string& name) { return name == cells_word || name == volume_word; }

/// Of all states with a mesh: how many cells of its highest dimension there are, or the volume of those that have one, now [m^3].
double ofMeshes(const Simulation& simulation, const std::string& name) {
  double sum = 0;
  for (const State* state : simulation.states()) {
    const Topology* topology = topologyOf(*state);
    if (!topology) continue;
    const Mesh& mesh = topology->mesh();
    std::vector<Vec3> places;
    for (Index i = 0; i < state->nodes(); ++i) places.emplace_back(state->x()[i * state->rows_per_node]);
    const int highest = highestDimension(mesh);
    forEachCellList(
        [&](const CellKind& kind, const auto& cells) {
          if (kind.dimension != highest || highest == 0) return;
          if (name == cells_word) sum += double(cells.size());
          for (std::size_t c = 0; name == volume_word && highest == 3 && c < cells.size(); ++c)
            sum += kind.size(cornersOf(cells[c], places).data()) / mesh.overlap;
        },
        mesh);
  }
  return sum;
}

std::vector<double> numbersIn(const std::string& text, const std::string& where) {
  std::vector<double> numbers;
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    double value = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc() || end != word.data() + word.size())
      throw std::runtime_error(fmt::format("{}: '{}' is no number", where, word));
    numbers.push_back(value);
  }
  return numbers;
}

}  // namespace

std::string WatchedData::fileName() const {
  std::string file = name.substr(name.starts_with("/"));
  std::replace(file.begin(), file.end(), '/', '.');
  return file + ".data";
}

WatchedData readWatchedData(const std::string& word, double tolerance) {
  WatchedData data{word.substr(word.find('=') + 1), tolerance};
  if (const auto colon = data.name.rfind(':'); colon != std::string::npos) {
    const std::string text = data.name.substr(colon + 1);
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), data.tolerance);
    if (code != std::errc() || end != text.data() + text.size() || !(data.tolerance >= 0) || data.tolerance >= 1)
      throw UsageError(fmt::format("'{}': expected data=PATH.NAME:TOLERANCE with a tolerance from 0 to below 1", word));
    data.name.resize(colon);
  }
  if (data.name.empty() || (!isEnergy(data.name) && !isOfMeshes(data.name) && data.name.find('.') == std::string::npos))
    throw UsageError(fmt::format(
        "'{}': expected data=PATH.NAME, or kinetic_energy, elastic_energy, gravity_energy, total_energy, cells or volume", word));
  return data;
}

std::vector<double> numbersNow(const Simulation& simulation, const std::string& name) {
  if (isEnergy(name)) return {energyNow(simulation, name)};
  if (isOfMeshes(name)) return {ofMeshes(simulation, name)};
  const auto dot = name.rfind('.');
  const Component* owner = findComponent(simulation.root(), name.substr(0, dot));
  const Data* data = owner ? owner->data().find(name.substr(dot + 1)) : nullptr;
  if (!data) throw std::runtime_error(fmt::format("data={}: the scene has no such attribute", name));
  return numbersIn(data->print(), "data=" + name);
}

void writeData(const std::string& file, const DataOverTime& values) {
  std::string text = "# a line for each time [s]: the time, then the numbers\n";
  for (const auto& [time, numbers] : values) text += fmt::format("{} {}\n", printReal(time), fmt::join(numbers, " "));
  writeWholeFile(file, text);
}

DataOverTime readData(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file + " cannot be opened");
  DataOverTime values;
  for (std::string line; std::getline(stream, line);) {
    if (trimmed(line).empty() || line[0] == '#') continue;
    const std::vector<double> row = numbersIn(line, file);
    values[row[0]].assign(row.begin() + 1, row.end());
  }
  return values;
}

std::string compareData(const DataOverTime& reference, const DataOverTime& actual, double tolerance, double& error) {
  if (reference.size() != actual.size()) return fmt::format("{} times instead of {}", actual.size(), reference.size());
  double size = 0;
  for (const auto& [time, numbers] : reference)
    for (const double number : numbers) size = std::max(size, std::abs(number));
  std::string failure;
  for (auto wanted = reference.begin(), found = actual.begin(); wanted != reference.end(); ++wanted, ++found) {
    constexpr double close = 1e-9;
    if (!(std::abs(wanted->first - found->first) <= close * std::max(1., std::abs(wanted->first))))
      return fmt::format("t = {:g} instead of {:g}", found->first, wanted->first);
    if (wanted->second.size() != found->second.size())
      return fmt::format("{} numbers instead of {} at t = {:g}", found->second.size(), wanted->second.size(), wanted->first);
    for (std::size_t i = 0; i < wanted->second.size(); ++i) {
      const double off = std::abs(wanted->second[i] - found->second[i]), share = size > 0 ? off / size : off;
      if (share <= error) continue;  // not what is no number
      error = std::isfinite(share) ? share : INFINITY;
      if (!(share <= tolerance))
        failure = fmt::format("number {} is {:.9g} instead of {:.9g} at t = {:g}", i, found->second[i], wanted->second[i],
                              wanted->first);
      if (!std::isfinite(share)) return failure;
    }
  }
  return failure;
}

}  // namespace stroma::command
