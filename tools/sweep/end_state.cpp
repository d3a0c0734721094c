// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/end_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "framework/mesh/cell_lists.h"
#include "framework/scene/value_lists.h"

namespace stroma::sweep {
namespace {

std::vector<Vec3> pointsIn(const ValueLists& values, const std::string& name) {
  const Reals& numbers = values.get<Reals>(name);
  std::vector<Vec3> points(numbers.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = Vec3(numbers.data() + 3 * i);
  return points;
}

template <class Cell>
std::vector<Cell> cellsIn(const ValueLists& values, const std::string& name, std::size_t nodes) {
  const Integers& numbers = values.get<Integers>(name);
  constexpr std::size_t size = std::tuple_size_v<Cell>;
  std::vector<Cell> cells(numbers.size() / size);
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (std::size_t a = 0; a < size; ++a) {
      const auto node = numbers[c * size + a];
      if (node < 0 || std::size_t(node) >= nodes) throw std::runtime_error("a cell names a node that there is not");
      cells[c][a] = Index(node);
    }
  return cells;
}

}  // namespace

std::size_t EndState::nodes() const {
  std::size_t nodes = 0;
  for (const Body& body : bodies) nodes += body.rest.size();
  return nodes;
}

std::size_t EndState::cells() const {
  std::size_t cells = 0;
  for (const Body& body : bodies) cells += body.cells();
  return cells;
}

double EndState::spacing() const {
  double sum = 0, volume = 0;
  const auto add = [&](const CellKind& kind, const auto& cells, const std::vector<Vec3>& rest) {
    for (const auto& cell : cells) {
      const auto corners = cornersOf(cell, rest);
      const double size = std::abs(kind.size(corners.data()));
      double longest = 0;
      for (const auto& [a, b] : kind.edges)
        longest = std::max(longest, (corners[std::size_t(a)] - corners[std::size_t(b)]).norm());
      sum += size * longest, volume += size;
    }
  };
  for (const Body& body : bodies) {
    add(cell_kinds::tetrahedron, body.tetrahedra, body.rest);
    add(cell_kinds::hexahedron, body.hexahedra, body.rest);
  }
  return volume > 0 ? sum / volume : 0;
}

EndState EndState::read(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot open", file));
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  try {
    const ValueLists values = ValueLists::fromBytes(bytes);
    EndState end;
    const Reals& times = values.get<Reals>("times");
    if (times.size() != 2) throw std::runtime_error("it has no times");
    end.time = times[0], end.dt = times[1];
    end.quantity = values.get<Reals>("quantity");
    end.inputs = values.get<Texts>("inputs");
    const Texts& units = values.get<Texts>("units");
    if (units.size() != 2) throw std::runtime_error("it has no units");
    end.length_unit = units[0], end.time_unit = units[1];
    for (const std::string& path : values.get<Texts>("states")) {
      Body& body = end.bodies.emplace_back();
      body.path = path;
      body.rest = pointsIn(values, "rest " + path), body.x = pointsIn(values, "x " + path);
      body.v = pointsIn(values, "v " + path);
      if (body.x.size() != body.rest.size() || body.v.size() != body.rest.size())
        throw std::runtime_error("its lists have not the same lengths");
      body.tetrahedra = cellsIn<Tetrahedron>(values, "tetrahedra " + path, body.rest.size());
      body.hexahedra = cellsIn<Hexahedron>(values, "hexahedra " + path, body.rest.size());
    }
    return end;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{} is not what `stroma run --measure` writes: {}", file, error.what()));
  }
}

}  // namespace stroma::sweep
